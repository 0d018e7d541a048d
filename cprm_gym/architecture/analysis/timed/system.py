"""A timed net with its outside as arrays, ready to be explored."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ....errors import NetError
from ...petri import UNBOUNDED, CompiledNet, PetriNet, PlaceKind, Transition, compile_net
from ..kernels import timed as kernels
from ..net_arrays import FREE, KEEP, System
from .joint import Joint, joint_cells
from .variables import Variable, cell_arcs, ranges_of, variables_of, volatile_variables

Rows = list[list[tuple[Any, ...]]]
"""Entries per transition."""


class Observed(NamedTuple):
    """What the environment sets, and what hangs on it; the same whatever the outside may do with tokens."""

    variables: tuple[Variable, ...]
    of_place: Mapping[str, int]
    """Place -> its variable."""
    volatile: Mapping[str, list[int]]
    """Moved place -> variables whose value hangs on it within a cycle."""
    joint: Joint


@dataclass(frozen=True, eq=False)
class TimedSystem:
    """A net with its outside, ready to be explored cycle by cycle.

    Attributes
    ----------
    compiled : CompiledNet
    transitions : tuple of Transition
        Those of the net, then those of the outside.
    labels : tuple of str
        What each edge label means: transitions, then cells, then ``clocks stop``, ``end of cycle`` and ``next cycle``.
    untimed : System
        The same discrete part without time.
    observed : Observed
        What the environment sets.
    """

    compiled: CompiledNet
    transitions: tuple[Transition, ...]
    labels: tuple[str, ...]
    untimed: System
    net: kernels.TimedNet
    start: np.ndarray
    observed: Observed

    @property
    def places(self) -> tuple[str, ...]:
        """Discrete and object places, then the places added for the outside."""
        return self.untimed.places

    @property
    def n_own(self) -> int:
        """Number of transitions of the net; those of the outside follow."""
        return self.compiled.n_transitions

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What the environment sets."""
        return self.observed.variables

    @property
    def joint(self) -> Joint:
        """Which cells of several variables go together."""
        return self.observed.joint

    def with_outside(self, outside: Sequence[Transition]) -> TimedSystem:
        """The same net with other moves of its surroundings, on the same places; nothing is cut into cells anew."""
        own = slice(self.n_own)
        rows = {key: getattr(self.untimed, key)[own] for key in ("pre", "post", "need", "inhibit", "sets", "group", "preempts")}
        untimed = _extended(replace(self.untimed, transitions=self.untimed.transitions[own], **rows), outside)
        return _assembled(self.compiled, untimed, outside, self.observed, int(self.net.limit))

    def place(self, name: str) -> int:
        """Column of a place."""
        return self.places.index(name)

    @property
    def end_label(self) -> int:
        """Label of the edge into a boundary."""
        return int(self.net.end_label)

    @property
    def tick_label(self) -> int:
        """Label of the edge out of a boundary."""
        return int(self.net.tick_label)


def timed_system(
    net: PetriNet | CompiledNet,
    outside: Sequence[Transition] = (),
    extra: Mapping[str, int] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limit: int = 30_000,
    enough: Callable[[], bool] = lambda: False,
) -> TimedSystem:
    """Prepare a net for exploration.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    outside : sequence of Transition
        What the surroundings may do with the net's discrete places and the `extra` ones, at any instant, any number of times.
    extra : mapping from name to tokens, optional
        Places added for the bookkeeping of the outside.
    bounds : mapping from place to (least, largest), optional
        What is known about the values of continuous, input, belief and math places; math places follow from their operands.
    limit : int
        Tokens in one place beyond which it counts as unbounded.
    enough : callable
        Whether the time granted is spent; which cells go together stays undecided then.

    Raises
    ------
    NetError
        For nets with more tokens, longer delays, more thresholds or more clocks than this exploration can follow.
    """
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    limit = _check_size(c, limit)
    own = _widened(System.from_net(c), extra or {})
    ranges = ranges_of(c, bounds or {})
    variables, of_place = variables_of(c, ranges)
    volatile = volatile_variables(c, of_place)
    joint = joint_cells(c, variables, own.places, ranges, bounds or {}, {x for found in volatile.values() for x in found}, enough)
    return _assembled(c, _extended(own, outside), outside, Observed(variables, of_place, volatile, joint), limit)


