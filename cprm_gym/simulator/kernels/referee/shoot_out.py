"""The penalty shoot-out (specification/simulator.md 7.14): one side after the other shoots at the goal on ``pen_side``."""

from __future__ import annotations

from ...pitch import CENTRE_RADIUS, PENALTY_Y
from ...state import Announcement
from .. import kernel
from ..geometry import in_circle, in_penalty_area, side_of
from ..random import PENALTY_SIDE, PENALTY_TAKER, PENALTY_WINNER, REFEREE, bernoulli, decide
from .modes import (
    BEFORE_KICK_OFF,
    LEFT,
    NEUTRAL,
    PAIR,
    PENALTY_MISS,
    PENALTY_READY,
    PENALTY_SCORE,
    PENALTY_SETUP,
    PENALTY_TAKEN,
    RIGHT,
    RULING_MODE,
    RULING_NONE,
    RULING_PENALTY_FOUL,
    RULING_PENALTY_MISS,
    RULING_PENALTY_SCORE,
    RULING_PENALTY_SETUP,
    SIDE,
    TIME_OVER,
    announce,
    of_side,
    rule,
    team_of,
)
from .places import (
    nearest_on_circle,
    place_ball,
    radius_of,
    sign_up,
)
from .set_mode import award, set_mode

SAY_ONFIELD = int(Announcement.PENALTY_ONFIELD)
SAY_FOUL = int(Announcement.PENALTY_FOUL)
SAY_WINNER = int(Announcement.PENALTY_WINNER)
SAY_DRAW = int(Announcement.PENALTY_DRAW)
NEAR_BALL = 2.0
"""The taker stands within this distance of the ball."""
WAITING_X, WAITING_Y = 54.5, 25.0
"""Where the goalie of the shooting side waits, 2 m around."""
MARGIN = 1.5


@kernel
def who_shoots(w):
    """The side that shoots. In a mode that a trainer has set without a shoot-out nobody does, until something happens."""
    if w.pen_taker_side == NEUTRAL:
        w.pen_taker_side = SIDE[w.mode]
    return w.pen_taker_side


# --- who stands where


@kernel
def goalie_of(w, side):
    """Index of the enabled goalie of `side`, -1 when there is none."""
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if w.enabled[i] and w.goalie[i]:
            return i
    return -1


@kernel
def distance_squared(w, i, x, y):
    """Squared distance of player `i` from a point."""
    dx, dy = w.pos[i + 1, 0] - x, w.pos[i + 1, 1] - y
    return dx * dx + dy * dy


@kernel
def stands_in_circle(w, i, x, y, radius):
    """Player `i` is in a circle round (x, y)."""
    return in_circle(w.pos[i + 1, 0], w.pos[i + 1, 1], x, y, radius)


@kernel
def near_ball(w, i):
    """Player `i` is within 2 m of the ball."""
    return stands_in_circle(w, i, w.pos[0, 0], w.pos[0, 1], NEAR_BALL)


@kernel
def outside_circle(w, p, i):
    """Player `i` is not inside the centre circle."""
    return not stands_in_circle(w, i, 0.0, 0.0, CENTRE_RADIUS - radius_of(w, p, i))


@kernel
def takers_stand_right(w, p, side, goalie, outside, taker):
    """The shooting side: one player at most outside the circle, who takes the kick; the goalie beside the goal."""
    if outside == 0:
        return True
    x, y = abs(w.pos[goalie + 1, 0]), abs(w.pos[goalie + 1, 1])
    if outside > 1 or x < p.goal_line - MARGIN or y < PENALTY_Y - MARGIN:
        return False
    return PAIR[w.mode] != PENALTY_SETUP or near_ball(w, taker)


@kernel
def keepers_stand_right(w, p, goalie, outside):
    """The other side: the goalie in front of his goal until the kick is taken, the others in the circle."""
    if outside > 0:
        return False
    if PAIR[w.mode] == PENALTY_TAKEN:
        return True
    in_line = abs(w.pos[goalie + 1, 1]) <= 0.5 * p.goal_width
    return in_line and abs(w.pos[goalie + 1, 0]) >= p.goal_line - p.pen_max_goalie_dist_x


