"""Goals, outs and catches (specification/simulator.md 7.8, 7.9): where the ball is, and whose hands it is in."""

from __future__ import annotations

from .. import kernel
from ..geometry import in_penalty_area, side_of
from .marks import forget_passes
from .modes import (
    BACK_PASS,
    BIT_BACK_PASS,
    CATCH_FAULT,
    FREE_KICK,
    GOAL,
    GOAL_WAIT_STEPS,
    INDIRECT_FREE_KICK,
    LEFT,
    PAIR,
    RIGHT,
    RULING_BACK_PASS,
    RULING_CATCH_FAULT,
    RULING_CORNER_KICK,
    RULING_DROP_BALL,
    RULING_FREE_KICK,
    RULING_GOAL,
    RULING_GOAL_KICK,
    RULING_KICK_IN,
    RULING_KICK_OFF,
    SIDE,
    TIME_OVER,
    WAIT_BACK_PASS,
    WAIT_CATCH_FAULT,
    rule_here,
)
from .waits import end_stoppage

# --- module Touch


@kernel
def crossed_goal_line(p, x0, y0, x1, y1, side):
    """The way of the ball from (x0, y0) to (x1, y1) leads through the goal of `side`."""
    line = -side * p.out_x
    if x0 == x1 or abs(x0) > p.out_x or -side * x1 <= p.out_x:
        return False
    if abs(y0) > p.post_y and abs(x0) > p.goal_line:
        return False
    return abs(y0 + (y1 - y0) * (line - x0) / (x1 - x0)) <= p.post_y


@kernel
def defended_goal(w, p):
    """Side of the goal the ball has gone into, 0 when it has not; a ball in the hands of an attacker does not count."""
    catcher = 0 if w.ball_catcher == 0 else side_of(w.ball_catcher - 1)
    for side in (LEFT, RIGHT):
        if catcher != -side and crossed_goal_line(p, w.ball_prev[0], w.ball_prev[1], w.pos[0, 0], w.pos[0, 1], side):
            return side
    return 0


@kernel
def ball_is_out(w, p):
    """The ball has left the pitch, but not through a goal."""
    last = 0 if w.touch_player == 0 else side_of(w.touch_player - 1)
    x, y = w.pos[0, 0], w.pos[0, 1]
    if abs(x) > p.out_x:
        defender = RIGHT if x > 0.0 else LEFT
        if last == defender:
            rule_here(w, RULING_CORNER_KICK, -defender)
        elif w.ball_catcher == 0:
            rule_here(w, RULING_GOAL_KICK, defender)
    elif abs(y) > p.out_y:
        if last == 0:
            rule_here(w, RULING_DROP_BALL, 0)
        else:
            rule_here(w, RULING_KICK_IN, -last)


@kernel
def touch_step(w, p):
    """Judge the place of the ball."""
    if PAIR[w.mode] == GOAL:
        w.goal_wait += 1
        if w.goal_wait > GOAL_WAIT_STEPS:
            rule_here(w, RULING_KICK_OFF, -SIDE[w.mode])
        return
    if w.mode == TIME_OVER or (abs(w.pos[0, 0]) <= p.out_x and abs(w.pos[0, 1]) <= p.out_y):
        return
    scored_on = 0 if w.touch_indirect else defended_goal(w, p)
    if scored_on != 0:
        rule_here(w, RULING_GOAL, -scored_on)
    else:
        ball_is_out(w, p)


# --- module Catch


@kernel
def pass_is_allowed(w, goalie, punched):
    """The last kick, by a team-mate or himself, does not forbid the goalie to touch the ball."""
    opponent_before = w.bp_before_last != 0 and side_of(w.bp_before_last - 1) != side_of(goalie)
    if w.bp_last == goalie + 1 and opponent_before:
        return True
    if punched:
        return False
    return w.time == w.bp_time and (w.bp_before_last == 0 or opponent_before)


@kernel
def call_back_pass(w, goalie):
    """The goalie used his hands on a team-mate's pass."""
    w.bits[w.bp_last - 1] |= BIT_BACK_PASS
    rule_here(w, RULING_BACK_PASS, side_of(goalie))


@kernel
def caught(w, p, i):
    """Goalie `i` has the ball in his hands."""
    if PAIR[w.mode] == GOAL or w.mode == TIME_OVER:
        return
    side = side_of(i)
    if not in_penalty_area(p, side, w.pos[0, 0], w.pos[0, 1]):
        rule_here(w, RULING_CATCH_FAULT, side)
        return
    if p.back_passes and w.bp_last != 0 and side_of(w.bp_last - 1) == side and not pass_is_allowed(w, i, False):
        call_back_pass(w, i)
        return
    forget_passes(w)
    rule_here(w, RULING_FREE_KICK, side)


@kernel
def punched(w, p, i):
    """Goalie `i` tried to catch the ball and only touched it."""
    if PAIR[w.mode] == GOAL or w.mode == TIME_OVER:
        return
    side = side_of(i)
    if not in_penalty_area(p, side, w.pos[0, 0], w.pos[0, 1]):
        rule_here(w, RULING_CATCH_FAULT, side)
        return
    if p.back_passes and w.bp_last != 0 and side_of(w.bp_last - 1) == side:
        if w.time != w.bp_time and not pass_is_allowed(w, i, True):
            call_back_pass(w, i)
        return
    forget_passes(w)


@kernel
def catch_step(w, p):
    """Wait after back passes and catch faults; a goalie must not carry the ball out of his area."""
    w.bp_touched[0], w.bp_touched[1] = 0, 0
    pair = PAIR[w.mode]
    if pair == BACK_PASS:
        end_stoppage(w, p, WAIT_BACK_PASS, INDIRECT_FREE_KICK)
    elif pair == CATCH_FAULT:
        end_stoppage(w, p, WAIT_CATCH_FAULT, FREE_KICK)
    elif w.ball_catcher != 0:
        side = side_of(w.ball_catcher - 1)
        if not in_penalty_area(p, side, w.pos[0, 0], w.pos[0, 1]):
            rule_here(w, RULING_CATCH_FAULT, side)
