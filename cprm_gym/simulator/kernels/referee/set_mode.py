"""A change of the play mode and what every module does because of it (specification/simulator.md 7.2)."""

from __future__ import annotations

from ...state import Announcement
from .. import event, kernel
from .keepaway import begin_episode
from .marks import forget_passes, mark_indirect
from .modes import (
    BACK_PASS,
    CATCH_FAULT,
    DROP_BALL,
    FOUL_CHARGE,
    FOUL_PUSH,
    FREE_KICK_FAULT,
    GOAL,
    GOAL_KICK,
    ILLEGAL_DEFENSE,
    NEUTRAL,
    OFFSIDE,
    PAIR,
    PENALTY_MISS,
    PENALTY_READY,
    PENALTY_SCORE,
    PENALTY_SETUP,
    PENALTY_TAKEN,
    PLAY_ON,
    RULE_CATCH,
    RULE_FOUL,
    RULE_FREE_KICK,
    RULE_ILLEGAL_DEFENSE,
    RULE_KEEPAWAY,
    RULE_OFFSIDE,
    RULE_PENALTY,
    RULE_TOUCH,
    SIDE,
    WAIT_BACK_PASS,
    WAIT_CATCH_FAULT,
    WAIT_FOUL,
    WAIT_FREE_KICK_FAULT,
    WAIT_ILLEGAL_DEFENSE,
    WAIT_OFFSIDE,
    announce,
    is_set_play,
    is_shoot_out,
)
from .offside import forget_candidates
from .places import clear_ball, place_ball

SAY_MODE = int(Announcement.MODE)


@kernel
def set_play_begins(w, p, mode):
    """The free-kick module hears of the new mode: keep opponents away, start the timer."""
    pair, side = PAIR[mode], SIDE[mode]
    if mode != PLAY_ON:
        w.fk_taken = 0
    w.fk_timer = -1
    if is_set_play(mode) or pair == GOAL_KICK:
        w.fk_timer = p.drop_ball_time
        clear_ball(w, p, -side)
    elif mode == DROP_BALL:
        clear_ball(w, p, NEUTRAL)
    w.fk_goal_count = w.fk_goal_count + 1 if pair == GOAL_KICK else 0
    if pair == FREE_KICK_FAULT:
        w.wait[WAIT_FREE_KICK_FAULT] = 0
        w.ball_catcher = 0


@kernel
def waits_begin(w, p, mode):
    """The counters of stoppages; of back passes and catch faults only the left ones start here (a quirk of the server)."""
    pair = PAIR[mode]
    if pair == OFFSIDE:
        w.wait[WAIT_OFFSIDE] = 0
    elif mode == BACK_PASS:
        w.wait[WAIT_BACK_PASS] = 0
    elif mode == CATCH_FAULT:
        w.wait[WAIT_CATCH_FAULT] = 0
    elif pair == FOUL_CHARGE or pair == FOUL_PUSH:
        w.wait[WAIT_FOUL] = 0
    elif pair == ILLEGAL_DEFENSE:
        w.wait[WAIT_ILLEGAL_DEFENSE] = 0


@kernel
def shoot_out_timer(w, p, mode):
    """Start the timer of a mode of the shoot-out; without a shoot-out the first one that a trainer sets chooses its opponents' goal."""
    pair = PAIR[mode]
    if w.pen_side == NEUTRAL:
        w.pen_side = -SIDE[mode]
    if pair == PENALTY_SETUP:
        w.pen_timer = p.pen_setup_wait
    elif pair == PENALTY_READY:
        w.pen_timer = p.pen_ready_wait
    elif pair == PENALTY_TAKEN:
        w.pen_timer = p.pen_taken_wait
    elif pair == PENALTY_MISS or pair == PENALTY_SCORE:
        w.pen_timer = p.pen_before_setup_wait
    if pair != PENALTY_TAKEN:
        w.pen_last_taker = 0


@event
def tell_modules(w, p, mode):
    """The event MODE, given to all modules in their order."""
    if p.rules & RULE_OFFSIDE and mode != PLAY_ON:
        forget_candidates(w)
    if p.rules & RULE_FREE_KICK:
        set_play_begins(w, p, mode)
    if p.rules & RULE_TOUCH:
        mark_indirect(w, mode)
    if p.rules & RULE_CATCH and mode != PLAY_ON:
        forget_passes(w)
    if p.rules & (RULE_OFFSIDE | RULE_CATCH | RULE_FOUL | RULE_ILLEGAL_DEFENSE):
        waits_begin(w, p, mode)
    if p.rules & RULE_KEEPAWAY and p.keepaway and mode == PLAY_ON and not w.keepaway_begun:
        begin_episode(w, p)
    if p.rules & RULE_PENALTY and is_shoot_out(mode):
        shoot_out_timer(w, p, mode)


@kernel
def side_with_the_ball(w, mode):
    """``kick_off_side`` in the new mode: who takes a set play; unchanged in modes that are none."""
    pair, side = PAIR[mode], SIDE[mode]
    if is_set_play(mode) or pair == GOAL_KICK:
        return side
    if pair == ILLEGAL_DEFENSE:
        return -side
    return NEUTRAL if mode == DROP_BALL else w.kick_off_side


@kernel
def set_mode(w, p, mode):
    """Change the play mode, tell all modules, then announce it; goals announce themselves with the score."""
    w.mode = mode
    tell_modules(w, p, mode)
    w.kick_off_side = side_with_the_ball(w, mode)
    if mode == PLAY_ON:
        w.last_play_on_start = w.time
    if PAIR[mode] != GOAL:
        announce(w, SAY_MODE, mode, 0, 0)


@kernel
def award(w, p, mode, side, x, y):
    """Give the ball at (x, y) to `side` in a new mode; a shoot-out is never interrupted by play_on or drop_ball."""
    place_ball(w, side, x, y)
    if not (is_shoot_out(w.mode) and (mode == PLAY_ON or mode == DROP_BALL)):
        set_mode(w, p, mode)
