"""What a log shows of the players of one world."""

from __future__ import annotations

import numpy as np

from ...state import PLAYERS
from . import kernel


@kernel
def fill_players(worlds, visible_angle, point_to_duration, counts, rows):
    """Fill the rows of all players; `point` stays as it is for those who do not point.

    worlds : (1,) WORLD; visible_angle : degrees; counts : (n,) which counters a log has, in its order; rows : (22,) PLAYER_FRAME
    """
    w = worlds[0]
    for i in range(PLAYERS):
        row, enabled = rows[i], w.enabled[i] != 0
        row.type, row.state = w.type[i], w.bits_shown[i]
        for k in range(2):
            row.pos[k], row.vel[k] = w.pos[i + 1, k], w.vel[i + 1, k]
        row.body, row.neck = np.degrees(w.body[i]), np.degrees(w.neck[i])
        if enabled and w.arm_timer[i] < point_to_duration:
            row.point[0], row.point[1] = w.arm_target[i, 0], w.arm_target[i, 1]
        row.view_quality = 2 if w.view_quality[i] == 2 else 1
        if w.synchronous[i]:
            row.view_width = 60.0 * w.view_width[i]
        else:
            row.view_width = visible_angle * 0.25 * 2.0 ** w.view_width[i]
        row.focus[0], row.focus[1] = w.focus_distance[i], np.degrees(w.focus_direction[i])
        row.stamina, row.effort, row.recovery, row.capacity = w.stamina[i], w.effort[i], w.recovery[i], w.capacity[i]
        row.attention = w.attention[i] if enabled else 0
        for k in range(counts.shape[0]):
            row.counts[k] = w.counts[i, counts[k]]
