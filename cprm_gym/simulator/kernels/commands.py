"""The players' commands at the moment they are received (specification/simulator.md 4), and what is left of a dash for the step.

`execute` carries out one `COMMAND` record of one player: the body command, then the free ones. A number that is not finite makes
its command void, as the server's parser refuses it; numbers beyond a million count as a million.
"""

from __future__ import annotations

import math

import numpy as np

from ..player_types import (
    T_CATCHABLE_AREA_L_STRETCH,
    T_DASH_POWER_RATE,
    T_EXTRA_STAMINA,
    T_INERTIA_MOMENT,
    T_KICK_POWER_RATE,
    T_KICK_RAND,
    T_KICKABLE_MARGIN,
    T_PLAYER_SIZE,
)
from ..state import Announcement, CommandKind, Count, PlayerBit, PlayMode
from . import kernel
from .audio import hears_at_once, say
from .contacts import resolve_collisions
from .geometry import (
    D2R,
    clip,
    direction,
    is_kickable,
    length,
    mirror_along,
    norm,
    quantize,
    rotate,
    scale,
)
from .random import (
    CATCH_SUCCESS,
    DASH_TURN_NOISE,
    KICK_NOISE,
    PHYSICS,
    TACKLE_NOISE,
    TACKLE_SUCCESS,
    TURN_NOISE,
    decide,
    polar_noise,
    uniform_between,
)
from .referee.events import (
    announce,
    on_caught,
    on_kick,
    on_kick_fail,
    on_punched,
    on_tackle,
    on_tackle_fail,
    on_touch,
)
from .referee.modes import BEFORE_KICK_OFF, PLAY_ON, TIME_OVER, is_shoot_out, is_stopped
from .senses import view_cone

_LARGEST = 1e6
_FOCUS_FARTHEST = 40.0

DASH, TURN, KICK, TACKLE = int(CommandKind.DASH), int(CommandKind.TURN), int(CommandKind.KICK), int(CommandKind.TACKLE)
CATCH, MOVE, DASH_LEGS = int(CommandKind.CATCH), int(CommandKind.MOVE), int(CommandKind.DASH_LEGS)

KICK_BIT, KICK_FAULT = int(PlayerBit.KICK), int(PlayerBit.KICK_FAULT)
CATCH_BIT, CATCH_FAULT = int(PlayerBit.CATCH), int(PlayerBit.CATCH_FAULT)
TACKLE_BIT, TACKLE_FAULT = int(PlayerBit.TACKLE), int(PlayerBit.TACKLE_FAULT)

N_KICK, N_DASH, N_TURN, N_CATCH, N_MOVE = int(Count.KICK), int(Count.DASH), int(Count.TURN), int(Count.CATCH), int(Count.MOVE)
N_TURN_NECK, N_CHANGE_VIEW, N_CHANGE_FOCUS = int(Count.TURN_NECK), int(Count.CHANGE_VIEW), int(Count.CHANGE_FOCUS)
N_TACKLE, N_ARM, N_ATTENTION = int(Count.TACKLE), int(Count.ARM), int(Count.ATTENTION)

GOAL_L, GOAL_R = int(PlayMode.goal_l), int(PlayMode.goal_r)
CATCH_FAULT_L, CATCH_FAULT_R = int(PlayMode.catch_fault_l), int(PlayMode.catch_fault_r)
FREE_KICK_L, FREE_KICK_R = int(PlayMode.free_kick_l), int(PlayMode.free_kick_r)
DISCARD = int(PlayerBit.DISCARD)
GOALIE_CATCH_BALL = int(Announcement.GOALIE_CATCH_BALL)


@kernel
def is_dead(mode):
    """Whether `mode` is of group DEAD, in which kicks have no effect."""
    return mode == BEFORE_KICK_OFF or mode == TIME_OVER or is_stopped(mode)


