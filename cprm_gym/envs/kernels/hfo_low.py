"""Kernel of the preset ``hfo_low``: HFO's low level features of every agent, in one pass, angles relative to the body."""

from __future__ import annotations

import numpy as np

from ...simulator.kernels.senses import lowest_bit
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.player_types import T_PLAYER_SPEED_MAX
from . import kernel
from .bearings import SINGLE, bearing, turned_within
from .vectors import RECENT, flag, kickable, last_action_possible, near, put, put_course, put_way, ways_to, within

PLAYER_ENTRIES = 8
NUMBERED = 3
"""Level from which a player is seen with his number, his body and his motion."""


@kernel
def put_self(w, p, m, i, body, collided, stamina_max, cosine, sine, out):
    """The player himself, entries 0 to 12; collided : first of three columns of `body`."""
    flag(out, 0, m.located > 0)
    speed = put_course(out, 2, m.vx, m.vy, cosine, sine)
    flag(out, 1, speed > 0.0)
    put(out, 4, 2.0 * speed / p.types[w.type[i], T_PLAYER_SPEED_MAX] - 1.0)
    put(out, 5, sine)
    put(out, 6, cosine)
    put(out, 7, 2.0 * m.stamina / stamina_max - 1.0)
    flag(out, 8, m.free == 0)
    for f in range(3):
        put(out, 9 + f, 2.0 * body[collided + f] - 1.0)
    flag(out, 12, kickable(w, p, m, i))
    return 13


@kernel
def put_pitch(m, marks, diagonal, cosine, sine, ways, out, at):
    """Landmarks and lines; marks : (2, 11) x and y."""
    ways_to(m, marks[0], marks[1], cosine, sine, diagonal, ways)
    for k in range(marks.shape[1]):
        for f in range(3):
            out[at + 3 * k + f] = ways[f, k]
    at += 3 * marks.shape[1]
    put(out, at, near(within(m.x), diagonal))
    put(out, at + 1, near(within(HALF_LENGTH - m.x), diagonal))
    put(out, at + 2, near(within(m.y + HALF_WIDTH), diagonal))
    put(out, at + 3, near(within(HALF_WIDTH - m.y), diagonal))
    return at + 4


@kernel
def put_ball(m, ball_speed, diagonal, cosine, sine, out, at):
    """Where the ball is and how it rolls."""
    seen = m.ball_age <= RECENT
    flag(out, at, seen)
    if seen:
        put_way(out, at + 1, m.ball_x - m.x, m.ball_y - m.y, cosine, sine, diagonal)
        speed = put_course(out, at + 6, m.ball_vx, m.ball_vy, cosine, sine)
        flag(out, at + 4, speed > 0.0)
        put(out, at + 5, 2.0 * speed / ball_speed - 1.0)
    else:
        flag(out, at + 4, False)
    return at + 8


@kernel
def put_motion(m, seen, along, aside, fastest, out, at):
    """Body, speed and course of a player seen in this cycle; (along, aside): the own velocity relative to the own body."""
    neck_x, neck_y = bearing(m.neck)
    out[at + 1], out[at] = turned_within(neck_x, neck_y, seen[4], SINGLE)
    cosine, sine = turned_within(neck_x, neck_y, seen[1], SINGLE)
    across = seen[3] * seen[0]
    vx = seen[2] * cosine - across * sine + along
    vy = seen[2] * sine + across * cosine + aside
    speed = put_course(out, at + 3, vx, vy, 1.0, 0.0)
    put(out, at + 2, 2.0 * speed / fastest - 1.0)


@kernel
def put_others(w, p, m, i, others, seen, levels, diagonal, cosine, sine, ways, out, at):
    """The other players; others : memory indices; seen : (22, 7) and levels : (23,), as told in this cycle; `out` holds zeros."""
    count = others.shape[0]
    numbers = at + PLAYER_ENTRIES * count
    ways_to(m, m.px, m.py, cosine, sine, diagonal, ways)
    along, aside = m.vx * cosine + m.vy * sine, m.vy * cosine - m.vx * sine
    moving = np.int64(0)
    for k in range(count):
        j = others[k]
        known = m.age[j] <= RECENT
        o = at + PLAYER_ENTRIES * k
        out[o] = ways[0, j] if known else 0.0
        out[o + 1] = ways[1, j] if known else 0.0
        out[o + 2] = ways[2, j] if known else 0.0
        out[numbers + k] = (j % 11 + 1) * (1.0 / 11.0) if known else 0.0
        moving |= np.int64(levels[seen_row(i, j) + 1] >= NUMBERED) << k
    while moving:  # bits, not a branch for every player: few are seen
        k = lowest_bit(moving)
        moving &= moving - 1
        row = seen_row(i, others[k])
        put_motion(m, seen[row], along, aside, p.types[w.type[row], T_PLAYER_SPEED_MAX], out, at + PLAYER_ENTRIES * k + 3)
    return numbers + count


@kernel
def seen_row(i, j):
    """Row in the percepts of player `i` of the one whom he remembers at index `j`."""
    return j if i < 11 else (j + 11 if j < 11 else j - 11)


@kernel
def hfo_low(
    worlds, packed, chosen, players, memory, sent, cycles, body, collided, seen, levels, others, marks, diagonal, ball_speed, stamina_max,
    ways, kicks, out,
):  # fmt: skip
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; sent : (W, 22) COMMAND of the cycle; cycles : (W,);
    body : (W, A, columns), collided : first column of the three touches; seen : (W, A, 22, 7); levels : (W, A, 23);
    others : (A, mates + opponents) memory indices; marks : (2, 11); ways : (3, 22) to be
    overwritten; kicks : (W, A); out : (W, A, entries)
    """
    p = packed[0]
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k] - 1
            m = memory[n, i]
            o = out[n, k]
            o[:] = 0.0  # what is not known stays so
            cosine, sine = bearing(m.body)
            at = put_self(w, p, m, i, body[n, k], collided, stamina_max, cosine, sine, o)
            at = put_pitch(m, marks, diagonal, cosine, sine, ways, o, at)
            at = put_ball(m, ball_speed, diagonal, cosine, sine, o, at)
            at = put_others(w, p, m, i, others[k], seen[n, k], levels[n, k], diagonal, cosine, sine, ways, o, at)
            flag(o, at, last_action_possible(w, i, sent[n, i], cycles[n], kicks[n], k))
