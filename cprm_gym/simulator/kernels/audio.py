"""Say and hear (specification/simulator.md 6.3): messages wait in the world's queue from the command to the end of the step."""

from __future__ import annotations

import numpy as np

from ..state import PLAYERS, SAY_QUEUE, SAY_SIZE, Count
from . import kernel
from .geometry import D2R, direction, norm, squared_distance
from .random import HEAR_CHOICE, SENSORS, uniform
from .rounding import rounded_degrees, truncated_degrees

COMPLETE, PARTIAL = 1, 2  # bits of w.ear
QUEUE_PROTOCOL = 8
"""From this protocol on speech waits for the end of the step."""
ROUNDED_PROTOCOL = 7
"""Its clients are told rounded directions of speech, all others truncated ones."""
_SAY = int(Count.SAY)


@kernel
def side_index(i, j):
    """0 when `j` is of the team of `i`, else 1."""
    return 0 if (i < 11) == (j < 11) else 1


@kernel
def hear_degrees(w, i, j, rounded):
    """Direction (degrees) of the speaker `j` relative to the body of player `i`: towards zero, or rounded as for version 7."""
    x, y = w.pos[j + 1, 0] - w.pos[i + 1, 0], w.pos[j + 1, 1] - w.pos[i + 1, 1]
    angle = norm(direction(x, y) - w.body[i])
    return rounded_degrees(angle) if rounded else truncated_degrees(angle)


@kernel
def hear_degrees_in(worlds, n, i, j, rounded):
    """`hear_degrees` in world `n`, for callers outside: a record of an array takes them longer to hand over than the array."""
    return hear_degrees(worlds[n], i, j, rounded)


@kernel
def hears_at_once(w, i):
    """The client of player `i` speaks a protocol before 8: what is said is not queued for him."""
    return 0 < w.protocol[i] < QUEUE_PROTOCOL


@kernel
def hear_at_once(w, p, i, speaker, message):
    """Player `i` hears a message in the moment in which it is said, if he has capacity left for the speaker's side."""
    side = side_index(i, speaker)
    if w.hear_capacity[i, side] < p.hear_decay:
        return
    w.hear_capacity[i, side] -= p.hear_decay
    n = w.heard_count[i]
    w.heard[i, n] = message + 1
    w.heard_from[i, n] = int(hear_degrees(w, i, speaker, w.protocol[i] == ROUNDED_PROTOCOL))
    w.heard_count[i] = n + 1


@kernel
def say(w, p, i, text, length):
    """Player `i` says ``text[:length]``; too long or empty messages are dropped, as the server drops them.

    Who can hear it is decided here, with the positions of this moment: whoever is within ``audio_cut_dist`` and has an ear on for the
    speaker's side. Clients before protocol 8 hear it at once, whatever their ears, as long as they have capacity; others after the step.
    """
    if length < 1 or length > p.say_msg_size or length > SAY_SIZE:
        return
    w.counts[i, _SAY] += 1
    if w.audio_done:
        w.audio_count, w.audio_done = 0, 0
        for j in range(PLAYERS):
            w.heard_count[j] = 0
    k = w.audio_count
    if k == SAY_QUEUE:
        return
    w.audio_time = w.time
    reach = p.audio_cut_dist * p.audio_cut_dist
    listeners = np.uint32(0)
    for j in range(PLAYERS):
        if j != i and w.enabled[j] and squared_distance(w, i + 1, j + 1) <= reach:
            if hears_at_once(w, j):
                hear_at_once(w, p, j, i, k)
            elif w.ear[j, side_index(j, i)]:
                listeners |= np.uint32(1) << np.uint32(j)
    w.audio_from[k], w.audio_length[k], w.audio_listeners[k] = i + 1, length, listeners
    for c in range(length):
        w.audio_text[k, c] = text[c]
    w.audio_count = k + 1


@kernel
def choose(w, i, waiting, draw):
    """Index in the queue of the message that player `i` hears next, among those of the bit set `waiting`."""
    total, wanted = 0, 0
    for k in range(w.audio_count):
        if waiting >> np.uint64(k) & np.uint64(1):
            total += 1
            if w.audio_from[k] == w.attention[i]:
                wanted += 1
    attend = wanted > 0
    pick = int(uniform(w, SENSORS, i, HEAR_CHOICE, draw) * (wanted if attend else total))
    for k in range(w.audio_count):
        if waiting >> np.uint64(k) & np.uint64(1) and (not attend or w.audio_from[k] == w.attention[i]):
            if pick == 0:
                return k
            pick -= 1
    return -1


@kernel
def listen(w, p, i):
    """What player `i` hears of the queue, in order, into ``w.heard``; his capacities shrink.

    That somebody speaks who is not understood is told where the capacity is used up: a partial ear alone hears nothing.
    """
    waiting, n, heard = np.uint64(0), 0, 0
    for k in range(w.audio_count):
        if w.audio_listeners[k] >> np.uint32(i) & np.uint32(1):
            waiting |= np.uint64(1) << np.uint64(k)
            n += 1
    for draw in range(n):
        k = choose(w, i, waiting, draw)
        waiting &= ~(np.uint64(1) << np.uint64(k))
        side = side_index(i, w.audio_from[k] - 1)
        if w.hear_capacity[i, side] >= p.hear_decay:
            if w.ear[i, side] & COMPLETE:
                w.hear_capacity[i, side] -= p.hear_decay
                w.heard[i, heard] = k + 1
                heard += 1
        elif w.ear[i, side] & PARTIAL:
            w.heard[i, heard] = -(k + 1)
            heard += 1
    w.heard_count[i] = heard


@kernel
def deliver_audio(w, p):
    """The audio flush after a step."""
    if w.audio_done:
        w.audio_count = 0
    w.audio_done = 1
    for i in range(PLAYERS):
        if w.audio_count and hears_at_once(w, i):
            continue
        w.heard_count[i] = 0
        if w.audio_count and w.enabled[i]:
            listen(w, p, i)


@kernel
def hear_world(w, sender, level, unum, direction, length, text, count):
    """The hear arrays of one world (`cprm_gym.simulator.senses.Hear`); what was not heard is zero."""
    slots = sender.shape[1]
    for i in range(PLAYERS):
        n = 0
        for slot in range(slots):
            sender[i, slot], level[i, slot], unum[i, slot], direction[i, slot], length[i, slot] = 0, 0, 0, 0.0, 0
            text[i, slot] = 0
        for k in range(w.heard_count[i]):
            if n < slots:
                entry = w.heard[i, k]
                message = abs(entry) - 1
                speaker = w.audio_from[message]
                own = side_index(i, speaker - 1) == 0
                sender[i, n] = 1 if own else 2
                unum[i, n] = (speaker - 1) % 11 + 1 if own else 0
                level[i, n] = 1
                if entry > 0:
                    level[i, n] = 2
                    degrees = w.heard_from[i, k] if hears_at_once(w, i) else hear_degrees(w, i, speaker - 1, False)
                    direction[i, n] = degrees * D2R
                    length[i, n] = w.audio_length[message]
                    for c in range(w.audio_length[message]):
                        text[i, n, c] = w.audio_text[message, c]
            n += 1
        count[i] = n


@kernel
def hear_worlds(worlds, parameters, chosen, sender, level, unum, direction, length, text, count, start, stop):
    """`hear_world` for the worlds ``chosen[start:stop]``; row k of every array is world ``chosen[k]``."""
    for k in range(start, stop):
        hear_world(worlds[chosen[k]], sender[k], level[k], unum[k], direction[k], length[k], text[k], count[k])
