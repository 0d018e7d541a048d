"""Gaussian mixtures: states as modes, numbers as normals in each mode, so that a model keeps its real numbers.

A component of the belief is a mode, the states of its variables, with a normal over the numbers. A slice takes it through the CPDs in their
order: a number that is a straight line of others is appended exactly, any other by sigma points; a reading conditions all that depends on
it; a variable with states parts the component, by a table or by a chance that depends on numbers. Then the likest components of one mode
are merged, and what that loses at most is told.

Of linear models with normal noise and known modes the answer is the Kalman filter's, with modes that switch that of all their sequences as
long as there is room for them; of others it is an approximation. The engine never says that it is exact.

References
----------
Kalman 1960; Rauch, Tung and Striebel 1965; Julier and Uhlmann 2004 (sigma points);
Garcia-Fernandez and others 2015 (iterated posterior linearisation); Runnalls 2007 (which components to merge);
Lauritzen and Jensen 2001 (conditional Gaussian models); dissertation sections 2.3.2, 2.3.5 and 3.2.3.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cprm_gym.errors import ModelError, ParameterError

from .. import smoothing
from ..compiled.cache import Recent, TableStore
from ..compiled.slice_info import SliceInfo
from ..conflicts import smallest_conflict
from ..continuous.belief import Group, MixtureBelief, joined, side_by_side, with_agents
from ..continuous.kernels import groups as kernels
from ..continuous.kernels import leaves
from ..continuous.splitting import Loose, apart, loose_parts
from ..continuous.structure import Structure, Work, inner_variables, linking_leaves
from ..evidence import UNOBSERVED, Readings
from .engine import Engine, StepResult
from .mixture_answers import MixtureResult, SmoothedNumbers
from .noise_learning import expected_statistics

LEAST_ROOM = 64
"""Components that a step may have for an agent and a part, at least, before some are merged."""


class MixtureEngine(Engine):
    """Mixtures of normals.

    Parameters
    ----------
    components : int
        Most of them that a belief keeps for each part and agent.
    merge : float
        Components of one mode are merged where that loses less than this, in nats; 0 merges only when they are too many.
    split : float
        What a slice no longer links is believed apart from it on where that loses at most this, in nats, for each of the agents; 0 keeps
        together what was linked once. What is lost is told as the loss of the step.
    """

    name: ClassVar[str] = "mixture"
    exact: ClassVar[bool] = False
    divisible: ClassVar[bool] = True
    continuous: ClassVar[bool] = True

    def __init__(self, components: int = 16, merge: float = 1e-4, split: float = 0.0) -> None:
        if isinstance(components, bool) or not isinstance(components, (int, np.integer)) or components < 1:
            raise ParameterError(f"`components` is at least 1, got {components!r}")
        if not 0.0 <= merge < np.inf:
            raise ParameterError(f"`merge` is a loss in nats of at least 0, got {merge!r}")
        if not 0.0 <= split < np.inf:
            raise ParameterError(f"`split` is a loss in nats of at least 0, got {split!r}")
        self.count, self.merge, self.split = int(components), float(merge), float(split)
        self.store = TableStore()
        self.temporal = frozenset()
        self.sampled: frozenset[str] = frozenset()
        self._structures: Recent[tuple[Any, ...], Structure] = Recent(512)
        self._inner: Recent[tuple[Any, ...], tuple[frozenset[str], tuple[str, ...]]] = Recent(512)
        self._loose: Recent[tuple[Any, ...], tuple[Loose, ...]] = Recent(512)
        self._scratch: Recent[tuple[int, ...], tuple[np.ndarray, ...]] = Recent(32)

    # ------------------------------------------------------------------------------------------------- steps

    def start(self, batch: int) -> MixtureBelief:
        return MixtureBelief(None, (), batch)

    def advance(self, belief: MixtureBelief, info: SliceInfo, readings: Readings, forgive: np.ndarray | None = None) -> MixtureResult:
        return self.step(belief, info, readings)

    def step(
        self,
        belief: MixtureBelief,
        info: SliceInfo,
        readings: Readings,
        wanted: frozenset[str] = frozenset(),
        label: str = "",
        room: int = 0,
    ) -> MixtureResult:
        """Go on by one slice.

        Parameters
        ----------
        belief : MixtureBelief
        info : SliceInfo
        readings : Readings
        wanted : frozenset of str
            Variables to be kept besides.
        label : str
            When not empty, what was believed of the slice before is kept too, each name with this behind it.
        room : int
            Components to keep at most, if not as many as ever.

        Returns
        -------
        MixtureResult
            Its report says which agents' readings were ``"impossible"`` and of what, where straight lines that were sought again where the
            readings led to did not settle (``"astray"``, (W,) bool array: those through the points of the prediction were taken), and
            what hangs together (``"parts"``).
        """
        before = belief
        belief, loss = self._apart(belief, info, readings, wanted) if self.split and not label else (belief, np.zeros(belief.batch))
        structure = self.structure(belief, info, readings, wanted, label)
        told = _Told.of(info, readings)
        groups, agents = [], belief.batch
        increment = np.zeros(agents)
        dead: dict[int, list[np.ndarray]] = {}
        astray = np.zeros(agents, bool)
        for work in structure.works:
            group, more, lost, strayed = self._run(work, belief, told, room or self.count)
            astray |= strayed.reshape(-1, agents).any(axis=0)
            increment += more.reshape(-1, agents).sum(axis=0)
            loss += lost.reshape(-1, agents).sum(axis=0)
            if not np.isfinite(more).all():
                for b in np.flatnonzero(~np.isfinite(more)):
                    dead.setdefault(int(b % agents), []).append(work.rows[b // agents])
            if any(part.names for part in work.parts):
                groups.append(group)
        after = belief._replace(info=info, groups=tuple(groups))
        status = np.zeros(len(info.names), np.int8)
        return MixtureResult(
            after, info, readings, status, increment, loss,
            lambda more: self.step(before, info, readings, wanted | more, label, room).belief,
            self.name, False, {"impossible": dead, "astray": astray, "parts": tuple(p.names for g in groups for p in g.parts)},
        )  # fmt: skip

    def structure(self, belief: MixtureBelief, info: SliceInfo, readings: Readings, wanted: frozenset[str], label: str) -> Structure:
        """The structure of a step."""
        inner, unread = self._unread(info, readings, wanted)
        key = belief.form, belief.info, info, inner, unread, label
        return self._structures.fetch(key, lambda: Structure(belief, info, inner, unread, self.sampled, label))

    def _unread(self, info: SliceInfo, readings: Readings, wanted: frozenset[str]) -> tuple[frozenset[str], frozenset[str]]:
        """Variables that are kept, and leaves that would link what is independent and that nobody read."""
        inner, linking = self._inner.fetch((info, self.temporal, wanted), lambda: self._variables(info, wanted))
        return inner, frozenset(n for n in linking if n not in readings.soft and (readings.hard[info.row[n]] < 0).all())

    def _apart(
        self, belief: MixtureBelief, info: SliceInfo, readings: Readings, wanted: frozenset[str]
    ) -> tuple[MixtureBelief, np.ndarray]:
        """The belief with what the slice links no more in parts of its own, and what that loses."""
        _, unread = self._unread(info, readings, wanted)
        loose = self._loose.fetch((belief.form, belief.info, info, unread), lambda: loose_parts(belief, info, unread))
        return apart(belief, loose, self.split) if loose else (belief, np.zeros(belief.batch))

    def _variables(self, info: SliceInfo, wanted: frozenset[str]) -> tuple[frozenset[str], tuple[str, ...]]:
        inner = inner_variables(info, self.temporal, wanted)
        return inner, linking_leaves(info, inner)

    def _run(self, work: Work, belief: MixtureBelief, told: _Told, room: int) -> tuple[Group, np.ndarray, np.ndarray, np.ndarray]:
        """One group of a step: what is believed after it, what its readings add, the loss, and where lines did not settle."""
        agents, members, program = belief.batch, len(work.parts), work.program
        old, lost = _before(work, belief, max(room, LEAST_ROOM))
        copies = room if work.draws else 1
        there = max(old[0].shape[1], copies)
        capacity = min(there * program.growth, max(8 * room, LEAST_ROOM, there))
        count = min(capacity, room)
        rows = members * agents
        keep, slots = len(work.keep_columns), len(work.keep_slots)
        new = (
            np.empty((rows, count)), np.zeros((rows, count, slots), np.int64), np.zeros((rows, count, keep)),
            np.zeros((rows, count, keep, keep)),
        )  # fmt: skip
        increment, loss, astray, fault = np.empty(rows), np.empty(rows), np.zeros(rows, bool), np.zeros(3, np.int64)
        few, leaves = min(capacity, 2 * room), len(program.leaves)
        scratch = self._rooms(capacity, work.slots, work.columns, program.depth, program.width, few, there, leaves)
        normals, uniforms = self._numbers(rows, capacity if work.draws else 0, work.draws)
        kernels.step_group(
            *old, work.load_slots, work.load_columns, copies, *program[:10], told.hard, told.low, told.high, told.soft, work.rows,
            told.soft_rows(work.rows), normals, uniforms, work.keep_slots,
            work.keep_columns, work.periods, work.turns, room, self.merge, self.draws,
            *scratch, *new, increment, loss, astray, fault,
        )  # fmt: skip
        if fault[0]:
            raise _fault(work, fault, agents)
        return Group(work.parts, *new), increment, loss + lost, astray

    draws: ClassVar[bool] = False
    """Which components stay is drawn."""

    def _numbers(self, rows: int, capacity: int, draws: int) -> tuple[np.ndarray, np.ndarray]:
        """Random numbers of a step: normals (rows, components, draws) and uniforms (rows,)."""
        return np.zeros((rows, 0, 0)), np.zeros(rows)

    def _rooms(
        self, capacity: int, slots: int, columns: int, depth: int, width: int, few: int, there: int, leaves: int
    ) -> tuple[np.ndarray, ...]:
        """Arrays in which kernels work; made once for a size."""

        def make() -> tuple[np.ndarray, ...]:
            wide = max(2 * width, columns, 16)
            return (
                np.empty((3, capacity)), np.zeros((3, capacity, slots), np.int64), np.zeros((3, capacity, columns)),
                np.zeros((3, capacity, columns, columns)), np.empty(max(width, 1)), np.empty(depth + 1), np.empty((6 + 2 * width, wide)),
                np.empty((width, columns)), np.empty(capacity), np.empty((few, few)), np.empty(capacity), np.empty(capacity, np.int64),
                np.empty(columns), np.empty((columns, columns)), np.empty((columns + 1, columns)), np.empty(2), np.empty(there),
                np.empty((there, columns)), np.empty((there, columns, columns)), np.zeros((leaves, 3 + width)),
            )  # fmt: skip

        return self._scratch.fetch((capacity, slots, columns, depth, width, few, there, leaves), make)

    def replace_agents(self, result: StepResult, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> MixtureResult:
        assert isinstance(result, MixtureResult)
        believed = [n for parts in result.belief.form for part in parts for n in part.names]
        kept = frozenset(n for n in believed if n in first.slice.variables)
        anew = self.step(self.start(len(agents)), first, readings, kept)
        increment, loss = result.increment.copy(), result.loss.copy()
        increment[agents], loss[agents] = anew.increment, anew.loss
        belief = with_agents(result.belief, anew.belief, agents, max(self.count, LEAST_ROOM))
        dead = {a: rows for a, rows in result.report["impossible"].items() if a not in agents}
        dead |= {int(agents[a]): rows for a, rows in anew.report["impossible"].items()}
        astray = result.report["astray"].copy()
        astray[agents] = anew.report["astray"]

        def again(more: frozenset[str]) -> MixtureBelief:
            begun = self.step(self.start(len(agents)), first, readings, kept | more)
            return with_agents(result.again(more), begun.belief, agents, LEAST_ROOM)

        return replace(
            result,
            belief=belief,
            increment=increment,
            loss=loss,
            again=again,
            report={**result.report, "impossible": dead, "astray": astray},
        )

    # ------------------------------------------------------------------------------------------------- agents

    def form(self, belief: MixtureBelief) -> Hashable:
        return belief.info, belief.form

    def select(self, belief: MixtureBelief, agents: np.ndarray) -> MixtureBelief:
        return belief.select(np.asarray(agents))

    def join(self, beliefs: Sequence[MixtureBelief]) -> MixtureBelief:
        return joined(beliefs)

    def renamed(self, belief: MixtureBelief, info: SliceInfo, pairs: tuple[tuple[str, str], ...]) -> MixtureBelief:
        return belief.renamed(info, dict(pairs))

    def handed_over(self, belief: MixtureBelief) -> MixtureBelief:
        """As it is, for other engines that keep real numbers."""
        return belief

    def adopt(self, belief: MixtureBelief) -> MixtureBelief:
        return belief

    # ------------------------------------------------------------------------------------------------- looking back, samples

    def smooth(self, window: Sequence[smoothing.Slice]) -> list[Any]:
        """Posteriors of the slices of a window given all its readings: the filter of a state that forgets nothing."""
        belief = self.path(window)
        return [SmoothedNumbers(belief, window, t) for t in range(len(window))]

    def path(self, window: Sequence[smoothing.Slice]) -> MixtureBelief:
        """The belief of all slices of a window together; `noise_learning.kept_name` says what a variable is called there."""
        belief: MixtureBelief = window[0].before
        room = max(self.count, 256)
        for t, (_, info, readings) in enumerate(window):
            wanted = frozenset(n for n in info.slice.variables if not info.given[info.row[n]])
            belief = self.step(belief, info, readings, wanted, f"#{t - 1}", room).belief
        return belief

    def most_probable_path(self, window: Sequence[smoothing.Slice]) -> list[Any]:
        self._cannot("knows no most probable path; `smooth` gives the posteriors of a window")

    def expected_counts(self, window: Sequence[smoothing.Slice]) -> dict[Hashable, np.ndarray]:
        return expected_statistics(self.path(window), window)

    def sample(self, belief: MixtureBelief, count: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
        found: dict[str, np.ndarray] = {}
        for g in belief.groups:
            for m, part in enumerate(g.parts):
                log_weights, states, means, covs = g.rows(belief.batch, m)
                total = np.cumsum(np.exp(log_weights), axis=1)
                chosen = (rng.random((belief.batch, count, 1)) * total[:, None, -1:] > total[:, None, :]).sum(axis=2)
                rows = np.arange(belief.batch)[:, None]
                for k, name in enumerate(part.slots):
                    found[name] = states[rows, chosen, k]
                if part.columns:
                    values, vectors = np.linalg.eigh(covs[rows, chosen])
                    noise = rng.standard_normal((belief.batch, count, len(part.columns))) * np.sqrt(np.maximum(values, 0.0))
                    drawn = means[rows, chosen] + np.einsum("wcij,wcj->wci", vectors, noise)
                    found.update({name: drawn[:, :, k] for k, name in enumerate(part.columns)})
        return found

    # ------------------------------------------------------------------------------------------------- impossible readings

    def conflict(self, before: MixtureBelief, result: StepResult, agent: int) -> list[str]:
        """A smallest set of an agent's readings that are impossible together."""
        names, info = result.suspects(agent), result.info
        alone, own = before.select(np.array([agent])), result.readings.rows(np.array([agent]))

        def impossible(sets: Sequence[Sequence[str]]) -> list[bool]:
            out = []
            for kept in sets:
                hard = own.hard.copy()
                for name in set(names) - set(kept):
                    hard[info.row[name]] = UNOBSERVED
                soft = {n: s for n, s in own.soft.items() if n not in names or n in kept}
                out.append(bool(self.step(alone, info, Readings(hard, soft, own.numbers)).impossible[0]))
            return out

        return smallest_conflict(names, impossible) if names else []


