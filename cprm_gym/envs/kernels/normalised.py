"""Kernel of the preset ``normalised`` (`cprm_gym.envs.vectors.normalised`): every agent's vector in one pass over his memory."""

from __future__ import annotations

import math

from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.player_types import T_PLAYER_SPEED_MAX
from . import kernel
from .vectors import RECENT, clear, kickable

ME_ENTRIES, BALL_ENTRIES, GOAL_ENTRIES, PLAYER_ENTRIES = 17, 6, 6, 9
HALF_TURN = 0.5 * math.pi
NUMBERED = 3
"""Level from which a player is seen with his number, his body and his motion."""


@kernel
def bounded(value):
    """Within -1 and 1, and 0 for what is no number."""
    return 0.0 if value != value else min(1.0, max(-1.0, value))


@kernel
def way(dx, dy, cosine, sine, farthest, out, at):
    """Three entries: sine and cosine of the way (dx, dy) against the direction (cosine, sine), and its length on a logarithmic scale."""
    d = math.sqrt(dx * dx + dy * dy)
    if d > 0.0:
        out[at] = bounded((dy * cosine - dx * sine) / d)
        out[at + 1] = bounded((dx * cosine + dy * sine) / d)
    else:
        out[at], out[at + 1] = 0.0, 1.0
    out[at + 2] = bounded(math.log(1.0 + d) / farthest)


@kernel
def course(vx, vy, cosine, sine, top, out, at):
    """Two entries: a velocity along the direction (cosine, sine) and across it, in units of `top`."""
    out[at] = bounded((vx * cosine + vy * sine) / top)
    out[at + 1] = bounded((vy * cosine - vx * sine) / top)


@kernel
def write_me(w, p, m, i, body, fresh, flags, stamina_max, cosine, sine, out):
    """The player himself."""
    located = m.located > 0
    out[0] = 1.0 if located else 0.0
    if located:
        out[1], out[2] = bounded(m.x / HALF_LENGTH), bounded(m.y / HALF_WIDTH)
        out[3], out[4] = sine, cosine
    else:
        clear(out, 1, 5)
    out[5] = bounded(m.neck / HALF_TURN)
    course(m.vx, m.vy, cosine, sine, p.types[w.type[i], T_PLAYER_SPEED_MAX], out, 6)
    out[8] = max(0.0, bounded(m.stamina / stamina_max))
    out[9] = max(0.0, bounded(m.effort))
    out[10] = 1.0 if m.free else 0.0
    out[11] = body[fresh]
    out[12] = 1.0 if kickable(w, p, m, i) else 0.0
    out[13] = 1.0 if w.goalie[i] else 0.0
    side = 0 if i < 11 else 1
    for f in range(3):
        out[14 + f] = flags[w.mode, side, f]


@kernel
def write_ball(m, farthest, top, cosine, sine, out, at):
    """Where the ball is and how it rolls; whether it is known."""
    if m.ball_age > RECENT:
        clear(out, at, at + BALL_ENTRIES)
        return 0.0
    way(m.ball_x - m.x, m.ball_y - m.y, cosine, sine, farthest, out, at)
    course(m.ball_vx, m.ball_vy, cosine, sine, top, out, at + 3)
    out[at + 5] = m.ball_age / RECENT
    return 1.0


@kernel
def write_goals(m, farthest, cosine, sine, out, at):
    """The middles of the opponents' and of the own goal."""
    if m.located > 0:
        way(HALF_LENGTH - m.x, -m.y, cosine, sine, farthest, out, at)
        way(-HALF_LENGTH - m.x, -m.y, cosine, sine, farthest, out, at + 3)
    else:
        clear(out, at, at + GOAL_ENTRIES)


@kernel
def write_motion(m, seen, along, aside, top, out, at):
    """Body and velocity of a player seen in this cycle; (along, aside): the own velocity relative to the own body."""
    direction = seen[4] + m.neck
    out[at], out[at + 1] = math.sin(direction), math.cos(direction)
    bearing = seen[1] + m.neck
    cosine, sine = math.cos(bearing), math.sin(bearing)
    across = seen[3] * seen[0]
    out[at + 2] = bounded((seen[2] * cosine - across * sine + along) / top)
    out[at + 3] = bounded((seen[2] * sine + across * cosine + aside) / top)


@kernel
def write_others(w, p, m, i, others, seen, levels, farthest, cosine, sine, out, at, known):
    """The other players; others : memory indices, -1 for nobody; seen : (22, 7), levels : (23,); known : first entry of the mask."""
    along, aside = m.vx * cosine + m.vy * sine, m.vy * cosine - m.vx * sine
    for k in range(others.shape[0]):
        j = others[k]
        if j < 0 or m.age[j] > RECENT:
            clear(out, at, at + PLAYER_ENTRIES)
            out[known + k] = 0.0
        else:
            way(m.px[j] - m.x, m.py[j] - m.y, cosine, sine, farthest, out, at)
            out[at + 3] = m.age[j] / RECENT
            row = j if i < 11 else (j + 11) % 22
            if levels[row + 1] >= NUMBERED:
                out[at + 4] = 1.0
                write_motion(m, seen[row], along, aside, p.types[w.type[row], T_PLAYER_SPEED_MAX], out, at + 5)
            else:
                clear(out, at + 4, at + PLAYER_ENTRIES)
            out[known + k] = 1.0
        at += PLAYER_ENTRIES


@kernel
def normalised(worlds, packed, chosen, players, memory, body, fresh, seen, levels, others, flags, scales, out):
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; body : (W, A, columns); fresh : the column that says that a
    look came; seen : (W, A, 22, 7); levels : (W, A, 23); others : (A, rows) memory indices; flags : (modes, 2, 3);
    scales : logarithm of the farthest distance, top speed of the ball, most stamina; out : (W, A, entries) float32
    """
    p = packed[0]
    farthest, ball_speed, stamina_max = scales[0], scales[1], scales[2]
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k] - 1
            m = memory[n, i]
            o = out[n, k]
            cosine, sine = math.cos(m.body), math.sin(m.body)
            write_me(w, p, m, i, body[n, k], fresh, flags, stamina_max, cosine, sine, o)
            at = ME_ENTRIES
            ball = write_ball(m, farthest, ball_speed, cosine, sine, o, at)
            at += BALL_ENTRIES
            write_goals(m, farthest, cosine, sine, o, at)
            at += GOAL_ENTRIES
            mask = at + PLAYER_ENTRIES * others.shape[1]
            o[mask] = ball
            write_others(w, p, m, i, others[k], seen[n, k], levels[n, k], farthest, cosine, sine, o, at, mask + 1)
