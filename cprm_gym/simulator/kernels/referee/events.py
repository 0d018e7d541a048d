"""The referee: every event is given to ten modules in the server's order (specification/simulator.md 7.1).

Time, BallStuck, Offside, FreeKick, Touch, Catch, Foul, IllegalDefense, Keepaway, Penalty; each is served only while its bit
of ``p.rules`` is set. A module notes what it decides (a *ruling*); it is carried out before the next module is served, which
therefore sees the new mode. A change of mode is an event of its own (`set_mode`). Files:

- `modes` play modes, groups, rulings;  `marks` what is remembered of kicks and touches;  `offside` the offside rule;
- `places` where ball and players are put;  `touches` collisions this causes;
- `set_mode`, `rulings` changes of mode, what a ruling does;
- `steps`, `waits`, `goals`, `fouls`, `shoot_out`, `keepaway` the modules;
- `kick_off` the kick-off procedure and player types.

Kernels cannot call each other in a circle: a relocation by the referee drives the collision kernels itself and gives their
touches to `touches.note_touch`. Players are numbered 0 to 21 here.
"""

from __future__ import annotations

from ...state import Count
from .. import event, kernel
from ..geometry import side_of
from .fouls import NO_FOUL, YELLOW, judge_tackle, show_card
from .goals import catch_step, caught, crossed_goal_line, punched, touch_step
from .keepaway import keepaway_step
from .kick_off import automatic_kick_off, automatic_kick_offs, kick_off
from .marks import mark_attack, mark_last_touch, mark_pass, mark_pass_touch, mark_set_play, mark_set_play_touch, remember_taker
from .modes import (
    FOUL_CHARGE,
    FOUL_PUSH,
    PAIR,
    PENALTY_MISS,
    PENALTY_SCORE,
    PENALTY_TAKEN,
    RULE_BALL_STUCK,
    RULE_CATCH,
    RULE_FOUL,
    RULE_FREE_KICK,
    RULE_ILLEGAL_DEFENSE,
    RULE_KEEPAWAY,
    RULE_OFFSIDE,
    RULE_PENALTY,
    RULE_TIME,
    RULE_TOUCH,
    RULING_FOUL,
    RULING_NONE,
    RULING_PENALTY_FOUL,
    announce,
    is_shoot_out,
    of_side,
    rule,
)
from .offside import mark_failed_try, mark_offside
from .rulings import carry_out
from .set_mode import set_mode
from .shoot_out import (
    caught_in_shoot_out,
    freeze_ball,
    kicked_in_shoot_out,
    shoot_out_is_due,
    shoot_out_step,
    start_shoot_out,
    use_taker,
    who_shoots,
)
from .steps import (
    ball_stuck_step,
    free_kick_step,
    illegal_defense_step,
    keep_distance,
    offside_step,
    time_step,
)
from .waits import end_foul

__all__ = [
    "announce",
    "automatic_kick_off",
    "automatic_kick_offs",
    "kick_off",
    "on_caught",
    "on_kick",
    "on_kick_fail",
    "on_punched",
    "on_step",
    "on_tackle",
    "on_tackle_fail",
    "on_touch",
    "set_mode",
]

FOULS = int(Count.FOUL)


# --- kicks and tackles


@kernel
def ball_played(w, p, i, accel):
    """The modules from Offside to Catch hear of a kick or tackle."""
    if p.rules & RULE_OFFSIDE:
        mark_offside(w, p, i, accel)
        carry_out(w, p)
    if p.rules & RULE_FREE_KICK:
        taken = mark_set_play(w, p, i)
        carry_out(w, p)
        if taken:
            remember_taker(w, i)
    if p.rules & RULE_TOUCH:
        mark_last_touch(w, p, i, accel)
    if p.rules & RULE_CATCH:
        mark_pass(w, i)


@kernel
def shoot_out_kick(w, p, i):
    """Module Penalty: the ball is kicked."""
    if w.ball_catcher != 0:
        return
    shooting = who_shoots(w)
    starts = kicked_in_shoot_out(w, p, i)
    carry_out(w, p)
    if starts:
        use_taker(w, i)
        set_mode(w, p, of_side(PENALTY_TAKEN, shooting))
    if PAIR[w.mode] != PENALTY_TAKEN:
        freeze_ball(w)


@event
def on_kick(w, p, i, accel):
    """Player `i` gave the ball an acceleration of length `accel` (m / cycle^2)."""
    if p.rules == 0:
        return
    ball_played(w, p, i, accel)
    if p.rules & RULE_ILLEGAL_DEFENSE:
        mark_attack(w, i)
    if p.rules & RULE_PENALTY and is_shoot_out(w.mode):
        shoot_out_kick(w, p, i)


@event
def on_kick_fail(w, p, i):
    """Player `i` kicked without the ball in reach, in a mode in which kicks have an effect."""
    if p.rules & RULE_OFFSIDE:
        mark_failed_try(w, p, i)
        carry_out(w, p)


@kernel
def foul_of(w, p, i, intentional):
    """Module Foul: judge the tackle of player `i`, call the foul and show the card."""
    outcome = judge_tackle(w, p, i, intentional)
    if outcome == NO_FOUL:
        return
    rule(w, RULING_FOUL, side_of(i), w.pos[i + 1, 0], w.pos[i + 1, 1])
    carry_out(w, p)
    w.counts[i, FOULS] += 1
    if outcome >= YELLOW:
        show_card(w, i, outcome)


