"""Module contracts: does a behaviour module keep its interface, in every environment?

A behaviour module promises its caller (§2.2.6, §4.2): a token in `begin` starts it, `ongoing` is marked while it works, it ends in
exactly one of `done` and its errors, it leaves nothing behind, it answers interrupts in time. `check_contract` closes the module
with a caller that does everything a caller may do, lets inputs, beliefs and continuous places be anything in every cycle, explores
all that can happen cycle by cycle (`cycles.py`) and judges each promise. A broken promise comes with the shortest run that breaks it.

The caller: begins when the last run is over and its outcome was taken; takes the outcome at any later instant, or never; puts a
token into an interrupt at any instant, one at a time; puts tokens into further inputs (up to their capacity, one where there is
none) and takes them from further outputs whenever it likes. It may act between any two firings of the module.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....errors import NetError
from ...petri import ObjectPlace, PetriNet, Place, Transition, flatten
from ..behaviour.graphs import can_reach, closure, components, shortest_run
from ..behaviour.state_space import Budget, Graph
from ..kernels import cycles as kernels
from ..timed.state_space import CycleSpace, Step, explore_cycles, timed_system

IDLE, RUNNING = "caller idle", "caller waits"

TITLES = {
    "start": "a token in begin marks ongoing in the same instant",
    "exclusive end": "every run that ends, ends in exactly one outcome, and ongoing is empty in that instant",
    "clean": "at the end every inside place is as at the start (or begin overwrites it) and no clock is left",
    "interruption": "an interrupt is answered in time, in an outcome declared for it, and leaves nothing",
    "idle interrupt": "an interrupt while idle does what the ports declare",
    "no spontaneous activity": "without begin nothing fires",
    "bounded": "no place without a capacity fills up",
    "may end": "from everywhere some behaviour of the environment leads to an end",
    "becomes quiet": "immediate transitions never fire for ever within one instant",
}
"""Clause -> what it promises."""


@dataclass(frozen=True)
class Clause:
    """One promise of the contract and the verdict on it.

    Attributes
    ----------
    name : str
        A key of `TITLES`.
    holds : bool or None
        None: not known, because the exploration stopped early.
    why : str
        What is wrong, or why it is not known.
    run : tuple of Step
        The shortest run that breaks the promise.
    loop : tuple of Step
        What can follow that run for ever, for `becomes quiet`.
    """

    name: str
    holds: bool | None
    why: str = ""
    run: tuple[Step, ...] = ()
    loop: tuple[Step, ...] = ()

    @property
    def title(self) -> str:
        """The promise in words."""
        return TITLES[self.name]

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        steps = [[s.cycle, s.kind, s.what, dict(s.marking)] for s in self.run]
        loop = [[s.cycle, s.kind, s.what, dict(s.marking)] for s in self.loop]
        return {"clause": self.name, "promise": self.title, "holds": self.holds, "why": self.why, "run": steps, "loop": loop}


@dataclass(frozen=True)
class ContractReport:
    """The verdict on a module.

    Attributes
    ----------
    module : str
    clauses : tuple of Clause
    warnings : tuple of str
        Transitions that never fire, outcomes that never come.
    within : int
        Cycles granted for answering an interrupt.
    states, nodes : int
        Distinct (marking, clocks) at the ends of cycles; steps explored.
    complete : bool
        Whether everything was explored.
    assumptions : tuple of str
        What the verdict rests on.
    """

    module: str
    clauses: tuple[Clause, ...]
    warnings: tuple[str, ...] = ()
    within: int = 1
    states: int = 0
    nodes: int = 0
    complete: bool = True
    assumptions: tuple[str, ...] = field(default_factory=tuple)

    @property
    def holds(self) -> bool | None:
        """True if every clause holds, False if one is broken, None if some are not known."""
        verdicts = [c.holds for c in self.clauses]
        return False if False in verdicts else None if None in verdicts else True

    @property
    def broken(self) -> tuple[Clause, ...]:
        """The clauses that do not hold."""
        return tuple(c for c in self.clauses if c.holds is False)

    def clause(self, name: str) -> Clause:
        """The clause of that name."""
        return next(c for c in self.clauses if c.name == name)

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "module": self.module,
            "holds": self.holds,
            "within": self.within,
            "states": self.states,
            "nodes": self.nodes,
            "complete": self.complete,
            "clauses": [c.to_json() for c in self.clauses],
            "warnings": list(self.warnings),
            "assumptions": list(self.assumptions),
        }

    def __str__(self) -> str:
        signs = {True: "holds", False: "BROKEN", None: "unknown"}
        lines = [f"contract of {self.module!r}: {signs[self.holds]} ({self.states} states, {self.nodes} steps)"]
        for c in self.clauses:
            lines.append(f"  {signs[c.holds]:8} {c.name}: {c.why or c.title}")
            lines += [f"             {step}" for step in c.run]
            lines += [f"             for ever: {step}" for step in c.loop]
        return "\n".join([*lines, *(f"  warning  {w}" for w in self.warnings)])


def check_contract(
    module: PetriNet,
    k: int | None = None,
    *,
    budget: Budget | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    most_tokens: int = 255,
) -> ContractReport:
    """Check the contract of a behaviour module, for all environments.

    Parameters
    ----------
    module : PetriNet
        With `begin`, `ongoing` and at least one outcome among its ports.
    k : int, optional
        Cycles within which an interrupt must be answered; by default what the ports declare (`within`).
    budget : Budget, optional
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places; otherwise they may be anything.
    most_tokens : int
        Tokens beyond which a place without capacity counts as filling up.

    Raises
    ------
    NetError
        When the net is no behaviour module.
    """
    ports = module.ports
    if not (ports.begin and ports.ongoing and ports.outcomes):
        raise NetError(f"net {module.name!r}: a behaviour module has ports begin, ongoing and done or errors; it has {ports}")
    k = ports.within if k is None else k
    budget = budget or Budget()
    flat = flatten(module)
    judge = _Judge(flat, k, _explore(flat, False, budget, bounds, most_tokens))
    clauses = [judge.start(), judge.exclusive_end(), judge.clean()]
    spaces = [judge.space]
    if ports.interrupts:
        clauses.append(judge.interruption())
        other = _Judge(flat, k, _explore(flat, True, budget, bounds, most_tokens))
        clauses.append(other.idle_interrupt({c.name for c in clauses if c.holds is False}))
        spaces.append(other.space)
    clauses += [judge.spontaneous(), judge.bounded(), judge.may_end(), judge.quiet()]
    return ContractReport(
        module.name,
        tuple(clauses),
        (*_warnings(flat, spaces), *judge.ends_only_by_interrupt()),
        k,
        judge.space.n_states,
        sum(s.n_nodes for s in spaces),
        all(s.complete for s in spaces),
        (
            "the environment may set every input, belief and continuous place to anything in every cycle, and math places to anything "
            "that their expressions allow" + (", within the bounds given" if bounds else ""),
            "no fairness: `may end` says that an end stays possible, not that it comes",
        ),
    )


def caller(flat: PetriNet, idle_interrupts: bool) -> tuple[list[Transition], dict[str, int]]:
    """What a caller may do, as transitions of the outside, and the places that keep its books.

    Parameters
    ----------
    flat : PetriNet
        A behaviour module without modules in it.
    idle_interrupts : bool
        Also interrupt while the module is not ongoing.
    """
    ports = flat.ports
    assert ports.begin
    assert ports.ongoing
    extra = {IDLE: 1, RUNNING: 0, **{_asked(i): 0 for i in ports.interrupts}}
    moves = [Transition("caller begins", (IDLE,), (RUNNING, ports.begin))]
    forget = {_asked(i): 0 for i in ports.interrupts}
    moves += [Transition(f"caller takes {o}", (RUNNING, o), (IDLE,), sets=forget) for o in ports.outcomes]
    for i in ports.interrupts:
        moves.append(Transition(f"caller interrupts: {i}", (), (i, _asked(i)), tests=(ports.ongoing,), inhibitors=(_asked(i), i)))
        if idle_interrupts:
            moves.append(Transition(f"caller interrupts the idle module: {i}", (), (i,), inhibitors=(ports.ongoing, i)))
    own = {p.name: p for p in flat.places}
    for name in (*ports.inputs, *ports.parameters):
        place = own[name]
        if isinstance(place, Place):
            moves.append(Transition(f"outside puts {name}", (), (name,), inhibitors={name: place.capacity or 1}))
        elif isinstance(place, ObjectPlace) and place.select is None:
            moves += [
                Transition(f"outside puts {name}", (), (name,), inhibitors=(name,)),
                Transition(f"outside takes {name}", (name,), ()),
            ]
    for name in ports.outputs:
        if isinstance(own[name], (Place, ObjectPlace)):
            moves.append(Transition(f"outside takes {name}", (name,), ()))
    return moves, extra


def _asked(interrupt: str) -> str:
    return f"asked: {interrupt}"


def _explore(
    flat: PetriNet, idle_interrupts: bool, budget: Budget, bounds: Mapping[str, tuple[float, float]] | None, most: int
) -> CycleSpace:
    moves, extra = caller(flat, idle_interrupts)
    return explore_cycles(timed_system(flat, moves, extra, bounds, most), budget)


def _warnings(flat: PetriNet, spaces: list[CycleSpace]) -> tuple[str, ...]:
    """What never happens although it was written."""
    if not all(s.complete for s in spaces):
        return ()
    fired = np.unique(np.concatenate([s.graph.labels for s in spaces]))
    found = [f"transition {t.name!r} never fires" for n, t in enumerate(flat.transitions) if n not in fired]
    for o in flat.ports.outcomes:
        if not any(s.markings[:, s.system.place(o)].any() for s in spaces):
            found.append(f"outcome {o!r} never comes")
    return tuple(found)


class _Judge:
    """The verdicts on one exploration."""

    def __init__(self, flat: PetriNet, k: int, space: CycleSpace) -> None:
        self.flat, self.ports, self.k, self.space = flat, flat.ports, k, space
        tokens = space.markings
        column = space.system.place
        assert self.ports.begin
        assert self.ports.ongoing
        self.begin, self.ongoing = tokens[:, column(self.ports.begin)] > 0, tokens[:, column(self.ports.ongoing)] > 0
        self.outcomes = tokens[:, [column(o) for o in self.ports.outcomes]] > 0
        self.ends = self.outcomes.sum(axis=1)
        self.running = tokens[:, column(RUNNING)] > 0
        self.settled = space.kinds == kernels.QUIET
        self.over = self.settled & ((self.running & (self.ends == 1) & ~self.ongoing) | ~self.running)
        self.sources = space.graph.sources
        self.labels = space.graph.labels
        self.targets = space.graph.targets

    def verdict(self, name: str) -> Clause:
        """The clause, unbroken as far as explored."""
        space = self.space
        if space.complete:
            return Clause(name, True)
        return Clause(name, None, f"not broken in the {space.n_expanded} steps explored; stopped: {space.reason}")

    def broken(self, name: str, node: int, why: str) -> Clause:
        """The clause, broken at `node`."""
        return Clause(name, False, why, self.space.run(node))

    def by_edge(self, name: str, edge: int, why: str) -> Clause:
        """The clause, broken by an edge."""
        return Clause(name, False, why, self.space.steps([*self.space.edges_to(int(self.sources[edge])), edge]))

    def after(self, name: str, starts: np.ndarray, inside: np.ndarray, goal: np.ndarray, why: str) -> Clause | None:
        """The clause broken by a run that goes from one of `starts` (nodes) through nodes `inside` to one of `goal`."""
        allowed = inside[self.sources] & (inside | goal)[self.targets]
        found = shortest_run(self.space.graph, starts, goal, allowed) if len(starts) else None
        if found is None:
            return None
        nodes, edges = found
        return Clause(name, False, why, self.space.steps([*self.space.edges_to(nodes[0]), *edges]))

    def label(self, name: str) -> int:
        """Label of a transition of the caller."""
        return self.space.system.labels.index(name)

    def start(self) -> Clause:
        """From begin to ongoing in the same instant."""
        begun = np.unique(self.targets[self.labels == self.label("caller begins")]).astype(np.int64)
        not_yet = self.running & ~self.ongoing & (self.ends == 0)
        late = not_yet & self.settled
        skipped = self.running & ~self.ongoing & (self.ends > 0)
        greedy = self.settled & self.begin & self.ongoing
        return (
            self.after(
                "start", begun, not_yet, late, f"{self.ports.ongoing!r} is not marked in the instant in which {self.ports.begin!r} is"
            )
            or self.after("start", begun, not_yet, skipped, f"the module ends without ever marking {self.ports.ongoing!r}")
            or self.first("start", greedy, f"{self.ports.begin!r} is still marked")
            or self.verdict("start")
        )

    def first(self, name: str, bad: np.ndarray, why: str) -> Clause | None:
        """The clause broken at the first bad node, if there is one."""
        found = np.flatnonzero(bad)
        return self.broken(name, int(found[0]), why) if len(found) else None

    def exclusive_end(self) -> Clause:
        """Exactly one outcome, in the instant in which ongoing ends."""
        working = np.flatnonzero(self.running & self.ongoing & (self.ends == 0))
        gone = self.running & ~self.ongoing & (self.ends == 0)
        ongoing = self.ports.ongoing
        return (
            self.first("exclusive end", self.ends > 1, "two outcomes are marked")
            or self.first("exclusive end", ~self.running & (self.ends > 0), "an outcome comes although no run is on")
            or self.first("exclusive end", self.settled & (self.ends == 1) & self.ongoing, f"{ongoing!r} is still marked at the end")
            or self.after(
                "exclusive end",
                working,
                gone | self.ongoing,
                gone & self.settled & ~self.begin,
                f"{ongoing!r} is empty, but no outcome is marked",
            )
            or self.verdict("exclusive end")
        )

    def inside(self) -> list[int]:
        """Columns of the places that must be as at the start when a run is over."""
        ports = self.ports
        free = {*ports.outcomes, *ports.interrupts, *ports.inputs, *ports.outputs, *ports.parameters, ports.ongoing}
        free |= self.overwritten()
        known = set(self.space.system.places)
        return [self.space.system.place(p.name) for p in self.flat.places if p.name in known and p.name not in free]

    def overwritten(self) -> set[str]:
        """Places that every transition which takes the token of begin sets without looking at them: what they held is forgotten."""
        starts = [t for t in self.flat.transitions if self.ports.begin in t.inputs]
        sets = [set(t.sets) - {*t.inputs, *t.tests, *t.inhibitors} for t in starts]
        return set.intersection(*sets) if sets else set()

    def clean(self) -> Clause:
        """Nothing is left at the end."""
        space, columns = self.space, self.inside()
        rest = space.system.start[columns]
        dirty = (space.markings[:, columns] != rest).any(axis=1)
        clocks = space.rows[:, space.system.net.n_places + space.system.net.n_cells : -1]
        ends = np.flatnonzero(self.labels == space.system.end_label)
        standing = np.zeros_like(clocks, bool)
        standing[self.sources[ends]] = clocks[self.targets[ends]] < 0
        left = standing.any(axis=1)
        bad = np.flatnonzero(self.over & (dirty | left))
        if not len(bad):
            return self.verdict("clean")
        node = int(bad[0])
        wrong = [
            f"{space.system.places[c]!r} holds {space.markings[node, c]} instead of {r}"
            for c, r in zip(columns, rest)
            if space.markings[node, c] != r
        ]
        net = space.system.net
        owners = np.repeat(net.timed, np.diff(net.clock_start))[standing[node]]
        wrong += [f"the clock of {space.system.transitions[t].name!r} keeps its age" for t in dict.fromkeys(owners.tolist())]
        return self.broken("clean", node, "left behind at the end: " + ", ".join(wrong))

    def interruption(self) -> Clause:
        """Answered within k cycles, in a declared outcome, nothing left."""
        tokens, column = self.space.markings, self.space.system.place
        asked = {i: tokens[:, column(_asked(i))] > 0 for i in self.ports.interrupts}
        if not any(a.any() for a in asked.values()):
            return Clause("interruption", None if not self.space.complete else True, "the module is never ongoing")
        allowed = np.zeros(len(tokens), bool)
        for i, pending in asked.items():
            answers = self.answers(i)
            good = [n for n, o in enumerate(self.ports.outcomes) if o in answers]
            allowed |= pending & self.outcomes[:, good].any(axis=1)
        waiting = np.array(list(asked.values())).any(axis=0)
        wrong = np.flatnonzero(waiting & (self.ends > 0) & ~allowed)
        if len(wrong):
            node = int(wrong[0])
            outcome = self.ports.outcomes[int(self.outcomes[node].argmax())]
            name = next(i for i, a in asked.items() if a[node])
            declared = " or ".join(map(repr, self.answers(name)))
            return self.broken("interruption", node, f"interrupted by {name!r}, it ends in {outcome!r} instead of {declared}")
        for i in self.ports.interrupts:
            left = self.over & (tokens[:, column(i)] > 0)
            found = self.first("interruption", left, f"{i!r} is still marked when the run is over")
            if found:
                return found
        for i in self.ports.interrupts:
            found = self.late(i, asked[i])
            if found:
                return found
        return self.verdict("interruption")

    def answers(self, interrupt: str) -> tuple[str, ...]:
        """The outcomes allowed after an interrupt."""
        return self.ports.answers.get(interrupt) or self.ports.errors or self.ports.outcomes

    def late(self, interrupt: str, asked: np.ndarray) -> Clause | None:
        """A run in which `interrupt` is not answered within k cycles."""
        space, graph = self.space, self.space.graph
        region = asked & (self.ends == 0)
        tick = space.system.tick_label
        within = region[self.sources] & region[self.targets]
        crossing = np.flatnonzero(within & (self.labels == tick))
        still = within & (self.labels != tick)
        puts = self.labels == self.label(f"caller interrupts: {interrupt}")
        starts = np.unique(self.targets[puts & region[self.targets]]).astype(np.int64)
        layers: list[tuple[np.ndarray, np.ndarray]] = []
        for _ in range(self.k + 1):
            reached = closure(graph, starts, still)
            layers.append((starts, reached))
            edges = crossing[reached[self.sources[crossing]]]
            starts = np.unique(self.targets[edges]).astype(np.int64)
            if not len(starts):
                return None
        goal = np.zeros(graph.n_nodes, bool)
        goal[starts] = True
        edges_back: list[int] = []
        for begin, reached in reversed(layers):
            hop = crossing[reached[self.sources[crossing]] & goal[self.targets[crossing]]]
            ready = np.zeros(graph.n_nodes, bool)
            ready[self.sources[hop]] = True
            found = shortest_run(graph, begin, ready, still)
            assert found is not None
            nodes, edges_here = found
            hop_edge = int(hop[self.sources[hop] == nodes[-1]][0])
            edges_back = [*edges_here, hop_edge, *edges_back]
            goal = np.zeros(graph.n_nodes, bool)
            goal[nodes[0]] = True
            first = nodes[0]
        into = int(np.flatnonzero(puts & (self.targets == first))[0])
        steps = space.steps([*space.edges_to(int(self.sources[into])), into, *edges_back])
        return Clause("interruption", False, f"{interrupt!r} is not answered within {self.k} cycles", steps)

    def idle_interrupt(self, broken: set[str]) -> Clause:
        """An interrupt that comes while the module is not ongoing; `broken` clauses are so without it."""
        name = "idle interrupt"
        tokens, column = self.space.markings, self.space.system.place
        if self.ports.idle_interrupts == "consumed":
            for i in self.ports.interrupts:
                kept = self.settled & ~self.ongoing & (tokens[:, column(i)] > 0)
                found = self.first(name, kept, f"{i!r} is not consumed (declared: consumed)")
                if found:
                    return found
        else:
            for i in self.ports.interrupts:
                calls = self.labels == self.label(f"caller interrupts the idle module: {i}")
                idle = ~self.running & ~self.begin
                eaten = (self.labels < self.space.system.n_own) & idle[self.sources]
                eaten &= (tokens[self.sources, column(i)] > 0) & (tokens[self.targets, column(i)] == 0)
                if calls.any() and eaten.any():
                    edge = int(np.flatnonzero(eaten)[0])
                    return self.by_edge(name, edge, f"{i!r} is consumed (declared: kept)")
        for check in (self.start, self.exclusive_end, self.clean):
            other = check()
            if other.holds is False and other.name not in broken:
                return Clause(name, False, f"breaks {other.name}: {other.why}", other.run)
        return self.verdict(name)

    def spontaneous(self) -> Clause:
        """Nothing fires without begin."""
        system = self.space.system
        answers = [bool(set(t.inputs) & set(self.ports.interrupts)) for t in system.transitions[: system.n_own]]
        own = self.labels < system.n_own
        own[own] = ~np.array(answers, bool)[self.labels[own]]
        edges = np.flatnonzero(own & ~self.running[self.sources])
        if not len(edges):
            return self.verdict("no spontaneous activity")
        edge = int(edges[0])
        fires = self.space.system.labels[self.labels[edge]]
        return self.by_edge("no spontaneous activity", edge, f"{fires!r} fires although no run is on")

    def bounded(self) -> Clause:
        """No place without capacity fills up."""
        space = self.space
        if space.reason != "unbounded":
            return self.verdict("bounded")
        node = space.n_expanded
        t = space.system.transitions[space.overflow]
        grown = [p for p in t.outputs if space.markings[node, space.system.place(p)] + t.outputs[p] > space.system.net.limit]
        why = f"{t.name!r} fills {grown[0]!r}, which has no capacity, beyond {space.system.net.limit} tokens"
        return self.broken("bounded", node, why)

    def may_end(self) -> Clause:
        """The option to complete."""
        graph = self.space.graph
        parts = components(graph, len(self.space.system.labels))
        able = can_reach(graph, parts, (self.ends > 0) | (self.space.kinds < 0))
        stuck = self.running & (self.ends == 0) & ~able
        return self.first("may end", stuck, "from here no behaviour of the environment leads to an end") or self.verdict("may end")

    def ends_only_by_interrupt(self) -> tuple[str, ...]:
        """A warning if the module can come where nothing but an interrupt ends it."""
        space = self.space
        if not space.complete or not self.ports.interrupts:
            return ()
        calls = np.isin(self.labels, [self.label(f"caller interrupts: {i}") for i in self.ports.interrupts])
        graph = _part(space.graph, ~calls)
        able = can_reach(graph, components(graph, len(space.system.labels)), self.ends > 0)
        pending = space.markings[:, [space.system.place(i) for i in self.ports.interrupts]].any(axis=1)
        stuck = np.flatnonzero(self.running & (self.ends == 0) & ~able & ~pending)
        if not len(stuck):
            return ()
        marked = ", ".join(space.marking(int(stuck[0])))
        return (f"there are states from which only an interrupt leads to an end, the first with {marked} marked",)

    def quiet(self) -> Clause:
        """No timeless trap."""
        space = self.space
        inner = (self.labels < space.system.n_own) | (
            (self.labels >= len(space.system.transitions)) & (self.labels < space.system.end_label)
        )
        found = immediate_loop(space, inner)
        if found is None:
            return self.verdict("becomes quiet")
        node, edges = found
        loop = space.steps(edges)
        names = " -> ".join(dict.fromkeys(s.what for s in loop if s.kind == "fires"))
        return Clause("becomes quiet", False, f"fires for ever in one instant: {names}", space.run(node), loop)


def immediate_loop(space: CycleSpace, inner: np.ndarray) -> tuple[int, list[int]] | None:
    """A node and the edges of a loop through it that takes no time, over the edges `inner` (E,) bool; None if there is none."""
    graph = space.graph
    sub = _part(graph, inner)
    parts = components(sub, len(space.system.labels))
    loops = np.flatnonzero(parts.cyclic[parts.component])
    if not len(loops):
        return None
    node = int(loops[0])
    same = parts.component == parts.component[node]
    numbers = np.flatnonzero(inner)
    for k in range(sub.offsets[node], sub.offsets[node + 1]):
        if same[sub.targets[k]]:
            goal = np.zeros(graph.n_nodes, bool)
            goal[node] = True
            back = shortest_run(sub, np.array([sub.targets[k]]), goal, same[sub.sources] & same[sub.targets])
            if back is not None:
                return node, [int(numbers[e]) for e in (k, *back[1])]
    return None


def _part(graph: Graph, kept: np.ndarray) -> Graph:
    """The graph with the edges `kept` (E,) bool only."""
    counts = np.bincount(graph.sources[kept], minlength=graph.n_nodes)
    return Graph(np.concatenate(([0], np.cumsum(counts))).astype(np.int64), graph.targets[kept], graph.labels[kept])
