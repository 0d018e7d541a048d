"""What the referee says, kept in the world until the next step (specification/simulator.md 7.2)."""

from __future__ import annotations

from ...state import ANNOUNCEMENTS
from .. import kernel

CAPACITY = int(ANNOUNCEMENTS)


@kernel
def announce(w, kind, a, b, c):
    """Record an announcement of the referee, with the time at which it is made; beyond 32 in a step they are dropped.

    The first after a step replaces those of that step.
    """
    if w.announced_done:
        w.announced, w.announced_done = 0, 0
    n = w.announced
    if n < CAPACITY:
        w.announcement[n, 0], w.announcement[n, 1], w.announcement[n, 2], w.announcement[n, 3] = kind, a, b, c
        w.announced_at[n] = w.time
        w.announced = n + 1
