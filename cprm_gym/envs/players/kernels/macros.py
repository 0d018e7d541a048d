"""Kernels of the macro actions: what each means for one cycle, and when it can be done at all.

The set is that of HFO's mid and high level (Hausknecht et al. 2016); a macro is carried out from the player's own memory.
"""

from __future__ import annotations

import math

from ....simulator.state import CommandKind, PlayMode
from . import kernel
from .keepers import hold, receive
from .memory import D2R, NEVER, norm
from .motion import (
    GOAL_X,
    ball_distance,
    chase,
    clear,
    kick_to,
    kickable,
    look_to,
    pass_speed,
    run_to,
    search,
    turn_to,
)
from .team import best_shot, dribble, home

CATCH, MOVE, PLAY_ON = int(CommandKind.CATCH), int(CommandKind.MOVE), int(PlayMode.play_on)
NOOP, REORIENT, GO_TO_BALL, INTERCEPT, MOVE_TO, DRIBBLE, SHOOT, HOLD, DEFEND_GOAL, CATCH_BALL, RECEIVE, FIRST_PASS = range(12)


@kernel
def applicable(w, m, i, mates, opponents, mask):
    """Which macros can be done now; `mask` has 11 + mates + opponents entries."""
    with_ball = kickable(m)
    sees = m.ball_age < 10
    mask[NOOP] = True
    mask[REORIENT] = True
    mask[GO_TO_BALL] = sees and not with_ball
    mask[INTERCEPT] = sees and not with_ball
    mask[MOVE_TO] = not with_ball
    mask[DRIBBLE] = with_ball
    mask[SHOOT] = with_ball
    mask[HOLD] = with_ball
    mask[DEFEND_GOAL] = not with_ball
    mask[CATCH_BALL] = (
        w.goalie[i] == 1 and w.mode == PLAY_ON and w.catch_ban[i] == 0 and m.ball_age <= 1 and ball_distance(m) < m.catch_reach + 0.3
    )
    mask[RECEIVE] = not with_ball
    own = i % 11
    for k in range(mates):
        other = k if k < own else k + 1
        mask[FIRST_PASS + k] = with_ball and m.age[other] < 20
    for k in range(opponents):
        mask[FIRST_PASS + mates + k] = not with_ball and m.age[11 + k] < 30


@kernel
def perform(w, m, c, i, macro, mates, formation, half_x, half_y, fresh):
    """The command of one cycle of a macro."""
    clear(c)
    if not m.free:
        return
    if macro == NOOP:
        return
    if macro == REORIENT or (m.ball_age >= NEVER and macro != CATCH_BALL):
        search(m, c, fresh)
        return
    me = i % 11
    if macro == GO_TO_BALL:
        if run_to(m, c, m.ball_x, m.ball_y, 100.0, 0.5):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    elif macro == INTERCEPT:
        chase(m, c, 100.0)
    elif macro == MOVE_TO:
        x, y = home(m, formation, me, 4.0, True)
        if run_to(m, c, x, y, 80.0, 1.0):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    elif macro == DRIBBLE:
        dribble(m, c, 2)
    elif macro == SHOOT:
        y, _ = best_shot(m)
        kick_to(m, c, GOAL_X + 1.0, y, m.ball_speed)
    elif macro == HOLD:
        hold(m, c)
    elif macro == DEFEND_GOAL:
        gx = -GOAL_X
        dx, dy = m.ball_x - gx, m.ball_y
        d = max(0.5, math.sqrt(dx * dx + dy * dy))
        y = min(m.goal_half, max(-m.goal_half, 3.0 * dy / d))
        if run_to(m, c, gx + 3.0 * max(0.3, dx / d), y, 100.0, 0.4):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    elif macro == CATCH_BALL:
        c.kind = CATCH
        c.a = norm(math.atan2(m.ball_y - m.y, m.ball_x - m.x) - m.body) / D2R
        return
    elif macro == RECEIVE:
        receive(m, c, me, mates + 1, half_x, half_y, fresh)
        return
    elif macro < FIRST_PASS + mates:
        k = macro - FIRST_PASS
        other = k if k < me else k + 1
        dx, dy = m.px[other] - m.ball_x, m.py[other] - m.ball_y
        kick_to(m, c, m.px[other], m.py[other], pass_speed(m, math.sqrt(dx * dx + dy * dy), 1.1))
    else:
        mark(m, c, 11 + macro - FIRST_PASS - mates)
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def mark(m, c, opponent):
    """Stand between an opponent and the own goal."""
    dx, dy = -GOAL_X - m.px[opponent], -m.py[opponent]
    d = max(0.5, math.sqrt(dx * dx + dy * dy))
    if run_to(m, c, m.px[opponent] + 1.5 * dx / d, m.py[opponent] + 1.5 * dy / d, 90.0, 0.7):
        turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))


@kernel
def masks(worlds, chosen, memory, players, mates, opponents, out):
    """Applicability of every macro in the chosen worlds, ``out`` (W, A, macros); mates and opponents: (A,) numbers of other players."""
    for n in chosen:
        for k in range(players.shape[0]):
            i = players[k] - 1
            out[n, k] = False
            if worlds[n].enabled[i]:
                applicable(worlds[n], memory[n, i], i, mates[k], opponents[k], out[n, k])
            else:
                out[n, k, NOOP] = True


@kernel
def act(worlds, memory, players, macros, mates, formation, half_x, half_y, fresh, commands):
    """Commands of one cycle of the macros (W, A) of the players; ``commands`` (W, 22)."""
    for n in range(worlds.shape[0]):
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k] - 1
            if w.enabled[i]:
                m = memory[n, i]
                m.left = 1 if i < 11 else 0
                perform(w, m, commands[n, i], i, macros[n, k], mates[k], formation, half_x, half_y, fresh[n, i])
