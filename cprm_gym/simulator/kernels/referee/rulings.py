"""Carrying out what a module decided: the ball is placed, players are moved, the mode changes (specification/simulator.md 7.2 to 7.12)."""

from __future__ import annotations

from ...state import Announcement
from .. import kernel
from .modes import (
    BACK_PASS,
    BEFORE_KICK_OFF,
    CATCH_FAULT,
    CORNER_KICK,
    DROP_BALL,
    FOUL_CHARGE,
    FREE_KICK,
    FREE_KICK_FAULT,
    GOAL,
    GOAL_KICK,
    ILLEGAL_DEFENSE,
    KICK_IN,
    KICK_OFF,
    LEFT,
    NEUTRAL,
    OFFSIDE,
    PLAY_ON,
    RIGHT,
    RULING_BACK_PASS,
    RULING_CATCH_FAULT,
    RULING_CORNER_KICK,
    RULING_DROP_BALL,
    RULING_FOUL,
    RULING_FREE_KICK,
    RULING_FREE_KICK_FAULT,
    RULING_GOAL,
    RULING_GOAL_KICK,
    RULING_HALF_TIME,
    RULING_ILLEGAL_DEFENSE,
    RULING_KICK_IN,
    RULING_KICK_OFF,
    RULING_MODE,
    RULING_NONE,
    RULING_OFFSIDE,
    TIME_OVER,
    WAIT_BACK_PASS,
    WAIT_CATCH_FAULT,
    announce,
    is_shoot_out,
    of_side,
    team_of,
)
from .offside import forget_candidates
from .places import (
    GOAL_AREA_X,
    GOAL_AREA_Y,
    clamp_pitch,
    field_clamp,
    nearest_edge,
    out_of_goal_area,
    out_of_penalty_area,
    own_halves,
    place_ball,
    sign_up,
)
from .set_mode import award, set_mode
from .shoot_out import rule_shoot_out

SAY_GOAL = int(Announcement.GOAL)
ILLEGAL_DEFENSE_X = 41.5
"""|x| of the free kick after an illegal defence."""
OFFSIDE_MARGIN = 1.0
"""The ball of an offside call is at least this far inside the pitch."""


@kernel
def offside_place(p, x, y):
    """Where the ball is put for an offside whose stored point is (x, y)."""
    if abs(x) > p.goal_line or (abs(x) >= GOAL_AREA_X and abs(y) <= GOAL_AREA_Y):
        return sign_up(x) * GOAL_AREA_X, sign_up(y) * GOAL_AREA_Y
    half_x, half_y = p.goal_line - OFFSIDE_MARGIN, p.touch_line - OFFSIDE_MARGIN
    if abs(x) > half_x or abs(y) > half_y:
        return nearest_edge(x, y, half_x, half_y)
    return x, y


@kernel
def place_of(p, ruling, side, x, y):
    """Where the ball is put for a ruling at (x, y)."""
    if ruling == RULING_OFFSIDE:
        return offside_place(p, x, y)
    if ruling == RULING_GOAL_KICK:
        return -side * GOAL_AREA_X, sign_up(y) * GOAL_AREA_Y
    if ruling == RULING_CORNER_KICK:
        return side * (p.goal_line - p.ckick_margin), sign_up(y) * (p.touch_line - p.ckick_margin)
    if ruling == RULING_ILLEGAL_DEFENSE:
        return -side * ILLEGAL_DEFENSE_X, 0.0
    x, y = clamp_pitch(p, x, y)
    if ruling == RULING_KICK_IN:
        return x, sign_up(y) * p.touch_line
    if ruling == RULING_FREE_KICK:
        return out_of_penalty_area(-side, x, y)
    if ruling == RULING_BACK_PASS:
        return out_of_goal_area(side, x, y)
    if ruling == RULING_FOUL:
        x, y = out_of_goal_area(NEUTRAL, x, y)
        return out_of_penalty_area(-side, x, y)
    if ruling == RULING_DROP_BALL:
        return out_of_penalty_area(NEUTRAL, x, y)
    return out_of_penalty_area(side, x, y)


