"""Kernel of the preset ``hfo_high``: HFO's high level features of every agent, with what opponents cover found without angles.

The goal is looked at along 29 rays. An opponent covers those that pass within half a metre of him (seen from at least 0.3 m away); they
lie side by side, so cross products of the edges of his cone with the posts tell the first and the last of them. Most opponents are too far
aside of the goal for any, which their distance from the rays to the posts tells without a root. Covered rays are bits of a word, and an
arctangent is taken only of the gaps that are left. What is open for team-mates stays as it is until the player has had another look.
"""

from __future__ import annotations

import math

import numpy as np

from ...simulator.kernels.senses import lowest_bit
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from . import kernel
from .observations import wrapped
from .vectors import RECENT, angle_between, clear, flag, kickable, last_action_possible, length, near, put, unit

PI = math.pi
RAYS = 29
COVER, CLOSE = 0.5, 0.3
"""Metres beside an opponent that he covers, and the least distance from which he is looked at."""
ASIDE = COVER + 1e-6
ALL = (1 << RAYS) - 1


@kernel
def covered(dx, dy, low, high, ahead):
    """The rays that an opponent at (dx, dy) covers, as bits; the goal lies `ahead` m away from `low` to `high` m aside."""
    distance = math.sqrt(dx * dx + dy * dy)
    far = max(distance, CLOSE)
    if distance == 0.0:
        dx, dy = 1.0, 0.0
    # the edges of his cone, turned by the angle whose tangent is COVER / far; a ray is between them where both products are above 0
    first_x, first_y = dx * far + dy * COVER, dy * far - dx * COVER
    last_x, last_y = dx * far - dy * COVER, dy * far + dx * COVER
    first_low, first_high = first_x * low - first_y * ahead, first_x * high - first_y * ahead
    last_low, last_high = ahead * last_y - low * last_x, ahead * last_y - high * last_x
    if (first_low <= 0.0 and first_high <= 0.0) or (last_low <= 0.0 and last_high <= 0.0):
        return np.int64(0)
    return above(first_low, first_high) & above(last_low, last_high)


@kernel
def above(low, high):
    """The rays, as bits, at which a number that grows evenly from `low` at the first to `high` at the last is above 0."""
    if low > 0.0 and high > 0.0:
        return np.int64(ALL)
    if low > 0.0:
        count = int(math.ceil((RAYS - 1) * low / (low - high)))
        return (np.int64(1) << count) - 1
    below = int(math.floor((RAYS - 1) * -low / (high - low))) + 1
    return np.int64(ALL) & ~((np.int64(1) << below) - 1)


@kernel
def widest(free, low, high, ahead):
    """Angle of the widest gap between rays that are free (bits)."""
    best = 0.0
    step = (high - low) / (RAYS - 1)
    first = 0
    while free:
        skipped = lowest_bit(free)
        first += skipped
        free >>= skipped
        count = lowest_bit(~free)
        if count > 1:
            best = max(best, angle_between(ahead, low + first * step, ahead, low + (first + count - 1) * step))
        first += count
        free >>= count
    return best


@kernel
def gap_from_behind(x, y, post, places, count):
    """The widest gap, ray by ray: for who stands on the goal line or behind it, where rays do not lie side by side."""
    best, run, before, was_free = 0.0, 0.0, 0.0, False
    for k in range(RAYS):
        ray = math.atan2(-post + k * (2.0 * post / (RAYS - 1)) - y, HALF_LENGTH - x)
        free = True
        for j in range(count):
            dx, dy = places[0, j] - x, places[1, j] - y
            if dx < HALF_LENGTH - x:
                half = math.atan2(COVER, max(length(dx, dy), CLOSE))
                free = free and not abs(wrapped(math.atan2(dy, dx) - ray)) < half
        run = run + abs(ray - before) if free and was_free else 0.0
        best = max(best, run)
        before, was_free = ray, free
    return best


@kernel
def goal_opening(x, y, post, places, count):
    """The widest part of the goal that no opponent covers, seen from (x, y), as share of 90 degrees mapped to [-1, 1].

    places : (2, n) x and y of the `count` opponents that are known
    """
    ahead = HALF_LENGTH - x
    if ahead > 0.0:
        low, high = -post - y, post - y
        low_x, low_y, _ = unit(ahead, low)
        high_x, high_y, _ = unit(ahead, high)
        cover = np.int64(0)
        for j in range(count):
            dx, dy = places[0, j] - x, places[1, j] - y
            # metres aside of the rays to the posts: who is farther than what he covers hides nothing between them
            if (dx < ahead) & (low_x * dy - low_y * dx > -ASIDE) & (high_y * dx - high_x * dy > -ASIDE):
                cover |= covered(dx, dy, low, high, ahead)
        gap = widest(np.int64(ALL) & ~cover, low, high, ahead) if cover else angle_between(ahead, low, ahead, high)
    else:
        gap = gap_from_behind(x, y, post, places, count)
    return 2.0 * min(gap / (0.5 * PI), 1.0) - 1.0


@kernel
def nearest(x, y, places, count, diagonal):
    """Proximity of the nearest opponent that is known; -1 when there is none."""
    least = diagonal * diagonal
    for j in range(count):
        dx, dy = places[0, j] - x, places[1, j] - y
        least = min(least, dx * dx + dy * dy)
    return near(math.sqrt(least), diagonal)


