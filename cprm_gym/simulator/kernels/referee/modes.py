"""Play modes as plain integers, their groups (specification/simulator.md 0.4), and how decisions and announcements are noted.

Kernels take the server's numbers; the left member of a pair (``kick_in_l``) names the pair and `of_side` gives the member.
"""

from __future__ import annotations

import numpy as np

from ...parameters import Rules
from ...state import ANNOUNCEMENTS, PlayerBit, PlayMode
from .. import kernel

LEFT, NEUTRAL, RIGHT = 1, 0, -1

BEFORE_KICK_OFF = int(PlayMode.before_kick_off)
TIME_OVER = int(PlayMode.time_over)
PLAY_ON = int(PlayMode.play_on)
DROP_BALL = int(PlayMode.drop_ball)
# the left member of each pair
KICK_OFF = int(PlayMode.kick_off_l)
KICK_IN = int(PlayMode.kick_in_l)
FREE_KICK = int(PlayMode.free_kick_l)
CORNER_KICK = int(PlayMode.corner_kick_l)
GOAL_KICK = int(PlayMode.goal_kick_l)
GOAL = int(PlayMode.goal_l)
OFFSIDE = int(PlayMode.offside_l)
FOUL_CHARGE = int(PlayMode.foul_charge_l)
FOUL_PUSH = int(PlayMode.foul_push_l)
BACK_PASS = int(PlayMode.back_pass_l)
FREE_KICK_FAULT = int(PlayMode.free_kick_fault_l)
CATCH_FAULT = int(PlayMode.catch_fault_l)
INDIRECT_FREE_KICK = int(PlayMode.indirect_free_kick_l)
PENALTY_SETUP = int(PlayMode.penalty_setup_l)
PENALTY_READY = int(PlayMode.penalty_ready_l)
PENALTY_TAKEN = int(PlayMode.penalty_taken_l)
PENALTY_MISS = int(PlayMode.penalty_miss_l)
PENALTY_SCORE = int(PlayMode.penalty_score_l)
ILLEGAL_DEFENSE = int(PlayMode.illegal_defense_l)

RULE_TIME = int(Rules.TIME)
RULE_BALL_STUCK = int(Rules.BALL_STUCK)
RULE_OFFSIDE = int(Rules.OFFSIDE)
RULE_FREE_KICK = int(Rules.FREE_KICK)
RULE_TOUCH = int(Rules.TOUCH)
RULE_CATCH = int(Rules.CATCH)
RULE_FOUL = int(Rules.FOUL)
RULE_ILLEGAL_DEFENSE = int(Rules.ILLEGAL_DEFENSE)
RULE_KEEPAWAY = int(Rules.KEEPAWAY)
RULE_PENALTY = int(Rules.PENALTY)

BIT_STAND = int(PlayerBit.STAND)
BIT_GOALIE = int(PlayerBit.GOALIE)
BIT_BACK_PASS = int(PlayerBit.BACK_PASS)
BIT_FREE_KICK_FAULT = int(PlayerBit.FREE_KICK_FAULT)
BIT_FOUL_CHARGED = int(PlayerBit.FOUL_CHARGED)
BIT_YELLOW = int(PlayerBit.YELLOW_CARD)
BIT_RED = int(PlayerBit.RED_CARD)
BIT_DISCARD = int(PlayerBit.DISCARD)
BIT_ILLEGAL_DEFENSE = int(PlayerBit.ILLEGAL_DEFENSE)
KEPT_BY_SUBSTITUTION = int(PlayerBit.STAND | PlayerBit.GOALIE | PlayerBit.DISCARD)

# indices of WORLD["wait"]
WAIT_OFFSIDE, WAIT_FREE_KICK_FAULT, WAIT_BACK_PASS, WAIT_CATCH_FAULT, WAIT_FOUL, WAIT_ILLEGAL_DEFENSE = range(6)
WAIT_STEPS = 30
"""A stoppage ends when its counter exceeds this."""
CLEAR_AFTER = 25
"""Offenders are kept away from the ball once the counter exceeds this."""
GOAL_WAIT_STEPS = 50

