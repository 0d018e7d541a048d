"""See: landmarks and lines (SIMULATOR.md 6.1.6, 6.1.7); computed only when asked for."""

from __future__ import annotations

import math

import numpy as np

from cprm_gym.simulator.kernels import kernel
from cprm_gym.simulator.kernels.geometry import D2R, norm, quantize
from cprm_gym.simulator.kernels.random import SEE_FLAG, SEE_FLAG_DISTANCE, SENSORS, normal
from cprm_gym.simulator.kernels.rounding import (
    banded_distance,
    face_degrees,
    face_direction,
    quantised_length,
    seen_distance,
    told_degrees,
    truncated_degrees,
)
from cprm_gym.simulator.kernels.senses import (
    FELT,
    FOCUS_PROTOCOL,
    LOW_QUALITY,
    ROUNDING_PROTOCOL,
    TOLD,
    TOLD_MOVING,
    UNSEEN,
    _MARGIN,
    _VISUAL,
    PI,
    changes,
    forget_distances,
    is_fresh,
    is_lost,
    message_of_arrays,
    view_edge,
)
from cprm_gym.simulator.landmarks import GOALS, LANDMARK_POSITIONS, LANDMARK_PROTOCOLS, LANDMARKS
from cprm_gym.simulator.player_types import (
    T_FLAG_CHG_FAR_LENGTH,
    T_FLAG_CHG_TOO_FAR_LENGTH,
    T_FLAG_MAX_OBSERVATION_LENGTH,
    T_LAND_DIST_NOISE_RATE,
    T_LAND_FOCUS_DIST_NOISE_RATE,
)
from cprm_gym.simulator.state import PLAYERS

_TICK = 64
_RIGHT_GOAL, _LEFT_GOAL = GOALS
_HALF_LENGTH, _HALF_WIDTH = 52.5, 34.0


@kernel
def look_at_landmarks(w, p, i, protocol, tick, rows, levels):
    """Landmarks of one message of player `i`, in the server's order.

    rows : (55, 4) distance, direction, distance change, direction change; m, rad, m / cycle, rad / cycle; zero when called
    levels : (55,) UNSEEN, FELT, TOLD or TOLD_MOVING
    """
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    body, neck = w.body[i], w.neck[i]
    cosine, sine = math.cos(body + neck), math.sin(body + neck)
    half_cone, edge = view_edge(w, p, i)
    behind = edge >= -_MARGIN
    modern, gaussian = protocol >= FOCUS_PROTOCOL, w.gaussian[i]
    low = w.view_quality[i] == LOW_QUALITY and not w.synchronous[i]
    focused = modern and w.focus_distance[i] != 0.0
    focus_x, focus_y = x, y
    if focused:
        angle = norm(body + neck + w.focus_direction[i])
        focus_x += w.focus_distance[i] * math.cos(angle)
        focus_y += w.focus_distance[i] * math.sin(angle)
    kind = w.type[i]
    farthest = p.types[kind, T_FLAG_MAX_OBSERVATION_LENGTH] if modern else _VISUAL
    far = p.types[kind, T_FLAG_CHG_FAR_LENGTH] if modern else 20.0
    too_far = p.types[kind, T_FLAG_CHG_TOO_FAR_LENGTH] if modern else 40.0
    near = p.visible_distance
    near_squared = near * near * (1.0 + _MARGIN)
    vx, vy = 0.0 - w.vel[i + 1, 0], 0.0 - w.vel[i + 1, 1]
    for j in range(LANDMARKS):
        dx, dy = LANDMARK_POSITIONS[j, 0] - x, LANDMARK_POSITIONS[j, 1] - y
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
        seen = seen and distance < farthest
        if (not seen and distance > near) or LANDMARK_PROTOCOLS[j] > protocol:
            continue
        draw = j + _TICK * tick
        if not focused and not gaussian:
            told = banded_distance(distance, p.quantize_step_l)
        else:
            focus_distance = math.sqrt((x + dx - focus_x) ** 2 + (y + dy - focus_y) ** 2) if focused else distance
            if gaussian:
                sigma = distance * p.types[kind, T_LAND_DIST_NOISE_RATE] + focus_distance * p.types[kind, T_LAND_FOCUS_DIST_NOISE_RATE]
                told = max(0.0, normal(w, SENSORS, i, SEE_FLAG_DISTANCE, draw, distance, sigma) if draw >= 0 else distance)
            else:
                told = seen_distance(distance, focus_distance, p.quantize_step_l)
        rows[j, 0] = told
        if protocol >= ROUNDING_PROTOCOL:
            rows[j, 1] = face_degrees(dx, dy, ahead, dy * cosine - dx * sine, body, neck) * D2R
        else:
            rows[j, 1] = truncated_degrees(face_direction(dx, dy, body, neck)) * D2R
        levels[j] = FELT
        if seen:
            levels[j] = TOLD
            if told <= far or not is_lost(w, i, SEE_FLAG, draw, told, far, too_far):
                levels[j] = TOLD_MOVING
                rows[j, 2], rows[j, 3] = changes(vx, vy, dx, dy, distance, told, gaussian)
        if low:
            forget_distances(rows[j])


