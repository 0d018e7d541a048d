"""Timed nets in any environment: cycles, clocks and what the environment may do, explored in full.

The state of a timed net is its marking and the clocks of its timed transitions. One cycle is explored as it is executed (the rule
stands in `cprm_gym.architecture.petri`), with two differences: every order among immediate transitions of equal priority is followed,
and what comes from outside may be anything. Continuous, input, belief and math places and selected objects are *variables*: the
thresholds at which the net reads a variable cut its values into cells, and in every cycle it may be in any of them. Places that show
the same observation, or the same view of the same random variable, are one variable.

Math places are cut like the others and move freely within the range that their expression can have: the exploration holds more than
the net can do, never less.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from ....errors import NetError
from ...expressions import Expression
from ...petri import (
    UNBOUNDED,
    Belief,
    CompiledNet,
    Continuous,
    Input,
    ObjectPlace,
    PetriNet,
    Place,
    PlaceKind,
    Transition,
    compile_net,
)
from ...petri.net.net import resolve_name
from ..behaviour.state_space import Budget, Graph, Progress
from ..kernels import cycles as kernels
from ..kernels.table import rehash
from ..net_arrays import FREE, KEEP, System, selected_places

INFINITY = float("inf")
LARGEST = 1.7976931348623157e308
Rows = list[list[tuple[Any, ...]]]
"""Entries per transition."""


@dataclass(frozen=True)
class Variable:
    """What the environment sets: a set of places that show the same thing, and the cells of its values.

    Attributes
    ----------
    name : str
    places : tuple of str
    cells : tuple of (float, float)
        Half-open intervals; of a selected object (0, 1) absent and (1, 2) present.
    is_object : bool
    fixed : int
        The cell of a constant, 0 if it may change.
    """

    name: str
    places: tuple[str, ...]
    cells: tuple[tuple[float, float], ...]
    is_object: bool = False
    fixed: int = 0

    def text(self, cell: int) -> str:
        """Cell number `cell` (from 1) in words: ``off_axis >= 3``."""
        low, high = self.cells[cell - 1]
        if self.is_object:
            return f"{self.name} {'present' if low else 'absent'}"
        if low == -INFINITY:
            return f"{self.name} < {high:g}" if high < INFINITY else f"{self.name} anything"
        return f"{low:g} <= {self.name} < {high:g}" if high < INFINITY else f"{self.name} >= {low:g}"

    def inside(self, cell: int) -> float:
        """A value in the cell."""
        low, high = self.cells[cell - 1]
        if low == -INFINITY:
            return 0.0 if high == INFINITY else high - 1.0
        return low


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
    """

    compiled: CompiledNet
    places: tuple[str, ...]
    transitions: tuple[Transition, ...]
    n_own: int
    variables: tuple[Variable, ...]
    labels: tuple[str, ...]
    untimed: System
    net: kernels.CycleNet
    start: np.ndarray

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


@dataclass(frozen=True)
class Step:
    """One step of a run.

    Attributes
    ----------
    cycle : int
    what : str
        The transition that fires, or the cell that a variable is found in.
    kind : str
        ``"fires"``, ``"outside"``, ``"observed"``, ``"end of cycle"``.
    marking : dict
        The marked places afterwards.
    """

    cycle: int
    what: str
    kind: str
    marking: Mapping[str, int] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"cycle {self.cycle}: {self.what}" + (" fires" if self.kind == "fires" else "")


