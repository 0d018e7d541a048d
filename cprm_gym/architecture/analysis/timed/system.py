"""A timed net with its outside as arrays, ready to be explored."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import NetError
from ...petri import UNBOUNDED, CompiledNet, PetriNet, PlaceKind, Transition, compile_net
from ..kernels import timed as kernels
from ..net_arrays import FREE, KEEP, System
from .joint import Joint, joint_cells
from .variables import Variable, cell_arcs, ranges_of, variables_of, volatile_variables

Rows = list[list[tuple[Any, ...]]]
"""Entries per transition."""


@dataclass(frozen=True, eq=False)
class TimedSystem:
    """A net with its outside, ready to be explored cycle by cycle.

    Attributes
    ----------
    compiled : CompiledNet
    places : tuple of str
        Discrete and object places, then the places added for the outside.
    transitions : tuple of Transition
        Those of the net, then those of the outside.
    variables : tuple of Variable
    labels : tuple of str
        What each edge label means: transitions, then cells, then ``clocks stop``, ``end of cycle`` and ``next cycle``.
    untimed : System
        The same discrete part without time.
    joint : Joint
        Which cells of several variables go together.
    """

    compiled: CompiledNet
    places: tuple[str, ...]
    transitions: tuple[Transition, ...]
    n_own: int
    variables: tuple[Variable, ...]
    labels: tuple[str, ...]
    untimed: System
    net: kernels.TimedNet
    start: np.ndarray
    joint: Joint

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
    untimed = _discrete_part(c, outside, extra or {})
    ranges = ranges_of(c, bounds or {})
    variables, of_place = variables_of(c, ranges)
    volatile = volatile_variables(c, of_place)
    joint = joint_cells(c, variables, untimed.places, ranges, bounds or {}, {x for found in volatile.values() for x in found}, enough)
    transitions = (*c.net.transitions, *outside)
    own = c.n_transitions
    immediate = sorted((t for t in range(own) if c.delay[t] == 0), key=lambda t: (-c.priority[t], t))
    timed = sorted((t for t in range(own) if c.delay[t] > 0), key=lambda t: (-c.priority[t], t))
    ends = [k + 1 for k in range(len(immediate)) if k + 1 == len(immediate) or c.priority[immediate[k]] != c.priority[immediate[k + 1]]]
    labels = [t.name for t in transitions]
    first = []
    for v in variables:
        first.append(len(labels))
        labels += [v.text(k + 1) for k in range(len(v.cells))]
    labels += ["clocks stop", "end of cycle", "next cycle"]
    fixed = [v.fixed for v in variables]
    arcs = _arc_tables(c, untimed, transitions, variables, of_place, volatile)
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
        clock_start=len(untimed.places) + len(variables) + np.concatenate(([0], np.cumsum(clocks))).astype(np.int64),
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
        **_joint_tables(joint),
    )
    start = np.concatenate((untimed.marking, fixed, np.zeros(sum(clocks) + 1))).astype(np.int16)
    return TimedSystem(c, untimed.places, transitions, own, variables, tuple(labels), untimed, arrays, start, joint)


MOST = 15_000
"""Most tokens, weights and cycles of delay that fit a node."""
MOST_CLOCKS = 64
"""Most clocks of one transition; what `servers` may be as a number."""


def _check_size(c: CompiledNet, limit: int) -> int:
    """Refuse what a node cannot hold; the number of tokens beyond which a place counts as unbounded."""
    for k, t in enumerate(c.net.transitions):
        if c.clock_count(k) > MOST_CLOCKS:
            raise NetError(
                f"net {c.net.name!r}, transition {t.name!r}: analysis follows up to {MOST_CLOCKS} clocks per transition, it may have "
                f"{c.clock_count(k)}; give its input places capacities or it fewer servers"
            )
        if t.delay > MOST:
            raise NetError(f"net {c.net.name!r}, transition {t.name!r}: analysis follows delays up to {MOST} cycles, it has {t.delay}")
    discrete = c.kind == PlaceKind.DISCRETE
    tokens = int(c.initial[discrete].max(initial=0))
    weight = int(max(a.max(initial=0) for a in (c.pre, c.post, c.set_to)))
    capacity = int(c.capacity[c.capacity < UNBOUNDED].max(initial=0))
    most = max(tokens, weight, capacity)
    if most > MOST:
        raise NetError(f"net {c.net.name!r}: analysis with clocks follows up to {MOST} tokens in a place, it has {most}")
    return min(max(limit, capacity, tokens + weight), MOST)


def _arc_tables(
    c: CompiledNet,
    u: System,
    transitions: tuple[Transition, ...],
    variables: tuple[Variable, ...],
    of_place: Mapping[str, int],
    volatile: Mapping[str, list[int]],
) -> dict[str, Any]:
    """The arcs of `TimedNet`, from `guard_start` to `write`, by field."""
    guards, cells, takes, puts, sets, writes = tables = [Rows() for _ in range(6)]
    for t, transition in enumerate(transitions):
        guards.append([(p, u.need[t, p], u.inhibit[t, p]) for p in np.flatnonzero((u.need[t] > 0) | (u.inhibit[t] != FREE))])
        takes.append([(p, u.pre[t, p]) for p in np.flatnonzero(u.pre[t])])
        puts.append([(p, u.post[t, p]) for p in np.flatnonzero((u.post[t] > 0) & (u.sets[t] == KEEP))])
        sets.append([(p, u.sets[t, p]) for p in np.flatnonzero(u.sets[t] != KEEP)])
        masks, written = cell_arcs(transition, variables, of_place) if t < c.n_transitions else ([], [])
        cells.append(masks)
        touched = {u.places[p] for p in np.flatnonzero((u.incidence[t] != 0) | (u.sets[t] != KEEP))}
        stale = {x for name in touched for x in volatile.get(name, ())} - {w[0] for w in written}
        writes.append([*written, *((x, -1) for x in sorted(stale))])
    arrays: dict[str, Any] = {}
    for name, rows, width in zip(("guard", "cell", "take", "put", "set", "write"), tables, (3, 2, 2, 2, 2, 2)):
        arrays[f"{name}_start"], arrays[name] = _table(rows, width)
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
    return (u.pre > 0).astype(np.int64) @ (u.need[timed] > 0).T.astype(np.int64) > 0


def _ints(values: object) -> np.ndarray:
    return np.array(list(values), np.int64)  # type: ignore[call-overload]


def _table(rows: Rows, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows per transition as start (T + 1,) and one array (., width)."""
    start = np.concatenate(([0], np.cumsum([len(r) for r in rows]))).astype(np.int64)
    flat = [entry for r in rows for entry in r]
    return start, np.array(flat, np.int64).reshape(len(flat), width)


