"""Sense_body: what a player is told of himself (specification/simulator.md 6.2), and what is due after a step."""

from __future__ import annotations

import math

import numpy as np

from ..state import PLAYERS, PlayerBit
from . import kernel
from .audio import deliver_audio
from .geometry import D2R, R2D, direction, norm, quantize
from .rounding import truncated_degrees
from .senses import see_messages_due

(
    STAMINA,
    EFFORT,
    CAPACITY,
    SPEED,
    SPEED_DIRECTION,
    HEAD_ANGLE,
    VIEW_WIDTH,
    VIEW_QUALITY,
    COUNTS,
) = range(9)
ARM_MOVABLE = COUNTS + 13
(
    ARM_EXPIRES,
    ARM_DISTANCE,
    ARM_DIRECTION,
    ATTENTION,
    TACKLE_EXPIRES,
    FOUL_CHARGED,
    HIT_BALL,
    HIT_PLAYER,
    HIT_POST,
    CARD,
    FOCUS_DISTANCE,
    FOCUS_DIRECTION,
    COLUMNS,
) = range(ARM_MOVABLE + 1, ARM_MOVABLE + 14)
_YELLOW, _RED = int(PlayerBit.YELLOW_CARD), int(PlayerBit.RED_CARD)


@kernel
def arm(w, p, i):
    """(cycles until the arm can be moved, cycles it stays up, distance, direction relative to the face in whole degrees)."""
    timer = w.arm_timer[i]
    movable = max(0, p.point_to_ban - timer)
    if timer >= p.point_to_duration:
        return movable, 0, 0.0, 0.0
    x, y = w.arm_target[i, 0] - w.pos[i + 1, 0], w.arm_target[i, 1] - w.pos[i + 1, 1]
    distance = np.rint(10.0 * math.sqrt(x * x + y * y)) / 10.0
    degrees = quantize(norm(norm(direction(x, y) - w.body[i]) - w.neck[i]) * R2D, 0.1)
    return movable, p.point_to_duration - timer, distance, np.float64(int(degrees))


@kernel
def arm_in(worlds, parameters, n, i):
    """`arm` in world `n`, for callers outside: a record of an array takes them longer to hand over than the array."""
    return arm(worlds[n], parameters[0], i)


@kernel
def sense_body(w, p, i, row):
    """The message of player `i` as numbers: m, m / cycle, cycles, rad; rounded as the message is."""
    row[STAMINA], row[EFFORT], row[CAPACITY] = w.stamina[i], w.effort[i], w.capacity[i]
    vx, vy = w.vel[i + 1, 0], w.vel[i + 1, 1]
    row[SPEED] = quantize(math.sqrt(vx * vx + vy * vy), 0.01)
    row[SPEED_DIRECTION] = truncated_degrees(norm(norm(direction(vx, vy) - w.body[i]) - w.neck[i])) * D2R
    row[HEAD_ANGLE] = truncated_degrees(w.neck[i]) * D2R
    row[VIEW_WIDTH], row[VIEW_QUALITY] = w.view_width[i], w.view_quality[i]
    for k in range(13):
        row[COUNTS + k] = w.counts[i, k]
    movable, expires, distance, degrees = arm(w, p, i)
    row[ARM_MOVABLE], row[ARM_EXPIRES], row[ARM_DISTANCE], row[ARM_DIRECTION] = movable, expires, distance, degrees * D2R
    row[ATTENTION] = w.attention[i]
    row[TACKLE_EXPIRES], row[FOUL_CHARGED] = w.tackle_cycles[i], w.foul_cycles[i]
    told = w.collided[i] >> 4
    row[HIT_BALL], row[HIT_PLAYER], row[HIT_POST] = told & 1, told >> 1 & 1, told >> 2 & 1
    row[CARD] = 2 if w.bits[i] & _RED else 1 if w.bits[i] & _YELLOW else 0
    row[FOCUS_DISTANCE], row[FOCUS_DIRECTION] = w.focus_distance[i], w.focus_direction[i]


@kernel
def sense_bodies(worlds, parameters, chosen, rows, start, stop):
    """`sense_body` of every player that is there into ``rows`` (n, 22, COLUMNS), worlds ``chosen[start:stop]``; zeros for the others."""
    p = parameters[0]
    for k in range(start, stop):
        w = worlds[chosen[k]]
        for i in range(PLAYERS):
            if w.enabled[i]:
                sense_body(w, p, i, rows[k, i])
            else:
                rows[k, i] = 0.0


@kernel
def messages_due(w, p):
    """The end of a step, before anything is sent: who sees, what was bumped into since the last time, who hears what.

    The lower half of ``w.collided`` collects the collisions since the last message (1 ball, 2 player, 4 post), the upper half holds
    those that the message of this step tells.
    """
    see_messages_due(w)
    for i in range(PLAYERS):
        w.collided[i] = (w.collided[i] & 7) << 4
    deliver_audio(w, p)