@dataclass(eq=False)
class CycleSpace:
    """Everything a timed net may do, step by step; node 0 is the start.

    Attributes
    ----------
    rows : (N, S) int16
        Tokens, cells, clocks, phase.
    kinds : (N,) int8
        What each node is: see `kernels.cycles`.
    graph : Graph
    parents : (N,) int32
    complete : bool
    reason : str
        Why not: ``"memory"``, ``"states"``, ``"seconds"``, ``"interrupted"``, ``"unbounded"``.
    overflow : int
        The transition that overflowed a place, -1 if none.
    ties : (T, T) bool
        Timed transitions that were due at one instant.
    """

    system: TimedSystem
    rows: np.ndarray
    kinds: np.ndarray
    graph: Graph
    parents: np.ndarray
    n_expanded: int
    complete: bool
    reason: str
    overflow: int
    ties: np.ndarray
    seconds: float

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.rows)

    @property
    def markings(self) -> np.ndarray:
        """Tokens per node, (N, P) int16."""
        return self.rows[:, : len(self.system.places)]

    @property
    def n_states(self) -> int:
        """Distinct (marking, clocks) at the ends of cycles."""
        return int((self.rows[:, -1] == kernels.BOUNDARY).sum())

    def marking(self, node: int) -> dict[str, int]:
        """Marked places of a node."""
        row = self.markings[node]
        return {self.system.places[p]: int(row[p]) for p in np.flatnonzero(row)}

    def label_at(self, edge: int) -> int:
        """Label of an edge."""
        return int(self.graph.labels[edge])

    def run(self, node: int) -> tuple[Step, ...]:
        """A shortest run from the start to a node."""
        return self.steps(self.edges_to(node))

    def edges_to(self, node: int) -> list[int]:
        """The edges of a shortest run from the start to a node."""
        chain = [node]
        while chain[-1]:
            chain.append(int(self.parents[chain[-1]]))
        chain.reverse()
        g = self.graph
        edges = []
        for a, b in pairwise(chain):
            low, high = g.offsets[a], g.offsets[a + 1]
            edges.append(int(low + np.flatnonzero(g.targets[low:high] == b)[0]))
        return edges

    def steps(self, edges: Sequence[int], cycle: int = 0) -> tuple[Step, ...]:
        """A path given by its edge numbers, in words; cycles are counted from `cycle`."""
        steps = []
        system, own = self.system, self.system.n_own
        for edge in edges:
            label = self.label_at(edge)
            if label == system.tick_label:
                cycle += 1
                continue
            if label in (system.end_label, system.net.stop_label):
                continue
            kind = "fires" if label < own else "outside" if label < len(system.transitions) else "observed"
            steps.append(Step(cycle, system.labels[label], kind, self.marking(int(self.graph.targets[edge]))))
        return tuple(steps)