@kernel
def new_mode(ruling, side):
    """(play mode, side that gets the ball) of a ruling for or against `side`."""
    if ruling == RULING_FREE_KICK:
        return of_side(FREE_KICK, side), side
    if ruling == RULING_GOAL_KICK:
        return of_side(GOAL_KICK, side), side
    if ruling == RULING_CORNER_KICK:
        return of_side(CORNER_KICK, side), side
    if ruling == RULING_KICK_IN:
        return of_side(KICK_IN, side), side
    if ruling == RULING_DROP_BALL:
        return DROP_BALL, NEUTRAL
    if ruling == RULING_OFFSIDE:
        return of_side(OFFSIDE, side), -side
    if ruling == RULING_FREE_KICK_FAULT:
        return of_side(FREE_KICK_FAULT, side), -side
    if ruling == RULING_BACK_PASS:
        return of_side(BACK_PASS, side), -side
    if ruling == RULING_CATCH_FAULT:
        return of_side(CATCH_FAULT, side), -side
    if ruling == RULING_FOUL:
        return of_side(FOUL_CHARGE, side), -side
    return of_side(ILLEGAL_DEFENSE, side), -side


@kernel
def rule_place(w, p, ruling, side, x, y):
    """A ruling that puts the ball somewhere and sets a mode."""
    if ruling != RULING_FREE_KICK:
        w.ball_catcher = 0
    if ruling == RULING_BACK_PASS:
        w.wait[WAIT_BACK_PASS] = 0
    elif ruling == RULING_CATCH_FAULT:
        w.wait[WAIT_CATCH_FAULT] = 0
    elif ruling == RULING_OFFSIDE:
        w.offside_point[0], w.offside_point[1] = x, y
    mode, beneficiary = new_mode(ruling, side)
    x, y = place_of(p, ruling, side, x, y)
    award(w, p, mode, beneficiary, x, y)
    if ruling == RULING_OFFSIDE:
        forget_candidates(w)
        field_clamp(w, p)
    elif ruling == RULING_DROP_BALL:
        field_clamp(w, p)
        if not is_shoot_out(w.mode):
            w.ruling, w.ruling_side = RULING_MODE, PLAY_ON


@kernel
def score_goal(w, p, side):
    """A goal of `side`: the ball stays in the net."""
    team = team_of(side)
    w.score[team] += 1
    announce(w, SAY_GOAL, side, w.score[team], 0)
    w.goal_wait = 0
    place_ball(w, -side, w.pos[0, 0], w.pos[0, 1])
    over = p.golden_goal and p.half_time >= 0 and w.time >= p.normal_cycles
    return TIME_OVER if over else of_side(GOAL, side)


@kernel
def begin_pause(w, p):
    """The part of a half-time call before the mode changes."""
    w.ball_catcher = 0
    place_ball(w, LEFT if w.half_count % 2 == 0 else RIGHT, 0.0, 0.0)


@kernel
def end_pause(w, p, time):
    """The part of a half-time call after the mode has changed."""
    w.time = time
    if w.half_count == p.nr_normal_halfs:
        for i in range(22):
            if w.enabled[i]:
                w.capacity[i] = p.stamina_capacity
    w.wind[0], w.wind[1] = -w.wind[0], -w.wind[1]
    own_halves(w, p)


@kernel
def rule_mode(w, p, ruling, side):
    """A ruling that sets a mode and leaves the ball, or puts it to the centre."""
    mode = side
    if ruling == RULING_GOAL:
        mode = score_goal(w, p, side)
    elif ruling == RULING_KICK_OFF:
        place_ball(w, side, 0.0, 0.0)
        mode = of_side(KICK_OFF, side)
    elif ruling == RULING_HALF_TIME:
        begin_pause(w, p)
        mode = BEFORE_KICK_OFF
    set_mode(w, p, mode)
    if ruling == RULING_KICK_OFF:
        own_halves(w, p)
    elif ruling == RULING_HALF_TIME:
        end_pause(w, p, side)


@kernel
def carry_out(w, p):
    """Do what was decided, and what is decided while it is done."""
    while w.ruling != RULING_NONE:
        ruling, side = w.ruling, w.ruling_side
        x, y = w.ruling_pos[0], w.ruling_pos[1]
        w.ruling = RULING_NONE
        if ruling == RULING_MODE or RULING_GOAL <= ruling <= RULING_HALF_TIME:
            rule_mode(w, p, ruling, side)
        elif ruling <= RULING_ILLEGAL_DEFENSE:
            rule_place(w, p, ruling, side, x, y)
        else:
            rule_shoot_out(w, p, ruling, side)
