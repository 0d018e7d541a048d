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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...petri import PetriNet
from ..behaviour.graphs import can_reach, closure, components, shortest_run
from ..behaviour.state_space import Graph, Progress
from ..budget import Budget
from ..kernels import graph as graph_kernels
from ..kernels import timed as kernels
from ..kernels.table import rehash
from ..verdicts import Step, Verdict
from .system import TimedSystem, timed_system

UNDECIDED = "it is not decided whether what is observed can be so at once"


@dataclass(eq=False)
class TimedStateSpace:
    """Everything a timed net may do, step by step; node 0 is the start.

    Attributes
    ----------
    rows : (N, S) int16
        Tokens, cells, clocks, phase.
    kinds : (N,) int8
        What each node is: see `kernels.timed`.
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

    @cached_property
    def unsure(self) -> np.ndarray | None:
        """(E,) edges by which the environment answers what it may not be able to answer; None if every edge is sure.

        What holds on all nodes holds for the net; what some node shows is shown for the net only if the way to it is sure.
        """
        system, joint = self.system, self.system.joint
        sure = np.concatenate([g.sure for g in joint.groups]) if joint.groups else np.zeros(0, bool)
        listed = all(g.listed for g in joint.groups)
        if listed and sure.all() and not system.net.losing:
            return None
        starts = np.cumsum([0, *(len(g.rows) for g in joint.groups)]).astype(np.int64)
        variable = np.full(len(system.labels), -1, np.int64)
        for x, v in enumerate(system.variables):
            variable[system.net.first_label[x] : system.net.first_label[x] + len(v.cells)] = x
        g = self.graph
        found = np.zeros(len(g.labels), bool)
        kernels.unsure_edges(system.net, sure, starts, variable, self.rows, g.offsets, g.targets, g.labels, found)
        return found if found.any() else None

    @cached_property
    def real(self) -> np.ndarray:
        """(N,) nodes that some environment leads the net to, over sure edges."""
        if self.unsure is None:
            return np.ones(self.n_nodes, bool)
        return closure(self.graph, np.zeros(1, np.int64), ~self.unsure)

    @cached_property
    def real_part(self) -> TimedStateSpace:
        """The real nodes and the sure edges alone: every run in it is a run of the net in some environment."""
        if self.unsure is None:
            return self
        number = np.cumsum(self.real) - 1
        kept = ~self.unsure & self.real[self.graph.sources]
        whole = part(self.graph, kept)
        starts = whole.offsets[:-1][self.real]
        nodes = np.flatnonzero(self.real)
        graph = Graph(np.append(starts, len(whole.targets)), number[whole.targets].astype(np.int32), whole.labels)
        seen = bool(self.overflow >= 0 and self.real[self.n_expanded])
        expanded = int(number[self.n_expanded]) if seen else int(self.real[: self.n_expanded].sum())
        return TimedStateSpace(
            self.system, self.rows[nodes], self.kinds[nodes], graph, breadth_first(graph), expanded, self.complete,
            self.reason, self.overflow if seen else -1, self.ties, self.seconds,
        )  # fmt: skip

    def judged(self, check: Callable[[TimedStateSpace], Verdict]) -> Verdict:
        """What `check` says of all runs; a no that only runs show which may not be is unknown.

        Parameters
        ----------
        check : callable
            State space -> verdict, which says no only for a run that is in it.
        """
        verdict = check(self)
        if verdict.holds is not False or self.unsure is None:
            return verdict
        real = check(self.real_part)
        return real if real.holds is False else replace(verdict, holds=None, why=f"{UNDECIDED}: {verdict.why}", run=(), loop=())

    def always_can(self, goal: np.ndarray, asked: np.ndarray, why: str) -> Verdict:
        """Whether a node of `goal` (N,) bool can be reached from every node of `asked`; nodes that were not expanded count as goals."""
        count = len(self.system.labels)
        goal = goal | (self.kinds < 0)
        lost = np.flatnonzero(asked & self.real & ~can_reach(self.graph, components(self.graph, count), goal))
        if len(lost):
            return Verdict(False, why, self.real_run(int(lost[0])))
        if not self.complete:
            return Verdict(None, f"the exploration stopped: {self.reason}")
        if self.unsure is None:
            return Verdict(True)
        lead = self.surely_leads(goal)
        maybe = (asked & ~lead).any()
        return Verdict(None, f"{UNDECIDED}: {why}") if maybe else Verdict(True)

    def surely_leads(self, goal: np.ndarray) -> np.ndarray:
        """(N,) nodes from which some environment leads to a node of `goal`, whatever is undecided.

        Where no answer of the environment is sure, one of them is possible: all of them must lead there.
        """
        assert self.unsure is not None
        graph = self.graph
        order = np.argsort(graph.targets, kind="stable")
        starts = np.searchsorted(graph.targets[order], np.arange(self.n_nodes + 1))
        open_edges = np.bincount(graph.sources[self.unsure], minlength=self.n_nodes)
        left = np.where(open_edges == np.diff(graph.offsets), open_edges, -1)
        lead = goal.copy()
        graph_kernels.lead(starts, graph.sources[order], self.unsure[order], left, lead, np.empty(self.n_nodes, np.int64))
        return lead

    def standstills(self) -> np.ndarray:
        """(N,) real nodes after which nothing ever fires, whatever is observed."""
        active = np.zeros(self.n_nodes, bool)
        active[self.graph.sources[self.graph.labels < len(self.system.transitions)]] = True
        parts = components(self.graph, len(self.system.labels))
        return self.real & (self.kinds == kernels.OVER) & ~can_reach(self.graph, parts, active | (self.kinds < 0))

    def real_run(self, node: int) -> tuple[Step, ...]:
        """A shortest run over sure edges to a node that is real."""
        return self.run(node) if self.unsure is None else self.real_part.run(int(np.count_nonzero(self.real[:node])))

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

    def values(self, edges: Sequence[int]) -> tuple[dict[str, float], ...]:
        """What to observe in each cycle so that a path over sure edges is taken: place -> value, for all that is asked for in it."""
        nodes = [0, *(int(self.graph.targets[e]) for e in edges)]
        ends = [k for k, e in enumerate(edges) if self.label_at(e) == self.system.end_label]
        return tuple(
            self._values_at(self.rows[nodes[k]]) for k in (*ends, *([len(edges)] if not ends or ends[-1] < len(edges) - 1 else []))
        )

    def _values_at(self, row: np.ndarray) -> dict[str, float]:
        """Values of places that agree with all that is known in a node."""
        system, joint = self.system, self.system.joint
        places, found = len(system.places), {}
        for x, v in enumerate(system.variables):
            if row[places + x] > 0 and not v.is_object:
                found.update(dict.fromkeys(v.places, v.inside(int(row[places + x]))))
        for group in (*joint.groups, *joint.whole):
            here = row[list(group.columns)]
            token = np.array([c < places for c in group.columns], bool)
            agrees = group.sure & ((group.rows == here) | (~token & (here <= 0))).all(axis=1)
            if agrees.any():
                for atom, value in group.points[int(agrees.argmax())].items():
                    found.update(dict.fromkeys(joint.shown_by.get(atom, ()), value))
        maths = {m.name for m in system.compiled.math}
        return {name: value for name, value in found.items() if name not in maths}


def explore_timed(
    system: TimedSystem | PetriNet, budget: Budget | None = None, progress: Progress | None = None, chunk: int = 20_000
) -> TimedStateSpace:
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
    budget, clock = (budget or Budget()).start()
    n = len(system.transitions)
    chunk = max(100, min(chunk, 1_000_000 // (n + 1)))
    widest = max((len(v.cells) for v in system.variables), default=0)
    branch = n + widest + 2
    width = len(system.start)
    capacity, bits, edge_capacity = 4096 + 2 * branch, np.uint64(14), 16384 + 4 * branch
    while (1 << int(bits)) * 6 // 10 < capacity:
        bits += np.uint64(1)
    rows, parents, kinds = np.empty((capacity, width), np.int16), np.zeros(capacity, np.int32), np.empty(capacity, np.int8)
    offsets, targets, labels = np.zeros(capacity + 1, np.int64), np.empty(edge_capacity, np.int32), np.empty(edge_capacity, np.int32)
    table = np.zeros(1 << int(bits), np.uint32)
    out, step, between = np.empty((branch, width), np.int16), np.empty(branch, np.int64), np.empty(width, np.int16)
    ties = np.zeros((n, n), bool)
    state = np.array([0, 1, 0, -1], np.int64)
    rows[0] = system.start
    rehash(rows, 1, table, bits)
    began = time.monotonic()
    reason, complete = "", False
    try:
        while not reason:
            code = kernels.expand(
                system.net, rows, parents, kinds, offsets, targets, labels, table, bits, out, step, between, ties, state, chunk
            )
            seconds = time.monotonic() - began
            if code == kernels.DONE:
                complete = True
                break
            if clock.spent():
                reason = clock.reason
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
                    bits += np.uint64(1)
                    table = np.zeros(1 << int(bits), np.uint32)
                    rehash(rows, int(state[1]), table, bits)
            if progress:
                progress(int(state[1]), int(state[0]), seconds)
    except KeyboardInterrupt:
        reason = "interrupted"
        clock.interrupt()
    except MemoryError:
        reason = "memory"
    done, nodes, edges = (int(v) for v in state[:3])
    offsets = offsets[: nodes + 1].copy()
    offsets[done:] = edges
    kinds[done:nodes] = -1
    return TimedStateSpace(
        system, rows[:nodes], kinds[:nodes], Graph(offsets, targets[:edges], labels[:edges]), parents[:nodes], done, complete, reason,
        int(state[3]), ties, time.monotonic() - began,
    )  # fmt: skip


def _longer(array: np.ndarray) -> np.ndarray:
    """A copy of `array` with room for twice as many rows."""
    grown = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    grown[: len(array)] = array
    return grown


def immediate_loop(space: TimedStateSpace, inner: np.ndarray) -> tuple[int, list[int]] | None:
    """A node and the edges of a loop through it that takes no time, over the edges `inner` (E,) bool; None if there is none."""
    graph = space.graph
    sub = part(graph, inner)
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


def breadth_first(graph: Graph) -> np.ndarray:
    """(N,) int32: from which node each was found first, breadth first from node 0."""
    came = np.full(graph.n_nodes, -1, np.int64)
    everything, nothing = np.ones(len(graph.targets), bool), np.zeros(graph.n_nodes, bool)
    graph_kernels.search(graph.offsets, graph.targets, np.zeros(1, np.int64), everything, nothing, came, np.empty(graph.n_nodes, np.int64))
    found = came >= 0
    came[found] = graph.sources[came[found]]
    return np.where(found, came, 0).astype(np.int32)


def part(graph: Graph, kept: np.ndarray) -> Graph:
    """The graph with the edges `kept` (E,) bool only."""
    counts = np.bincount(graph.sources[kept], minlength=graph.n_nodes)
    return Graph(np.concatenate(([0], np.cumsum(counts))).astype(np.int64), graph.targets[kept], graph.labels[kept])
