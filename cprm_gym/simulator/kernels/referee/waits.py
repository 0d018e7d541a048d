"""The stoppages of 30 steps after an offence (specification/simulator.md 7.12)."""

from __future__ import annotations

from .. import kernel
from ..geometry import in_penalty_area
from .modes import (
    CLEAR_AFTER,
    FREE_KICK,
    INDIRECT_FREE_KICK,
    RULING_MODE,
    SIDE,
    WAIT_FOUL,
    WAIT_STEPS,
    of_side,
    rule,
)
from .places import clear_ball


@kernel
def clear_offenders(w, p, wait):
    """One step of the stoppage: count, and towards its end keep the offenders away from the ball."""
    w.wait[wait] += 1
    if w.wait[wait] > CLEAR_AFTER:
        clear_ball(w, p, SIDE[w.mode])


@kernel
def restart(w, wait, pair):
    """At the end of the stoppage the other side restarts the game with `pair` (a free kick, direct or indirect)."""
    if w.wait[wait] > WAIT_STEPS:
        rule(w, RULING_MODE, of_side(pair, -SIDE[w.mode]), 0.0, 0.0)


@kernel
def end_stoppage(w, p, wait, pair):
    """One step of a stoppage."""
    clear_offenders(w, p, wait)
    restart(w, wait, pair)


@kernel
def end_foul(w, p):
    """One step of the stoppage after a foul; in the offender's own penalty area the free kick is indirect."""
    indirect = in_penalty_area(p, SIDE[w.mode], w.pos[0, 0], w.pos[0, 1])
    end_stoppage(w, p, WAIT_FOUL, INDIRECT_FREE_KICK if indirect else FREE_KICK)
