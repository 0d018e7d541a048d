"""Collisions caused by the referee's own relocations."""

from __future__ import annotations

from .. import kernel
from ..collisions import (
    ROUNDS,
    apply_pushes,
    bounce,
    clear_pushes,
    push_from_ball,
    push_players,
    touches_ball,
)
from .marks import mark_last_touch, mark_pass_touch, mark_set_play_touch
from .modes import RULE_CATCH, RULE_FREE_KICK, RULE_OFFSIDE, RULE_TOUCH
from .offside import mark_offside


@kernel
def note_touch(w, p, i):
    """The event TOUCH inside a relocation: a ruling it leads to waits until the present one is carried out."""
    if p.rules & RULE_OFFSIDE:
        mark_offside(w, p, i, 0.0)
    if p.rules & RULE_FREE_KICK:
        mark_set_play_touch(w, p, i)
    if p.rules & RULE_TOUCH:
        mark_last_touch(w, p, i, 0.0)
    if p.rules & RULE_CATCH:
        mark_pass_touch(w, i)


@kernel
def settle_overlaps(w, p):
    """Resolve the collisions that a relocation caused."""
    for round in range(ROUNDS):
        clear_pushes(w)
        found = False
        for i in range(22):
            if touches_ball(w, p, i):
                found = True
                note_touch(w, p, i)
                push_from_ball(w, p, i, round)
        if push_players(w, p, round):
            found = True
        if not found:
            break
        apply_pushes(w)
    bounce(w)