@kernel
def hide_landmarks(rows, levels):
    """Take from felt landmarks the place that would tell their name.

    What remains known is whether it is a flag or a goal: felt flags go to the first slots of unseen flags, a felt goal to that of
    the right goal, unless that is seen. Several are put in the order of distance, then of direction.
    """
    for slot in range(LANDMARKS):
        if levels[slot] > FELT or slot == _LEFT_GOAL or slot == _RIGHT_GOAL:
            continue
        best = -1
        for j in range(slot, LANDMARKS):
            if levels[j] == FELT and j != _RIGHT_GOAL and j != _LEFT_GOAL:
                if best < 0 or rows[j, 0] < rows[best, 0] or (rows[j, 0] == rows[best, 0] and rows[j, 1] < rows[best, 1]):
                    best = j
        if best < 0:
            break
        if best != slot:
            move_landmark(rows, levels, slot, best)
    if levels[_LEFT_GOAL] == FELT and levels[_RIGHT_GOAL] == UNSEEN:
        move_landmark(rows, levels, _RIGHT_GOAL, _LEFT_GOAL)


@kernel
def move_landmark(rows, levels, a, b):
    """Exchange two rows."""
    for k in range(4):
        rows[a, k], rows[b, k] = rows[b, k], rows[a, k]
    levels[a], levels[b] = levels[b], levels[a]


@kernel
def look_at_lines(w, p, i, protocol, rows, ids):
    """Lines of one message of player `i`: one when he is inside the pitch, at most two outside.

    rows : (2, 2) distance (m) and direction (rad); zero when called
    ids : (2,) `Line`
    """
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    wanted = 1 if abs(x) < _HALF_LENGTH and abs(y) < _HALF_WIDTH else 2
    found = 0
    for line in range(1, 5):
        if line <= 2:
            across = (-_HALF_LENGTH if line == 1 else _HALF_LENGTH) - x
            normal_direction = PI if line == 1 else 0.0
            beyond = across > 0.0 if line == 1 else across < 0.0
        else:
            across = (-_HALF_WIDTH if line == 3 else _HALF_WIDTH) - y
            normal_direction = -0.5 * PI if line == 3 else 0.5 * PI
            beyond = across > 0.0 if line == 3 else across < 0.0
        if beyond:
            normal_direction += PI
        slant = norm(normal_direction - w.body[i] - w.neck[i])
        if abs(slant) >= 0.5 * PI:
            continue
        if line <= 2:
            hit, end = y - across * math.tan(slant), _HALF_WIDTH
        else:
            hit, end = x + across * math.tan(slant), _HALF_LENGTH
        if abs(hit) > end:
            continue
        rows[found, 0] = quantize(quantised_length(abs(across / math.cos(slant)), p.quantize_step_l), 0.1)
        rows[found, 1] = told_degrees(slant - 0.5 * PI if slant > 0.0 else slant + 0.5 * PI, protocol) * D2R
        if w.view_quality[i] == LOW_QUALITY and not w.synchronous[i]:
            rows[found, 0] = np.nan
        ids[found] = line
        found += 1
        if found == wanted:
            return


@kernel
def landmarks_of_world(w, p, rows, levels, line_rows, line_ids):
    """The landmark and line arrays of one world; zero for players who get no message."""
    for i in range(PLAYERS):
        rows[i] = 0.0
        levels[i] = 0
        line_rows[i] = 0.0
        line_ids[i] = 0
        if is_fresh(w, i):
            protocol, tick = message_of_arrays(w, i)
            look_at_landmarks(w, p, i, protocol, tick, rows[i], levels[i])
            hide_landmarks(rows[i], levels[i])
            look_at_lines(w, p, i, protocol, line_rows[i], line_ids[i])


@kernel
def landmarks_of_worlds(worlds, parameters, rows, levels, line_rows, line_ids, start, stop):
    """`landmarks_of_world` for worlds `start` to `stop`."""
    p = parameters[0]
    for k in range(start, stop):
        landmarks_of_world(worlds[k], p, rows[k], levels[k], line_rows[k], line_ids[k])