STOPPED, PENALTY, SET_PLAY = 1, 2, 4
"""Groups Z (the clock stands), PEN and SET of specification/simulator.md 0.4."""


def _tables() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    pair, side, group = np.arange(52, dtype=np.int32), np.zeros(52, np.int32), np.zeros(52, np.int32)
    stopped = {
        "goal",
        "offside",
        "illegal_defense",
        "foul_charge",
        "foul_push",
        "back_pass",
        "free_kick_fault",
        "catch_fault",
    }
    set_plays = {"kick_off", "kick_in", "free_kick", "corner_kick", "indirect_free_kick"}
    shoot_out = {"penalty_setup", "penalty_ready", "penalty_taken", "penalty_miss", "penalty_score"}
    for mode in PlayMode:
        stem, _, end = mode.name.rpartition("_")
        if end in ("l", "r"):
            pair[mode] = PlayMode[f"{stem}_l"]
            side[mode] = LEFT if end == "l" else RIGHT
            group[mode] = STOPPED * (stem in stopped) + PENALTY * (stem in shoot_out) + SET_PLAY * (stem in set_plays)
    return pair, side, group


PAIR, SIDE, GROUP = _tables()
"""Of each mode: the left member of its pair (itself when it has no side), the side of its suffix, its groups."""


@kernel
def of_side(pair, side):
    """The member of `pair` (given by its left member) with the suffix of `side`."""
    return pair if side == LEFT else pair + 1


@kernel
def is_stopped(mode):
    """The mode is in Z: after a goal or an offence, the clock stands."""
    return GROUP[mode] & STOPPED != 0


@kernel
def is_shoot_out(mode):
    """The mode belongs to the penalty shoot-out (PEN)."""
    return GROUP[mode] & PENALTY != 0


@kernel
def is_set_play(mode):
    """Kick-off, kick-in, free kick, corner or indirect free kick (SET); the goal kick is not one."""
    return GROUP[mode] & SET_PLAY != 0


@kernel
def team_of(side):
    """Index of a side in arrays over teams: left 0, right 1."""
    return 0 if side == LEFT else 1


# --- rulings: what a module decides and `rulings.carry_out` does
(
    RULING_NONE,
    RULING_MODE,  # set the mode whose number is the side
    RULING_FREE_KICK,  # for the side at the place
    RULING_GOAL_KICK,
    RULING_CORNER_KICK,
    RULING_KICK_IN,
    RULING_DROP_BALL,  # at the place
    RULING_OFFSIDE,  # of the side, stored point
    RULING_FREE_KICK_FAULT,  # of the side at the place
    RULING_BACK_PASS,
    RULING_CATCH_FAULT,
    RULING_FOUL,
    RULING_ILLEGAL_DEFENSE,
    RULING_GOAL,  # of the side
    RULING_KICK_OFF,  # of the side, after a goal
    RULING_HALF_TIME,  # the time is the side
    RULING_PENALTY_SETUP,  # the next kick of the shoot-out
    RULING_PENALTY_SCORE,
    RULING_PENALTY_MISS,
    RULING_PENALTY_FOUL,  # of the side
) = range(20)


@kernel
def rule(w, ruling, side, x, y):
    """Note a decision for `carry_out`; a later one replaces it."""
    w.ruling, w.ruling_side = ruling, side
    w.ruling_pos[0], w.ruling_pos[1] = x, y


@kernel
def rule_here(w, ruling, side):
    """A decision at the place of the ball."""
    rule(w, ruling, side, w.pos[0, 0], w.pos[0, 1])


# --- what the referee says, kept in the world until the next step (specification/simulator.md 7.2)
MOST_ANNOUNCEMENTS = int(ANNOUNCEMENTS)


@kernel
def announce(w, kind, a, b, c):
    """Record an announcement of the referee, with the time at which it is made; beyond 32 in a step they are dropped.

    The first after a step replaces those of that step.
    """
    if w.announced_done:
        w.announced, w.announced_done = 0, 0
    n = w.announced
    if n < MOST_ANNOUNCEMENTS:
        w.announcement[n, 0], w.announcement[n, 1], w.announcement[n, 2], w.announcement[n, 3] = kind, a, b, c
        w.announced_at[n] = w.time
        w.announced = n + 1