@kernel
def pass_opening(tx, ty, ways, count):
    """Angle between the way (tx, ty) to a team-mate and the opponent nearest to it, as share of 180 degrees mapped to [-1, 1].

    ways : (3, n) directions (x, y) of the `count` opponents that are known, and how far they are
    """
    ux, uy, distance = unit(tx, ty)
    best, which = -2.0, -1
    for j in range(count):
        along = ux * ways[0, j] + uy * ways[1, j]
        if ways[2, j] < distance + 1.0 and along > best:
            best, which = along, j
    if which < 0:
        return 1.0
    return 2.0 * angle_between(ux, uy, ways[0, which], ways[1, which]) / PI - 1.0


@kernel
def known_opponents(m, opponents, places, ways):
    """Note the opponents that are known: where they are, in which direction and how far; how many they are."""
    count = 0
    for j in range(11, 11 + opponents):
        if m.age[j] <= RECENT:
            places[0, count], places[1, count] = m.px[j], m.py[j]
            ways[0, count], ways[1, count], ways[2, count] = unit(m.px[j] - m.x, m.py[j] - m.y)
            count += 1
    return count


@kernel
def put_place(out, at, known, x, y, number):
    """Three entries: a place in the half field, -1 to 1 in both directions, and a number."""
    put(out, at, 2.0 * x / HALF_LENGTH - 1.0 if known else 0.0)
    put(out, at + 1, y / HALF_WIDTH if known else 0.0)
    put(out, at + 2, number / 11.0 if known else 0.0)


@kernel
def put_passes(m, mates, ways, count, out, at):
    """The way to each of the team-mates (memory indices)."""
    for k in range(mates.shape[0]):
        j = mates[k]
        known = m.age[j] <= RECENT
        put(out, at + k, pass_opening(m.px[j] - m.x, m.py[j] - m.y, ways, count) if known else 0.0)


@kernel
def put_mates(m, mates, post, places, count, diagonal, out, at):
    """What is open for the team-mates, entry after entry of each kind, and where they are; their passes lie between."""
    n = mates.shape[0]
    for k in range(n):
        j = mates[k]
        known = m.age[j] <= RECENT
        put(out, at + k, goal_opening(m.px[j], m.py[j], post, places, count) if known else 0.0)
        put(out, at + n + k, nearest(m.px[j], m.py[j], places, count, diagonal) if known else 0.0)
        put_place(out, at + 3 * n + 3 * k, known, m.px[j], m.py[j], j + 1)


@kernel
def put_opponents(m, opponents, out, at):
    """Where the opponents are."""
    for j in range(opponents):
        put_place(out, at + 3 * j, m.age[11 + j] <= RECENT, m.px[11 + j], m.py[11 + j], j + 1)


@kernel
def picture(m):
    """A number that changes when the player has looked again or somebody has been unseen for too long: what he knows of the others."""
    known = np.int64(0)
    for j in range(m.age.shape[0]):
        known |= np.int64(m.age[j] <= RECENT) << j
    return known | np.int64(m.looks) << m.age.shape[0]


@kernel
def put_own(w, p, m, i, post, places, count, diagonal, out):
    """The player himself and the ball, entries 0 to 9."""
    put(out, 0, 2.0 * m.x / HALF_LENGTH - 1.0)
    put(out, 1, m.y / HALF_WIDTH)
    put(out, 2, m.body / PI)
    if m.ball_age <= RECENT:
        put(out, 3, 2.0 * m.ball_x / HALF_LENGTH - 1.0)
        put(out, 4, m.ball_y / HALF_WIDTH)
    else:
        clear(out, 3, 5)
    flag(out, 5, kickable(w, p, m, i))
    put(out, 6, near(length(HALF_LENGTH - m.x, m.y), diagonal))
    put(out, 7, math.atan2(-m.y, HALF_LENGTH - m.x) / PI)
    put(out, 8, goal_opening(m.x, m.y, post, places, count))
    put(out, 9, nearest(m.x, m.y, places, count, diagonal))
    return 10


@kernel
def hfo_high(
    worlds, packed, chosen, players, memory, sent, cycles, mates, opponents, post, diagonal, stamina_max, places, ways, kicks, drawn, out,
):  # fmt: skip
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; sent : (W, 22) COMMAND of the cycle; cycles : (W,);
    mates : (A, mates) memory indices; opponents : how many; post : |y| of the posts; places : (2, 11) and ways : (3, 11) to be
    overwritten; kicks : (W, A); drawn : (W, A), the `picture` that the entries of others in `out` rest on; out : (W, A, entries)
    """
    p = packed[0]
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k] - 1
            m = memory[n, i]
            o = out[n, k]
            count = known_opponents(m, opponents, places, ways)
            at = put_own(w, p, m, i, post, places, count, diagonal, o)
            n_mates = mates.shape[1]
            known = picture(m)
            if known != drawn[n, k]:
                put_mates(m, mates[k], post, places, count, diagonal, o, at)
                put_opponents(m, opponents, o, at + 6 * n_mates)
                drawn[n, k] = known
            put_passes(m, mates[k], ways, count, o, at + 2 * n_mates)
            at += 6 * n_mates + 3 * opponents
            flag(o, at, last_action_possible(w, i, sent[n, i], cycles[n], kicks[n], k))
            put(o, at + 1, 2.0 * m.stamina / stamina_max - 1.0)
