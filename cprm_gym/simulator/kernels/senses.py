"""See: what each player is told of the ball and the others, and when (specification/simulator.md 6.1).

`look` makes one message, in which everybody stands at his own place; `see_worlds` makes the arrays, in which players without a number
have lost theirs (`fill_team_slots`, `fill_unknown_slots`). Text is made from `look`, and draws are numbered by observer, object and
message of the cycle, so text and arrays agree. `see_messages_due` decides, once per step, who gets a message.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..pitch import PITCH_LENGTH, PITCH_WIDTH
from ..player_types import (
    T_BALL_MAX_OBSERVATION_LENGTH,
    T_BALL_VEL_FAR_LENGTH,
    T_BALL_VEL_TOO_FAR_LENGTH,
    T_DIST_NOISE_RATE,
    T_FOCUS_DIST_NOISE_RATE,
    T_PLAYER_MAX_OBSERVATION_LENGTH,
    T_TEAM_FAR_LENGTH,
    T_TEAM_TOO_FAR_LENGTH,
    T_UNUM_FAR_LENGTH,
    T_UNUM_TOO_FAR_LENGTH,
)
from ..state import PLAYERS, ViewWidth
from . import kernel
from .geometry import D2R, R2D, norm, quantize
from .random import (
    SEE_DISTANCE,
    SEE_POINTING,
    SEE_TEAM,
    SEE_UNUM,
    SEE_VELOCITY,
    SENSORS,
    normal,
    uniform,
)
from .rounding import (
    banded_distance,
    face_degrees,
    face_direction,
    seen_distance,
    told_degrees,
    truncated_degrees,
)

PI = math.pi
NARROW, WIDE = int(ViewWidth.NARROW), int(ViewWidth.WIDE)
LOW_QUALITY = 2
FOCUS_PROTOCOL = 18  # first protocol version that sees with a focus
NEWEST = 19
ROUNDING_PROTOCOL = 7  # first protocol version whose directions are rounded, not truncated

UNSEEN, FELT, TEAM_SEEN, NAME_SEEN = 0, 1, 2, 3  # levels of players
TOLD, TOLD_MOVING = 2, 3  # levels of the ball and of landmarks above FELT
TACKLING, KICKING, POINTING, IN_VIEW = 1, 2, 4, 8  # marks of players

VISUAL = math.sqrt(PITCH_LENGTH * PITCH_LENGTH + PITCH_WIDTH * PITCH_WIDTH)  # DEF_VISUAL_DIST, for protocols before 18
_POINT_SIGMA = 1.25 * D2R
_TICK = 32  # draws between two messages of one cycle
MARGIN = 1e-9  # of the distance, within which the exact formula decides
_SLACK = 1e-6  # m or m^2, by which `perhaps_seen` errs on the safe side


# ---------------------------------------------------------------------------------------------- when
@kernel
def view_cone(w, p, i):
    """Angle (rad) of the view cone of player `i`."""
    width = w.view_width[i]
    if w.synchronous[i]:
        degrees = 60.0 if width == NARROW else 180.0 if width == WIDE else 120.0
    else:
        degrees = p.visible_angle * (0.5 if width == NARROW else 2.0 if width == WIDE else 1.0)
    return degrees * D2R


@kernel
def view_edge(w, p, i):
    """Half the view cone (rad) of player `i` and its cosine; -2, which no direction has, for cones that miss nothing."""
    half = 0.5 * view_cone(w, p, i)
    if w.synchronous[i]:
        width = w.view_width[i]
        return half, 0.8660254037844387 if width == NARROW else 0.0 if width == WIDE else 0.5000000000000001
    return half, math.cos(half) if half < PI else -2.0


@kernel
def see_interval(w, i):
    """Opportunities (cycles, or 37.5 ms sub-ticks when asynchronous) from one message of player `i` to the next."""
    width = w.view_width[i]
    if w.synchronous[i]:
        return 1 if width == NARROW else 3 if width == WIDE else 2
    interval = 2 if width == NARROW else 8 if width == WIDE else 4
    return interval // 2 if w.view_quality[i] == LOW_QUALITY else interval


@kernel
def count_opportunity(w, i, bit):
    """One opportunity for player `i`; sets `bit` of ``w.saw`` when it brings a message."""
    w.see_counter[i] += 1
    if w.see_counter[i] >= see_interval(w, i):
        w.see_counter[i] = 0
        w.saw[i] |= np.uint8(bit)


@kernel
def late_messages_due(w):
    """Count the sub-tick that lies between the commands and the next step (at 80, 190 and 270 of 300 ms), once per cycle.

    Sets bit 4 of ``w.saw`` for asynchronous players who get a message then; it shows the world before the step.
    """
    for i in range(PLAYERS):
        if w.enabled[i] and not w.synchronous[i] and not w.saw[i] & 8:
            count_opportunity(w, i, 4)
            w.saw[i] |= np.uint8(8)


@kernel
def late_messages_of_all(worlds):
    """`late_messages_due` of all worlds."""
    for n in range(worlds.shape[0]):
        late_messages_due(worlds[n])


@kernel
def see_messages_due(w):
    """Decide after a step who gets a see message before the next commands: bits 1 and 2 of ``w.saw``, first and second.

    A synchronous player has one opportunity; an asynchronous one those sub-ticks of the 300 ms period (40, 80, 120, 150, 190, 230,
    270, 300) that lie between this step and the commands, which are taken to arrive 60 ms after it.
    """
    sub_ticks = 1 if w.steps % 3 == 2 else 2
    for i in range(PLAYERS):
        w.saw[i] = 0
        if w.enabled[i]:
            count_opportunity(w, i, 1)
            if not w.synchronous[i] and sub_ticks == 2:
                count_opportunity(w, i, 2)


@kernel
def is_fresh(w, i):
    """Whether player `i` gets a see message in this cycle.

    An asynchronous player's late message counts before it is sent: in real time it would still come before the commands.
    """
    if not w.enabled[i]:
        return False
    if w.saw[i]:
        return True
    return not w.synchronous[i] and w.see_counter[i] + 1 >= see_interval(w, i)


# ---------------------------------------------------------------------------------------------- the eye
class Eye(NamedTuple):
    """What looking needs to know of the observer; see `eye_of`."""

    x: float
    y: float
    body: float
    neck: float
    cosine: float  # of the face, body + neck
    sine: float
    half_cone: float  # rad
    edge: float  # its cosine, -2 for a cone that misses nothing
    near: float  # m, radius of the feel
    modern: bool  # protocol 18 or later: focus, limits of the player's type
    rounded: bool  # protocol 7 or later: directions rounded, not truncated
    gaussian: bool
    focused: bool
    focus_x: float
    focus_y: float
    low: bool  # low view quality: names and directions only


@kernel
def eye_of(w, p, i, protocol):
    """The `Eye` of player `i`, whose client speaks that protocol version."""
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    body, neck = w.body[i], w.neck[i]
    half_cone, edge = view_edge(w, p, i)
    modern = protocol >= FOCUS_PROTOCOL
    focused = modern and w.focus_distance[i] != 0.0
    focus_x, focus_y = x, y
    if focused:
        angle = norm(body + neck + w.focus_direction[i])
        focus_x += w.focus_distance[i] * math.cos(angle)
        focus_y += w.focus_distance[i] * math.sin(angle)
    low = w.view_quality[i] == LOW_QUALITY and w.synchronous[i] == 0
    return Eye(
        x, y, body, neck, math.cos(body + neck), math.sin(body + neck), half_cone, edge, p.visible_distance,
        modern, protocol >= ROUNDING_PROTOCOL, w.gaussian[i] != 0, focused, focus_x, focus_y, low,
    )  # fmt: skip


@kernel
def perhaps_seen(eye, dx, dy):
    """False only for an object at relative position (dx, dy) that is certainly neither seen nor felt; without root and branches."""
    ahead = dx * eye.cosine + dy * eye.sine
    squared = dx * dx + dy * dy
    in_cone = (ahead > -_SLACK) & (ahead * ahead > eye.edge * eye.edge * squared - _SLACK)
    return in_cone | (squared < eye.near * eye.near + _SLACK) | (eye.edge < -_SLACK)


@kernel
def lowest_bit(mask):
    """Number of the lowest bit that is set in a positive word."""
    return (np.float64(mask & -mask).view(np.int64) >> 52) - 1023


@kernel
def is_in_view(eye, dx, dy, distance, farthest):
    """Whether an object is within the view cone and the observation length."""
    if distance >= farthest:
        return False
    inside = dx * eye.cosine + dy * eye.sine - eye.edge * distance
    if abs(inside) > MARGIN * distance:
        return inside > 0.0
    return abs(face_direction(dx, dy, eye.body, eye.neck)) < eye.half_cone


@kernel
def focus_distance(eye, dx, dy, distance):
    """Distance (m) of the object from the focus point."""
    if not eye.focused:
        return distance
    fx, fy = eye.x + dx - eye.focus_x, eye.y + dy - eye.focus_y
    return math.sqrt(fx * fx + fy * fy)


@kernel
def told_direction(eye, dx, dy):
    """Direction (rad, whole degrees) of the object relative to the face."""
    if eye.rounded:
        ahead, aside = dx * eye.cosine + dy * eye.sine, dy * eye.cosine - dx * eye.sine
        return face_degrees(dx, dy, ahead, aside, eye.body, eye.neck) * D2R
    return truncated_degrees(face_direction(dx, dy, eye.body, eye.neck)) * D2R


@kernel
def noisy_distance(w, i, purpose, draw, distance, sigma):
    """The distance (m) told by the Gaussian model; a negative draw is without noise."""
    return max(0.0, normal(w, SENSORS, i, purpose, draw, distance, sigma)) if draw >= 0 else distance


# ---------------------------------------------------------------------------------------------- what
@kernel
def is_lost(w, i, purpose, draw, distance, far, too_far):
    """Whether something certain up to `far` and lost from `too_far` is lost at the told `distance`; a negative draw never loses."""
    probability = (distance - far) / (too_far - far)
    if probability >= 1.0:
        return True
    return probability > 0.0 and draw >= 0 and uniform(w, SENSORS, i, purpose, draw) < probability


@kernel
def pointing_direction(w, i, j, distance, draw, rounded):
    """Direction (rad, whole degrees) of the arm of player `j` as player `i` sees it."""
    x = w.arm_target[j, 0] - w.pos[j + 1, 0]
    y = w.arm_target[j, 1] - w.pos[j + 1, 1]
    share = distance / VISUAL
    sigma = share * share * share * share * (PI - _POINT_SIGMA) + _POINT_SIGMA
    noise = normal(w, SENSORS, i, SEE_POINTING, draw, 0.0, sigma) if draw >= 0 else 0.0
    return told_degrees(norm(face_direction(x, y, w.body[i], w.neck[i]) + noise), rounded) * D2R


@kernel
def changes(vx, vy, dx, dy, distance, told, gaussian):
    """Changes of distance (m / cycle) and direction (rad / cycle) of an object, seen at relative position (dx, dy) and told `distance`.

    (vx, vy) is its relative velocity (specification/simulator.md 6.1.5).
    """
    if distance == 0.0:
        return 0.0, 0.0
    ex, ey = dx / distance, dy / distance
    radial = vx * ex + vy * ey
    across = (vy * ex - vx * ey) / distance * R2D
    turned = 0.0 if across == 0.0 else quantize(across, 0.1) * D2R
    if gaussian:
        return quantize(radial * told / distance, 0.01), turned
    return told * quantize(radial / distance, 0.02), turned


@kernel
def tell_distance(w, p, i, eye, draw, dx, dy, distance):
    """The distance (m) told of a movable object."""
    if eye.gaussian:
        kind = w.type[i]
        sigma = distance * p.types[kind, T_DIST_NOISE_RATE]
        sigma += focus_distance(eye, dx, dy, distance) * p.types[kind, T_FOCUS_DIST_NOISE_RATE]
        return noisy_distance(w, i, SEE_DISTANCE, draw, distance, sigma)
    if eye.focused:
        return seen_distance(distance, focus_distance(eye, dx, dy, distance), p.quantize_step)
    return banded_distance(distance, p.quantize_step)


@kernel
def tell_player(w, p, i, eye, draw, j, dx, dy, distance, told, players):
    """The rest of the row of player `j`, who is in view of player `i`: level and marks as a pair."""
    far, too_far, team_far, team_too_far = 20.0, 40.0, 40.0, 60.0
    kind = w.type[i]
    if eye.modern:
        team_far, team_too_far = p.types[kind, T_TEAM_FAR_LENGTH], p.types[kind, T_TEAM_TOO_FAR_LENGTH]
        far, too_far = p.types[kind, T_UNUM_FAR_LENGTH], p.types[kind, T_UNUM_TOO_FAR_LENGTH]
    if told > team_far and is_lost(w, i, SEE_TEAM, draw, told, team_far, team_too_far):
        return FELT, IN_VIEW
    marks = IN_VIEW
    if w.tackle_cycles[j] > 0:
        marks |= TACKLING
    elif w.kick_cycles[j] >= 0:
        marks |= KICKING
    if w.arm_timer[j] < p.point_to_duration:
        marks |= POINTING
        players[i, j, 6] = pointing_direction(w, i, j, distance, draw, eye.rounded)
    if told > far and is_lost(w, i, SEE_UNUM, draw, told, far, too_far):
        return TEAM_SEEN, marks
    vx, vy = w.vel[j + 1, 0] - w.vel[i + 1, 0], w.vel[j + 1, 1] - w.vel[i + 1, 1]
    players[i, j, 2], players[i, j, 3] = changes(vx, vy, dx, dy, distance, told, eye.gaussian)
    players[i, j, 4] = told_degrees(norm(w.body[j] - eye.body - eye.neck), eye.rounded) * D2R
    players[i, j, 5] = told_degrees(norm(w.body[j] + w.neck[j] - eye.body - eye.neck), eye.rounded) * D2R
    return NAME_SEEN, marks


@kernel
def tell_ball(w, p, i, eye, draw, dx, dy, distance, told, ball):
    """The rest of the row of the ball, which is in view of player `i`: its level."""
    far, too_far = 20.0, 40.0
    if eye.modern:
        far, too_far = p.types[w.type[i], T_BALL_VEL_FAR_LENGTH], p.types[w.type[i], T_BALL_VEL_TOO_FAR_LENGTH]
    if told > far and is_lost(w, i, SEE_VELOCITY, draw, told, far, too_far):
        return TOLD
    vx, vy = w.vel[0, 0] - w.vel[i + 1, 0], w.vel[0, 1] - w.vel[i + 1, 1]
    ball[i, 2], ball[i, 3] = changes(vx, vy, dx, dy, distance, told, eye.gaussian)
    return TOLD_MOVING


@kernel
def forget_distances(row):
    """Low quality tells names and directions only; the rest becomes NaN."""
    row[0] = np.nan
    for k in range(2, row.shape[0]):
        row[k] = np.nan


@kernel
def look_at_ball(w, p, i, eye, tick, ball):
    """The ball in one message of player `i`: row `i` of `ball`, returns its level; arguments as `look`."""
    dx, dy = w.pos[0, 0] - eye.x, w.pos[0, 1] - eye.y
    distance = math.sqrt(dx * dx + dy * dy)
    farthest = p.types[w.type[i], T_BALL_MAX_OBSERVATION_LENGTH] if eye.modern else VISUAL
    seen = is_in_view(eye, dx, dy, distance, farthest)
    if not seen and distance > eye.near:
        return UNSEEN
    draw = _TICK * tick
    told = tell_distance(w, p, i, eye, draw, dx, dy, distance)
    ball[i, 0], ball[i, 1] = told, told_direction(eye, dx, dy)
    level = tell_ball(w, p, i, eye, draw, dx, dy, distance, told, ball) if seen else FELT
    if eye.low:
        forget_distances(ball[i])
    return level


@kernel
def look(w, p, i, protocol, tick, ball, players, levels, marks):
    """One see message of player `i`: ball and players, everybody at his own place.

    Parameters
    ----------
    protocol : version of the client, which decides focus and limits
    tick : 0 for the first message of the cycle, 1 for a second one, 2 for the one between commands and step; -1: without draws, so
        that nothing is lost that could be told
    ball : (22, 4) distance, direction, distance change, direction change; m, rad, m / cycle, rad / cycle
    players : (22, 22, 7) the same, then body, head and arm directions relative to the observer's face, rad
    levels, marks : (22, 22)
        First axis: observers; only row `i` is written and must be zero when called. Everything is rounded as the message is.

    Returns
    -------
    (level of the ball, left players and right players of level 2 as ordered words (see `inserted`), their numbers, how many of level 1)
    """
    eye = eye_of(w, p, i, protocol)
    ball_level = look_at_ball(w, p, i, eye, tick, ball)
    farthest = p.types[w.type[i], T_PLAYER_MAX_OBSERVATION_LENGTH] if eye.modern else VISUAL
    mask = np.int64(0)
    for j in range(PLAYERS):
        perhaps = perhaps_seen(eye, w.pos[j + 1, 0] - eye.x, w.pos[j + 1, 1] - eye.y) & (w.enabled[j] != 0)
        mask |= np.int64(perhaps) << j
    mask &= ~(np.int64(1) << i)
    left_order, right_order, left, right, unknown = np.int64(0), np.int64(0), 0, 0, 0
    while mask:
        j = lowest_bit(mask)
        mask &= mask - 1
        dx, dy = w.pos[j + 1, 0] - eye.x, w.pos[j + 1, 1] - eye.y
        distance = math.sqrt(dx * dx + dy * dy)
        seen = is_in_view(eye, dx, dy, distance, farthest)
        if not seen and distance > eye.near:
            continue
        draw = j + 1 + _TICK * tick
        told = tell_distance(w, p, i, eye, draw, dx, dy, distance)
        players[i, j, 0], players[i, j, 1] = told, told_direction(eye, dx, dy)
        level, mark = FELT, 0
        if seen:
            level, mark = tell_player(w, p, i, eye, draw, j, dx, dy, distance, told, players)
        levels[i, j], marks[i, j] = level, mark
        if level == FELT:
            unknown += 1
        elif level == TEAM_SEEN and j < 11:
            left_order = inserted(left_order, left, players, marks, i, j)
            left += 1
        elif level == TEAM_SEEN:
            right_order = inserted(right_order, right, players, marks, i, j)
            right += 1
        if eye.low:
            forget_distances(players[i, j])
    return ball_level, left_order, right_order, left, right, unknown


# ---------------------------------------------------------------------------------------------- who: nobody without a name
@kernel
def comes_before(players, marks, i, a, b):
    """Whether row `a` stands before row `b` among objects without a name: by what is told of them only."""
    if players[i, a, 0] != players[i, b, 0]:
        return players[i, a, 0] < players[i, b, 0]
    if players[i, a, 1] != players[i, b, 1]:
        return players[i, a, 1] < players[i, b, 1]
    return marks[i, a] > marks[i, b]


@kernel
def inserted(order, n, players, marks, i, row):
    """The ordered word with `row` put in its place.

    An ordered word holds the numbers of up to eleven rows in digits of five bits, the nearest lowest; `n` are in it so far.
    """
    k = n
    while k > 0 and comes_before(players, marks, i, row, (order >> (5 * k - 5)) & 31):
        k -= 1
    below = (np.int64(1) << (5 * k)) - 1
    return (order & below) | (np.int64(row) << (5 * k)) | ((order & ~below) << 5)


@kernel
def swap_rows(players, levels, marks, i, a, b):
    """Exchange two rows."""
    for k in range(7):
        players[i, a, k], players[i, b, k] = players[i, b, k], players[i, a, k]
    levels[i, a], levels[i, b] = levels[i, b], levels[i, a]
    marks[i, a], marks[i, b] = marks[i, b], marks[i, a]


@kernel
def fill_team_slots(players, levels, marks, i, slot, order, count):
    """Move the `count` rows of the ordered word, all of level 2 and of one team, to the first free slots from `slot` on.

    A slot is free unless a player seen with his number stands there or it is the observer's own.
    """
    for k in range(count):
        while levels[i, slot] == NAME_SEEN or slot == i:
            slot += 1
        row = (order >> (5 * k)) & 31
        if row != slot:
            if levels[i, slot] == TEAM_SEEN:  # waits in this slot: it is now found where `row` stood
                for later in range(k + 1, count):
                    if (order >> (5 * later)) & 31 == slot:
                        order += (row - np.int64(slot)) << (5 * later)
            swap_rows(players, levels, marks, i, slot, row)
        slot += 1


@kernel
def nearest_unknown(players, levels, marks, i, low, high, best):
    """The row of level 1 in ``low .. high - 1`` that stands before all others and before `best` (-1: none yet)."""
    for row in range(low, high):
        if levels[i, row] == FELT and (best < 0 or comes_before(players, marks, i, row, best)):
            best = row
    return best


@kernel
def fill_unknown_slots(players, levels, marks, i):
    """Move the rows of level 1 to the slots free after `fill_team_slots`: the opponents' first, then the own team's, nearest first."""
    opponents = 11 if i < 11 else 0
    own = 11 - opponents
    for k in range(PLAYERS):
        slot = opponents + k if k < 11 else own + k - 11
        if levels[i, slot] > FELT or slot == i:
            continue
        if k < 11:
            best = nearest_unknown(players, levels, marks, i, slot, opponents + 11, -1)
            best = nearest_unknown(players, levels, marks, i, own, own + 11, best)
        else:
            best = nearest_unknown(players, levels, marks, i, slot, own + 11, -1)
        if best < 0:
            return
        if best != slot:
            swap_rows(players, levels, marks, i, slot, best)


@kernel
def message_of_arrays(w, i):
    """(protocol version, message of the cycle) that the arrays of player `i` show: the last one before the commands."""
    protocol = w.protocol[i] if w.protocol[i] > 0 else NEWEST
    return protocol, 1 if w.saw[i] & 2 else 0 if w.saw[i] & 1 else 2


@kernel
def see_world(w, p, fresh, ball, ball_level, players, players_level, players_flags):
    """The see arrays of one world; what is not seen is zero.

    Rows without a number lose the place that would tell it: rows of level 2 go to the free slots of their team, rows of level 1 to those
    of the opponents, then of the own team, each in the order of distance.
    """
    players[:] = 0.0
    ball[:] = 0.0
    players_level[:] = 0
    players_flags[:] = 0
    for i in range(PLAYERS):
        ball_level[i] = UNSEEN
        fresh[i] = is_fresh(w, i)
        if fresh[i]:
            protocol, tick = message_of_arrays(w, i)
            level, left_order, right_order, left, right, unknown = look(
                w, p, i, protocol, tick, ball, players, players_level, players_flags
            )
            ball_level[i] = level
            fill_team_slots(players, players_level, players_flags, i, 0, left_order, left)
            fill_team_slots(players, players_level, players_flags, i, 11, right_order, right)
            if unknown:
                fill_unknown_slots(players, players_level, players_flags, i)


@kernel
def see_worlds(worlds, parameters, chosen, fresh, ball, ball_level, players, players_level, players_flags, start, stop):
    """`see_world` for the worlds ``chosen[start:stop]``; row k of every array is world ``chosen[k]``."""
    p = parameters[0]
    for k in range(start, stop):
        see_world(worlds[chosen[k]], p, fresh[k], ball[k], ball_level[k], players[k], players_level[k], players_flags[k])