def timed_system(
    net: PetriNet | CompiledNet,
    outside: Sequence[Transition] = (),
    extra: Mapping[str, int] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limit: int = 30_000,
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

    Raises
    ------
    NetError
        For nets with more tokens, longer delays, more thresholds or more clocks than this exploration can follow.
    """
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    limit = _check_size(c, limit)
    untimed = _discrete_part(c, outside, extra or {})
    variables, of_place = _variables(c, bounds or {})
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
    arcs = _arc_tables(c, untimed, transitions, variables, of_place)
    clocks = [c.clock_count(t) for t in timed]
    shifts = _shifting(arcs, timed) & (c.memory[timed] == kernels.ENABLING)
    arrays = kernels.CycleNet(
        **arcs,
        n_places=len(untimed.places),
        n_cells=len(variables),
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
    )
    start = np.concatenate((untimed.marking, fixed, np.zeros(sum(clocks) + 1))).astype(np.int16)
    return TimedSystem(c, untimed.places, transitions, own, variables, tuple(labels), untimed, arrays, start)


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
) -> dict[str, Any]:
    """The arcs of `CycleNet`, from `guard_start` to `write`, by field."""
    volatile = _volatile(c, of_place)
    guards, cells, takes, puts, sets, writes = tables = [Rows() for _ in range(6)]
    for t, transition in enumerate(transitions):
        guards.append([(p, u.need[t, p], u.inhibit[t, p]) for p in np.flatnonzero((u.need[t] > 0) | (u.inhibit[t] != FREE))])
        takes.append([(p, u.pre[t, p]) for p in np.flatnonzero(u.pre[t])])
        puts.append([(p, u.post[t, p]) for p in np.flatnonzero((u.post[t] > 0) & (u.sets[t] == KEEP))])
        sets.append([(p, u.sets[t, p]) for p in np.flatnonzero(u.sets[t] != KEEP)])
        masks, written = _cell_arcs(transition, variables, of_place) if t < c.n_transitions else ([], [])
        cells.append(masks)
        touched = {u.places[p] for p in np.flatnonzero((u.incidence[t] != 0) | (u.sets[t] != KEEP))}
        stale = {x for name in touched for x in volatile.get(name, ())} - {w[0] for w in written}
        writes.append([*written, *((x, -1) for x in sorted(stale))])
    arrays: dict[str, Any] = {}
    for name, rows, width in zip(("guard", "cell", "take", "put", "set", "write"), tables, (3, 2, 2, 2, 2, 2)):
        arrays[f"{name}_start"], arrays[name] = _table(rows, width)
    return arrays


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


def _keys(c: CompiledNet) -> dict[str, tuple[str, ...]]:
    """What each place shows; places with equal keys are one variable. Math places with one expression of the same things are, too."""
    keys: dict[str, tuple[str, ...]] = {}
    for p in c.net.places:
        if isinstance(p, Input):
            keys[p.name] = ("input", p.observes, str(p.value))  # before the first observation they show their own value
        elif isinstance(p, Belief):
            keys[p.name] = ("belief", p.variable, p.view, p.state, str(p.value))
        else:
            keys[p.name] = ("place", p.name)
    scope = {p.name: p for p in c.net.places}
    number: dict[tuple[str, ...], int] = {}
    for m in c.math:

        def canonical(name: str) -> str:
            place, attribute = resolve_name(name, scope)
            which = number.setdefault(keys[place], len(number))
            return f"v{which}.{attribute}" if attribute else f"v{which}"

        keys[m.name] = ("math", Expression(m.expression).rename(canonical).text, str(m.default))
    return keys


def _variables(c: CompiledNet, bounds: Mapping[str, tuple[float, float]]) -> tuple[tuple[Variable, ...], dict[str, int]]:
    """The variables that some transition reads, and the variable of each of their places."""
    keys = _keys(c)
    cuts: dict[tuple[str, ...], set[float]] = {}
    places: dict[tuple[str, ...], list[object]] = {}
    by_name = {p.name: p for p in c.net.places}
    chosen = {p.name for p, s in zip(c.net.places, selected_places(c)) if s}
    for t in c.net.transitions:
        for arcs in (t.inputs, t.sets, t.tests, t.inhibitors):
            for name, value in arcs.items():
                if name in chosen or not c.moved[c.place_index[name]]:
                    cuts.setdefault(keys[name], set()).add(float(value))
    for p in c.net.places:
        if keys[p.name] in cuts:
            places.setdefault(keys[p.name], []).append(p)
    for name in bounds:
        if name not in by_name:
            c.place(name)
    ranges = _ranges(c, bounds)
    variables, of_place = [], {}
    for x, (key, members) in enumerate(places.items()):
        names = tuple(p.name for p in members)  # type: ignore[attr-defined]
        of_place.update(dict.fromkeys(names, x))
        first = members[0]
        if isinstance(first, ObjectPlace):
            variables.append(Variable(names[0], names, ((0.0, 1.0), (1.0, 2.0)), is_object=True))
            continue
        edges = [-INFINITY, *sorted(cuts[key]), INFINITY]
        low, high = max(ranges[n][0] for n in names), min(ranges[n][1] for n in names)
        if len(edges) > 60:
            raise NetError(f"place {names[0]!r}: read at {len(edges) - 2} thresholds; analysis follows at most 58 per variable")
        cells = tuple((a, b) for a, b in pairwise(edges) if b > low and a <= high)
        fixed = 0
        if isinstance(first, Continuous) and first.name not in c.net.ports.parameters:
            fixed = 1 + next(k for k, (a, b) in enumerate(cells) if a <= first.value < b)
        variables.append(Variable(names[0], names, cells, fixed=fixed))
    return tuple(variables), of_place


def _ranges(c: CompiledNet, bounds: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Least and largest value of every place, as far as known; of math places as far as their expressions say."""
    ranges: dict[str, tuple[float, float]] = {}
    for p in c.net.places:
        low, high = -LARGEST, LARGEST
        if isinstance(p, Place):
            low, high = 0.0, LARGEST if p.capacity is None else float(p.capacity)
        elif isinstance(p, Continuous) and p.name not in c.net.ports.parameters:
            low = high = p.value
        elif isinstance(p, Belief) and p.view in ("probability", "entropy", "variance"):
            low, high = 0.0, 1.0 if p.view == "probability" else LARGEST
        ranges[p.name] = _narrowed(p.name, low, high, bounds)
    scope = {p.name: p for p in c.net.places}
    for m in c.math:
        expression = Expression(m.expression)
        read = {name: resolve_name(name, scope) for name in expression.names}
        held = any(attribute for _, attribute in read.values())
        found = expression.bounds({n: (-LARGEST, LARGEST) if attribute else ranges[place] for n, (place, attribute) in read.items()})
        low, high = (-LARGEST, LARGEST) if found.empty else (found.low, found.high)
        if held:
            low, high = min(low, m.default), max(high, m.default)
        ranges[m.name] = _narrowed(m.name, low, high, bounds)
    return ranges


def _narrowed(name: str, low: float, high: float, bounds: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """The range (low, high) of a place together with what is given about it."""
    given = bounds.get(name, (low, high))
    both = max(low, given[0]), min(high, given[1])
    if both[0] > both[1]:
        raise NetError(f"bounds of place {name!r}: {given} and [{low:g}, {high:g}] have nothing in common")
    return both


def _cell_arcs(
    t: Transition, variables: tuple[Variable, ...], of_place: Mapping[str, int]
) -> tuple[list[tuple[int, ...]], list[tuple[int, ...]]]:
    """Masks of the cells that let `t` be enabled, and the cells it writes."""
    masks: dict[int, int] = {}
    writes: dict[int, int] = {}
    for kind in ("inputs", "tests", "inhibitors"):
        for name, value in getattr(t, kind).items():
            if name not in of_place:
                continue
            x = of_place[name]
            v = variables[x]
            above = sum(2 << k for k, (low, _) in enumerate(v.cells) if low >= value)
            every = sum(2 << k for k in range(len(v.cells)))
            masks[x] = masks.get(x, every) & (every ^ above if kind == "inhibitors" else above)
            if kind == "inputs":
                writes[x] = 1
    writes.update({of_place[name]: 1 for name in t.sets if name in of_place})
    return list(masks.items()), list(writes.items())


def _volatile(c: CompiledNet, of_place: Mapping[str, int]) -> dict[str, list[int]]:
    """Moved place -> variables whose value hangs on it within a cycle (math places, attributes of held objects)."""
    scope = {p.name: p for p in c.net.places}
    reads: dict[str, set[str]] = {}
    for place in c.math:
        operands = {resolve_name(n, scope)[0] for n in Expression(place.expression).names}
        reads[place.name] = set().union(*({o} | reads.get(o, set()) for o in operands if o)) if operands else set()
    for p in c.net.places:
        if isinstance(p, Belief):
            owner = resolve_name(p.variable, scope)[0]
            if isinstance(scope.get(owner), ObjectPlace):
                reads[p.name] = {owner}
    result: dict[str, list[int]] = {}
    for name, operands in reads.items():
        for operand in operands:
            if name in of_place and c.kind[c.place_index[operand]] in (PlaceKind.DISCRETE, PlaceKind.OBJECT):
                result.setdefault(operand, []).append(of_place[name])
    return result


def explore_cycles(
    system: TimedSystem | PetriNet, budget: Budget | None = None, progress: Progress | None = None, chunk: int = 20_000
) -> CycleSpace:
    """Everything a timed net may do, breadth first.

    Parameters
    ----------
    system : TimedSystem or PetriNet
    budget : Budget, optional
        Where to stop with a partial answer.
    progress : callable, optional
        Called about every `chunk` nodes with nodes found, nodes expanded, seconds.
    """
    if isinstance(system, PetriNet):
        system = timed_system(system)
    budget = budget or Budget()
    n = len(system.transitions)
    widest = max((len(v.cells) for v in system.variables), default=0)
    branch = n + widest + 2
    width = len(system.start)
    capacity, slots, edge_capacity = 4096 + 2 * branch, 1 << 14, 16384 + 4 * branch
    while slots * 6 // 10 < capacity:
        slots *= 2
    rows, parents, kinds = np.empty((capacity, width), np.int16), np.zeros(capacity, np.int32), np.empty(capacity, np.int8)
    offsets, targets, labels = np.zeros(capacity + 1, np.int64), np.empty(edge_capacity, np.int32), np.empty(edge_capacity, np.int32)
    table = np.zeros(slots, np.int32)
    out, step, between = np.empty((branch, width), np.int16), np.empty(branch, np.int64), np.empty(width, np.int16)
    ties = np.zeros((n, n), bool)
    state = np.array([0, 1, 0, -1], np.int64)
    rows[0] = system.start
    rehash(rows, 1, table)
    began = time.monotonic()
    reason, complete = "", False
    try:
        while not reason:
            code = kernels.expand(system.net, rows, parents, kinds, offsets, targets, labels, table, out, step, between, ties, state, chunk)
            seconds = time.monotonic() - began
            if code == kernels.DONE:
                complete = True
                break
            if seconds > budget.seconds:
                reason = "seconds"
            elif state[1] >= min(budget.states, 2**30):
                reason = "states"
            elif code == kernels.OVERFLOW:
                reason = "unbounded"
            elif code == kernels.GROW:
                need = 2 * (rows.nbytes + 5 * len(rows) + offsets.nbytes + targets.nbytes + labels.nbytes + table.nbytes)
                if need > budget.memory:
                    reason = "memory"
                    break
                if state[2] > len(targets) - branch:
                    targets, labels = _longer(targets), _longer(labels)
                if state[1] > len(rows) - branch:
                    rows, parents, kinds, offsets = _longer(rows), _longer(parents), _longer(kinds), _longer(offsets)
                if state[1] > len(table) * 6 // 10 - branch:
                    table = np.zeros(2 * len(table), np.int32)
                    rehash(rows, int(state[1]), table)
            if progress:
                progress(int(state[1]), int(state[0]), seconds)
    except KeyboardInterrupt:
        reason = "interrupted"
    except MemoryError:
        reason = "memory"
    done, nodes, edges = (int(v) for v in state[:3])
    offsets = offsets[: nodes + 1].copy()
    offsets[done:] = edges
    kinds[done:nodes] = -1
    return CycleSpace(
        system, rows[:nodes], kinds[:nodes], Graph(offsets, targets[:edges], labels[:edges]), parents[:nodes], done, complete, reason,
        int(state[3]), ties, time.monotonic() - began,
    )  # fmt: skip


def _longer(array: np.ndarray) -> np.ndarray:
    """A copy of `array` with room for twice as many rows."""
    grown = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    grown[: len(array)] = array
    return grown
