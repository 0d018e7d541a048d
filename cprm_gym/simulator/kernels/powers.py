"""What trainer and coach do to worlds at once, between steps (specification/simulator.md 4.9, 4.10), and how worlds begin anew.

`chosen` holds the indices of the worlds concerned, ``(n,)`` int64; arrays of places and the like have one row per chosen world. `trainer`
and `simulator` check what is given before they call these.
"""

from __future__ import annotations

import math

from ..state import Announcement
from . import kernel
from .contacts import resolve_collisions
from .referee.kick_off import book_substitution, kick_off, substitute
from .referee.modes import (
    BIT_GOALIE,
    PAIR,
    PENALTY_READY,
    PENALTY_TAKEN,
    PLAY_ON,
    announce,
)
from .referee.set_mode import set_mode
from .stamina import recover

SAY_PROMOTION = int(Announcement.PROMOTE_GOALIE)
(
    ACCEPTED,
    WHILE_PLAY_ON,
    WHILE_SHOOT_OUT,
    NO_SUBSTITUTIONS_LEFT,
    NO_SUCH_TYPE,
    TYPE_USED_UP,
    NO_SUCH_PLAYER,
    TYPE_ON_FIELD,
    GOALIE_WHILE_PLAY_ON,
    GOALIE_WHILE_PENALTY,
    HAS_GOALIE,
) = range(11)
"""The server's answers to a coach."""


@kernel
def restart(worlds, rows, start, chosen):
    """Put the chosen worlds into a state; their random streams go on, that of resets with its next call.

    worlds : (W,) WORLD; rows : the same as bytes, which are copied much faster than fields, (W, n); start : (n,) bytes of the state;
    chosen : (n,) int64
    """
    for n in chosen:
        w = worlds[n]
        steps, draws = w.steps, w.draws
        physics, sensors, referee, resets = w.key[0], w.key[1], w.key[2], w.key[3]
        rows[n, :] = start
        w.steps, w.draws = steps, draws + 1
        w.key[0], w.key[1], w.key[2], w.key[3] = physics, sensors, referee, resets


@kernel
def move_ball(w, x, y, vx, vy):
    """The trainer moves the ball of a world; nobody holds it any more."""
    w.ball_catcher = 0
    w.pos[0, 0], w.pos[0, 1] = x, y
    w.vel[0, 0], w.vel[0, 1] = vx, vy
    w.acc[0, 0], w.acc[0, 1] = 0.0, 0.0


@kernel
def move_player(w, p, i, x, y, body, vx, vy):
    """The trainer moves player `i` of a world; body and velocity stay where NaN is given. Collisions are resolved."""
    w.pos[i + 1, 0], w.pos[i + 1, 1] = x, y
    if not math.isnan(body):
        w.body[i], w.body_staged[i] = body, body
    if not math.isnan(vx):
        w.vel[i + 1, 0], w.vel[i + 1, 1] = vx, vy
    resolve_collisions(w, p)


@kernel
def put_ball(worlds, chosen, places, velocities):
    """`move_ball` in the chosen worlds."""
    for n in range(chosen.shape[0]):
        move_ball(worlds[chosen[n]], places[n, 0], places[n, 1], velocities[n, 0], velocities[n, 1])


@kernel
def put_player(worlds, parameters, chosen, i, places, bodies, velocities):
    """`move_player` in the chosen worlds."""
    p = parameters[0]
    for n in range(chosen.shape[0]):
        move_player(worlds[chosen[n]], p, i, places[n, 0], places[n, 1], bodies[n], velocities[n, 0], velocities[n, 1])


@kernel
def set_modes(worlds, parameters, chosen, mode):
    """The trainer changes the play mode; the ball stays where it is."""
    for n in range(chosen.shape[0]):
        set_mode(worlds[chosen[n]], parameters[0], mode)


@kernel
def kick_off_worlds(worlds, parameters, chosen):
    """The kick-off procedure."""
    for n in range(chosen.shape[0]):
        kick_off(worlds[chosen[n]], parameters[0])


@kernel
def recover_all(worlds, parameters, chosen):
    """Everybody on the field is rested."""
    for n in range(chosen.shape[0]):
        w = worlds[chosen[n]]
        for i in range(22):
            if w.enabled[i]:
                recover(w, parameters[0], i)


@kernel
def change_type(worlds, parameters, chosen, i, new_type):
    """The trainer substitutes player `i`, without limits."""
    for n in range(chosen.shape[0]):
        w = worlds[chosen[n]]
        book_substitution(w, i, new_type)
        substitute(w, parameters[0], i, new_type)


@kernel
def exempt(p, new_type):
    """The default type may be given as often as one likes."""
    return new_type == 0 and p.allow_mult_default_type != 0


@kernel
def judge_substitution(w, p, team, i, new_type):
    """The server's answer to a coach who wants to substitute player `i`."""
    if w.mode == PLAY_ON:
        return WHILE_PLAY_ON
    if p.half_time >= 0 and w.time >= p.total_cycles:
        return WHILE_SHOOT_OUT
    if w.substitutions[team] >= p.subs_max:
        return NO_SUBSTITUTIONS_LEFT
    if new_type < 0 or new_type >= p.player_types:
        return NO_SUCH_TYPE
    used = w.used_types[team, new_type]
    if used > 0 and used >= p.pt_max and not exempt(p, new_type):
        return TYPE_USED_UP
    if not w.enabled[i]:
        return NO_SUCH_PLAYER
    same = w.substituted[i] != 0 and w.type[i] == new_type
    if w.on_field[team, new_type] >= p.pt_max and not exempt(p, new_type) and not same:
        return TYPE_ON_FIELD
    return ACCEPTED


@kernel
def coach_change_type(worlds, parameters, chosen, i, new_type, answers):
    """A coach substitutes player `i` where the rules allow it; `answers` tells where they do not."""
    p = parameters[0]
    for n in range(chosen.shape[0]):
        w = worlds[chosen[n]]
        answers[n] = judge_substitution(w, p, i // 11, i, new_type)
        if answers[n] == ACCEPTED:
            book_substitution(w, i, new_type)
            substitute(w, p, i, new_type)


@kernel
def judge_promotion(w, i):
    """The server's answer to a coach who wants player `i` to become the goalie."""
    if w.mode == PLAY_ON:
        return GOALIE_WHILE_PLAY_ON
    if PAIR[w.mode] == PENALTY_READY or PAIR[w.mode] == PENALTY_TAKEN:
        return GOALIE_WHILE_PENALTY
    if not w.enabled[i]:
        return NO_SUCH_PLAYER
    first = 0 if i < 11 else 11
    for j in range(first, first + 11):
        if w.enabled[j] and w.goalie[j]:
            return HAS_GOALIE
    return ACCEPTED


@kernel
def coach_promote(worlds, chosen, i, answers):
    """A coach makes field player `i` the goalie where the rules allow it."""
    for n in range(chosen.shape[0]):
        w = worlds[chosen[n]]
        answers[n] = judge_promotion(w, i)
        if answers[n] == ACCEPTED:
            w.goalie[i] = 2
            w.bits[i] |= BIT_GOALIE
            announce(w, SAY_PROMOTION, 1 if i < 11 else -1, i % 11 + 1, 0)
