"""See: landmarks and lines (specification/simulator.md 6.1.6, 6.1.7); computed only when asked for."""

from __future__ import annotations

import math

import numpy as np

from ..landmarks import GOALS, LANDMARK_POSITIONS, LANDMARK_PROTOCOLS, LANDMARKS
from ..pitch import HALF_LENGTH, HALF_WIDTH
from ..player_types import (
    T_FLAG_CHG_FAR_LENGTH,
    T_FLAG_CHG_TOO_FAR_LENGTH,
    T_FLAG_MAX_OBSERVATION_LENGTH,
    T_LAND_DIST_NOISE_RATE,
    T_LAND_FOCUS_DIST_NOISE_RATE,
)
from ..state import PLAYERS
from . import kernel
from .geometry import D2R, norm, quantize
from .random import SEE_FLAG, SEE_FLAG_DISTANCE
from .rounding import banded_distance, is_settled, quantised_length, rough_degrees, seen_distance, told_degrees
from .senses import (
    FELT,
    LOW_QUALITY,
    MARGIN,
    PI,
    ROUNDING_PROTOCOL,
    TOLD,
    TOLD_MOVING,
    UNSEEN,
    VISUAL,
    changes,
    eye_of,
    focus_distance,
    forget_distances,
    is_fresh,
    is_in_view,
    is_lost,
    lowest_bit,
    message_of_arrays,
    noisy_distance,
    perhaps_seen,
    told_direction,
)

_TICK = 64
_RIGHT_GOAL, _LEFT_GOAL = GOALS
_MARK_X, _MARK_Y = (np.ascontiguousarray(LANDMARK_POSITIONS[:, axis]) for axis in range(2))


@kernel
def tell_landmark_distance(w, p, i, eye, draw, dx, dy, distance):
    """The distance (m) told of a landmark."""
    if eye.gaussian:
        kind = w.type[i]
        sigma = distance * p.types[kind, T_LAND_DIST_NOISE_RATE]
        sigma += focus_distance(eye, dx, dy, distance) * p.types[kind, T_LAND_FOCUS_DIST_NOISE_RATE]
        return noisy_distance(w, i, SEE_FLAG_DISTANCE, draw, distance, sigma)
    if eye.focused:
        return seen_distance(distance, focus_distance(eye, dx, dy, distance), p.quantize_step_l)
    return banded_distance(distance, p.quantize_step_l)


@kernel
def flag_limits(w, p, i, modern):
    """(farthest, far, too far): metres up to which player `i` sees landmarks, tells their changes surely, and loses them surely."""
    if not modern:
        return VISUAL, 20.0, 40.0
    kind = w.type[i]
    farthest = p.types[kind, T_FLAG_MAX_OBSERVATION_LENGTH]
    return farthest, p.types[kind, T_FLAG_CHG_FAR_LENGTH], p.types[kind, T_FLAG_CHG_TOO_FAR_LENGTH]


@kernel
def perhaps_seen_landmarks(eye, protocol):
    """The landmarks, as bits, that are not certainly out of sight."""
    mask = np.int64(0)
    for j in range(LANDMARKS):
        perhaps = perhaps_seen(eye, LANDMARK_POSITIONS[j, 0] - eye.x, LANDMARK_POSITIONS[j, 1] - eye.y)
        mask |= np.int64(perhaps & (LANDMARK_PROTOCOLS[j] <= protocol)) << j
    return mask


@kernel
def survey(eye, sight):
    """Distance (m) and rough direction (degrees) of every landmark, side by side; those that are not certainly out of the cone, as bits.

    One pass without branches, so that several landmarks are worked out at once. sight : (3, 55), the last row how far inside the cone's
    edge, m
    """
    mask = np.int64(0)
    for j in range(LANDMARKS):
        dx, dy = _MARK_X[j] - eye.x, _MARK_Y[j] - eye.y
        ahead, aside = dx * eye.cosine + dy * eye.sine, dy * eye.cosine - dx * eye.sine
        distance = math.sqrt(dx * dx + dy * dy)
        sight[0, j], sight[1, j] = distance, rough_degrees(ahead, aside)
        sight[2, j] = ahead - eye.edge * distance
    for j in range(LANDMARKS):
        mask |= np.int64(sight[2, j] >= -MARGIN * sight[0, j]) << j
    return mask


