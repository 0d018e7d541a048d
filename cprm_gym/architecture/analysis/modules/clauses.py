"""The clauses of a module's contract, judged on an exploration with a caller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...petri import PetriNet
from ..behaviour.graphs import can_reach, closure, components, shortest_run
from ..kernels import timed as kernels
from ..timed.environment import RUNNING, asked
from ..timed.state_space import TimedStateSpace, immediate_loop, part
from ..verdicts import Verdict


class Judge:
    """The verdicts on one exploration."""

    def __init__(self, flat: PetriNet, k: int, space: TimedStateSpace) -> None:
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

    def verdict(self, name: str) -> Verdict:
        """The clause, unbroken as far as explored."""
        space = self.space
        if space.complete:
            return Verdict(True, name=name)
        return Verdict(None, f"not broken in the {space.n_expanded} steps explored; stopped: {space.reason}", name=name)

    def broken(self, name: str, node: int, why: str) -> Verdict:
        """The clause, broken at `node`."""
        return Verdict(False, why, self.space.run(node), name=name)

    def by_edge(self, name: str, edge: int, why: str) -> Verdict:
        """The clause, broken by an edge."""
        return Verdict(False, why, self.space.steps([*self.space.edges_to(int(self.sources[edge])), edge]), name=name)

    def after(self, name: str, starts: np.ndarray, inside: np.ndarray, goal: np.ndarray, why: str) -> Verdict | None:
        """The clause broken by a run that goes from one of `starts` (nodes) through nodes `inside` to one of `goal`."""
        allowed = inside[self.sources] & (inside | goal)[self.targets]
        found = shortest_run(self.space.graph, starts, goal, allowed) if len(starts) else None
        if found is None:
            return None
        nodes, edges = found
        return Verdict(False, why, self.space.steps([*self.space.edges_to(nodes[0]), *edges]), name=name)

    def label(self, name: str) -> int:
        """Label of a transition of the caller."""
        return self.space.system.labels.index(name)

    def start(self) -> Verdict:
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

    def first(self, name: str, bad: np.ndarray, why: str) -> Verdict | None:
        """The clause broken at the first bad node, if there is one."""
        found = np.flatnonzero(bad)
        return self.broken(name, int(found[0]), why) if len(found) else None

    def exclusive_end(self) -> Verdict:
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

    def clean(self) -> Verdict:
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

    def interruption(self) -> Verdict:
        """Answered within k cycles, in a declared outcome, nothing left."""
        tokens, column = self.space.markings, self.space.system.place
        pending_of = {i: tokens[:, column(asked(i))] > 0 for i in self.ports.interrupts}
        if not any(a.any() for a in pending_of.values()):
            return Verdict(True if self.space.complete else None, "the module is never ongoing", name="interruption")
        allowed = np.zeros(len(tokens), bool)
        for i, pending in pending_of.items():
            answers = self.answers(i)
            good = [n for n, o in enumerate(self.ports.outcomes) if o in answers]
            allowed |= pending & self.outcomes[:, good].any(axis=1)
        waiting = np.array(list(pending_of.values())).any(axis=0)
        wrong = np.flatnonzero(waiting & (self.ends > 0) & ~allowed)
        if len(wrong):
            node = int(wrong[0])
            outcome = self.ports.outcomes[int(self.outcomes[node].argmax())]
            name = next(i for i, a in pending_of.items() if a[node])
            declared = " or ".join(map(repr, self.answers(name)))
            return self.broken("interruption", node, f"interrupted by {name!r}, it ends in {outcome!r} instead of {declared}")
        for i in self.ports.interrupts:
            left = self.over & (tokens[:, column(i)] > 0)
            found = self.first("interruption", left, f"{i!r} is still marked when the run is over")
            if found:
                return found
        for i in self.ports.interrupts:
            found = self.late(i, pending_of[i])
            if found:
                return found
        return self.verdict("interruption")

    def answers(self, interrupt: str) -> tuple[str, ...]:
        """The outcomes allowed after an interrupt."""
        return self.ports.answers.get(interrupt) or self.ports.errors or self.ports.outcomes

    def late(self, interrupt: str, asked: np.ndarray) -> Verdict | None:
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
        return Verdict(False, f"{interrupt!r} is not answered within {self.k} cycles", steps, name="interruption")

    def idle_interrupt(self, broken: set[str]) -> Verdict:
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
                return Verdict(False, f"breaks {other.name}: {other.why}", other.run, name=name)
        return self.verdict(name)

    def spontaneous(self) -> Verdict:
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

    def bounded(self) -> Verdict:
        """No place without capacity fills up."""
        space = self.space
        if space.reason != "unbounded" or space.overflow < 0:
            return self.verdict("bounded")
        node = space.n_expanded
        t = space.system.transitions[space.overflow]
        grown = [p for p in t.outputs if space.markings[node, space.system.place(p)] + t.outputs[p] > space.system.net.limit]
        why = f"{t.name!r} fills {grown[0]!r}, which has no capacity, beyond {space.system.net.limit} tokens"
        return self.broken("bounded", node, why)

    def may_end(self) -> Verdict:
        """The option to complete."""
        why = "from here no behaviour of the environment leads to an end"
        return replace(self.space.always_can(self.ends > 0, self.running & (self.ends == 0), why), name="may end")

    def ends_only_by_interrupt(self) -> tuple[str, ...]:
        """A warning if the module can come where nothing but an interrupt ends it."""
        space = self.space
        if not space.complete or not self.ports.interrupts:
            return ()
        calls = np.isin(self.labels, [self.label(f"caller interrupts: {i}") for i in self.ports.interrupts])
        graph = part(space.graph, ~calls)
        able = can_reach(graph, components(graph, len(space.system.labels)), self.ends > 0)
        pending = space.markings[:, [space.system.place(i) for i in self.ports.interrupts]].any(axis=1)
        stuck = np.flatnonzero(space.real & self.running & (self.ends == 0) & ~able & ~pending)
        if not len(stuck):
            return ()
        marked = ", ".join(space.marking(int(stuck[0])))
        return (f"there are states from which only an interrupt leads to an end, the first with {marked} marked",)

    def quiet(self) -> Verdict:
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
        return Verdict(False, f"fires for ever in one instant: {names}", space.run(node), loop, name="becomes quiet")