def _assembled(c: CompiledNet, untimed: System, outside: Sequence[Transition], observed: Observed, limit: int) -> TimedSystem:
    """The arrays of a net whose discrete part and cells are known."""
    variables = observed.variables
    transitions = (*c.net.transitions, *outside)
    own = c.n_transitions
    delay, priority = c.delay.tolist(), c.priority.tolist()
    ranked = sorted(range(own), key=lambda t: (-priority[t], t))
    immediate, timed = [t for t in ranked if not delay[t]], [t for t in ranked if delay[t]]
    ends = [k + 1 for k in range(len(immediate)) if k + 1 == len(immediate) or priority[immediate[k]] != priority[immediate[k + 1]]]
    labels = [t.name for t in transitions]
    first = []
    for v in variables:
        first.append(len(labels))
        labels += [v.text(k + 1) for k in range(len(v.cells))]
    labels += ["clocks stop", "end of cycle", "next cycle"]
    fixed = [v.fixed for v in variables]
    arcs = _arc_tables(c, untimed, transitions, observed)
    clocks = [c.clock_count(t) for t in timed]
    shifts = _shifting(arcs, timed) & (c.memory[timed] == kernels.ENABLING)
    arrays = kernels.TimedNet(
        **arcs,
        n_places=len(untimed.places),
        n_cells=len(variables),
        n_own=own,
        immediate=_ints(immediate),
        group_end=_ints(ends),
        timed=_ints(timed),
        clock_start=len(untimed.places) + len(variables) + np.cumsum([0, *clocks], dtype=np.int64),
        delay=c.delay[timed].astype(np.int64),
        memory=c.memory[timed].astype(np.int64),
        touches=_touching(c, untimed, timed),
        shifts=shifts,
        shifting=bool(shifts.any()),
        outside=_ints(range(own, len(transitions))),
        cells=_ints([len(v.cells) for v in variables]),
        first_label=_ints(first),
        fixed=np.array([f > 0 for f in fixed], bool),
        stop_label=len(labels) - 3,
        end_label=len(labels) - 2,
        tick_label=len(labels) - 1,
        limit=limit,
        **_joint_tables(observed.joint),
    )
    start = np.concatenate((untimed.marking, fixed, np.zeros(sum(clocks) + 1))).astype(np.int16)
    return TimedSystem(c, transitions, tuple(labels), untimed, arrays, start, observed)


MOST = 15_000
"""Most tokens, weights and cycles of delay that fit a node."""
MOST_CLOCKS = 64
"""Most clocks of one transition; what `servers` may be as a number."""


def _check_size(c: CompiledNet, limit: int) -> int:
    """Refuse what a node cannot hold; the number of tokens beyond which a place counts as unbounded."""
    for k in np.flatnonzero(c.delay).tolist():
        t = c.net.transitions[k]
        if c.clock_count(k) > MOST_CLOCKS:
            raise NetError(
                f"net {c.net.name!r}, transition {t.name!r}: analysis follows up to {MOST_CLOCKS} clocks per transition, it may have "
                f"{c.clock_count(k)}; give its input places capacities or it fewer servers"
            )
        if t.delay > MOST:
            raise NetError(f"net {c.net.name!r}, transition {t.name!r}: analysis follows delays up to {MOST} cycles, it has {t.delay}")
    discrete = c.kind == PlaceKind.DISCRETE
    tokens = int(c.initial[discrete].max(initial=0))
    weight = int(max(a.value.max(initial=0) for a in (c.inputs, c.outputs, c.sets)))
    capacity = int(c.capacity[c.capacity < UNBOUNDED].max(initial=0))
    most = max(tokens, weight, capacity)
    if most > MOST:
        raise NetError(f"net {c.net.name!r}: analysis with clocks follows up to {MOST} tokens in a place, it has {most}")
    return min(max(limit, capacity, tokens + weight), MOST)


def _arc_tables(c: CompiledNet, u: System, transitions: tuple[Transition, ...], observed: Observed) -> dict[str, Any]:
    """The arcs of `TimedNet`, from `guard_start` to `write`, by field."""
    arrays: dict[str, Any] = {}
    sets = u.sets != KEEP
    for name, there, columns in (
        ("guard", (u.need > 0) | (u.inhibit != FREE), (u.need, u.inhibit)),
        ("take", u.pre != 0, (u.pre,)),
        ("put", (u.post > 0) & ~sets, (u.post,)),
        ("set", sets, (u.sets,)),
    ):
        row, place = np.nonzero(there)
        arrays[f"{name}_start"] = np.searchsorted(row, np.arange(len(there) + 1)).astype(np.int64)
        arrays[name] = np.stack((place, *(column[row, place] for column in columns)), axis=1).astype(np.int64)
    cells, writes = Rows(), Rows()
    for t, transition in enumerate(transitions):
        masks, written = cell_arcs(transition, observed.variables, observed.of_place) if t < c.n_transitions else ([], [])
        cells.append(masks)
        stale: set[int] = set()
        if observed.volatile:
            touched = np.flatnonzero((u.pre[t] != u.post[t]) | sets[t])
            stale = {x for p in touched for x in observed.volatile.get(u.places[p], ())} - {w[0] for w in written}
        writes.append([*written, *((x, -1) for x in sorted(stale))])
    for name, rows in (("cell", cells), ("write", writes)):
        arrays[f"{name}_start"], arrays[name] = _table(rows, 2)
    return arrays