@kernel
def glance_at_landmarks(w, p, i, protocol, tick, sight, rows):
    """What finding one's own place needs of `look_at_landmarks`: which landmarks are seen, as bits, where they are told to be.

    sight : (3, 55) to be overwritten; rows : (55, 4); only distance (m) and direction (rad) of those seen are written, the same numbers as
    in the message
    """
    eye = eye_of(w, p, i, protocol)
    farthest, _, _ = flag_limits(w, p, i, eye.modern)
    mask, seen = survey(eye, sight), np.int64(0)
    # what most eyes are, decided once and not landmark by landmark
    plain, step = not (eye.gaussian or eye.focused or eye.low), p.quantize_step_l
    while mask:
        j = lowest_bit(mask)
        mask &= mask - 1
        distance = sight[0, j]
        if distance >= farthest or protocol < LANDMARK_PROTOCOLS[j]:
            continue
        if sight[2, j] <= MARGIN * distance and not is_in_view(eye, _MARK_X[j] - eye.x, _MARK_Y[j] - eye.y, distance, farthest):
            continue
        seen |= np.int64(1) << j
        degrees = np.rint(sight[1, j])
        if plain and is_settled(sight[1, j], degrees) and eye.rounded and distance > 1e-6:
            rows[j, 0], rows[j, 1] = banded_distance(distance, step), degrees * D2R
        else:
            dx, dy = _MARK_X[j] - eye.x, _MARK_Y[j] - eye.y
            rows[j, 0] = np.nan if eye.low else tell_landmark_distance(w, p, i, eye, j + _TICK * tick, dx, dy, distance)
            rows[j, 1] = told_direction(eye, dx, dy)
    return seen


@kernel
def look_at_landmarks(w, p, i, protocol, tick, rows, levels):
    """Landmarks of one message of player `i`, in the server's order.

    rows : (22, 55, 4) distance, direction, distance change, direction change; m, rad, m / cycle, rad / cycle
    levels : (22, 55) UNSEEN, FELT, TOLD or TOLD_MOVING

    First axis: observers; only row `i` is written and must be zero when called.
    """
    eye = eye_of(w, p, i, protocol)
    farthest, far, too_far = flag_limits(w, p, i, eye.modern)
    vx, vy = 0.0 - w.vel[i + 1, 0], 0.0 - w.vel[i + 1, 1]
    mask = perhaps_seen_landmarks(eye, protocol)
    while mask:
        j = lowest_bit(mask)
        mask &= mask - 1
        dx, dy = LANDMARK_POSITIONS[j, 0] - eye.x, LANDMARK_POSITIONS[j, 1] - eye.y
        distance = math.sqrt(dx * dx + dy * dy)
        seen = is_in_view(eye, dx, dy, distance, farthest)
        if not seen and distance > eye.near:
            continue
        draw = j + _TICK * tick
        told = tell_landmark_distance(w, p, i, eye, draw, dx, dy, distance)
        rows[i, j, 0], rows[i, j, 1] = told, told_direction(eye, dx, dy)
        levels[i, j] = FELT
        if seen:
            levels[i, j] = TOLD
            if told <= far or not is_lost(w, i, SEE_FLAG, draw, told, far, too_far):
                levels[i, j] = TOLD_MOVING
                rows[i, j, 2], rows[i, j, 3] = changes(vx, vy, dx, dy, distance, told, eye.gaussian)
        if eye.low:
            forget_distances(rows[i, j])


@kernel
def hide_landmarks(i, rows, levels):
    """Take from felt landmarks the place that would tell their name.

    What remains known is whether it is a flag or a goal: felt flags go to the first slots of unseen flags, a felt goal to that of
    the right goal, unless that is seen. Several are put in the order of distance, then of direction.
    """
    for slot in range(LANDMARKS):
        if levels[i, slot] > FELT or slot == _LEFT_GOAL or slot == _RIGHT_GOAL:
            continue
        best = -1
        for j in range(slot, LANDMARKS):
            if levels[i, j] == FELT and j != _RIGHT_GOAL and j != _LEFT_GOAL:
                nearer = best < 0 or rows[i, j, 0] < rows[i, best, 0]
                if nearer or (rows[i, j, 0] == rows[i, best, 0] and rows[i, j, 1] < rows[i, best, 1]):
                    best = j
        if best < 0:
            break
        if best != slot:
            swap_landmarks(i, rows, levels, slot, best)
    if levels[i, _LEFT_GOAL] == FELT and levels[i, _RIGHT_GOAL] == UNSEEN:
        swap_landmarks(i, rows, levels, _RIGHT_GOAL, _LEFT_GOAL)


@kernel
def swap_landmarks(i, rows, levels, a, b):
    """Exchange two rows."""
    for k in range(4):
        rows[i, a, k], rows[i, b, k] = rows[i, b, k], rows[i, a, k]
    levels[i, a], levels[i, b] = levels[i, b], levels[i, a]


