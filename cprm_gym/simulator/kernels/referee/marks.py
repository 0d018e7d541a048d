"""What the referee remembers of kicks, tackles and touches, and what he decides at once because of them.

One handler per module and event. A handler changes memory and may note a ruling; it never moves anybody, so that it can be
called from a collision resolution that is itself part of a ruling.
"""

from __future__ import annotations

from ...state import Count
from .. import kernel
from ..geometry import side_of
from .modes import (
    BIT_FREE_KICK_FAULT,
    DROP_BALL,
    GOAL_KICK,
    INDIRECT_FREE_KICK,
    NEUTRAL,
    OFFSIDE,
    PAIR,
    PLAY_ON,
    RULING_FREE_KICK_FAULT,
    RULING_GOAL_KICK,
    RULING_MODE,
    SIDE,
    is_shoot_out,
    rule,
    rule_here,
    team_of,
)

DASHES = int(Count.DASH)


# --- set plays


@kernel
def remember_taker(w, i):
    """Player `i` has taken the set play."""
    w.fk_taken = 1
    w.fk_taker = i + 1
    w.fk_taker_dashes = w.counts[i, DASHES]


@kernel
def call_free_kick_fault(w, i):
    """The taker played the ball a second time before anybody else."""
    w.bits[i] |= BIT_FREE_KICK_FAULT
    rule_here(w, RULING_FREE_KICK_FAULT, side_of(i))


@kernel
def mark_goal_kick(w, p, i):
    """Player `i` plays the ball during a goal kick; true when he counts as its taker afterwards."""
    side = SIDE[w.mode]
    if side_of(i) != side:
        w.fk_goal_count = -1
        w.fk_taken = 0
        rule_here(w, RULING_GOAL_KICK, side)
        return False
    if w.fk_taken and w.fk_taker != i + 1:
        if p.proper_goal_kicks:
            rule_here(w, RULING_GOAL_KICK, side)
    elif w.fk_taken and w.counts[i, DASHES] != w.fk_taker_dashes:
        if p.free_kick_faults:
            call_free_kick_fault(w, i)
            return False
        if p.proper_goal_kicks:
            rule_here(w, RULING_GOAL_KICK, side)
    return True


@kernel
def mark_touch_after_free_kick(w, p, i):
    """The first touch after a set play was taken: a fault if the taker himself dashed to it."""
    if w.fk_taker == i + 1 and p.free_kick_faults:
        if w.counts[i, DASHES] > w.fk_taker_dashes:
            call_free_kick_fault(w, i)
    else:
        w.fk_taken = 0


@kernel
def mark_set_play(w, p, i):
    """Player `i` plays the ball; true when he is to be remembered as the taker once the ruling is carried out."""
    pair = PAIR[w.mode]
    if is_shoot_out(w.mode) or pair == OFFSIDE:
        return False
    if pair == GOAL_KICK:
        return mark_goal_kick(w, p, i)
    if w.mode != PLAY_ON:
        rule(w, RULING_MODE, PLAY_ON, 0.0, 0.0)
        return True
    if w.fk_taken:
        mark_touch_after_free_kick(w, p, i)
    return False


@kernel
def mark_set_play_touch(w, p, i):
    """Player `i` touches the ball without playing it."""
    if PAIR[w.mode] == GOAL_KICK and side_of(i) != SIDE[w.mode]:
        w.fk_goal_count = -1
        w.fk_taken = 0
        rule_here(w, RULING_GOAL_KICK, SIDE[w.mode])
    elif w.fk_taken:
        mark_touch_after_free_kick(w, p, i)


# --- last touch, for goals and outs


@kernel
def mark_last_touch(w, p, i, strength):
    """Player `i` played (`strength` > 0) or touched the ball: he is the last who did, unless somebody was stronger."""
    if abs(w.pos[0, 0]) > p.out_x:
        return
    if w.touch_player == 0 or w.touch_time != w.time or strength >= w.touch_accel:
        w.touch_player, w.touch_time, w.touch_accel = i + 1, w.time, strength
    if w.mode == PLAY_ON and w.touch_kicker != 0 and w.touch_kicker != i + 1:
        w.touch_indirect, w.touch_kicker = 0, 0
    if w.touch_indirect:
        w.touch_kicker = i + 1


@kernel
def mark_indirect(w, mode):
    """Nobody can score directly from an indirect free kick."""
    if PAIR[mode] == INDIRECT_FREE_KICK:
        w.touch_indirect, w.touch_kicker = 1, 0
    elif mode != PLAY_ON and mode != DROP_BALL:
        w.touch_indirect = 0
    if mode != PLAY_ON:
        w.touch_player = 0


# --- back passes


@kernel
def forget_passes(w):
    """Nobody passed the ball."""
    w.bp_last, w.bp_before_last = 0, 0


@kernel
def both_teams(w, i):
    """Note that the team of `i` had the ball in this cycle; true when now both had."""
    w.bp_touched[team_of(side_of(i))] = 1
    return w.bp_touched[0] != 0 and w.bp_touched[1] != 0


@kernel
def mark_pass(w, i):
    """Player `i` kicked or tackled the ball."""
    if both_teams(w, i):
        forget_passes(w)
        return
    if w.bp_last != i + 1:
        w.bp_before_last, w.bp_last = w.bp_last, i + 1
    w.bp_time = w.time


@kernel
def mark_pass_touch(w, i):
    """Player `i` touched the ball."""
    if both_teams(w, i):
        forget_passes(w)


# --- illegal defence


@kernel
def mark_attack(w, i):
    """The side of `i` has the ball; nobody has when both sides played it at the same time."""
    side = side_of(i)
    w.illegal_side = NEUTRAL if w.illegal_time == w.time and w.illegal_side != side else side
    w.illegal_time = w.time
