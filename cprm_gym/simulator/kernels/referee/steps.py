"""What the modules Time, BallStuck, Offside, FreeKick and IllegalDefense do in each step (specification/simulator.md 7.4 to 7.7, 7.11)."""

from __future__ import annotations

from ...pitch import PENALTY_X, PENALTY_Y
from ...state import Announcement
from .. import kernel
from ..geometry import clip, in_circle, in_penalty_area, length
from .modes import (
    BACK_PASS,
    BEFORE_KICK_OFF,
    BIT_DISCARD,
    BIT_ILLEGAL_DEFENSE,
    CATCH_FAULT,
    FREE_KICK,
    FREE_KICK_FAULT,
    GOAL,
    GOAL_KICK,
    ILLEGAL_DEFENSE,
    KICK_OFF,
    LEFT,
    NEUTRAL,
    OFFSIDE,
    PAIR,
    PLAY_ON,
    RIGHT,
    RULING_DROP_BALL,
    RULING_FREE_KICK,
    RULING_GOAL_KICK,
    RULING_HALF_TIME,
    RULING_ILLEGAL_DEFENSE,
    RULING_MODE,
    SIDE,
    TIME_OVER,
    WAIT_FREE_KICK_FAULT,
    WAIT_ILLEGAL_DEFENSE,
    WAIT_OFFSIDE,
    announce,
    is_set_play,
    is_shoot_out,
    is_stopped,
    rule,
    rule_here,
    team_of,
)
from .offside import forget_candidates
from .places import (
    clear_ball,
    field_clamp,
    nearest_on_circle,
    own_halves,
    radius_of,
)
from .waits import clear_offenders, end_stoppage, restart

SAY_HALF_TIME = int(Announcement.HALF_TIME)
SAY_TIME_EXTENDED = int(Announcement.TIME_EXTENDED)
SAY_TIME_UP = int(Announcement.TIME_UP)
SAY_WITHOUT_A_TEAM = int(Announcement.TIME_UP_WITHOUT_A_TEAM)


# --- Time


@kernel
def team_exists(w, side):
    """Some player of `side` takes part, or did until he was sent off."""
    start = 0 if side == LEFT else 11
    players = 0
    for i in range(start, start + 11):
        if w.enabled[i] or w.bits[i] & BIT_DISCARD:
            players += 1
    return players > 0


@kernel
def end_match(w, kind):
    """The match is over."""
    announce(w, kind, 0, 0, 0)
    rule(w, RULING_MODE, TIME_OVER, 0.0, 0.0)


@kernel
def call_half_time(w, kind, time):
    """A half is over."""
    w.half_count += 1
    announce(w, kind, 0, 0, 0)
    rule(w, RULING_HALF_TIME, time, 0.0, 0.0)


@kernel
def time_step(w, p):
    """Ends of halves and of the match."""
    if p.half_time <= 0 or w.mode == BEFORE_KICK_OFF or w.mode == TIME_OVER or is_stopped(w.mode):
        return
    level = w.score[0] == w.score[1]
    if w.time >= p.total_cycles:
        if not (p.penalty_shoot_outs and level):
            end_match(w, SAY_TIME_UP)
    elif w.time >= p.normal_cycles:
        extra = w.half_count + 1 - p.nr_normal_halfs
        if not (team_exists(w, LEFT) and team_exists(w, RIGHT)):
            end_match(w, SAY_WITHOUT_A_TEAM)
        elif p.golden_goal and not level:
            end_match(w, SAY_TIME_UP)
        elif w.time >= p.normal_cycles + p.extra_half_cycles * extra:
            if extra == 0 and not level:
                end_match(w, SAY_TIME_UP)
            else:
                call_half_time(w, SAY_TIME_EXTENDED, p.normal_cycles + p.extra_half_cycles * extra)
    elif w.time >= p.half_cycles * (w.half_count + 1):
        call_half_time(w, SAY_HALF_TIME, p.half_cycles * (w.half_count + 1))


# --- BallStuck


@kernel
def ball_stuck_step(w, p):
    """A ball that stays within a small area of play for too long is dropped."""
    if p.ball_stuck_area <= 0.0 or p.drop_ball_time <= 0:
        return
    if w.mode == PLAY_ON:
        dx, dy = w.pos[0, 0] - w.stuck_pos[0], w.pos[0, 1] - w.stuck_pos[1]
        if length(dx, dy) <= p.ball_stuck_area:
            w.stuck_count += 1
            if w.stuck_count < p.drop_ball_time:
                return
            rule_here(w, RULING_DROP_BALL, NEUTRAL)
    w.stuck_pos[0], w.stuck_pos[1] = w.pos[0, 0], w.pos[0, 1]
    w.stuck_count = 0


# --- Offside


@kernel
def push_back(w, p, side):
    """Players of the offside team leave the place of the offence and go behind its line (positions only)."""
    sx, sy = w.offside_point[0], w.offside_point[1]
    radius = p.offside_active_area_size
    goal = -side * p.goal_line
    low, high = min(goal, sx), max(goal, sx)
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if not w.enabled[i]:
            continue
        x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
        if in_circle(x, y, sx, sy, radius):
            x, y = nearest_on_circle(x, y, sx, sy, radius)
        if not low <= x <= high or abs(y) > p.touch_line:
            edge = low if abs(x - low) < abs(x - high) else high
            x, y = edge - side * p.offside_kick_margin, clip(-p.touch_line, y, p.touch_line)
        w.pos[i + 1, 0], w.pos[i + 1, 1] = x, y


