"""Kernel of the preset ``hfo_high``: HFO's high level features of every agent, with what opponents cover found without angles.

The goal is looked at along 29 rays. An opponent covers those that pass within half a metre of him (seen from at least 0.3 m away); they
lie side by side, so cross products of the edges of his cone with the posts tell the first and the last of them. Most opponents are too far
aside of the goal for any, which their distance from the rays to the posts tells without a root, for the whole team at once. Covered rays
are bits of a word, and an arctangent is taken of the widest gap alone. What is open for team-mates stays as it is until the player has had
another look.
"""

from __future__ import annotations

import math

import numpy as np

from ...simulator.kernels.senses import lowest_bit
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from . import kernel
from .observations import wrapped
from .vectors import RECENT, angle_between, arc, clear, flag, kickable, last_action_possible, length, near, put, unit

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
    """Angle of the widest gap between rays that are free (bits); gaps are compared by products, and one arctangent is taken at the end."""
    cross, dot = 0.0, 1.0
    step = (high - low) / (RAYS - 1)
    first = 0
    while free:
        skipped = lowest_bit(free)
        first += skipped
        free >>= skipped
        count = lowest_bit(~free)
        begin, end = low + first * step, low + (first + count - 1) * step
        c, d = ahead * (end - begin), ahead * ahead + begin * end
        cross, dot = (c, d) if c * dot > cross * d else (cross, dot)
        first += count
        free >>= count
    return arc(cross, dot)


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
def goal_opening(x, y, post, places, count, hiders):
    """The widest part of the goal that no opponent covers, seen from (x, y), as share of 90 degrees mapped to [-1, 1].

    places : (2, n) x and y of the `count` opponents that are known; hiders : those of `hiders_of`, as bits
    """
    ahead = HALF_LENGTH - x
    if ahead > 0.0:
        low, high = -post - y, post - y
        cover = np.int64(0)
        while hiders:
            j = lowest_bit(hiders)
            hiders &= hiders - 1
            cover |= covered(places[0, j] - x, places[1, j] - y, low, high, ahead)
        gap = widest(np.int64(ALL) & ~cover, low, high, ahead)
    else:
        gap = gap_from_behind(x, y, post, places, count)
    return 2.0 * min(gap / (0.5 * PI), 1.0) - 1.0


@kernel
def rays_to_posts(x, y, post):
    """Directions (x, y) of the posts seen from (x, y), the lower first."""
    low_x, low_y, _ = unit(HALF_LENGTH - x, -post - y)
    high_x, high_y, _ = unit(HALF_LENGTH - x, post - y)
    return low_x, low_y, high_x, high_y


@kernel
def may_hide(dx, dy, ahead, low_x, low_y, high_x, high_y):
    """Whether somebody at (dx, dy) may cover a ray: who is farther aside of the rays to the posts than what he covers hides nothing."""
    return (dx < ahead) & (low_x * dy - low_y * dx > -ASIDE) & (high_y * dx - high_x * dy > -ASIDE)


@kernel
def hiders_of(x, y, post, places, count):
    """The opponents who may cover a part of the goal from (x, y), as bits."""
    low_x, low_y, high_x, high_y = rays_to_posts(x, y, post)
    hiders = np.int64(0)
    for j in range(count):
        dx, dy = places[0, j] - x, places[1, j] - y
        hiders |= np.int64(may_hide(dx, dy, HALF_LENGTH - x, low_x, low_y, high_x, high_y)) << j
    return hiders


@kernel
def survey_team(m, team, post, places, count, diagonal, rays, squares, hiders):
    """`hiders_of` and the squared distance of the nearest opponent for all of the own team, side by side.

    rays : (4, 11), squares : (11,), hiders : (11,), to be overwritten; columns are memory indices 0 to `team` - 1
    """
    for k in range(team):
        rays[0, k], rays[1, k], rays[2, k], rays[3, k] = rays_to_posts(m.px[k], m.py[k], post)
        squares[k], hiders[k] = diagonal * diagonal, 0
    for j in range(count):
        x, y = places[0, j], places[1, j]
        for k in range(team):
            dx, dy = x - m.px[k], y - m.py[k]
            squares[k] = min(squares[k], dx * dx + dy * dy)
            hides = may_hide(dx, dy, HALF_LENGTH - m.px[k], rays[0, k], rays[1, k], rays[2, k], rays[3, k])
            hiders[k] |= np.int64(hides) << j


