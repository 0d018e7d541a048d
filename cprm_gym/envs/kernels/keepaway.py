"""Kernel of the preset ``keepaway``: the state variables of Stone, Sutton and Kuhlmann (2005), others in the order of distance."""

from __future__ import annotations

import math

from . import kernel
from .vectors import angle_between, length, put, unit

PI = math.pi


@kernel
def sort_by_distance(m, indices, first, count, ways):
    """Write x, y, direction (x, y) and distance of players into ``ways[:, first: first + count]``, the nearest first.

    The eye rounds distances, so that two are often equal but for the last bit: they are told apart by the correctly rounded one.

    indices : memory indices; ways : (5, n)
    """
    for k in range(count):
        x, y = m.px[indices[k]], m.py[indices[k]]
        ux, uy, _ = unit(x - m.x, y - m.y)
        distance = math.hypot(x - m.x, y - m.y)
        at = first + k
        while at > first and ways[4, at - 1] > distance:
            for f in range(5):
                ways[f, at] = ways[f, at - 1]
            at -= 1
        ways[0, at], ways[1, at], ways[2, at], ways[3, at], ways[4, at] = x, y, ux, uy, distance


@kernel
def nearest_taker(ways, k, keepers, count, scale):
    """(distance, angle seen by the observer) between keeper `k` and the takers, each the least of all of them."""
    least, best, which = scale * scale, -2.0, -1
    for t in range(keepers, keepers + count):
        dx, dy = ways[0, k] - ways[0, t], ways[1, k] - ways[1, t]
        least = min(least, dx * dx + dy * dy)
        along = ways[2, k] * ways[2, t] + ways[3, k] * ways[3, t]
        if along > best:
            best, which = along, t
    angle = PI if which < 0 else angle_between(ways[2, k], ways[3, k], ways[2, which], ways[3, which])
    return math.sqrt(least), angle


@kernel
def put_keepaway(m, mates, takers, scale, ways, out):
    """The vector of one player; mates, takers : memory indices; ways : (5, n) to be overwritten."""
    keepers, count = mates.shape[0], takers.shape[0]
    total = keepers + count
    sort_by_distance(m, mates, 0, keepers, ways)
    sort_by_distance(m, takers, keepers, count, ways)
    put(out, 0, length(m.x, m.y) / scale)
    for k in range(total):
        put(out, 1 + k, length(ways[0, k], ways[1, k]) / scale)
        put(out, 1 + total + k, ways[4, k] / scale)
    for k in range(keepers):
        distance, angle = nearest_taker(ways, k, keepers, count, scale)
        put(out, 1 + 2 * total + k, distance / scale)
        put(out, 1 + 2 * total + keepers + k, angle / PI)


@kernel
def keepaway(chosen, players, memory, mates, takers, scale, ways, out):
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; mates : (A, mates) and takers : (takers,) memory indices;
    scale : m, what distances are divided by; ways : (5, n) to be overwritten; out : (W, A, entries)
    """
    for c in range(chosen.shape[0]):
        n = chosen[c]
        for k in range(players.shape[0]):
            put_keepaway(memory[n, players[k] - 1], mates[k], takers, scale, ways, out[n, k])