def _joint_tables(joint: Joint) -> dict[str, Any]:
    """What the kernels see of the groups: one array, since every array of the net costs them time."""
    count = len(joint.of_variable)
    records, starts = [], []
    at = 2 * count
    for number, group in enumerate(joint.groups):
        starts.append(at)
        head = (number, len(group.columns), len(group.rows), int(group.listed))
        records.append(np.concatenate((np.array((*head, *group.columns), np.int64), group.rows.reshape(-1).astype(np.int64))))
        at += len(records[-1])
    begins = np.array([starts[g] if g >= 0 else -1 for g in joint.of_variable], np.int64)
    return {"joint": np.concatenate((begins, joint.lossy.astype(np.int64), *records)), "losing": bool(joint.lossy.any())}


def _shifting(arcs: Mapping[str, Any], timed: list[int]) -> np.ndarray:
    """Which of the timed transitions read a variable that some firing changes, (C,) bool."""
    written = set(arcs["write"][:, 0].tolist())
    start = arcs["cell_start"]
    return np.array([not written.isdisjoint(arcs["cell"][start[t] : start[t + 1], 0].tolist()) for t in timed], bool)


def _touching(c: CompiledNet, u: System, timed: list[int]) -> np.ndarray:
    """Which transitions take tokens that a timed one needs, (T, C) bool; none do where persistence looks at whole firings only."""
    if c.net.semantics.persistence == "atomic":
        return np.zeros((len(u.transitions), len(timed)), bool)
    return (u.pre > 0).astype(np.float32) @ (u.need[timed] > 0).T.astype(np.float32) > 0  # by BLAS, 20 times as fast as of integers


def _ints(values: object) -> np.ndarray:
    return np.array(list(values), np.int64)  # type: ignore[call-overload]


def _table(rows: Rows, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows per transition as start (T + 1,) and one array (., width)."""
    start = np.concatenate(([0], np.cumsum([len(r) for r in rows]))).astype(np.int64)
    flat = [entry for r in rows for entry in r]
    return start, np.array(flat, np.int64).reshape(len(flat), width)


def _widened(base: System, extra: Mapping[str, int]) -> System:
    """The system with more places, which none of its transitions touches."""
    count = len(extra)
    if not count:
        return base
    wider: dict[str, Any] = {}
    for key, nothing in (("pre", 0), ("post", 0), ("need", 0), ("inhibit", FREE), ("sets", KEEP)):
        narrow = getattr(base, key)
        wider[key] = np.concatenate((narrow, np.full((len(narrow), count), nothing, np.int32)), axis=1)
    marking = np.concatenate((base.marking, np.array(list(extra.values()), np.int64)))
    capacity = np.concatenate((base.capacity, np.full(count, KEEP)))
    return replace(base, places=(*base.places, *extra), marking=marking, capacity=capacity, **wider)


def _extended(own: System, outside: Sequence[Transition]) -> System:
    """The system with the transitions of the outside, without priorities."""
    known = {name: i for i, name in enumerate(own.places)}
    shape = (len(outside), len(known))
    pre, post, test, inhibit = (np.zeros(shape, np.int32) for _ in range(4))
    sets = np.full(shape, KEEP, np.int32)
    for k, t in enumerate(outside):
        for array, arcs in ((pre, t.inputs), (post, t.outputs), (test, t.tests), (inhibit, t.inhibitors), (sets, t.sets)):
            for name, value in arcs.items():
                array[k, known[name]] = int(value)
    names = tuple(t.name for t in outside)
    moves = System.from_arrays(
        pre, post, own.marking, places=own.places, transitions=names, test=test, inhibit=inhibit, sets=sets, capacity=own.capacity,
        name=own.name,
    )  # fmt: skip
    both: dict[str, Any] = {
        key: np.concatenate((getattr(own, key), getattr(moves, key))) for key in ("pre", "post", "need", "inhibit", "sets")
    }
    count = len(own.transitions) + len(names)
    return replace(own, transitions=(*own.transitions, *names), group=np.zeros(count, np.int64), preempts=np.ones(count, bool), **both)
