"""Kernel of the preset ``keepaway``: the state variables of Stone, Sutton and Kuhlmann (2005), others in the order of distance."""

from __future__ import annotations

import math

from . import kernel
from .vectors import angle_between, length, put, unit

PI = math.pi
CLOSE = 1e-12
"""Share by which two squared distances differ at most where only the correctly rounded distances say which is less."""


@kernel
def sort_by_distance(m, indices, first, count, ways):
    """Write x, y, direction (x, y) and distance of players into ``ways[:, first: first + count]``, the nearest first.

    The eye rounds distances, so that two are often equal but for the last bits: they are told apart by the correctly rounded ones.

    indices : memory indices; ways : (7, 22), rows 5 and 6 to be overwritten: squared distances and numbers in the order of distance
    """
    squares, order = ways[5], ways[6]
    for k in range(count):
        dx, dy = m.px[indices[k]] - m.x, m.py[indices[k]] - m.y
        squared, at = dx * dx + dy * dy, k
        while at > 0 and comes_before(m, dx, dy, squared, indices[int(order[at - 1])], squares[at - 1]):
            squares[at], order[at] = squares[at - 1], order[at - 1]
            at -= 1
        squares[at], order[at] = squared, k
    for k in range(count):
        j = indices[int(order[k])]
        at = first + k
        ways[0, at], ways[1, at] = m.px[j], m.py[j]
        ways[2, at], ways[3, at], ways[4, at] = unit(m.px[j] - m.x, m.py[j] - m.y)


@kernel
def comes_before(m, dx, dy, squared, other, other_squared):
    """Whether who is (dx, dy) away is nearer than the player at memory index `other`."""
    if abs(squared - other_squared) > CLOSE * other_squared:
        return squared < other_squared
    return math.hypot(dx, dy) < math.hypot(m.px[other] - m.x, m.py[other] - m.y)


@kernel
def nearest_takers(ways, keepers, count, scale, near):
    """For all keepers, side by side, the squared distance of the nearest taker and the one seen nearest to them by the observer.

    near : (4, 11), overwritten: the square, the cosine of the angle (-2: nobody) and that taker's direction (x, y)
    """
    for k in range(keepers):
        near[0, k], near[1, k], near[2, k], near[3, k] = scale * scale, -2.0, 1.0, 0.0
    for t in range(keepers, keepers + count):
        x, y, ux, uy = ways[0, t], ways[1, t], ways[2, t], ways[3, t]
        for k in range(keepers):
            dx, dy = ways[0, k] - x, ways[1, k] - y
            near[0, k] = min(near[0, k], dx * dx + dy * dy)
            along = ways[2, k] * ux + ways[3, k] * uy
            nearer = along > near[1, k]
            near[1, k] = along if nearer else near[1, k]
            near[2, k] = ux if nearer else near[2, k]
            near[3, k] = uy if nearer else near[3, k]


@kernel
def put_keepaway(m, mates, takers, scale, ways, near, out):
    """The vector of one player; mates, takers : memory indices; ways : (7, 22) and near : (4, 11) to be overwritten."""
    keepers, count = mates.shape[0], takers.shape[0]
    total = keepers + count
    sort_by_distance(m, mates, 0, keepers, ways)
    sort_by_distance(m, takers, keepers, count, ways)
    nearest_takers(ways, keepers, count, scale, near)
    inverse = 1.0 / scale
    put(out, 0, length(m.x, m.y) * inverse)
    for k in range(total):
        put(out, 1 + k, length(ways[0, k], ways[1, k]) * inverse)
        put(out, 1 + total + k, ways[4, k] * inverse)
    for k in range(keepers):
        angle = angle_between(ways[2, k], ways[3, k], near[2, k], near[3, k]) if near[1, k] > -2.0 else PI
        put(out, 1 + 2 * total + k, math.sqrt(near[0, k]) * inverse)
        put(out, 1 + 2 * total + keepers + k, angle * (1.0 / PI))


@kernel
def keepaway(chosen, players, memory, mates, takers, scale, ways, near, out):
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; mates : (A, mates) and takers : (takers,) memory indices;
    scale : m, what distances are divided by; ways : (7, 22) and near : (4, 11) to be overwritten; out : (W, A, entries)
    """
    for c in range(chosen.shape[0]):
        n = chosen[c]
        for k in range(players.shape[0]):
            put_keepaway(memory[n, players[k] - 1], mates[k], takers, scale, ways, near, out[n, k])