@kernel
def stands_right(w, p, side):
    """All players of `side` are where the present phase of the shoot-out wants them."""
    pair = PAIR[w.mode]
    if pair == PENALTY_MISS or pair == PENALTY_SCORE:
        return True
    goalie = goalie_of(w, side)
    if goalie < 0:
        return False
    outside, taker = 0, -1
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if w.enabled[i] and i != goalie and outside_circle(w, p, i):
            outside += 1
            taker = i
    if side != w.pen_taker_side:
        return keepers_stand_right(w, p, goalie, outside)
    if outside == 0 and pair == PENALTY_SETUP and near_ball(w, goalie):
        taker = goalie
    if not takers_stand_right(w, p, side, goalie, outside, taker):
        return False
    return pair != PENALTY_SETUP or taker < 0 or not w.pen_used[taker]


@kernel
def next_taker(w, side):
    """Who is put to the ball: the last taker, else the nearest field player who has not shot yet, else the goalie."""
    if w.pen_last_taker != 0 and side_of(w.pen_last_taker - 1) == side:
        return w.pen_last_taker - 1
    best, nearest = -1, 0.0
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if w.enabled[i] and not w.goalie[i] and not w.pen_used[i]:
            d = distance_squared(w, i, w.pos[0, 0], w.pos[0, 1])
            if best < 0 or d < nearest:
                best, nearest = i, d
    return best if best >= 0 else goalie_of(w, side)


@kernel
def pull_to_circle(w, i, x, y, radius):
    """A player outside a circle goes to its nearest point; his velocity is kept."""
    if not stands_in_circle(w, i, x, y, radius):
        w.pos[i + 1, 0], w.pos[i + 1, 1] = nearest_on_circle(w.pos[i + 1, 0], w.pos[i + 1, 1], x, y, radius)


@kernel
def reposition_goalie(w, p, i):
    """The goalie of the side that does not shoot goes back to his goal."""
    line = p.goal_line - p.pen_max_goalie_dist_x
    if -w.pen_side * w.pos[i + 1, 0] < line:
        w.pos[i + 1, 0], w.pos[i + 1, 1] = -w.pen_side * (line + MARGIN), 0.0


@kernel
def reposition(w, p, side):
    """Put the players of `side` where they belong (positions only)."""
    shooting = side == w.pen_taker_side
    waiting = PAIR[w.mode] != PENALTY_TAKEN
    taker = next_taker(w, side) if shooting else -1
    start = 0 if side == LEFT else 11
    for i in range(start, start + 11):
        if not w.enabled[i]:
            continue
        if i == taker:
            if waiting:
                pull_to_circle(w, i, w.pos[0, 0], w.pos[0, 1], NEAR_BALL)
        elif w.goalie[i] and shooting:
            pull_to_circle(w, i, -w.pen_side * WAITING_X, sign_up(w.pos[i + 1, 1]) * WAITING_Y, NEAR_BALL)
        elif w.goalie[i]:
            if waiting:
                reposition_goalie(w, p, i)
        else:
            pull_to_circle(w, i, 0.0, 0.0, CENTRE_RADIUS - radius_of(w, p, i))


# --- rulings


@kernel
def freeze_ball(w):
    """The ball stops where it is."""
    place_ball(w, w.pen_taker_side, w.pos[0, 0], w.pos[0, 1])


@kernel
def next_kick(w, p):
    """It is the other side's turn."""
    w.pen_taker_side = -w.pen_taker_side
    x = -w.pen_side * (p.goal_line - p.pen_dist_x)
    award(w, p, of_side(PENALTY_SETUP, w.pen_taker_side), NEUTRAL, x, 0.0)