@kernel
def execute(w, p, i, c):
    """Everything that the `COMMAND` record `c` says, for player `i` (0..21)."""
    if not w.enabled[i]:
        return
    _execute_body(w, p, i, c)
    if np.isfinite(c.turn_neck):
        turn_neck(w, p, i, _bounded(c.turn_neck))
    if c.view_width > 0:
        change_view(w, p, i, c.view_width, c.view_quality)
    if np.isfinite(c.focus[0]) and np.isfinite(c.focus[1]):
        change_focus(w, p, i, _bounded(c.focus[0]), _bounded(c.focus[1]))
    if np.isfinite(c.point[0]) and np.isfinite(c.point[1]):
        point_to(w, p, i, _bounded(c.point[0]), _bounded(c.point[1]))
    elif c.point[0] == np.inf and c.point[1] == np.inf:
        point_off(w, p, i)
    if c.attention_side != 0:
        attend(w, i, c.attention_side, c.attention_unum)
    if c.say_length > 0:
        say(w, p, i, c.say, c.say_length)


@kernel
def _execute_body(w, p, i, c):
    """The body command of `c`, if its numbers are finite."""
    kind = c.kind
    if kind == DASH_LEGS:
        _dash_by_legs(w, p, i, c)
        return
    if not np.isfinite(c.a):
        return
    a = _bounded(c.a)
    if kind == TURN:
        turn(w, p, i, a)
    elif kind == CATCH:
        catch(w, p, i, a)
    elif np.isfinite(c.b):
        b = _bounded(c.b)
        if kind == DASH:
            dash(w, p, i, a, b)
        elif kind == KICK:
            kick(w, p, i, a, b)
        elif kind == TACKLE:
            tackle(w, p, i, a, b != 0.0)
        elif kind == MOVE:
            move(w, p, i, a, b)


@kernel
def _dash_by_legs(w, p, i, c):
    """``(dash (l a b) (r c d))``; a leg with power NaN is absent, any other number that is not finite voids the command."""
    left, right = not np.isnan(c.a), not np.isnan(c.c)
    if (left and not (np.isfinite(c.a) and np.isfinite(c.b))) or (right and not (np.isfinite(c.c) and np.isfinite(c.d))):
        return
    if left:
        dash_leg(w, p, i, 0, _bounded(c.a), _bounded(c.b))
    if right:
        dash_leg(w, p, i, 1, _bounded(c.c), _bounded(c.d))


@kernel
def _bounded(number):
    """A finite number small enough that squares of what is computed from it stay finite."""
    return clip(-_LARGEST, number, _LARGEST)


# --- dash


@kernel
def dash(w, p, i, power, angle):
    """``(dash power angle)`` with both legs."""
    if w.busy[i]:
        return
    _use_leg(w, p, i, 0, power, angle)
    _use_leg(w, p, i, 1, power, angle)


@kernel
def dash_leg(w, p, i, leg, power, angle):
    """One leg (0 left, 1 right) of the two-leg form, which only that leg's own flag can block."""
    if not w.leg_busy[i, leg]:
        _use_leg(w, p, i, leg, power, angle)


@kernel
def _use_leg(w, p, i, leg, power, angle):
    w.leg_power[i, leg] = clip(p.min_dash_power, power, p.max_dash_power)
    w.leg_dir[i, leg] = quantize(clip(p.min_dash_angle, angle, p.max_dash_angle), p.dash_angle_step)
    w.leg_dashed[i, leg] = 1
    w.leg_busy[i, leg] = 1
    w.dash_cycles[i] = 1
    w.busy[i] = 1


