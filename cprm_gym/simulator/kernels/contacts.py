"""Collision resolution that tells the referee of every touch (specification/simulator.md 3.4)."""

from __future__ import annotations

from ..state import PLAYERS
from . import kernel
from .collisions import (
    ROUNDS,
    apply_pushes,
    bounce,
    clear_pushes,
    push_from_ball,
    push_players,
    touches_ball,
)
from .referee.events import on_touch


@kernel
def resolve_collisions(w, p):
    """Push overlapping objects apart, up to ten rounds; each round in which a player overlaps the ball is a touch."""
    for round in range(ROUNDS):
        clear_pushes(w)
        found = False
        for i in range(PLAYERS):
            if touches_ball(w, p, i):
                found = True
                on_touch(w, p, i)
                push_from_ball(w, p, i, round)
        if push_players(w, p, round):
            found = True
        if not found:
            break
        apply_pushes(w)
    bounce(w)
