"""Kernels between the simulator's senses and the observation arrays."""

from __future__ import annotations

from pathlib import Path

from ..compilation import kernel_group
from ..simulator.state import Count

kernel = kernel_group(Path(__file__))
PLAYERS = 22
KICK, DASH, TURN = int(Count.KICK), int(Count.DASH), int(Count.TURN)




@kernel
def open_eyes(worlds, chosen):
    """Give every player of the chosen worlds a look at once; the next one comes after a full interval of his view."""
    for k in range(chosen.shape[0]):
        w = worlds[chosen[k]]
        for i in range(PLAYERS):
            w.saw[i] = w.enabled[i]
            w.see_counter[i] = 0


@kernel
def pack(
    worlds, agents, columns, fresh, ball, ball_level, players, players_level, body, older, max_age,
    out_body, out_ball, out_players, out_level, out_age,
):  # fmt: skip
    """Observations of the agents, float32: values and levels of this percept, and how old each entry is.

    agents : (A,) object numbers of the observers
    columns : (12,) columns of `body` in the order of the first twelve entries of `BodyFeature`
    older : bool; False when an episode starts, where nothing has aged yet
    """
    for n in range(fresh.shape[0]):
        w = worlds[n]
        for k in range(agents.shape[0]):
            i = agents[k] - 1
            seen_now = fresh[n, i]
            pack_body(w, i, columns, body[n, i], seen_now, out_body[n, k])
            level = ball_level[n, i] if seen_now else 0
            note(level, older, max_age, 0, out_level[n, k], out_age[n, k])
            for f in range(4):
                out_ball[n, k, f] = ball[n, i, f] if level > 0 else 0.0
            for j in range(PLAYERS):
                level = players_level[n, i, j] if seen_now else 0
                note(level, older, max_age, j + 1, out_level[n, k], out_age[n, k])
                if level > 0:
                    for f in range(7):
                        out_players[n, k, j, f] = players[n, i, j, f]
                else:
                    for f in range(7):
                        out_players[n, k, j, f] = 0.0


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