@kernel
def effect_of_dash(w, p, i):
    """At the beginning of the step: what the legs of player `i` do to his acceleration, body and stamina."""
    if not (w.leg_dashed[i, 0] or w.leg_dashed[i, 1]):
        return
    w.counts[i, N_DASH] += 1
    type_, o = w.type[i], i + 1
    left, right = w.leg_power[i, 0], w.leg_power[i, 1]
    demand_left = -left if left < 0.0 else left / 2.0
    demand_right = -right if right < 0.0 else right / 2.0
    cost = demand_left + demand_right
    if cost < 1e-5:
        return
    cost = min(cost, w.stamina[i] + p.types[type_, T_EXTRA_STAMINA])
    share_left = cost * demand_left / (demand_left + demand_right)
    share_right = cost * demand_right / (share_left + demand_right)  # with the new left share, as the server does
    lx, ly = _leg_acceleration(w, p, i, 0, share_left)
    even = share_left == share_right and left == right and w.leg_dir[i, 0] == w.leg_dir[i, 1]
    rx, ry = (lx, ly) if even else _leg_acceleration(w, p, i, 1, share_right)
    vx, vy = w.vel[o, 0], w.vel[o, 1]
    lx, ly, rx, ry = vx + lx, vy + ly, vx + rx, vy + ry
    w.acc[o, 0] += (lx + rx) / 2.0 - vx
    w.acc[o, 1] += (ly + ry) / 2.0 - vy
    if even:
        w.body_staged[i] = norm(w.body[i])
    elif w.leg_dashed[i, 0]:
        ex, ey = math.cos(w.body[i]), math.sin(w.body[i])
        omega = ((ex * lx + ey * ly) - (ex * rx + ey * ry)) / (2.0 * p.types[type_, T_PLAYER_SIZE])
        rand = p.player_rand_of[0 if i < 11 else 1]
        noise = uniform_between(w, PHYSICS, i + 1, DASH_TURN_NOISE, 0, -rand, rand)
        w.body_staged[i] = norm(w.body[i] + (1.0 + noise) * omega)
    w.stamina[i] = max(0.0, w.stamina[i] - cost)


@kernel
def _leg_acceleration(w, p, i, leg, share):
    """Acceleration (x, y) of one leg that got `share` of the stamina."""
    type_ = w.type[i]
    power = -share if w.leg_power[i, leg] < 0.0 else 2.0 * share
    power = clip(p.min_dash_power, power, p.max_dash_power)
    degrees = abs(w.leg_dir[i, leg])
    if degrees > 90.0:
        rate = p.back_dash_rate - (p.back_dash_rate - p.side_dash_rate) * (1.0 - (degrees - 90.0) / 90.0)
    else:
        rate = p.side_dash_rate + (1.0 - p.side_dash_rate) * (1.0 - degrees / 90.0)
    rate = clip(0.0, rate, 1.0)
    size = abs(w.effort[i] * power * rate * p.types[type_, T_DASH_POWER_RATE])
    if w.pos[i + 1, 1] < 0.0:
        size /= p.slowness_of[0 if i < 11 else 1]
    angle = norm(w.body[i] + w.leg_dir[i, leg] * D2R)
    x, y = size * math.cos(angle), size * math.sin(angle)
    return (-x, -y) if power < 0.0 else (x, y)


# --- turn, turn_neck, move


@kernel
def _use_body(w, i):
    """Spend the body command and both legs."""
    w.busy[i] = 1
    w.leg_busy[i, 0] = 1
    w.leg_busy[i, 1] = 1


@kernel
def turn(w, p, i, moment):
    """``(turn moment)``: the new body angle, from the present velocity, committed in the step."""
    if w.busy[i]:
        return
    _use_body(w, i)
    o = i + 1
    moment = clip(p.minmoment, moment, p.maxmoment) * D2R
    rand = p.player_rand_of[0 if i < 11 else 1]
    noise = uniform_between(w, PHYSICS, o, TURN_NOISE, 0, -rand, rand)
    damping = 1.0 + p.types[w.type[i], T_INERTIA_MOMENT] * length(w.vel[o, 0], w.vel[o, 1])
    w.body_staged[i] = norm(w.body[i] + (1.0 + noise) * moment / damping)
    w.counts[i, N_TURN] += 1


@kernel
def turn_neck(w, p, i, moment):
    """``(turn_neck moment)``, once per cycle, committed in the step."""
    if w.neck_busy[i]:
        return
    w.neck_busy[i] = 1
    moment = clip(p.minneckmoment, moment, p.maxneckmoment) * D2R
    w.neck_staged[i] = clip(p.minneckang * D2R, w.neck[i] + moment, p.maxneckang * D2R)
    w.counts[i, N_TURN_NECK] += 1


