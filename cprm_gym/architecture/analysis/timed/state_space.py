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
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...petri import PetriNet
from ..behaviour.graphs import components, shortest_run
from ..behaviour.state_space import Budget, Graph, Progress
from ..kernels import timed as kernels
from ..kernels.table import rehash
from ..verdicts import Step
from .system import TimedSystem, timed_system


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
    budget = budget or Budget()
    n = len(system.transitions)
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
                    bits += np.uint64(1)
                    table = np.zeros(1 << int(bits), np.uint32)
                    rehash(rows, int(state[1]), table, bits)
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


def part(graph: Graph, kept: np.ndarray) -> Graph:
    """The graph with the edges `kept` (E,) bool only."""
    counts = np.bincount(graph.sources[kept], minlength=graph.n_nodes)
    return Graph(np.concatenate(([0], np.cumsum(counts))).astype(np.int64), graph.targets[kept], graph.labels[kept])
