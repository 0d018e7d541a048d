"""Which of some readings contradict each other: a smallest set, found by few questions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

Oracle = Callable[[Sequence[Sequence[str]]], Sequence[bool]]
"""Which of some sets of readings have probability zero."""


def smallest_conflict(names: Sequence[str], impossible: Oracle, at_once: int = 1) -> list[str]:
    """A smallest-by-inclusion subset of readings that have probability zero together.

    The readings are left out in turn, from the first on, and stay out while the rest is still impossible. How many can go is found by
    search, since what is left stays possible once it is.

    Parameters
    ----------
    names : sequence of str
        Impossible together.
    impossible : callable
    at_once : int
        How many sets are handed to `impossible` in one call.

    References
    ----------
    Junker, QuickXplain, AAAI 2004.
    """
    core: list[str] = []
    rest = list(names)
    while True:
        low, high = 0, len(rest) + 1
        while high - low > 1:
            probes = np.unique(np.linspace(low, high, min(at_once, high - low - 1) + 2).astype(int)[1:-1]).tolist()
            probes = [p for p in probes if low < p < high] or [low + 1]
            for probe, still in zip(probes, impossible([core + rest[p:] for p in probes])):
                if still:
                    low = max(low, probe)
                else:
                    high = min(high, probe)
        if low == len(rest):
            return core
        core.append(rest[low])
        rest = rest[low + 1 :]