@kernel
def move(w, p, i, x, y):
    """``(move x y)`` in the team's own frame: before kick-off, after goals, and with the caught ball."""
    if w.busy[i]:
        return
    side = 1.0 if i < 11 else -1.0
    mode, o = w.mode, i + 1
    if mode == BEFORE_KICK_OFF or mode == GOAL_L or mode == GOAL_R:
        w.pos[o, 0], w.pos[o, 1] = side * x, side * y
        resolve_collisions(w, p)
    elif (mode == FREE_KICK_L or mode == FREE_KICK_R) and w.ball_catcher == o:
        if p.goalie_max_moves < 0 or w.moves_since_catch[i] < p.goalie_max_moves:
            w.pos[o, 0], w.pos[o, 1] = side * x, side * y
            w.moves_since_catch[i] += 1
    else:
        return
    _use_body(w, i)
    w.counts[i, N_MOVE] += 1


# --- kick, tackle


@kernel
def _push_ball(w, p, i, ax, ay, noise, purpose):
    """Add an acceleration and polar noise up to `noise` to the ball, which nobody holds any more; the length added."""
    nx, ny = polar_noise(w, PHYSICS, i + 1, purpose, 0, noise)
    ax += nx
    ay += ny
    w.acc[0, 0] += ax
    w.acc[0, 1] += ay
    w.ball_catcher = 0
    return length(ax, ay)


@kernel
def _ball_speed_share(w, p):
    """Speed of the ball relative to the fastest a kick can find."""
    return length(w.vel[0, 0], w.vel[0, 1]) / p.ball_top_speed


@kernel
def kick(w, p, i, power, angle):
    """``(kick power angle)``: accelerates a ball in reach, at once."""
    if w.busy[i]:
        return
    power = clip(p.minpower, power, p.maxpower)
    angle = clip(p.minmoment, angle, p.maxmoment) * D2R
    w.busy[i] = 1
    w.kick_cycles[i] = 1
    w.bits[i] |= KICK_BIT
    if is_dead(w.mode):
        w.bits[i] |= KICK_FAULT
        return
    if not is_kickable(w, p, i):
        w.bits[i] |= KICK_FAULT
        on_kick_fail(w, p, i)
        return
    type_, o = w.type[i], i + 1
    dx, dy = w.pos[0, 0] - w.pos[o, 0], w.pos[0, 1] - w.pos[o, 1]
    off_axis = abs(norm(direction(dx, dy) - w.body[i])) / math.pi
    gap = (length(dx, dy) - p.types[type_, T_PLAYER_SIZE] - p.ball_size) / p.types[type_, T_KICKABLE_MARGIN]
    size = power * p.types[type_, T_KICK_POWER_RATE] * (1.0 - 0.25 * off_axis - 0.25 * gap)
    heading = angle + w.body[i]
    rand = p.types[type_, T_KICK_RAND] * p.kick_rand_factor_of[0 if i < 11 else 1]
    noise = rand * power / p.maxpower * ((0.5 + 0.25 * (off_axis + gap)) + (0.5 + 0.5 * _ball_speed_share(w, p)))
    accel = _push_ball(w, p, i, size * math.cos(heading), size * math.sin(heading), noise, KICK_NOISE)
    on_kick(w, p, i, accel)
    w.counts[i, N_KICK] += 1


@kernel
def _opponent_has_ball(w, p, i):
    """Whether the ball is kickable for an enabled opponent of player `i`."""
    first = 11 if i < 11 else 0
    for j in range(first, first + 11):
        if w.enabled[j] and is_kickable(w, p, j):
            return True
    return False


