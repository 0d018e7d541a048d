"""Exact filtering: the belief as a set of factors, carried from slice to slice by compiled plans.

The belief after a slice is a product of factors over its hidden variables. A step shifts it one slice back, multiplies the
CPDs that the active relations give, puts in the readings, and sums out the variables of the past only (`plans.py`). Which of
the present ones matter is decided by the next slice, so relations may switch on and off at any time and the answer is the one
of the unrolled, non-homogeneous net.

References
----------
Murphy, Dynamic Bayesian Networks, 2002, section 3; dissertation sections 2.3.3 and 2.3.4.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from cprm_gym.errors import CostError, ModelError, ParameterError, did_you_mean

from ...grounding.slices import SAME, STATIC
from ..compiled.alone.program import MOST_PLANS, Program, Shelf, fits
from ..compiled.belief import FactoredBelief, Layout, Renaming, belief_factors, join, merge, nothing_yet, renaming, select
from ..compiled.cache import Recent, TableStore
from ..compiled.slice_info import PAST, PRESENT, SliceInfo
from ..compiled.steps import Compiler, Group, SliceStep
from ..conflicts import smallest_conflict
from ..evidence import UNOBSERVED, Readings
from ..factors import Factor
from ..join_tree import connected
from .clusters import given_clusters, project
from .engine import ComponentCost, Engine, StepResult, status_of_beginners


@dataclass
class FactoredResult(StepResult):
    """What one compiled step gave.

    Attributes
    ----------
    belief : FactoredBelief, or what an engine makes of it
    factored : FactoredBelief
    slice_step : SliceStep
    marginals : list of (objects * W, columns) float arrays
    sums : list of (objects * W, roots) float arrays
        Normalising constants of each group of components.
    replaced : list of (agents, FactoredResult)
        Agents whose answer comes from another step: those that began anew.
    alone : (Program, float array), optional
        Of one agent: the program that was run, and all marginals as one array.
    """

    belief: Any
    factored: FactoredBelief
    info: SliceInfo
    readings: Readings
    slice_step: SliceStep
    marginals: list[np.ndarray]
    increment: np.ndarray
    loss: np.ndarray
    sums: list[np.ndarray]
    replaced: list[tuple[np.ndarray, FactoredResult]] = field(default_factory=list)
    engine: str = "exact"
    exact: bool = True
    report: dict[str, Any] = field(default_factory=dict)
    alone: tuple[Program, np.ndarray] | None = None

    def __post_init__(self) -> None:
        self.status = self.slice_step.status
        self._batch = int(self.readings.hard.shape[1])

    def marginal(self, name: str) -> np.ndarray:
        at = self.slice_step.where.get(name)
        if at is None:
            return self.joint((name,))
        group, instance, column, card = at
        batch = self._batch
        found: np.ndarray = self.marginals[group][instance * batch : (instance + 1) * batch, column : column + card]
        return self._of_others(found.copy(), (name,)) if self.replaced else found

    def joint(self, names: Sequence[str]) -> np.ndarray:
        found = super().joint(names)
        return self._of_others(found, names) if self.replaced else found

    def _of_others(self, found: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """The table with the rows of those who began anew; zeros where their slice has no such variable."""
        for agents, other in self.replaced:
            found[agents] = other.joint(names) if all(name in other.info.row for name in names) else 0.0
        return found

    def hidden_factors(self, names: Sequence[str]) -> list[Factor]:
        return [Factor(tuple(name for name, _ in f.scope), f.table) for f in belief_factors(self.factored)]

    def excluded(self, agent: int) -> list[tuple[Group, int]]:
        """Components in which an agent's readings are impossible: their group and number in it."""
        found = []
        for group, sums in zip(self.slice_step.groups, self.sums):
            for b in range(len(group.members)):
                if (sums[b * self._batch + agent] <= 0.0).any():
                    found.append((group, b))
        return found

    def suspects(self, agent: int) -> list[str]:
        info, hard = self.info, self.readings.hard
        read = {name for group, b in self.excluded(agent) for name in group.readings[b]}
        return [
            name
            for name in sorted(read, key=lambda n: info.row[n])
            if (hard[info.row[name], agent] >= 0 or name in self.readings.soft) and not info.given[info.row[name]]
        ]