@kernel
def start_shoot_out(w, p):
    """Choose the goal and the first side; the goalie of the side without that goal is put beside it."""
    w.pen_started = 1
    w.pen_side = LEFT if decide(w, w.forced_pen_side, REFEREE, -1, PENALTY_SIDE, 0, 0.5) else RIGHT
    announce(w, SAY_ONFIELD, w.pen_side, 0, 0)
    w.pen_taker_side = LEFT if decide(w, w.forced_pen_taker, REFEREE, -1, PENALTY_TAKER, 0, 0.5) else RIGHT
    goalie = goalie_of(w, -w.pen_side)
    if goalie >= 0:
        w.pos[goalie + 1, 0], w.pos[goalie + 1, 1] = -w.pen_side * (p.goal_line - 10.0), 10.0
    w.ruling = RULING_PENALTY_SETUP


@kernel
def announce_winner(w, side):
    """Say who won; the match ends with the next step."""
    announce(w, SAY_WINNER, side, 0, 0)
    w.pen_finished = 1


@kernel
def decide_shoot_out(w, p):
    """After a kick: is the shoot-out decided? A win of the right side ends it at once, of the left with the next step."""
    kicks, left, right = w.pen_number, w.pen_score[0], w.pen_score[1]
    if kicks > 2 * (p.pen_nr_kicks + p.pen_max_extra_kicks):
        if p.pen_random_winner:
            announce_winner(w, LEFT if bernoulli(w, REFEREE, -1, PENALTY_WINNER, 0, 0.5) else RIGHT)
        else:
            announce(w, SAY_DRAW, 0, 0, 0)
            w.pen_finished = 1
    elif kicks > 2 * p.pen_nr_kicks:
        if kicks % 2 == 0 and left != right:
            announce_winner(w, LEFT if left > right else RIGHT)
    else:
        remaining = p.pen_nr_kicks - kicks // 2
        odd = kicks % 2
        best_left = left + remaining - (odd if w.pen_taker_side == LEFT else 0)
        best_right = right + remaining - (odd if w.pen_taker_side == RIGHT else 0)
        if best_left < right:
            announce(w, SAY_WINNER, RIGHT, 0, 0)
            set_mode(w, p, TIME_OVER)
        elif best_right < left:
            announce_winner(w, LEFT)


@kernel
def record_kick(w, p, scored):
    """The kick of the present side is over."""
    side = w.pen_taker_side
    set_mode(w, p, of_side(PENALTY_SCORE if scored else PENALTY_MISS, side))
    if scored:
        w.pen_score[team_of(side)] += 1
    else:
        w.pen_miss[team_of(side)] += 1
    w.pen_number += 1
    decide_shoot_out(w, p)


@kernel
def rule_shoot_out(w, p, ruling, side):
    """Carry out a decision of this module."""
    shooting = who_shoots(w)
    if ruling == RULING_PENALTY_SETUP:
        next_kick(w, p)
        return
    scored = ruling == RULING_PENALTY_SCORE
    if ruling == RULING_PENALTY_FOUL:
        announce(w, SAY_FOUL, side, 0, 0)
        scored = side != shooting
    record_kick(w, p, scored)


# --- events; each leaves at most one ruling


@kernel
def foul(w, side):
    """Note a foul of `side`."""
    rule(w, RULING_PENALTY_FOUL, side, 0.0, 0.0)


@kernel
def kicked_in_shoot_out(w, p, i):
    """Player `i` plays the ball; true when this is the kick that starts the attempt."""
    pair, side, shooting = PAIR[w.mode], side_of(i), who_shoots(w)
    if pair == PENALTY_SETUP:
        foul(w, side)
    elif pair == PENALTY_TAKEN and side == shooting and not p.pen_allow_mult_kicks:
        foul(w, shooting)
    elif pair == PENALTY_READY or pair == PENALTY_TAKEN:
        if pair == PENALTY_READY and side == shooting and w.pen_used[i]:
            foul(w, shooting)
        elif w.pen_last_taker != 0 and side_of(w.pen_last_taker - 1) == shooting and w.pen_last_taker != i + 1:
            foul(w, shooting)
        elif side != shooting and not w.goalie[i]:
            foul(w, -shooting)
        else:
            w.pen_last_taker = i + 1
    return pair == PENALTY_READY and w.ruling == RULING_NONE


