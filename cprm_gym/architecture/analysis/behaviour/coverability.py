"""Coverability: what nets can reach or exceed, unbounded ones too.

The graph of Karp and Miller (1969) writes omega for "as many tokens as you like". Repeating a sequence that adds tokens is only sound
where the added tokens forbid nothing and are not overwritten: places under an inhibitor arc, a capacity or a set arc are never pumped,
and nets with priorities are refused. If such a place grows without end the answer is "unknown", not wrong (for nets with
inhibitor arcs or with set arcs boundedness is undecidable: Dufourd, Finkel, Schnoebelen 1998).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....errors import NetError
from ..budget import Budget
from ..kernels import coverability as kernels
from ..kernels.table import rehash
from ..net_arrays import FREE, System

OMEGA = kernels.OMEGA


@dataclass(frozen=True, eq=False)
class CoverabilityGraph:
    """The nodes of the coverability graph.

    Attributes
    ----------
    nodes : (N, P) int64
        `OMEGA` for places that can hold as many tokens as you like.
    complete : bool
    """

    system: System
    nodes: np.ndarray
    parents: np.ndarray
    by: np.ndarray
    complete: bool

    @property
    def unbounded_places(self) -> tuple[str, ...]:
        """Places that can hold as many tokens as you like."""
        return tuple(self.system.places[p] for p in np.flatnonzero((self.nodes >= OMEGA).any(axis=0)))

    @property
    def dead_transitions(self) -> tuple[str, ...]:
        """Transitions that no node enables; certain only if the graph is complete."""
        s = self.system
        able = np.zeros(len(s.transitions), bool)
        for row in self.nodes:
            able |= (row >= s.need).all(axis=1) & ((s.inhibit == FREE) | (row < s.inhibit)).all(axis=1)
        return tuple(s.transitions[t] for t in np.flatnonzero(~able))

    def covers(self, marking: dict[str, int]) -> bool | None:
        """Whether a marking at least as large can be reached; None if the graph is not complete and holds none."""
        wanted = np.zeros(len(self.system.places), np.int64)
        for name, tokens in marking.items():
            wanted[self.system.place(name)] = tokens
        if (self.nodes >= wanted).all(axis=1).any():
            return True
        return False if self.complete else None


def karp_miller(system: System, budget: Budget | None = None) -> CoverabilityGraph:
    """The coverability graph of `system`.

    Parameters
    ----------
    system : System
    budget : Budget, optional

    Raises
    ------
    NetError
        For nets with priorities.
    """
    if system.group.any():
        raise NetError(f"net {system.name!r}: coverability is not defined here for nets with priorities; leave them out")
    budget, clock = (budget or Budget(memory=512 * 1024**2)).start()
    places = len(system.places)
    pumpable = system.pumpable
    capacity = 4096 + 2 * len(system.transitions)
    bits = np.uint64(max(14, (2 * capacity - 1).bit_length()))
    nodes, parents, by = np.zeros((capacity, places), np.int64), np.full(capacity, -1, np.int64), np.full(capacity, -1, np.int64)
    table = np.zeros(1 << int(bits), np.uint32)
    nodes[0] = system.marking
    rehash(nodes, 1, table, bits)
    state = np.array([0, 1], np.int64)
    arrays = [a.astype(np.int64) for a in (system.pre, system.post, system.need, system.inhibit, system.sets)]
    complete = False
    try:
        while True:
            code = kernels.grow(*arrays, pumpable, nodes, parents, by, table, bits, state, np.empty((1, places), np.int64), 200)
            if code == 0:
                complete = True
                break
            if clock.spent() or state[1] >= budget.states:
                break
            if code == 2:
                if 3 * (nodes.nbytes + parents.nbytes + by.nbytes + table.nbytes) > budget.memory:
                    break
                nodes, parents, by = (np.concatenate((a, np.full_like(a, fill))) for a, fill in ((nodes, 0), (parents, -1), (by, -1)))
                bits += np.uint64(1)
                table = np.zeros(1 << int(bits), np.uint32)
                rehash(nodes, int(state[1]), table, bits)
    except MemoryError:
        complete = False
    except KeyboardInterrupt:
        clock.interrupt()
    n = int(state[1])
    return CoverabilityGraph(system, nodes[:n], parents[:n], by[:n], complete)
