"""What a taker decides by, world by world: the formulas of the scripted takers and keepers, on what he knows."""

from __future__ import annotations

import math

from ...compilation import kernel_group
from ...envs.players.kernels.memory import PLAYERS, norm
from ...envs.players.kernels.motion import intercept, lane, nearest_opponent
from ...envs.players.kernels.team import rank_to_ball, tackle_chance

kernel = kernel_group()

AHEAD = 0.3
"""Radians off the ball beyond which a turn comes before the run to it."""
MATES = 11
"""Rows of the own team in a memory."""
RECENT = 30
"""Cycles within which somebody must have been seen to be reckoned with."""
AT_BALL = 2.0
"""Metres from the ball within which a keeper has it, and is not one to be covered."""
WAYS = 16
"""Directions in which the ball can be kicked out that are looked at."""


@kernel
def covered(m, me, count, share):
    """(x, y) before the keeper who is farthest from the other takers, on the ball's way to him; where the ball is, if there is none."""
    best, gap = -1, -1.0
    for k in range(MATES, PLAYERS):
        if m.age[k] > RECENT or math.hypot(m.px[k] - m.ball_x, m.py[k] - m.ball_y) <= AT_BALL:
            continue
        nearest = 50.0
        for j in range(count):
            if j != me and m.age[j] <= RECENT:
                nearest = min(nearest, math.hypot(m.px[k] - m.px[j], m.py[k] - m.py[j]))
        if nearest > gap:
            best, gap = k, nearest
    if best < 0:
        return m.ball_x, m.ball_y
    return share * m.px[best] + (1.0 - share) * m.ball_x, share * m.py[best] + (1.0 - share) * m.ball_y


@kernel
def way_out(m, half, speed):
    """(x, y) beyond the lines of the square, `half` metres from its middle: the way there is short and clear of keepers."""
    best, best_x, best_y = -1e9, m.ball_x, m.ball_y
    for k in range(WAYS):
        ux, uy = math.cos(2.0 * math.pi * k / WAYS), math.sin(2.0 * math.pi * k / WAYS)
        along_x = (half - m.ball_x if ux > 0.0 else half + m.ball_x) / max(abs(ux), 1e-6)
        along_y = (half - m.ball_y if uy > 0.0 else half + m.ball_y) / max(abs(uy), 1e-6)
        way = max(0.0, min(along_x, along_y))
        x, y = m.ball_x + (way + 1.0) * ux, m.ball_y + (way + 1.0) * uy
        value = min(lane(m, x, y, speed), 3.0) - 0.3 * way
        if value > best:
            best, best_x, best_y = value, x, y
    return best_x, best_y


@kernel
def judge(records, me, count, half, speed, share, out):
    """Everything that a taker decides by.

    records : (N,) MEMORY; me : (N,) row in his team; count : takers; half : m, half the length of the square; speed : m / cycle of a kick
    that sends the ball out; share : of `covered`; out : (N, 9), see `percepts.NAMES`
    """
    for n in range(records.shape[0]):
        m, o = records[n], out[n]
        o[0] = rank_to_ball(m, me[n], count)
        away = norm(math.atan2(m.ball_y - m.y, m.ball_x - m.x) - m.body)
        _, o[1], o[2] = intercept(m, m.x, m.y, 1.0 if abs(away) > AHEAD else 0.0)
        o[3], o[4] = covered(m, me[n], count, share)
        o[5], o[6] = way_out(m, half, speed)
        o[7], o[8] = nearest_opponent(m, m.ball_x, m.ball_y), tackle_chance(m)