@kernel
def use_taker(w, i):
    """Player `i` has had his kick; when all eleven have, everybody may shoot again."""
    start = 0 if w.pen_taker_side == LEFT else 11
    w.pen_used[start + i % 11] = 1
    for j in range(start, start + 11):
        if not w.pen_used[j]:
            return
    for j in range(start, start + 11):
        w.pen_used[j] = 0


@kernel
def caught_in_shoot_out(w, p, i):
    """Goalie `i` caught or punched the ball."""
    pair, side = PAIR[w.mode], side_of(i)
    if pair == PENALTY_TAKEN:
        if side == who_shoots(w):
            foul(w, side)
        elif not in_penalty_area(p, w.pen_side, w.pos[0, 0], w.pos[0, 1]):
            foul(w, side)
        else:
            w.ruling = RULING_PENALTY_MISS
    elif pair == PENALTY_READY:
        foul(w, side)


@kernel
def shoot_out_is_due(w, p):
    """The match is over, level, and goes to penalties."""
    if w.pen_started or not p.penalty_shoot_outs or w.mode == BEFORE_KICK_OFF or w.score[0] != w.score[1]:
        return False
    if p.half_time < 0:
        return p.nr_normal_halfs <= 0 and p.nr_extra_halfs <= 0
    return w.time >= p.total_cycles


@kernel
def watch_ball(w, p, crossed):
    """While everybody stands right: did the ball go in (`crossed`) or out?"""
    out = abs(w.pos[0, 0]) > p.out_x or abs(w.pos[0, 1]) > p.out_y
    if not crossed and not out:
        return
    if PAIR[w.mode] == PENALTY_TAKEN:
        w.ruling = RULING_PENALTY_SCORE if crossed else RULING_PENALTY_MISS
    freeze_ball(w)


@kernel
def phase_ends(w, p, bad):
    """The timer of the present phase has run out; `bad`: the side that stands wrong, NEUTRAL when none does."""
    pair = PAIR[w.mode]
    if pair == PENALTY_SETUP:
        if bad == NEUTRAL:
            rule(w, RULING_MODE, of_side(PENALTY_READY, who_shoots(w)), 0.0, 0.0)
        else:
            foul(w, bad)
    elif pair == PENALTY_READY or pair == PENALTY_TAKEN:
        w.ruling = RULING_PENALTY_MISS
    else:
        w.ruling = RULING_PENALTY_SETUP


@kernel
def shoot_out_step(w, p, crossed):
    """One step of the shoot-out; `crossed`: the ball crossed the goal line of ``pen_side`` in this step."""
    if w.pen_finished:
        rule(w, RULING_MODE, TIME_OVER, 0.0, 0.0)
        return
    pair = PAIR[w.mode]
    running = pair == PENALTY_READY or pair == PENALTY_TAKEN
    moves = p.pen_coach_moves_players and (running or (pair == PENALTY_SETUP and w.pen_timer == 0))
    bad = NEUTRAL
    first = w.pen_taker_side if w.pen_taker_side != NEUTRAL else SIDE[w.mode]
    for k in range(2):
        side = first if k == 0 else -first
        if not stands_right(w, p, side):
            if moves:
                reposition(w, p, side)
            elif bad == NEUTRAL:
                bad = side
    if w.pen_timer == 0:
        phase_ends(w, p, bad)
        return
    w.pen_timer -= 1
    if pair == PENALTY_MISS or pair == PENALTY_SCORE:
        freeze_ball(w)
    elif bad == NEUTRAL:
        watch_ball(w, p, crossed)
    elif running:
        foul(w, bad)
