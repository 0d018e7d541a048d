"""See: what each player is told of the ball and the others, and when (SIMULATOR.md 6.1).

`look` makes one message in the server's order of objects; `see_worlds` makes the arrays, in which objects without a name have lost
their place (`hide_identities`). Both use the same draws, numbered by observer, object and message of the cycle, so text and arrays
agree. `messages_due` decides, once per step, who gets a message.
"""

from __future__ import annotations

import math

import numpy as np

from cprm_gym.simulator.kernels import kernel
from cprm_gym.simulator.kernels.geometry import D2R, R2D, norm, quantize
from cprm_gym.simulator.kernels.random import (
    SEE_DISTANCE,
    SEE_POINTING,
    SEE_TEAM,
    SEE_UNUM,
    SEE_VELOCITY,
    SENSORS,
    normal,
    uniform,
)
from cprm_gym.simulator.kernels.rounding import (
    banded_distance,
    face_degrees,
    face_direction,
    rounded_degrees,
    seen_distance,
    told_degrees,
    truncated_degrees,
)
from cprm_gym.simulator.player_types import (
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
from cprm_gym.simulator.state import PLAYERS, ViewWidth

PI = math.pi
NARROW, WIDE = int(ViewWidth.NARROW), int(ViewWidth.WIDE)
LOW_QUALITY = 2
FOCUS_PROTOCOL = 18                          # first protocol version that sees with a focus
NEWEST = 19
ROUNDING_PROTOCOL = 7                        # first protocol version whose directions are rounded, not truncated

UNSEEN, FELT, TEAM_SEEN, NAME_SEEN = 0, 1, 2, 3          # levels of players
TOLD, TOLD_MOVING = 2, 3                                 # levels of the ball and of landmarks above FELT
TACKLING, KICKING, POINTING, IN_VIEW = 1, 2, 4, 8        # marks of players

_VISUAL = math.sqrt(105.0 * 105.0 + 68.0 * 68.0)         # DEF_VISUAL_DIST, for protocols before 18
_POINT_SIGMA = 1.25 * D2R
_TICK = 32                                               # draws between two messages of one cycle
_MARGIN = 1e-9


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


# ---------------------------------------------------------------------------------------------- what
@kernel
def is_lost(w, i, purpose, draw, distance, far, too_far):
    """Whether something certain up to `far` and lost from `too_far` is lost at the told `distance`; a negative draw never loses."""
    probability = (distance - far) / (too_far - far)
    if probability >= 1.0:
        return True
    return probability > 0.0 and draw >= 0 and uniform(w, SENSORS, i, purpose, draw) < probability


@kernel
def pointing_degrees(w, i, j, distance, draw):
    """Direction (degrees) of the arm of player `j` as player `i` sees it."""
    x = w.arm_target[j, 0] - w.pos[j + 1, 0]
    y = w.arm_target[j, 1] - w.pos[j + 1, 1]
    share = distance / _VISUAL
    sigma = share * share * share * share * (PI - _POINT_SIGMA) + _POINT_SIGMA
    noise = normal(w, SENSORS, i, SEE_POINTING, draw, 0.0, sigma) if draw >= 0 else 0.0
    return rounded_degrees(norm(face_direction(x, y, w.body[i], w.neck[i]) + noise))


@kernel
def tell_changes(w, i, j, dx, dy, distance, told, gaussian, row):
    """Distance change (m / cycle) and direction change (rad / cycle) of object `j` into ``row[2:4]``."""
    if distance == 0.0:
        return
    vx = w.vel[j, 0] - w.vel[i + 1, 0]
    vy = w.vel[j, 1] - w.vel[i + 1, 1]
    changes(vx, vy, dx / distance, dy / distance, distance, told, gaussian, row)


@kernel
def changes(vx, vy, ex, ey, distance, told, gaussian, row):
    """SIMULATOR.md 6.1.5: relative velocity (vx, vy), unit vector (ex, ey) towards the object."""
    radial = vx * ex + vy * ey
    across = (vy * ex - vx * ey) / distance * R2D
    if gaussian:
        row[2] = quantize(radial * told / distance, 0.01)
    else:
        row[2] = told * quantize(radial / distance, 0.02)
    row[3] = 0.0 if across == 0.0 else quantize(across, 0.1) * D2R


@kernel
def tell_player(w, p, i, j, protocol, draw, dx, dy, distance, told, row):
    """The rest of the row of player `j`, who is in view of player `i`: level and marks as a pair."""
    if protocol >= FOCUS_PROTOCOL:
        limits = p.types[w.type[i]]
        far, too_far = limits[T_UNUM_FAR_LENGTH], limits[T_UNUM_TOO_FAR_LENGTH]
        team_far, team_too_far = limits[T_TEAM_FAR_LENGTH], limits[T_TEAM_TOO_FAR_LENGTH]
    else:
        far, too_far, team_far, team_too_far = 20.0, 40.0, 40.0, 60.0
    if told > team_far and is_lost(w, i, SEE_TEAM, draw, told, team_far, team_too_far):
        return FELT, IN_VIEW
    marks = IN_VIEW
    if w.tackle_cycles[j] > 0:
        marks |= TACKLING
    elif w.kick_cycles[j] >= 0:
        marks |= KICKING
    if w.arm_timer[j] < p.point_to_duration:
        marks |= POINTING
        row[6] = pointing_degrees(w, i, j, distance, draw) * D2R
    if told > far and is_lost(w, i, SEE_UNUM, draw, told, far, too_far):
        return TEAM_SEEN, marks
    tell_changes(w, i, j + 1, dx, dy, distance, told, w.gaussian[i], row)
    body, neck = w.body[i], w.neck[i]
    row[4] = told_degrees(norm(w.body[j] - body - neck), protocol) * D2R
    row[5] = told_degrees(norm(w.body[j] + w.neck[j] - body - neck), protocol) * D2R
    return NAME_SEEN, marks


@kernel
def tell_ball(w, p, i, protocol, draw, dx, dy, distance, told, row):
    """The rest of the row of the ball, which is in view of player `i`: its level."""
    far, too_far = 20.0, 40.0
    if protocol >= FOCUS_PROTOCOL:
        limits = p.types[w.type[i]]
        far, too_far = limits[T_BALL_VEL_FAR_LENGTH], limits[T_BALL_VEL_TOO_FAR_LENGTH]
    if told > far and is_lost(w, i, SEE_VELOCITY, draw, told, far, too_far):
        return TOLD
    tell_changes(w, i, 0, dx, dy, distance, told, w.gaussian[i], row)
    return TOLD_MOVING


@kernel
def forget_distances(row):
    """Low quality tells names and directions only; the rest becomes NaN."""
    row[0] = np.nan
    for k in range(2, row.shape[0]):
        row[k] = np.nan


@kernel
def look(w, p, i, protocol, tick, ball, players, levels, marks):
    """One see message of player `i`: ball and players, in the server's order; returns the level of the ball.

    protocol : version of the client, which decides focus and limits
    tick : 0 for the first message of the cycle, 1 for a second one, 2 for the one between commands and step; -1: without draws, so
        that nothing is lost that could be told
    ball : (4,) distance, direction, distance change, direction change; m, rad, m / cycle, rad / cycle
    players : (22, 7) the same, then body, head and arm directions relative to the observer's face, rad
    levels, marks : (22,)

    Everything is rounded as the message is. The rows must be zero when called.
    """
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    body, neck = w.body[i], w.neck[i]
    cosine, sine = math.cos(body + neck), math.sin(body + neck)
    half_cone = 0.5 * view_cone(w, p, i)
    edge = math.cos(half_cone) if half_cone < PI else -2.0
    behind = edge >= -_MARGIN
    modern, gaussian = protocol >= FOCUS_PROTOCOL, w.gaussian[i]
    low = w.view_quality[i] == LOW_QUALITY and not w.synchronous[i]
    focused = modern and w.focus_distance[i] != 0.0
    focus_x, focus_y = x, y
    if focused:
        angle = norm(body + neck + w.focus_direction[i])
        focus_x += w.focus_distance[i] * math.cos(angle)
        focus_y += w.focus_distance[i] * math.sin(angle)
    limits = p.types[w.type[i]]
    far_ball = limits[T_BALL_MAX_OBSERVATION_LENGTH] if modern else _VISUAL
    far_player = limits[T_PLAYER_MAX_OBSERVATION_LENGTH] if modern else _VISUAL
    near = p.visible_distance
    near_squared = near * near * (1.0 + _MARGIN)
    ball_level = UNSEEN
    for j in range(PLAYERS + 1):
        if j == i + 1 or (j > 0 and not w.enabled[j - 1]):
            continue
        dx, dy = w.pos[j, 0] - x, w.pos[j, 1] - y
        ahead = dx * cosine + dy * sine
        squared = dx * dx + dy * dy
        if behind and ahead < -1e-6 and squared > near_squared:
            continue
        distance = math.sqrt(squared)
        inside = ahead - edge * distance
        if abs(inside) > _MARGIN * distance:
            seen = inside > 0.0
        else:
            seen = abs(face_direction(dx, dy, body, neck)) < half_cone
        seen = seen and distance < (far_player if j > 0 else far_ball)
        if not seen and distance > near:
            continue
        draw = j + _TICK * tick
        if not focused and not gaussian:
            told = banded_distance(distance, p.quantize_step)
        else:
            focus_distance = math.sqrt((x + dx - focus_x) ** 2 + (y + dy - focus_y) ** 2) if focused else distance
            if gaussian:
                sigma = distance * limits[T_DIST_NOISE_RATE] + focus_distance * limits[T_FOCUS_DIST_NOISE_RATE]
                told = max(0.0, normal(w, SENSORS, i, SEE_DISTANCE, draw, distance, sigma))
            else:
                told = seen_distance(distance, focus_distance, p.quantize_step)
        row = players[j - 1] if j > 0 else ball
        row[0] = told
        if protocol >= ROUNDING_PROTOCOL:
            row[1] = face_degrees(dx, dy, ahead, dy * cosine - dx * sine, body, neck) * D2R
        else:
            row[1] = truncated_degrees(face_direction(dx, dy, body, neck)) * D2R
        if j == 0:
            ball_level = tell_ball(w, p, i, protocol, draw, dx, dy, distance, told, row) if seen else FELT
        elif seen:
            levels[j - 1], marks[j - 1] = tell_player(w, p, i, j - 1, protocol, draw, dx, dy, distance, told, row)
        else:
            levels[j - 1] = FELT
        if low:
            forget_distances(row)
    return ball_level


# ---------------------------------------------------------------------------------------------- who: nobody without a name
@kernel
def comes_before(players, marks, a, b):
    """Whether row `a` stands before row `b` among objects without a name: by what is told of them only."""
    if players[a, 0] != players[b, 0]:
        return players[a, 0] < players[b, 0]
    if players[a, 1] != players[b, 1]:
        return players[a, 1] < players[b, 1]
    return marks[a] > marks[b]


@kernel
def swap_rows(players, levels, marks, a, b):
    """Exchange two rows."""
    for k in range(7):
        players[a, k], players[b, k] = players[b, k], players[a, k]
    levels[a], levels[b] = levels[b], levels[a]
    marks[a], marks[b] = marks[b], marks[a]


@kernel
def fill_slots(players, levels, marks, i, first, second, level):
    """Move the rows of `level` to the free slots of the block at `first`, then of the block at `second` (-1: none), nearest first.

    A slot is free unless a row of a higher level stands there or it is the observer's own.
    """
    blocks = 1 if second < 0 else 2
    for slot_block in range(blocks):
        start = first if slot_block == 0 else second
        for slot in range(start, start + 11):
            if levels[slot] > level or slot == i:
                continue
            best = -1
            for block in range(slot_block, blocks):
                low = slot if block == slot_block else second
                high = start + 11 if block == slot_block else second + 11
                for row in range(low, high):
                    if levels[row] == level and (best < 0 or comes_before(players, marks, row, best)):
                        best = row
            if best < 0:
                return
            if best != slot:
                swap_rows(players, levels, marks, slot, best)


@kernel
def hide_identities(i, players, levels, marks):
    """Take from rows without a number the place that would tell it.

    Rows of level 2 go to the free slots of their team, rows of level 1 to those of the opponents, then of the own team, each in the
    order of distance.
    """
    left, right, unknown = 0, 0, 0
    for j in range(PLAYERS):
        if levels[j] == TEAM_SEEN:
            if j < 11:
                left += 1
            else:
                right += 1
        elif levels[j] == FELT:
            unknown += 1
    if left:
        fill_slots(players, levels, marks, i, 0, -1, TEAM_SEEN)
    if right:
        fill_slots(players, levels, marks, i, 11, -1, TEAM_SEEN)
    if unknown:
        own = 0 if i < 11 else 11
        fill_slots(players, levels, marks, i, 11 - own, own, FELT)


@kernel
def message_of_arrays(w, i):
    """(protocol version, message of the cycle) that the arrays of player `i` show: the last one before the commands."""
    protocol = w.protocol[i] if w.protocol[i] > 0 else NEWEST
    return protocol, 1 if w.saw[i] & 2 else 0 if w.saw[i] & 1 else 2


@kernel
def see_world(w, p, fresh, ball, ball_level, players, players_level, players_flags):
    """The see arrays of one world; what is not seen is zero."""
    for i in range(PLAYERS):
        players[i] = 0.0
        ball[i] = 0.0
        players_level[i] = 0
        players_flags[i] = 0
        ball_level[i] = UNSEEN
        fresh[i] = is_fresh(w, i)
        if fresh[i]:
            protocol, tick = message_of_arrays(w, i)
            ball_level[i] = look(w, p, i, protocol, tick, ball[i], players[i], players_level[i], players_flags[i])
            hide_identities(i, players[i], players_level[i], players_flags[i])


@kernel
def see_worlds(worlds, parameters, fresh, ball, ball_level, players, players_level, players_flags, start, stop):
    """`see_world` for worlds `start` to `stop`; first axis of every array: worlds."""
    p = parameters[0]
    for k in range(start, stop):
        see_world(worlds[k], p, fresh[k], ball[k], ball_level[k], players[k], players_level[k], players_flags[k])
