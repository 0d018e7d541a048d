"""The offside rule: who is in an offside position when the ball is played, and who is called (specification/simulator.md 7.6).

What is done after the call stands in `rulings` (where the ball is put) and `steps` (the players of the side leave).
"""

from __future__ import annotations

from .. import kernel
from ..geometry import side_of
from .modes import CORNER_KICK, GOAL_KICK, KICK_IN, LEFT, NEUTRAL, PAIR, RULING_OFFSIDE, is_shoot_out, rule


@kernel
def forget_candidates(w):
    """Nobody is in an offside position."""
    for i in range(22):
        w.offside_candidate[i] = 0


@kernel
def offside_line(w, side):
    """x of the offside line that the players of `side` may not be beyond: second last opponent, ball or halfway line."""
    first, second = 0.0, 0.0
    start = 11 if side == LEFT else 0
    for i in range(start, start + 11):
        if w.enabled[i]:
            x = w.pos[i + 1, 0] * side
            if x > second:
                second = x
            if x > first:
                first, second = x, first
    return max(second, w.pos[0, 0] * side) * side


@kernel
def call_offside(w, i):
    """Candidate `i` took part in the game: offside of the side that played the ball last."""
    if not is_shoot_out(w.mode) and w.offside_side != NEUTRAL:
        rule(w, RULING_OFFSIDE, w.offside_side, w.offside_pos[i, 0], w.offside_pos[i, 1])


@kernel
def mark_offside(w, p, i, accel):
    """Player `i` plays (`accel` > 0) or touches the ball: judge him, then find who is now in an offside position."""
    if not p.use_offside:
        return
    if w.offside_time == w.time and w.offside_stoppage == w.stoppage:
        w.offside_side = NEUTRAL
        forget_candidates(w)
        return
    if w.offside_time != w.time:
        w.offside_accel = 0.0
    w.offside_time, w.offside_stoppage = w.time, w.stoppage
    side = side_of(i)
    if accel > w.offside_accel:
        w.offside_side, w.offside_accel = side, accel
    if w.offside_candidate[i]:
        call_offside(w, i)
        return
    forget_candidates(w)
    pair = PAIR[w.mode]
    if pair == GOAL_KICK or pair == KICK_IN or pair == CORNER_KICK:
        return
    line = offside_line(w, side)
    start = 0 if side == LEFT else 11
    for j in range(start, start + 11):
        if w.enabled[j] and j != i and (w.pos[j + 1, 0] - line) * side > 0.0:
            w.offside_candidate[j] = 1
            w.offside_pos[j, 0], w.offside_pos[j, 1] = line, w.pos[j + 1, 1]


@kernel
def mark_failed_try(w, p, i):
    """A candidate who tries to play the ball from nearby and fails is offside as well."""
    if p.use_offside and w.offside_candidate[i]:
        dx, dy = w.pos[i + 1, 0] - w.pos[0, 0], w.pos[i + 1, 1] - w.pos[0, 1]
        if dx * dx + dy * dy < p.offside_active_area_size * p.offside_active_area_size:
            call_offside(w, i)