class ExactEngine(Engine):
    """Compiles and runs steps.

    Parameters
    ----------
    memory_limit : float
        Bytes that one component may take; a larger one is refused before it is run.
    threads : int
        How many threads share the agents of a batch. Results do not depend on it.
    """

    name: ClassVar[str] = "exact"
    exact: ClassVar[bool] = True
    divisible: ClassVar[bool] = True
    max_flops: float = np.inf
    """Operations of a step from which on a belief is projected: never."""

    def __init__(self, memory_limit: float = 2.0**31, threads: int = 1) -> None:
        if threads < 1:
            raise ParameterError(f"`threads` is at least 1, got {threads!r}")
        self.threads = threads
        self.pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self.store = TableStore()
        self.compiler = Compiler(self.store)
        self.memory_limit = memory_limit
        self._shelf = Shelf()
        self._programs: Recent[SliceStep, Program | None] = Recent(512)
        self._known: Recent[tuple[Any, ...], SliceStep] = Recent(2048)  # steps of one agent, by what he observes
        self.temporal = frozenset()
        self._renamings: Recent[tuple[Layout, SliceInfo, tuple[tuple[str, str], ...]], Renaming] = Recent(1024)

    def start(self, batch: int) -> FactoredBelief:
        return nothing_yet(batch)

    # ------------------------------------------------------------------------------------------------- steps

    def slice_step(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, status: np.ndarray | None = None) -> SliceStep:
        """The compiled step; made if it is new."""
        if status is None:
            status = info.status(readings.hard, readings.soft, self.temporal)
        return self.compiler.slice_step(belief.layout, info, status)

    def advance(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, forgive: np.ndarray | None = None) -> FactoredResult:
        if readings.hard.shape[1] > 1 or readings.soft:
            return self.advance_as(belief, info, readings, None)
        key = belief.layout, info, (readings.hard >= 0).tobytes(), self.temporal, self.max_flops
        known = self._known.get(key)
        if known is not None:
            return self.run(belief, info, readings, known)
        result = self.advance_as(belief, info, readings, None)
        if not result.report:  # nothing was projected
            self._known.keep(key, result.slice_step)
        return result

    def advance_as(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, status: np.ndarray | None) -> FactoredResult:
        """As `advance`, with every variable's status given."""
        slice_step = self.slice_step(belief, info, readings, status)
        self.check(slice_step, readings.hard.shape[1])
        return self.run(belief, info, readings, slice_step)

    def run(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, slice_step: SliceStep) -> FactoredResult:
        """Run a compiled step."""
        batch = readings.hard.shape[1]
        program = self._program(slice_step, belief.layout) if batch == 1 else None
        if program is not None:
            return self._run_alone(belief, info, readings, slice_step, program)
        soft = soft_array(slice_step, info, readings)
        messages, marginals, sums = [], [], []
        increment = np.zeros(batch)
        for group in slice_step.groups:
            incoming = slice_step.assemble(group, belief.messages, batch)
            message, found, totals, _ = group.plan.run(
                incoming, group.columns, readings.hard, belief.hard, soft, group.soft_at, increment, self.pool, self.threads
            )
            messages.append(message)
            marginals.append(found)
            sums.append(totals)
        after = FactoredBelief(slice_step.layout, tuple(messages), readings.hard)
        return FactoredResult(after, after, info, readings, slice_step, marginals, increment, np.zeros(batch), sums, engine=self.name)

    def _program(self, slice_step: SliceStep, before: Layout) -> Program | None:
        """A step as a program for one agent, if it can be one."""

        def make() -> Program | None:
            if len(self._shelf.places) > MOST_PLANS:
                self._shelf = Shelf()
            return Program(self._shelf, slice_step, before) if fits(slice_step) else None

        return self._programs.fetch(slice_step, make)

    def _run_alone(
        self, belief: FactoredBelief, info: SliceInfo, readings: Readings, slice_step: SliceStep, program: Program
    ) -> FactoredResult:
        """As `run`, for one agent."""
        soft = soft_array(slice_step, info, readings) if slice_step.soft_width else program.no_soft
        before = np.concatenate(belief.messages, axis=None) if belief.messages else np.empty(0)
        found = program.run(before, readings.hard, belief.hard, soft)
        after = FactoredBelief(slice_step.layout, found.messages, readings.hard)
        zero, given = np.zeros(1), (program, found.flat)
        return FactoredResult(
            after, after, info, readings, slice_step, found.marginals, found.increment, zero, found.sums, engine=self.name, alone=given
        )

    def replace_agents(self, result: StepResult, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> FactoredResult:
        assert isinstance(result, FactoredResult)
        anew = self.advance_as(self.start(len(agents)), first, readings, status_of_beginners(result, first, readings, self.temporal))
        belief = merge(self.compiler.layouts, result.factored, anew.factored, agents)
        increment, loss = result.increment.copy(), result.loss.copy()
        increment[agents], loss[agents] = anew.increment, anew.loss
        return replace(result, belief=belief, factored=belief, increment=increment, loss=loss, replaced=[*result.replaced, (agents, anew)])

    # ------------------------------------------------------------------------------------------------- plans

    @property
    def compiled(self) -> int:
        return self.compiler.compiled

    def cost(self, belief: FactoredBelief, info: SliceInfo, readings: Readings) -> list[ComponentCost]:
        batch = readings.hard.shape[1]
        costs = []
        for group in self.slice_step(belief, info, readings).groups:
            rows = len(group.members) * batch
            one = group.plan.cost
            memory = one.bytes + 8 * rows * (group.plan.message_size + group.plan.marginal_size)
            names = tuple(f"{name}[t-1]" if lag == 1 else name for name, lag in group.members[0])
            costs.append(ComponentCost(names, len(group.members), memory, one.flops * rows, one.largest))
        return sorted(costs, key=lambda c: -c.bytes)

    def prepare(self, belief: FactoredBelief, info: SliceInfo, readings: Readings) -> FactoredBelief:
        return FactoredBelief(self.slice_step(belief, info, readings).layout, (), readings.hard)

    def check(self, slice_step: SliceStep, batch: int) -> None:
        """Refuse a step that would take more memory than is allowed.

        Raises
        ------
        CostError
        """
        for group in slice_step.groups:
            memory = group.plan.cost.bytes + 8 * len(group.members) * batch * group.plan.message_size
            if memory > self.memory_limit:
                names = ", ".join(sorted({name for name, _ in group.members[0]})[:12])
                raise CostError(
                    f"the component of {names} needs {memory / 2**30:.2f} GiB for {batch} agents, allowed are "
                    f"{self.memory_limit / 2**30:.2f}; project it (engine='projection' or 'anytime') or raise `memory_limit`"
                )

    # ------------------------------------------------------------------------------------------------- agents and factors

    def form(self, belief: FactoredBelief) -> Hashable:
        return belief.layout

    def select(self, belief: FactoredBelief, agents: np.ndarray) -> FactoredBelief:
        return select(belief, agents)

    def join(self, beliefs: Sequence[FactoredBelief]) -> FactoredBelief:
        return join(beliefs)

    def renamed(self, belief: FactoredBelief, info: SliceInfo, pairs: tuple[tuple[str, str], ...]) -> FactoredBelief:
        key = belief.layout, info, pairs
        return self._renamings.fetch(key, lambda: renaming(self.compiler.layouts, belief.layout, info, dict(pairs))).of(belief)

    def factored(self, belief: FactoredBelief) -> FactoredBelief:
        return belief

    def adopt(self, belief: FactoredBelief) -> FactoredBelief:
        return belief

    def project(self, belief: FactoredBelief, clusters: Sequence[Sequence[str]]) -> tuple[FactoredBelief, np.ndarray]:
        known = {name for name, _ in belief.layout.variables()}
        for name in (n for c in clusters for n in c):
            if name not in known:
                raise ModelError(f"`project`: {name!r} is not a hidden variable of the belief.{did_you_mean(name, known)}")
        chosen = given_clusters(belief, clusters)
        return project(self.compiler, self.memory_limit, belief, chosen) if chosen else (belief, np.zeros(belief.hard.shape[1]))

    # ------------------------------------------------------------------------------------------------- impossible readings

    def conflict(self, before: FactoredBelief, result: StepResult, agent: int) -> list[str]:
        """A smallest set of an agent's readings that is impossible; the same whoever else is in the batch."""
        assert isinstance(result, FactoredResult)
        for agents, other in reversed(result.replaced):
            if agent in agents:
                return self.conflict(self.start(len(agents)), other, int(np.flatnonzero(agents == agent)[0]))
        info, part = result.info, result.readings.rows(np.array([agent]))
        names = _around(before.layout, result, agent)
        rows = np.array([info.row[n] for n in names], np.int64)
        pattern = np.repeat(part.hard, 2, axis=1)
        pattern[rows, 1] = UNOBSERVED
        alone = select(before, np.array([agent]))
        slice_step = self.slice_step(alone, info, part, info.status(pattern, part.soft, self.temporal))
        try:
            self.check(slice_step, len(names))
        except CostError:
            return names

        def impossible(subsets: Sequence[Sequence[str]]) -> list[bool]:
            """One step of as many agents as there are subsets, each of whom made the readings of one."""
            count = len(subsets)
            kept = np.array([[n in subset for subset in map(set, subsets)] for n in names], bool).reshape(len(names), count)
            hard = np.repeat(part.hard, count, axis=1)
            hard[rows] = np.where(kept, hard[rows], UNOBSERVED)
            soft = {n: np.repeat(s, count, axis=0) for n, s in part.soft.items()}
            for k, name in enumerate(names):
                if name in soft:
                    soft[name][~kept[k]] = 1.0
            before_all = select(alone, np.zeros(count, np.int64))
            return self.run(before_all, info, Readings(hard, soft), slice_step).impossible.tolist()

        return smallest_conflict(names, impossible, at_once=64)


def _around(layout: Layout, result: FactoredResult, agent: int) -> list[str]:
    """What an agent observed of all that hangs together with the components in which his readings are impossible.

    A variable that is observed parts what depends on it; without its reading it would not, so it counts as a link here.
    """
    info, hard = result.info, result.readings.hard
    piece = layout.variables()
    scopes: list[tuple[Any, ...]] = []
    for cpd in info.slice.cpds:
        links: list[Any] = [cpd.child]
        for parent, lag in cpd.parents:
            at = piece.get((parent, STATIC if lag == STATIC else PRESENT), piece.get((parent, STATIC)))
            links.append(parent if lag == SAME or at is None else at)
        scopes.append(tuple(v for v in links if v not in info.row or not info.given[info.row[v]]))
    starts = {name for group, b in result.excluded(agent) for name in group.readings[b]}
    starts |= {name for group, b in result.excluded(agent) for name, time in group.members[b] if time != PAST}
    found: set[Any] = set()
    for group in connected(scopes):
        inside = {v for i in group for v in scopes[i]}
        if not starts.isdisjoint(inside):
            found |= inside
    soft = result.readings.soft
    return [n for n, row in info.row.items() if n in found and (hard[row, agent] >= 0 or n in soft) and not info.given[row]]


def soft_array(slice_step: SliceStep, info: SliceInfo, readings: Readings) -> np.ndarray:
    """Likelihood vectors of all `WEIGHTED` variables side by side, (W, columns)."""
    batch = readings.hard.shape[1]
    out = np.ones((batch, slice_step.soft_width))
    for name, columns in slice_step.soft_columns.items():
        values = readings.hard[info.row[name]]
        seen = np.flatnonzero(values >= 0)
        block = out[:, columns]
        block[seen] = 0.0
        block[seen, values[seen]] = 1.0
        if name in readings.soft:
            block *= readings.soft[name]
    return out
