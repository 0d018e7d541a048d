"""Siphons and traps.

A siphon is a set of places that stays empty once it is empty: whatever puts a token in needs one of it. A trap stays marked once it is
marked: whatever takes a token out leaves one in it. A set arc puts or takes, whatever was there. In an ordinary net in which every
minimal siphon holds a trap that is marked from the start, no deadlock can be reached (Commoner, 1972). Enumeration by partitioning
(Cordone, Ferrarini, Piroddi 2005).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..net_arrays import KEEP, System
from ..verdicts import Verdict
from .invariants import never


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
    """What each transition does to sets of places, as pairs of bit masks: if it is in the first, it must be in the second.

    Siphons: the places it puts tokens into, and those in which it needs some. Traps: the places it takes tokens from, and those in which
    it leaves some.
    """

    def __init__(self, system: System, traps: bool) -> None:
        kept = system.sets == KEEP
        puts = ((system.post > 0) & kept) | (system.sets > 0)
        if traps:
            if_in, also_in = (system.pre > 0) | (system.sets == 0), puts | ((system.need > system.pre) & kept)
        else:
            if_in, also_in = puts, system.need > 0
        self.pairs = sorted({(_mask(a), _mask(b)) for a, b in zip(if_in, also_in) if a.any()})

    def largest(self, within: int) -> int:
        """The largest siphon or trap inside a set of places."""
        changed = True
        while changed:
            changed = False
            for if_in, also_in in self.pairs:
                if if_in & within and not also_in & within:
                    within &= ~if_in
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


def minimal_siphons(system: System, limit: int = 20_000, enough: Callable[[], bool] = never) -> PlaceSets:
    """The siphons that hold no smaller one.

    Parameters
    ----------
    system : System
    limit : int
        Sub-problems to look at before giving up.
    enough : callable
        Whether to give up now.
    """
    return _enumerate(system, _Flow(system, False), limit, enough)


def minimal_traps(system: System, limit: int = 20_000, enough: Callable[[], bool] = never) -> PlaceSets:
    """The traps that hold no smaller one."""
    return _enumerate(system, _Flow(system, True), limit, enough)


def _enumerate(system: System, flow: _Flow, limit: int, enough: Callable[[], bool]) -> PlaceSets:
    found: set[int] = set()
    queue = deque([((1 << len(system.places)) - 1, 0)])
    looked = 0
    while queue and looked < limit and not enough():
        looked += 1
        allowed, required = queue.popleft()
        inside = flow.largest(allowed)
        if not inside or required & ~inside:
            continue
        small = inside
        for bit in _bits(inside & ~required):
            if enough():
                break
            if small & bit:
                less = flow.largest(small & ~bit)
                if less and not required & ~less:
                    small = less
        if enough():
            queue.append((allowed, required))
            break
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


def siphon_trap(system: System, siphons: PlaceSets | None) -> Verdict:
    """Commoner's condition for ordinary nets: every siphon holds a trap that is marked from the start, so no deadlock is reached."""
    if siphons is None or not is_ordinary(system):
        return Verdict(None, "says nothing about nets with weights, inhibitor arcs, set arcs or capacities" if siphons else "too large")
    bare = unprotected_siphon(system, siphons)
    if bare is not None:
        return Verdict(False, f"the siphon {{{', '.join(sorted(bare))}}} holds no marked trap: it may run empty")
    if not siphons.complete:
        return Verdict(None, "not every minimal siphon was found")
    return Verdict(True, "every siphon holds a marked trap: no deadlock can be reached")