@kernel
def nearest(x, y, places, count, diagonal):
    """Proximity of the nearest opponent that is known; -1 when there is none."""
    least = diagonal * diagonal
    for j in range(count):
        dx, dy = places[0, j] - x, places[1, j] - y
        least = min(least, dx * dx + dy * dy)
    return near(math.sqrt(least), diagonal)


@kernel
def nearest_ways(m, team, ways, count, best):
    """For all of the own team, side by side, the opponent whose direction is nearest to the way to them and who is not much farther.

    ways : (3, n) directions (x, y) of the `count` opponents that are known, and how far they are; best : (6, 11), overwritten: the way (x,
    y) and its length, the cosine of the angle (-2: nobody) and the opponent's direction (x, y)
    """
    for k in range(team):
        best[0, k], best[1, k], best[2, k] = unit(m.px[k] - m.x, m.py[k] - m.y)
        best[3, k], best[4, k], best[5, k] = -2.0, 1.0, 0.0
    for j in range(count):
        x, y, far = ways[0, j], ways[1, j], ways[2, j]
        for k in range(team):
            along = best[0, k] * x + best[1, k] * y
            nearer = (far < best[2, k] + 1.0) & (along > best[3, k])
            best[3, k] = along if nearer else best[3, k]
            best[4, k] = x if nearer else best[4, k]
            best[5, k] = y if nearer else best[5, k]


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
def put_passes(m, mates, best, out, at):
    """For each of the team-mates (memory indices) the angle between the way to him and the opponent nearest to it, as share of 180
    degrees mapped to [-1, 1]."""
    for k in range(mates.shape[0]):
        j = mates[k]
        angle = angle_between(best[0, j], best[1, j], best[4, j], best[5, j]) if best[3, j] > -2.0 else PI
        put(out, at + k, 2.0 * angle / PI - 1.0 if m.age[j] <= RECENT else 0.0)


@kernel
def put_mates(m, mates, post, places, count, diagonal, squares, hiders, out, at):
    """What is open for the team-mates, entry after entry of each kind, and where they are; their passes lie between."""
    n = mates.shape[0]
    for k in range(n):
        j = mates[k]
        known = m.age[j] <= RECENT
        put(out, at + k, goal_opening(m.px[j], m.py[j], post, places, count, hiders[j]) if known else 0.0)
        put(out, at + n + k, near(math.sqrt(squares[j]), diagonal) if known else 0.0)
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
    angle = arc(abs(m.y), HALF_LENGTH - m.x) / PI
    put(out, 7, -angle if m.y > 0.0 else angle)
    put(out, 8, goal_opening(m.x, m.y, post, places, count, hiders_of(m.x, m.y, post, places, count)))
    put(out, 9, nearest(m.x, m.y, places, count, diagonal))
    return 10


@kernel
def hfo_high(
    worlds, packed, chosen, players, memory, sent, cycles, mates, opponents, post, diagonal, stamina_max, places, ways, best, hiders, kicks,
    drawn, out,
):  # fmt: skip
    """The vectors of the agents in the chosen worlds.

    chosen : (n,); players : (A,) object numbers; memory : (W, 22) MEMORY; sent : (W, 22) COMMAND of the cycle; cycles : (W,);
    mates : (A, mates) memory indices; opponents : how many; post : |y| of the posts; places : (2, 11), ways : (3, 11), best : (6, 11) and
    hiders : (11,) int to be overwritten; kicks : (W, A); drawn : (W, A), the `picture` that the entries of others in `out` rest on;
    out : (W, A, entries)
    """
    p = packed[0]
    n_mates = mates.shape[1]
    team = n_mates + 1
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k] - 1
            m = memory[n, i]
            o = out[n, k]
            count = known_opponents(m, opponents, places, ways)
            at = put_own(w, p, m, i, post, places, count, diagonal, o)
            known = picture(m)
            if known != drawn[n, k]:
                survey_team(m, team, post, places, count, diagonal, best[:4], best[4], hiders)
                put_mates(m, mates[k], post, places, count, diagonal, best[4], hiders, o, at)
                put_opponents(m, opponents, o, at + 6 * n_mates)
                drawn[n, k] = known
            nearest_ways(m, team, ways, count, best)
            put_passes(m, mates[k], best, o, at + 2 * n_mates)
            at += 6 * n_mates + 3 * opponents
            flag(o, at, last_action_possible(w, i, sent[n, i], cycles[n], kicks[n], k))
            put(o, at + 1, 2.0 * m.stamina / stamina_max - 1.0)