class _Told(NamedTuple):
    """Readings as arrays: states, ends of intervals, and likelihoods side by side with the column of each variable."""

    hard: np.ndarray
    low: np.ndarray
    high: np.ndarray
    soft: np.ndarray
    column: np.ndarray

    @classmethod
    def of(cls, info: SliceInfo, readings: Readings) -> _Told:
        low = np.full(readings.hard.shape, np.nan)
        high = low.copy() if readings.numbers else low
        if readings.numbers:
            rows = [info.row[name] for name in readings.numbers]
            low[rows], high[rows] = ([read[k] for read in readings.numbers.values()] for k in (0, 1))
        column = np.full(len(info.names), -1, np.int64)
        width = 0
        for name in readings.soft:
            column[info.row[name]], width = width, width + info.variables[name].card
        soft = np.concatenate([*readings.soft.values()], axis=1) if width else np.zeros((readings.hard.shape[1], 0))
        return cls(np.ascontiguousarray(readings.hard), low, high, np.ascontiguousarray(soft), column)

    def soft_rows(self, rows: np.ndarray) -> np.ndarray:
        """Columns of the likelihoods of some variables, -1 for those without."""
        return self.column[rows]


def _before(work: Work, belief: MixtureBelief, room: int) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Components that a group goes on from, and the loss of those for which there was no room."""
    agents, members = belief.batch, len(work.parts)
    if not work.sources:
        rows = members * agents
        return (np.zeros((rows, 1)), np.zeros((rows, 1, 0), np.int64), np.zeros((rows, 1, 0)), np.zeros((rows, 1, 0, 0))), np.zeros(rows)
    sources = []
    for g, chosen in work.sources:
        group = belief.groups[g]
        arrays = group.arrays
        if len(chosen) != len(group.parts) or (chosen != np.arange(len(chosen))).any():
            picked = (chosen[:, None] * agents + np.arange(agents)).ravel()
            arrays = tuple(a[picked] for a in arrays)
        sources.append((group.parts[int(chosen[0])], arrays))
    arrays, _, lost = side_by_side(sources, room)
    return arrays, lost


def _fault(work: Work, fault: np.ndarray, agents: int) -> ModelError:
    """What went wrong in a formula, and where."""
    part, agent = work.parts[int(fault[2]) // agents], int(fault[2]) % agents
    text = work.program.formulas[int(fault[1])]
    what = {
        leaves.UNDEFINED: "has no finite value", leaves.NEGATIVE: "gives a negative sd", leaves.NO_CHANCE: "gives no probability, 0 to 1,",
    }[int(fault[0])]  # fmt: skip
    return ModelError(f"formula {text!r} {what} where agent {agent} believes {', '.join(part.names) or 'nothing'} to be")
