"""Kernels between the simulator's senses and the observation arrays."""

from __future__ import annotations

import math

from ...simulator.state import Count
from . import kernel

PLAYERS = 22
KICK, DASH, TURN = int(Count.KICK), int(Count.DASH), int(Count.TURN)


@kernel
def pack(
    worlds, chosen, agents, columns, fresh, ball, ball_level, players, players_level, body, older, max_age,
    out_body, out_ball, out_players, out_level, out_age,
):  # fmt: skip
    """Observations of the agents in the chosen worlds, float32: values and levels of this percept, and how old each entry is.

    chosen : (n,); row c of the senses, `fresh` to `body`, is world ``chosen[c]``
    agents : (A,) object numbers of the observers
    columns : (12,) columns of `body` in the order of the first twelve entries of `BodyFeature`
    older : bool; False when an episode starts, where nothing has aged yet
    """
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for k in range(agents.shape[0]):
            i = agents[k] - 1
            seen_now = fresh[c, i]
            pack_body(w, i, columns, body[c, i], seen_now, out_body[n, k])
            level = ball_level[c, i] if seen_now else 0
            note(level, older, max_age, 0, out_level[n, k], out_age[n, k])
            for f in range(4):
                out_ball[n, k, f] = ball[c, i, f] if level > 0 else 0.0
            for j in range(PLAYERS):
                level = players_level[c, i, j] if seen_now else 0
                note(level, older, max_age, j + 1, out_level[n, k], out_age[n, k])
                if level > 0:
                    for f in range(7):
                        out_players[n, k, j, f] = players[c, i, j, f]
                else:
                    for f in range(7):
                        out_players[n, k, j, f] = 0.0


@kernel
def pack_memory(memory, chosen, agents, out_self, out_memory, out_age):
    """The memories of the agents in the chosen worlds as observations: themselves, and ball, own team, opponents as last seen.

    memory : (W, 22) MEMORY; out_self : (W, A, 8); out_memory : (W, A, 23, 4); out_age : (W, A, 23)
    """
    for n in chosen:
        for k in range(agents.shape[0]):
            m = memory[n, agents[k] - 1]
            o = out_self[n, k]
            o[0], o[1], o[2], o[3], o[4], o[5] = m.x, m.y, m.vx, m.vy, m.body, m.face
            o[6], o[7] = m.located, m.free
            out_age[n, k, 0] = m.ball_age
            b = out_memory[n, k, 0]
            b[0], b[1], b[2], b[3] = m.ball_x, m.ball_y, m.ball_vx, m.ball_vy
            for j in range(PLAYERS):
                out_age[n, k, j + 1] = m.age[j]
                out_memory[n, k, j + 1, 0] = m.px[j]
                out_memory[n, k, j + 1, 1] = m.py[j]


@kernel
def pack_truth(worlds, chosen, agents, out_body, out_ball, out_players, out_level, out_age):
    """The truth in the layout of the percepts: everything seen, at level 3, without noise; what does not play stays at level 0."""
    for n in chosen:
        w = worlds[n]
        for k in range(agents.shape[0]):
            i = agents[k] - 1
            face = w.body[i] + w.neck[i]
            b = out_body[n, k]
            b[0], b[1], b[2] = w.stamina[i], w.effort[i], w.capacity[i]
            vx, vy = w.vel[i + 1, 0], w.vel[i + 1, 1]
            b[3] = math.sqrt(vx * vx + vy * vy)
            b[4] = wrapped(math.atan2(vy, vx) - face) if b[3] > 0.0 else 0.0
            b[5], b[12] = w.neck[i], 1.0
            for j in range(PLAYERS + 1):
                out_age[n, k, j] = 0.0
                out = out_ball[n, k] if j == 0 else out_players[n, k, j - 1]
                there = j == 0 or (w.enabled[j - 1] and j != i + 1)
                out_level[n, k, j] = 3.0 if there else 0.0
                if not there:
                    for f in range(out.shape[0]):
                        out[f] = 0.0
                    continue
                dx, dy = w.pos[j, 0] - w.pos[i + 1, 0], w.pos[j, 1] - w.pos[i + 1, 1]
                d = max(1e-9, math.sqrt(dx * dx + dy * dy))
                rx, ry = w.vel[j, 0] - vx, w.vel[j, 1] - vy
                out[0], out[1] = d, wrapped(math.atan2(dy, dx) - face)
                out[2] = (rx * dx + ry * dy) / d
                out[3] = min(6.0, max(-6.0, (ry * dx - rx * dy) / (d * d)))
                if j > 0:
                    out[4] = wrapped(w.body[j - 1] - face)
                    out[5] = wrapped(w.body[j - 1] + w.neck[j - 1] - face)
                    out[6] = 0.0


@kernel
def wrapped(a):
    """An angle in (-pi, pi]."""
    return a - 2.0 * math.pi * math.ceil((a - math.pi) / (2.0 * math.pi))


@kernel
def pack_hear(sender, level, unum, direction, length, text, chosen, agents, out):
    """What the agents heard in the chosen worlds; row c of the senses is world ``chosen[c]``.

    Per message sender (1 mate, 2 opponent), level, unum, direction, length and the first ten bytes.
    """
    for c in range(chosen.shape[0]):
        for k in range(agents.shape[0]):
            i = agents[k] - 1
            for s in range(out.shape[2]):
                o = out[chosen[c], k, s]
                o[0], o[1], o[2] = sender[c, i, s], level[c, i, s], unum[c, i, s]
                o[3], o[4] = direction[c, i, s], length[c, i, s]
                for f in range(10):
                    o[5 + f] = text[c, i, s, f]


@kernel
def note(level, older, max_age, j, out_level, out_age):
    """Level and age of entry `j`."""
    out_level[j] = level
    if level > 0:
        out_age[j] = 0.0
    elif older and out_age[j] < max_age:
        out_age[j] += 1.0


@kernel
def pack_body(w, i, columns, body, seen_now, out):
    """What player `i` is told of himself, in the order of `BodyFeature`."""
    side = 1.0 if i < 11 else -1.0
    own, other = (0, 1) if i < 11 else (1, 0)
    for f in range(columns.shape[0]):
        out[f] = body[columns[f]]
    f = columns.shape[0]
    out[f] = 1.0 if seen_now else 0.0
    out[f + 1] = side
    out[f + 2] = i % 11 + 1
    out[f + 3] = w.goalie[i]
    out[f + 4] = w.mode
    out[f + 5] = w.time
    out[f + 6] = w.score[own]
    out[f + 7] = w.score[other]
    out[f + 8] = w.counts[i, DASH]
    out[f + 9] = w.counts[i, KICK]
    out[f + 10] = w.counts[i, TURN]
    out[f + 11] = min(2, w.card_count[i])