@kernel
def offside_step(w, p):
    """Keep teams in their halves before and at kick-off; wait after an offside."""
    pair = PAIR[w.mode]
    if w.mode == PLAY_ON or is_shoot_out(w.mode):
        return
    if w.mode == BEFORE_KICK_OFF or pair == KICK_OFF:
        if p.forbid_kick_off_offside:
            own_halves(w, p)
    elif pair == OFFSIDE:
        clear_offenders(w, p, WAIT_OFFSIDE)
        push_back(w, p, SIDE[w.mode])
        restart(w, WAIT_OFFSIDE, FREE_KICK)
    else:
        forget_candidates(w)


# --- FreeKick


@kernel
def clear_penalty_area(w, p, side):
    """At a goal kick of `side` the opponents leave its penalty area (positions only)."""
    start = 11 if side == LEFT else 0
    for i in range(start, start + 11):
        if not w.enabled[i]:
            continue
        margin = radius_of(w, p, i)
        depth, y = -side * w.pos[i + 1, 0], w.pos[i + 1, 1]
        front, back, half = PENALTY_X - margin, p.goal_line + margin, PENALTY_Y + margin
        if depth < front or depth > back or abs(y) > half:
            continue
        if min(depth - front, back - depth) < half - abs(y):
            depth = front if depth - front < back - depth else back
        else:
            y = half if y > 0.0 else -half
        if depth >= p.goal_line:
            depth = front
        w.pos[i + 1, 0], w.pos[i + 1, 1] = -side * depth, y


@kernel
def count_down(w):
    """One step of a set play's timer; when it has run out the ball is dropped."""
    if w.fk_timer >= 0:
        w.fk_timer -= 1
    if w.fk_timer == 0:
        rule_here(w, RULING_DROP_BALL, NEUTRAL)


@kernel
def goal_kick_step(w, p):
    """A goal kick lasts until the ball leaves the penalty area."""
    side = SIDE[w.mode]
    clear_penalty_area(w, p, side)
    field_clamp(w, p)
    if not in_penalty_area(p, NEUTRAL, w.pos[0, 0], w.pos[0, 1]):
        rule(w, RULING_MODE, PLAY_ON, 0.0, 0.0)
    elif w.fk_taken and p.proper_goal_kicks:
        if length(w.vel[0, 0], w.vel[0, 1]) < p.stopped_ball_vel:
            if w.fk_goal_count >= p.max_goal_kicks:
                rule_here(w, RULING_FREE_KICK, -side)
            else:
                rule_here(w, RULING_GOAL_KICK, side)
    else:
        count_down(w)


@kernel
def free_kick_step(w, p):
    """First part of the module's step; true when the second part is to follow."""
    pair = PAIR[w.mode]
    if is_shoot_out(w.mode) or pair == BACK_PASS or pair == CATCH_FAULT:
        return False
    if pair == FREE_KICK_FAULT:
        end_stoppage(w, p, WAIT_FREE_KICK_FAULT, FREE_KICK)
        return False
    if pair == GOAL_KICK:
        goal_kick_step(w, p)
        return False
    moving = w.vel[0, 0] != 0.0 or w.vel[0, 1] != 0.0
    if moving and w.mode != PLAY_ON and w.mode != BEFORE_KICK_OFF and w.mode != TIME_OVER and not is_stopped(w.mode):
        rule(w, RULING_MODE, PLAY_ON, 0.0, 0.0)
    return True


@kernel
def keep_distance(w, p, mode):
    """Second part; `mode` is that at its beginning. Opponents keep away from the ball, also before kick-off and after goals."""
    field_clamp(w, p)
    if mode == PLAY_ON or mode == TIME_OVER or (is_stopped(mode) and PAIR[mode] != GOAL):
        return
    clear_ball(w, p, -w.kick_off_side)
    if is_set_play(mode):
        count_down(w)


# --- IllegalDefense


@kernel
def defenders_in_zone(w, p, side):
    """Players of `side` in front of their goal while the others attack; they are marked."""
    if w.illegal_side != -side or w.pos[0, 0] * side >= 0.0:
        return 0
    count = 0
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if w.enabled[i] and w.pos[i + 1, 0] * side < p.illegal_defense_dist_x - p.goal_line:
            if abs(w.pos[i + 1, 1]) < 0.5 * p.illegal_defense_width:
                w.bits[i] |= BIT_ILLEGAL_DEFENSE
                count += 1
    return count


@kernel
def unmark_defenders(w, side):
    """Nobody of `side` counts as defending illegally."""
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        w.bits[i] &= ~BIT_ILLEGAL_DEFENSE


@kernel
def illegal_defense_step(w, p):
    """Too many defenders in front of their goal for too long."""
    if p.illegal_defense_number <= 0:
        return
    if PAIR[w.mode] == ILLEGAL_DEFENSE:
        end_stoppage(w, p, WAIT_ILLEGAL_DEFENSE, FREE_KICK)
    elif w.mode == PLAY_ON:
        for side in (LEFT, RIGHT):
            team = team_of(side)
            if defenders_in_zone(w, p, side) < p.illegal_defense_number:
                unmark_defenders(w, side)
                w.illegal_count[team] = 0
                continue
            w.illegal_count[team] += 1
            if w.illegal_count[team] >= p.illegal_defense_duration:
                w.illegal_count[team] = 0
                w.ball_catcher = 0
                rule_here(w, RULING_ILLEGAL_DEFENSE, side)
                return