@kernel
def tackle(w, p, i, angle, intentional):
    """``(tackle angle [foul])``: succeeds by chance, accelerates the ball, and freezes the player (specification/simulator.md 4.4)."""
    if w.busy[i]:
        return
    _use_body(w, i)
    w.tackle_cycles[i] = p.tackle_cycles
    w.counts[i, N_TACKLE] += 1
    o = i + 1
    x, y = rotate(w.pos[0, 0] - w.pos[o, 0], w.pos[0, 1] - w.pos[o, 1], -w.body[i])
    reach = p.tackle_dist if x > 0.0 else p.tackle_back_dist
    if abs(reach) <= 1e-5:
        w.bits[i] |= TACKLE_FAULT
        return
    foul = intentional and _opponent_has_ball(w, p, i)
    exponent = p.foul_exponent if foul else p.tackle_exponent
    fail = (abs(x) / reach) ** exponent + (abs(y) / p.tackle_width) ** exponent
    if not fail < 1.0:
        w.bits[i] |= TACKLE_FAULT
        on_tackle_fail(w, p, i, foul)
        return
    if not decide(w, w.forced_tackle[i], PHYSICS, o, TACKLE_SUCCESS, 0, 1.0 - fail):
        w.bits[i] |= TACKLE_BIT | TACKLE_FAULT
        on_tackle_fail(w, p, i, foul)
        return
    w.bits[i] |= TACKLE_BIT
    if is_dead(w.mode) and w.mode != CATCH_FAULT_L and w.mode != CATCH_FAULT_R:
        return
    if foul:
        w.tackle_cycles[i] = 0
    size, heading, share = _tackle_strength(w, p, i, angle)
    size *= 1.0 - 0.5 * abs(direction(x, y)) / math.pi
    rand = p.types[w.type[i], T_KICK_RAND] * p.kick_rand_factor_of[0 if i < 11 else 1]
    noise = rand * p.tackle_rand_factor * share * ((0.5 + 0.5 * (1.0 - fail)) + (0.5 + 0.5 * _ball_speed_share(w, p)))
    accel = _push_ball(w, p, i, size * math.cos(heading), size * math.sin(heading), noise, TACKLE_NOISE)
    on_tackle(w, p, i, accel, foul)


@kernel
def _tackle_strength(w, p, i, angle):
    """(acceleration, direction, share of the full noise) before the ball's place is considered.

    Clients of protocols before 12 give a power instead of an angle.
    """
    if 0 < w.protocol[i] < 12:
        power = clip(-p.max_back_tackle_power, angle, p.max_tackle_power)
        share = power / p.max_tackle_power if power >= 0.0 else -power / p.max_back_tackle_power
        return power * p.tackle_power_rate, w.body[i], share
    angle = clip(p.minmoment, angle, p.maxmoment) * D2R
    power = p.max_back_tackle_power + (p.max_tackle_power - p.max_back_tackle_power) * (1.0 - abs(angle) / math.pi)
    return power * p.tackle_power_rate, angle + w.body[i], 1.0


# --- catch


@kernel
def catch(w, p, i, angle):
    """``(catch angle)`` of a goalie: takes the ball out of a rectangle, or punches it (specification/simulator.md 4.5)."""
    if w.busy[i]:
        return
    angle = clip(p.min_catch_angle, angle, p.max_catch_angle)
    angle = clip(p.minmoment, angle, p.maxmoment) * D2R
    w.busy[i] = 1
    w.bits[i] |= CATCH_BIT
    if not w.goalie[i] or w.catch_ban[i] > 0 or not (w.mode == PLAY_ON or is_shoot_out(w.mode)):
        w.bits[i] |= CATCH_FAULT
        return
    w.catch_ban[i] = p.catch_ban_cycle
    o = i + 1
    axis = w.body[i] + angle
    x, y = rotate(w.pos[0, 0] - w.pos[o, 0], w.pos[0, 1] - w.pos[o, 1], -axis)
    stretch = p.types[w.type[i], T_CATCHABLE_AREA_L_STRETCH]
    longest, sure = p.catchable_area_l * stretch, p.catchable_area_l * (2.0 - stretch)
    if x < 0.0 or x > longest or abs(y) > p.catchable_area_w / 2.0:
        w.bits[i] |= CATCH_FAULT
        return
    probability = p.catch_probability
    if x > sure:
        probability = clip(0.0, probability * (1.0 - (x - sure) / (longest - sure)), 1.0)
    if decide(w, w.forced_catch[i], PHYSICS, o, CATCH_SUCCESS, 0, probability):
        _take_ball(w, p, i)
    else:
        w.bits[i] |= CATCH_FAULT
        vx, vy = mirror_along(w.vel[0, 0], w.vel[0, 1], axis)
        w.acc[0, 0] += vx - w.vel[0, 0]
        w.acc[0, 1] += vy - w.vel[0, 1]
        on_touch(w, p, i)
        on_punched(w, p, i)
    w.counts[i, N_CATCH] += 1
    w.moves_since_catch[i] = 0


