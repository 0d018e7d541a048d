"""Siphons and traps.

A siphon is a set of places that stays empty once it is empty: whatever puts a token in also takes one out of it. A trap stays
marked once it is marked. Test arcs count as taking and giving back. In an ordinary net in which every minimal siphon holds a trap
that is marked from the start, no deadlock can be reached (Commoner, 1972); with weights, inhibitor or set arcs the sets are reported as
structure only. Enumeration by partitioning (Cordone, Ferrarini, Piroddi 2005).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from .system import KEEP, System


@dataclass(frozen=True)
class PlaceSets:
    """Minimal siphons or traps.

    Attributes
    ----------
    sets : tuple of frozenset of str
    complete : bool
        False if the enumeration was cut short.
    """

    sets: tuple[frozenset[str], ...]
    complete: bool


class _Flow:
    """Which places each transition takes from and gives to, as bit masks."""

    def __init__(self, system: System, reverse: bool) -> None:
        reads = (system.need > 0) & (system.pre == 0)
        takes = (system.pre > 0) | reads
        gives = (system.post > 0) | reads | (system.sets > 0)
        if reverse:
            takes, gives = gives, takes
        self.takes = [_mask(row) for row in takes]
        self.gives = [_mask(row) for row in gives]
        self.pairs = sorted({(t, g) for t, g in zip(self.takes, self.gives) if g})

    def largest(self, within: int) -> int:
        """The largest siphon inside a set of places."""
        changed = True
        while changed:
            changed = False
            for takes, gives in self.pairs:
                if gives & within and not takes & within:
                    within &= ~gives
                    changed = True
        return within


def _mask(row: np.ndarray) -> int:
    return sum(1 << int(p) for p in np.flatnonzero(row))


def _bits(mask: int) -> list[int]:
    found = []
    while mask:
        low = mask & -mask
        found.append(low)
        mask ^= low
    return found


def minimal_siphons(system: System, limit: int = 20_000) -> PlaceSets:
    """The siphons that hold no smaller one.

    Parameters
    ----------
    system : System
    limit : int
        Sub-problems to look at before giving up.
    """
    return _enumerate(system, _Flow(system, False), limit)


def minimal_traps(system: System, limit: int = 20_000) -> PlaceSets:
    """The traps that hold no smaller one."""
    return _enumerate(system, _Flow(system, True), limit)


def _enumerate(system: System, flow: _Flow, limit: int) -> PlaceSets:
    found: set[int] = set()
    queue = deque([((1 << len(system.places)) - 1, 0)])
    looked = 0
    while queue and looked < limit:
        looked += 1
        allowed, required = queue.popleft()
        inside = flow.largest(allowed)
        if not inside or required & ~inside:
            continue
        small = inside
        for bit in _bits(inside & ~required):
            if small & bit:
                less = flow.largest(small & ~bit)
                if less and not required & ~less:
                    small = less
        if all(not flow.largest(small & ~bit) for bit in _bits(small)):
            found.add(small)
        held = required
        for bit in _bits(small & ~required):
            queue.append((inside & ~bit, held))
            held |= bit
    names = [frozenset(p for k, p in enumerate(system.places) if s >> k & 1) for s in found]
    return PlaceSets(tuple(sorted(names, key=lambda s: (len(s), sorted(s)))), not queue)


def unprotected_siphon(system: System, siphons: PlaceSets) -> frozenset[str] | None:
    """A minimal siphon without an initially marked trap inside, or None: then an ordinary net cannot come to a deadlock."""
    traps = _Flow(system, True)
    column = {name: k for k, name in enumerate(system.places)}
    marked = _mask(system.marking > 0)
    for siphon in siphons.sets:
        inside = sum(1 << column[name] for name in siphon)
        if not traps.largest(inside) & marked:
            return siphon
    return None


def is_ordinary(system: System) -> bool:
    """Whether every arc is an ordinary one of weight 1 (test arcs of weight 1 allowed)."""
    return bool(
        system.pre.max(initial=0) <= 1
        and system.post.max(initial=0) <= 1
        and system.need.max(initial=0) <= 1
        and not system.inhibit.any()
        and (system.sets == KEEP).all()
    )