@kernel
def shoot_out_tackle(w, p, i, intentional):
    """Module Penalty: the ball is tackled."""
    pair = PAIR[w.mode]
    if pair == PENALTY_MISS or pair == PENALTY_SCORE:
        return
    if judge_tackle(w, p, i, intentional) != NO_FOUL:
        rule(w, RULING_PENALTY_FOUL, side_of(i), 0.0, 0.0)
        carry_out(w, p)
    else:
        shoot_out_kick(w, p, i)


@event
def on_tackle(w, p, i, accel, foul):
    """Player `i` tackled the ball; `foul`: intentionally with an opponent in reach of it."""
    if p.rules == 0:
        return
    ball_played(w, p, i, accel)
    if p.rules & RULE_FOUL and not is_shoot_out(w.mode) and not p.keepaway:
        foul_of(w, p, i, foul)
    if p.rules & RULE_ILLEGAL_DEFENSE:
        mark_attack(w, i)
    if p.rules & RULE_PENALTY and is_shoot_out(w.mode):
        shoot_out_tackle(w, p, i, foul)


@event
def on_tackle_fail(w, p, i, foul):
    """The tackle of player `i` failed within reach, or was out of reach in front."""
    on_kick_fail(w, p, i)


# --- touches and catches


@event
def on_touch(w, p, i):
    """The ball and player `i` overlap (each pass of a collision resolution), or he caught or punched it."""
    if p.rules == 0:
        return
    if p.rules & RULE_OFFSIDE:
        mark_offside(w, p, i, 0.0)
        carry_out(w, p)
    if p.rules & RULE_FREE_KICK:
        mark_set_play_touch(w, p, i)
        carry_out(w, p)
    if p.rules & RULE_TOUCH:
        mark_last_touch(w, p, i, 0.0)
    if p.rules & RULE_CATCH:
        mark_pass_touch(w, i)


@kernel
def shoot_out_catch(w, p, i):
    """Module Penalty: the ball is caught or punched."""
    caught_in_shoot_out(w, p, i)
    carry_out(w, p)
    freeze_ball(w)


@event
def on_caught(w, p, i):
    """Goalie `i` caught the ball; called after the collision resolution and `on_touch`."""
    if is_shoot_out(w.mode):
        if p.rules & RULE_PENALTY:
            shoot_out_catch(w, p, i)
    elif p.rules & RULE_CATCH:
        caught(w, p, i)
        carry_out(w, p)


@event
def on_punched(w, p, i):
    """Goalie `i` failed to catch the ball within the catch rectangle."""
    if is_shoot_out(w.mode):
        if p.rules & RULE_PENALTY:
            shoot_out_catch(w, p, i)
    elif p.rules & RULE_CATCH:
        punched(w, p, i)
        carry_out(w, p)


# --- steps


@kernel
def shoot_out(w, p):
    """Module Penalty: one step."""
    if shoot_out_is_due(w, p):
        start_shoot_out(w, p)
        carry_out(w, p)
    if is_shoot_out(w.mode):
        x, y = w.pen_ball_prev[0], w.pen_ball_prev[1]
        shoot_out_step(w, p, crossed_goal_line(p, x, y, w.pos[0, 0], w.pos[0, 1], w.pen_side))
        carry_out(w, p)
    w.pen_ball_prev[0], w.pen_ball_prev[1] = w.pos[0, 0], w.pos[0, 1]


@kernel
def free_kick(w, p):
    """Module FreeKick: one step."""
    mode = w.mode
    goes_on = free_kick_step(w, p)
    if w.ruling != RULING_NONE:
        carry_out(w, p)
    if goes_on:
        keep_distance(w, p, mode)
        if w.ruling != RULING_NONE:
            carry_out(w, p)


@event
def on_step(w, p):
    """One simulation step is done; called in every mode but time_over."""
    rules = p.rules
    if rules == 0:
        return
    if rules & RULE_TIME:
        time_step(w, p)
        carry_out(w, p)
    if rules & RULE_BALL_STUCK:
        ball_stuck_step(w, p)
        carry_out(w, p)
    if rules & RULE_OFFSIDE:
        offside_step(w, p)
        carry_out(w, p)
    if rules & RULE_FREE_KICK:
        free_kick(w, p)
    if rules & RULE_TOUCH:
        if not is_shoot_out(w.mode):
            touch_step(w, p)
            carry_out(w, p)
        w.ball_prev[0], w.ball_prev[1] = w.pos[0, 0], w.pos[0, 1]
    if rules & RULE_CATCH:
        catch_step(w, p)
        carry_out(w, p)
    if rules & RULE_FOUL and (PAIR[w.mode] == FOUL_CHARGE or PAIR[w.mode] == FOUL_PUSH):
        end_foul(w, p)
        carry_out(w, p)
    if rules & RULE_ILLEGAL_DEFENSE:
        illegal_defense_step(w, p)
        carry_out(w, p)
    if rules & RULE_KEEPAWAY and p.keepaway:
        keepaway_step(w, p)
        carry_out(w, p)
    if rules & RULE_PENALTY:
        shoot_out(w, p)