def _discrete_part(c: CompiledNet, outside: Sequence[Transition], extra: Mapping[str, int]) -> System:
    """Discrete and object places and the extra ones, with the transitions of the outside, as an untimed system."""
    base = System.from_net(c)
    known = {name: i for i, name in enumerate((*base.places, *extra))}
    shape = (len(base.transitions) + len(outside), len(known))
    own, width = len(base.transitions), len(base.places)
    pre, post, test, inhibit = (np.zeros(shape, np.int32) for _ in range(4))
    sets = np.full(shape, KEEP, np.int32)
    for array, source in ((pre, base.pre), (post, base.post), (test, base.need), (sets, base.sets)):
        array[:own, :width] = source
    for k, t in enumerate(outside):
        for array, arcs in ((pre, t.inputs), (post, t.outputs), (test, t.tests), (inhibit, t.inhibitors), (sets, t.sets)):
            for name, value in arcs.items():
                array[own + k, known[name]] = int(value)
    capacity = np.concatenate((base.capacity, np.full(len(extra), KEEP)))
    marking = np.concatenate((base.marking, np.array(list(extra.values()), np.int64)))
    whole = System.from_arrays(
        pre, post, marking, places=tuple(known), transitions=(*base.transitions, *(t.name for t in outside)), test=test,
        inhibit=inhibit, sets=sets, capacity=capacity, name=base.name,
    )  # fmt: skip
    whole.inhibit[:own, :width] = base.inhibit
    return whole