@kernel
def line_ahead(x, y, line, face_x, face_y):
    """(across, along, share) of a line: how far off it is, where the face meets its extension times `share`, the cosine of the slant.

    The slant, between the face (face_x, face_y) and the way straight to the line, is a quarter turn or more where `share` is not above 0.
    """
    if line <= 2:
        across = (-HALF_LENGTH if line == 1 else HALF_LENGTH) - x
        share, rise, other = face_x, face_y, y
    else:
        across = (-HALF_WIDTH if line == 3 else HALF_WIDTH) - y
        share, rise, other = face_y, face_x, x
    if across < 0.0 or (across == 0.0 and line % 2 == 1):
        share = -share
    return across, other * share + abs(across) * rise, share


@kernel
def slant_to(w, i, line, across):
    """Angle between the face of player `i` and the way straight to a line, rad."""
    if line <= 2:
        normal_direction = PI if line == 1 else 0.0
        beyond = across > 0.0 if line == 1 else across < 0.0
    else:
        normal_direction = -0.5 * PI if line == 3 else 0.5 * PI
        beyond = across > 0.0 if line == 3 else across < 0.0
    if beyond:
        normal_direction += PI
    return norm(normal_direction - w.body[i] - w.neck[i])


@kernel
def meets_line(x, y, line, across, slant):
    """Whether the face meets a line between its ends, by the server's formula."""
    if abs(slant) >= 0.5 * PI:
        return False
    if line <= 2:
        return abs(y - across * math.tan(slant)) <= HALF_WIDTH
    return abs(x + across * math.tan(slant)) <= HALF_LENGTH


@kernel
def lines_in_view(w, i):
    """The first line that player `i` sees, and the second, which he sees from outside the pitch alone; 0 for none.

    Components decide; only where they come near an end of a line or a quarter turn does the formula with its tangent.
    """
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    wanted = 1 if abs(x) < HALF_LENGTH and abs(y) < HALF_WIDTH else 2
    angle = w.body[i] + w.neck[i]
    face_x, face_y = math.cos(angle), math.sin(angle)
    first = 0
    for line in range(1, 5):
        across, along, share = line_ahead(x, y, line, face_x, face_y)
        spare = (HALF_WIDTH if line <= 2 else HALF_LENGTH) * share - abs(along)
        if abs(share) < 1e-6 or abs(spare) < 1e-6:
            seen = meets_line(x, y, line, across, slant_to(w, i, line, across))
        else:
            seen = share > 0.0 and spare > 0.0
        if seen:
            if wanted == 1 or first > 0:
                return (line, 0) if wanted == 1 else (first, line)
            first = line
    return first, 0


@kernel
def told_line_direction(w, i, line, protocol):
    """Direction (rad, whole degrees) of a line relative to the face of player `i`, who sees it."""
    x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
    across, _, _ = line_ahead(x, y, line, 1.0, 0.0)
    slant = slant_to(w, i, line, across)
    return told_degrees(slant - 0.5 * PI if slant > 0.0 else slant + 0.5 * PI, protocol >= ROUNDING_PROTOCOL) * D2R


@kernel
def look_at_lines(w, p, i, protocol, rows, ids):
    """Lines of one message of player `i`: one when he is inside the pitch, at most two outside.

    rows : (22, 2, 2) distance (m) and direction (rad); only row `i` is written and must be zero when called
    ids : (22, 2) `Line`
    """
    ids[i, 0], ids[i, 1] = lines_in_view(w, i)
    for k in range(2):
        line = ids[i, k]
        if line > 0:
            across, _, _ = line_ahead(w.pos[i + 1, 0], w.pos[i + 1, 1], line, 1.0, 0.0)
            slant = slant_to(w, i, line, across)
            rows[i, k, 0] = quantize(quantised_length(abs(across / math.cos(slant)), p.quantize_step_l), 0.1)
            rows[i, k, 1] = told_line_direction(w, i, line, protocol)
            if w.view_quality[i] == LOW_QUALITY and not w.synchronous[i]:
                rows[i, k, 0] = np.nan


@kernel
def landmarks_of_world(w, p, rows, levels, line_rows, line_ids):
    """The landmark and line arrays of one world; zero for players who get no message."""
    rows[:] = 0.0
    levels[:] = 0
    line_rows[:] = 0.0
    line_ids[:] = 0
    for i in range(PLAYERS):
        if is_fresh(w, i):
            protocol, tick = message_of_arrays(w, i)
            look_at_landmarks(w, p, i, protocol, tick, rows, levels)
            hide_landmarks(i, rows, levels)
            look_at_lines(w, p, i, protocol, line_rows, line_ids)


@kernel
def landmarks_of_worlds(worlds, parameters, chosen, rows, levels, line_rows, line_ids, start, stop):
    """`landmarks_of_world` for the worlds ``chosen[start:stop]``; row k of every array is world ``chosen[k]``."""
    p = parameters[0]
    for k in range(start, stop):
        landmarks_of_world(worlds[chosen[k]], p, rows[k], levels[k], line_rows[k], line_ids[k])