@kernel
def _take_ball(w, p, i):
    """Goalie `i` goes to the ball, turns to it and holds it, if the referee allows."""
    o = i + 1
    dx, dy = w.pos[0, 0] - w.pos[o, 0], w.pos[0, 1] - w.pos[o, 1]
    dx, dy = scale(dx, dy, length(dx, dy) - p.ball_size - p.types[w.type[i], T_PLAYER_SIZE])
    w.pos[o, 0] += dx
    w.pos[o, 1] += dy
    w.body_staged[i] = direction(dx, dy)
    w.vel[o, 0] = 0.0
    w.vel[o, 1] = 0.0
    if not is_shoot_out(w.mode):
        announce(w, GOALIE_CATCH_BALL, 1 if i < 11 else -1, 0, 0)
    resolve_collisions(w, p)
    on_touch(w, p, i)
    on_caught(w, p, i)
    if w.mode == FREE_KICK_L or w.mode == FREE_KICK_R:
        w.ball_catcher = o


# --- free commands


@kernel
def change_view(w, p, i, width, quality):
    """``(change_view width [quality])``; `quality` 0 is the one-argument form, which also clamps the focus, 1 high, 2 low."""
    if width > 3 or quality < 0 or quality > 2 or (quality == 2 and w.synchronous[i]):
        return
    w.view_width[i] = width
    w.view_quality[i] = 2 if quality == 2 else 1
    if quality == 0:
        half = view_cone(w, p, i) / 2.0
        w.focus_direction[i] = clip(-half, w.focus_direction[i], half)
    w.counts[i, N_CHANGE_VIEW] += 1


@kernel
def change_focus(w, p, i, distance, angle):
    """``(change_focus distance angle)``: moves the focus point, within 40 m and the view cone."""
    w.focus_distance[i] = clip(0.0, w.focus_distance[i] + distance, _FOCUS_FARTHEST)
    half = view_cone(w, p, i) / 2.0
    w.focus_direction[i] = clip(-half, norm(w.focus_direction[i] + angle * D2R), half)
    w.counts[i, N_CHANGE_FOCUS] += 1


@kernel
def point_to(w, p, i, distance, angle):
    """``(pointto distance angle)``: raises the arm towards a point fixed on the field."""
    if w.arm_timer[i] < p.point_to_ban:
        return
    heading = angle * D2R + w.body[i] + w.neck[i]
    w.arm_target[i, 0] = w.pos[i + 1, 0] + distance * math.cos(heading)
    w.arm_target[i, 1] = w.pos[i + 1, 1] + distance * math.sin(heading)
    w.arm_timer[i] = 0
    w.counts[i, N_ARM] += 1


@kernel
def point_off(w, p, i):
    """``(pointto off)``: lowers the arm."""
    if w.arm_timer[i] < p.point_to_ban:
        return
    w.arm_timer[i] = p.point_to_duration
    w.counts[i, N_ARM] += 1


@kernel
def attend(w, i, side, unum):
    """``(attentionto our|opp unum)`` with `side` 1 or 2, ``(attentionto off)`` with 3; the target may have been sent off.

    Who hears everybody at once, by a protocol before 8, has no focus; it is counted for him too.
    """
    if side == 3:
        w.attention[i] = 0
        w.counts[i, N_ATTENTION] += 1
        return
    if side < 1 or side > 3 or unum < 1 or unum > 11:
        return
    target = unum if (i < 11) == (side == 1) else 11 + unum
    if target == i + 1 or not (w.enabled[target - 1] or w.bits[target - 1] & DISCARD):
        return
    if not hears_at_once(w, i):
        w.attention[i] = target
    w.counts[i, N_ATTENTION] += 1
