"""What a keeper decides by, world by world: the formulas of the scripted keepers, on what he knows."""

from __future__ import annotations

import math

from ...compilation import kernel_group
from ...envs.players.kernels.keepers import best_receiver, open_place, sheltered
from ...envs.players.kernels.memory import PLAYERS, norm
from ...envs.players.kernels.motion import intercept, nearest_opponent
from ...envs.players.kernels.team import rank_to_ball

kernel = kernel_group()

AHEAD = 0.3
"""Radians off the ball beyond which a turn comes before the run to it."""


@kernel
def judge(records, me, count, half, out):
    """Everything that a keeper decides by.

    records : (N,) MEMORY; me : (N,) row in his team; count : keepers; half : m, half the length of the square less a margin;
    out : (N, 14), see `percepts.NAMES`
    """
    for n in range(records.shape[0]):
        m, o = records[n], out[n]
        o[0] = rank_to_ball(m, me[n], count)
        away = norm(math.atan2(m.ball_y - m.y, m.ball_x - m.x) - m.body)
        _, o[1], o[2] = intercept(m, m.x, m.y, 1.0 if abs(away) > AHEAD else 0.0)
        o[3], o[4] = open_place(m, me[n], count, half + 1.5, half + 1.5)
        o[5] = nearest_opponent(m, m.x, m.y)
        k, o[6] = best_receiver(m, me[n], count)
        o[7], o[8] = m.ball_x, m.ball_y
        if k >= 0:
            o[7], o[8] = m.px[k], m.py[k]
        x, y = sheltered(m)
        o[9], o[10] = x - m.ball_x, y - m.ball_y
        # whom he has not seen for the longest
        o[11], o[12], o[13] = m.ball_x, m.ball_y, 0.0
        for k in range(PLAYERS):
            if k != me[n] and o[13] < m.age[k] < 200 and (k < count or k >= 11):
                o[11], o[12], o[13] = m.px[k], m.py[k], m.age[k]
