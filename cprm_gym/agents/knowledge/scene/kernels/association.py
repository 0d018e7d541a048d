"""Who is who: readings without a number are shared out among those who can have caused them, within a budget.

Each of the likeliest assignments of all nameless readings of a look is a hypothesis; no player causes two readings, and who is not seen
where he should be makes a hypothesis less likely. A player's belief is the mixture over the hypotheses, merged to one normal for each mode.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .....architecture.prm.inference.continuous.kernels.reduction import log_volume
from . import kernel
from .players import (
    ASIDE,
    ELSEWHERE,
    FAR,
    FAR_NOISE,
    FIELD,
    FRESH,
    GATE,
    HALF,
    HIGH,
    LOW,
    MODES,
    SOFT,
    SPEED,
    STATE,
    STRAY,
    VARIANCE,
    add_paths,
    begin_track,
    clear,
    condition_paths,
    place_of,
    predict,
    readings_of,
    settle,
    stay,
    unseen_paths,
    volumes,
)
from .reading import turned_back

PLAYERS = 22
NOBODY, NEWCOMER = -1, -2
"""A reading that nobody caused, and, less the number, one of somebody who was not known."""
BELIEVED, GONE, CONFIRMED = 0.9, 0.02, 0.3
"""Share to which a nameless player is believed in at first, below which he is forgotten, and of the doubt that is left when he is seen."""


class Tracks(NamedTuple):
    """What N agents believe of the others, own team 0..10, opponents 11..21."""

    w: np.ndarray
    """(N, 22, MODES) weights."""
    mu: np.ndarray
    """(N, 22, MODES, 4)."""
    cv: np.ndarray
    """(N, 22, MODES, 4, 4)."""
    known: np.ndarray
    """(N, 22) int64: 0 never seen, 1 without a number, 2 with it."""
    age: np.ndarray
    """(N, 22) cycles since he was seen."""
    doubt: np.ndarray
    """(N, 22) probability that one without a number is not there."""
    arms: np.ndarray
    """(N, 22, 2) direction of the body (rad, unwrapped) and its variance."""
    dropped: np.ndarray
    """(N,) nats that the budget of hypotheses lost in the last look."""
    merged: np.ndarray
    """(N,) nats that merging lost at most (Runnalls' bound)."""


class Seen(NamedTuple):
    """What N agents are told in a cycle."""

    me: np.ndarray
    """(N, 7) x, y, vx, vy, face, variance of the place, variance of the face."""
    half: np.ndarray
    """(N,) half the view cone, rad."""
    fresh: np.ndarray
    """(N,) bool."""
    before: np.ndarray
    """(N,) bool: the look shows the world before the step."""
    rows: np.ndarray
    """(N, 22, 7) as observed."""
    levels: np.ndarray
    """(N, 22)."""
    side: np.ndarray
    """(N,) +1 left."""
    own: np.ndarray
    """(N,) own number less 1."""
    still: np.ndarray
    """(N,) bool: nothing new is told and nothing moves."""


class Modes(NamedTuple):
    """How players move."""

    switch: np.ndarray
    """(MODES, MODES) probabilities."""
    keeps: np.ndarray
    """(MODES,) share of the velocity that stays."""
    pushes: np.ndarray
    """(MODES,) variance of its change."""
    shares: np.ndarray
    """(MODES,) at first."""
    turning: float
    """Variance by which a body turns in a cycle."""


class Room(NamedTuple):
    """Arrays to work in; see `Rooms`."""

    pw: np.ndarray
    pm: np.ndarray
    pc: np.ndarray
    uw: np.ndarray
    um: np.ndarray
    uc: np.ndarray
    qw: np.ndarray
    qm: np.ndarray
    qc: np.ndarray
    pairs: np.ndarray
    """(PAIRS, 2) int64 reading, player."""
    scores: np.ndarray
    """(PAIRS, 2) log likelihood less that of not being seen; share of the hypotheses."""
    miss: np.ndarray
    places: np.ndarray
    told: np.ndarray
    mine: np.ndarray
    """(4, 4) a reading as one of a certain player."""
    sight: np.ndarray
    """(22, 3) cosine, sine, distance."""
    counts: np.ndarray
    loose: np.ndarray
    first: np.ndarray
    masks: np.ndarray
    logs: np.ndarray
    choices: np.ndarray
    sums: np.ndarray
    means: np.ndarray
    spreads: np.ndarray
    mean: np.ndarray
    cov: np.ndarray
    slopes: np.ndarray
    lower: np.ndarray


@kernel
def number_of(j, side):
    """Index of the player that stands at index `j` of the see arrays."""
    return j if side > 0.0 else (j + 11) % PLAYERS


@kernel
def chance_anywhere(told, count, p):
    """Log probability of a reading of somebody who may be anywhere and move anyhow."""
    total = -math.log(p[FIELD])
    for r in range(count):
        width = told[r, HIGH] - told[r, LOW]
        if width > 0.0:
            total += math.log(width)
        if r > ASIDE:
            total -= math.log(4.0 * p[SPEED])
    return total


@kernel
def near_enough(place, x, y, cos, sin, told, gate):
    """Whether a reading at (x, y) can be of somebody who is there."""
    along = (told[FAR, HIGH] - told[FAR, LOW]) ** 2 / 12.0 + told[FAR, VARIANCE]
    aside = (told[ASIDE, HIGH] - told[ASIDE, LOW]) ** 2 / 12.0 + told[ASIDE, VARIANCE]
    xx = place[2] + along * cos * cos + aside * sin * sin
    yy = place[4] + along * sin * sin + aside * cos * cos
    xy = place[3] + (along - aside) * cos * sin
    dx, dy = x - place[0], y - place[1]
    return yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy < gate * (xx * yy - xy * xy)


@kernel
def relabel(t, n, k, other):
    """Player `other` takes over what was believed of `k`, who is not known any more."""
    for m in range(MODES):
        t.w[n, other, m] = t.w[n, k, m]
        for i in range(STATE):
            t.mu[n, other, m, i] = t.mu[n, k, m, i]
            for j in range(STATE):
                t.cv[n, other, m, i, j] = t.cv[n, k, m, i, j]
    t.known[n, other], t.age[n, other], t.doubt[n, other] = t.known[n, k], t.age[n, k], t.doubt[n, k]
    t.arms[n, other, 0], t.arms[n, other, 1] = t.arms[n, k, 0], t.arms[n, k, 1]
    t.known[n, k] = 0


@kernel
def unused(t, n, low, high, mask, own):
    """The lowest number that nobody known has; -1 for none."""
    for k in range(low, high):
        if t.known[n, k] == 0 and k != own and not (mask >> k) & 1:
            return k
    return -1


@kernel
def paths_of(t, n, k, moves, modes, p, room):
    """The paths of a track in this cycle."""
    if moves:
        predict(t.w[n, k], t.mu[n, k], t.cv[n, k], modes.switch, modes.keeps, modes.pushes, p, room.pw[k], room.pm[k], room.pc[k])
    else:
        stay(t.w[n, k], t.mu[n, k], t.cv[n, k], room.pw[k], room.pm[k], room.pc[k])


@kernel
def keep(t, n, k, w, mu, cv, room):
    """A track from its paths alone."""
    clear(room.sums, room.means, room.spreads)
    add_paths(1.0, w, mu, cv, room.sums, room.means, room.spreads)
    settle(room.sums, room.means, room.spreads, t.w[n, k], t.mu[n, k], t.cv[n, k])


@kernel
def read_row(row, level, me, j, p, room):
    """Take down reading j: where it was seen and what it says."""
    angle = me[4] + row[1]
    count, far = readings_of(row, level, p, me[5], me[6], -1.0, room.told[j])
    room.counts[j] = count
    room.sight[j, 0], room.sight[j, 1], room.sight[j, 2] = math.cos(angle), math.sin(angle), far


@kernel
def begin_at(t, n, k, me, j, modes, p, room):
    """A track from reading j alone."""
    begin_track(
        me, room.sight[j, 0], room.sight[j, 1], room.told[j], room.counts[j], room.sight[j, 2], modes.shares, p,
        t.w[n, k], t.mu[n, k], t.cv[n, k], room.mean, room.cov, room.slopes,
    )  # fmt: skip
    t.arms[n, k, 0], t.arms[n, k, 1] = 0.0, 10.0


@kernel
def likelihood(k, me, row, level, j, q, p, room):
    """Log likelihood of reading j as one of player k, whose paths are then in place q of the room of pairs."""
    told = room.told[j]
    if p[FAR_NOISE] > 0.0:  # how large its errors are hangs on how far he is
        told = room.mine
        readings_of(row, level, p, me[5], me[6], expected_distance(room.pw[k], room.pm[k], me), told)
    return condition_paths(
        room.pw[k], room.pm[k], room.pc[k], me, room.sight[j, 0], room.sight[j, 1], told, room.counts[j],
        room.qw[q], room.qm[q], room.qc[q], room.mean, room.cov, room.slopes,
    )  # fmt: skip


@kernel
def expected_distance(w, mu, me):
    """How far the mean place of weighted paths is, m."""
    x, y = 0.0, 0.0
    for k in range(len(w)):
        if w[k] > 0.0:
            x += w[k] * mu[k, 0]
            y += w[k] * mu[k, 1]
    return math.hypot(x - me[0], y - me[1])


@kernel
def take_named(t, n, k, me, row, j, done, modes, p, room):
    """The reading of somebody whose number is told."""
    elsewhere = chance_anywhere(room.told[j], room.counts[j], p)
    own = t.known[n, k] > 0
    if own:
        own = likelihood(k, me, row, 3.0, j, 0, p, room) > elsewhere + math.log(p[ELSEWHERE])
        if not own and t.known[n, k] == 1:  # somebody else had his number
            low = 0 if k < 11 else 11
            other = unused(t, n, low, low + 11, done, k)
            if other >= 0:
                relabel(t, n, k, other)
                for m in range(len(room.pw[k])):
                    room.pw[other, m] = room.pw[k, m]
                    for i in range(STATE):
                        room.pm[other, m, i] = room.pm[k, m, i]
                        for l in range(STATE):
                            room.pc[other, m, i, l] = room.pc[k, m, i, l]
    if not own:  # one without a number who is there has it
        best, who = elsewhere + math.log(p[ELSEWHERE]), -1
        low = 0 if k < 11 else 11
        for other in range(low, low + 11):
            if t.known[n, other] == 1 and other != k and not (done >> other) & 1:
                told = likelihood(other, me, row, 3.0, j, 0, p, room)
                if told > best:
                    best, who = told, other
        if who >= 0:
            relabel(t, n, who, k)
            likelihood(who, me, row, 3.0, j, 0, p, room)
            own = True
    if own:
        keep(t, n, k, room.qw[0], room.qm[0], room.qc[0], room)
    else:
        begin_at(t, n, k, me, j, modes, p, room)
    t.known[n, k], t.age[n, k], t.doubt[n, k] = 2, 0, 0.0
    if room.counts[j] == 4:
        face_with(t.arms[n, k], me[4] + row[4], p[HALF] ** 2 / 3.0 + me[6])


@kernel
def face_with(arm, told, variance):
    """The direction of a body as it was told."""
    gain = arm[1] / (arm[1] + variance)
    arm[0] += gain * turned_back(told - arm[0])
    arm[1] *= 1.0 - gain


@kernel
def push(room, side, made, mask, weight, source, h, reading, choice, lost):
    """Add a hypothesis to a room, in which there may be no more than it has places; (how many, log weight that is lost)."""
    size = room.logs.shape[1]
    place = made
    if made < size:
        made += 1
    else:
        place = 0
        for i in range(1, size):
            if room.logs[side, i] < room.logs[side, place]:
                place = i
        least = min(weight, room.logs[side, place])
        lost = least + math.log1p(math.exp(lost - least)) if lost > -np.inf else least
        if room.logs[side, place] >= weight:
            return made, lost
    room.masks[side, place], room.logs[side, place] = mask, weight
    for i in range(reading):
        room.choices[side, place, i] = room.choices[source, h, i]
    room.choices[side, place, reading] = choice
    return made, lost


@kernel
def assign(t, n, loose, done, own, levels, p, room):
    """The likeliest assignments of the nameless readings: (room, how many, nats lost); shares of the pairs into ``room.scores[:, 1]``."""
    side, made = 0, 1
    room.masks[0, 0], room.logs[0, 0] = done, 0.0
    dropped = 0.0
    for i in range(loose):
        j = room.loose[i]
        anywhere = chance_anywhere(room.told[j], room.counts[j], p)
        count, made, lost = made, 0, -np.inf
        low, high = room.places[PLAYERS + i, 0], room.places[PLAYERS + i, 1]
        for h in range(count):
            mask, weight = room.masks[side, h], room.logs[side, h]
            for q in range(room.first[i], room.first[i + 1]):
                k = room.pairs[q, 1]
                if not (mask >> k) & 1:
                    made, lost = push(room, 1 - side, made, mask | (np.int64(1) << k), weight + room.scores[q, 0], side, h, i, q, lost)
            if levels[j] >= 2.0:
                k = unused(t, n, int(low), int(high), mask, own)
                if k >= 0:
                    more = weight + anywhere + math.log(p[FRESH])
                    made, lost = push(room, 1 - side, made, mask | (np.int64(1) << k), more, side, h, i, NEWCOMER - k, lost)
            made, lost = push(room, 1 - side, made, mask, weight + anywhere + math.log(p[STRAY]), side, h, i, NOBODY, lost)
        side = 1 - side
        if lost > -np.inf:
            best = -np.inf
            for h in range(made):
                best = max(best, room.logs[side, h])
            total = 0.0
            for h in range(made):
                total += math.exp(room.logs[side, h] - best)
            dropped += math.log1p(math.exp(lost - best) / total)
    best = 0
    for h in range(1, made):
        if room.logs[side, h] > room.logs[side, best]:
            best = h
    total = 0.0
    for h in range(made):
        room.logs[side, h] = math.exp(room.logs[side, h] - room.logs[side, best]) if h != best else room.logs[side, h]
        total += room.logs[side, h] if h != best else 1.0
    room.logs[side, best] = 1.0
    for h in range(made):
        share = room.logs[side, h] / total
        if p[SOFT] == 0.0:
            share = 1.0 if h == best else 0.0
        for i in range(loose):
            q = room.choices[side, h, i]
            if q >= 0:
                room.scores[q, 1] += share
    return side, best, dropped


@kernel
def look(t, n, seen, modes, p, room):
    """One look of agent n; the paths of those known are in the room."""
    me, own, side = seen.me[n], seen.own[n], seen.side[n]
    rows, levels = seen.rows[n], seen.levels[n]
    done = np.int64(1) << own
    loose = 0
    for j in range(PLAYERS):
        if levels[j] <= 0.0:
            continue
        read_row(rows[j], levels[j], me, j, p, room)
        if levels[j] < 3.0:
            room.loose[loose] = j
            loose += 1
            continue
        k = number_of(j, side)
        if k != own:
            take_named(t, n, k, me, rows[j], j, done, modes, p, room)
            done |= np.int64(1) << k
    for k in range(PLAYERS):
        if t.known[n, k] and not (done >> k) & 1:
            room.miss[k] = unseen_paths(
                room.pw[k], room.pm[k], room.pc[k], me, me[4], seen.half[n], me[6], p, room.uw[k], room.um[k], room.uc[k],
                room.mean, room.cov, room.slopes,
            )  # fmt: skip
            place_of(room.pw[k], room.pm[k], room.pc[k], room.places[k])
    pairs = find_pairs(t, n, loose, done, me, side, rows, levels, p, room)
    hypotheses, best, t.dropped[n] = assign(t, n, loose, done, own, levels, p, room)
    for k in range(PLAYERS):
        if t.known[n, k] and not (done >> k) & 1:
            take_shares(t, n, k, pairs, room)
    for i in range(loose):
        k = NEWCOMER - room.choices[hypotheses, best, i]
        if k >= 0:
            begin_at(t, n, k, me, room.loose[i], modes, p, room)
            t.known[n, k], t.age[n, k], t.doubt[n, k] = 1, 0, 1.0 - BELIEVED


@kernel
def find_pairs(t, n, loose, done, me, side, rows, levels, p, room):
    """Who can have caused which nameless reading, with what that says of him; how many pairs."""
    pairs = 1  # the first place is for those with numbers
    for i in range(loose):
        j = room.loose[i]
        room.first[i] = pairs
        low, high = 0, PLAYERS
        if levels[j] >= 2.0:
            low = 0 if number_of(j, side) < 11 else 11
            high = low + 11
        room.places[PLAYERS + i, 0], room.places[PLAYERS + i, 1] = low, high
        x, y = me[0] + room.sight[j, 2] * room.sight[j, 0], me[1] + room.sight[j, 2] * room.sight[j, 1]
        for k in range(low, high):
            if t.known[n, k] == 0 or (done >> k) & 1 or pairs >= len(room.pairs):
                continue
            if not near_enough(room.places[k], x, y, room.sight[j, 0], room.sight[j, 1], room.told[j], p[GATE]):
                continue
            told = likelihood(k, me, rows[j], levels[j], j, pairs, p, room)
            if told > -np.inf:
                room.pairs[pairs, 0], room.pairs[pairs, 1] = j, k
                room.scores[pairs, 0], room.scores[pairs, 1] = told - room.miss[k], 0.0
                pairs += 1
        room.first[i + 1] = pairs
    return pairs


@kernel
def take_shares(t, n, k, pairs, room):
    """A track from the readings that are his in a share of the hypotheses, and from not being seen in the others."""
    clear(room.sums, room.means, room.spreads)
    rest, before = 1.0, 0.0
    for q in range(1, pairs):
        if room.pairs[q, 1] == k and room.scores[q, 1] > 1e-12:
            share = min(rest, room.scores[q, 1])
            rest -= share
            add_paths(share, room.qw[q], room.qm[q], room.qc[q], room.sums, room.means, room.spreads)
            before += volumes(share, room.qw[q], room.qc[q], room.lower)
    seen = rest < 0.5
    if rest > 1e-12:
        add_paths(rest, room.uw[k], room.um[k], room.uc[k], room.sums, room.means, room.spreads)
        before += volumes(rest, room.uw[k], room.uc[k], room.lower)
    settle(room.sums, room.means, room.spreads, t.w[n, k], t.mu[n, k], t.cv[n, k])
    after = 0.0
    for m in range(MODES):
        if t.w[n, k, m] > 0.0:
            after += t.w[n, k, m] * log_volume(t.cv[n, k, m], STATE, room.lower)
    t.merged[n] += max(0.0, 0.5 * (after - before))
    if seen:
        t.age[n, k] = 0
        t.doubt[n, k] *= CONFIRMED
    elif t.known[n, k] == 1:
        there = (1.0 - t.doubt[n, k]) * math.exp(room.miss[k])
        t.doubt[n, k] = 1.0 - there / (there + t.doubt[n, k])
        if t.doubt[n, k] > 1.0 - GONE:
            t.known[n, k] = 0


@kernel
def know_players(t, seen, modes, p, room):
    """A cycle of what N agents believe of the others, in place."""
    for n in range(len(t.w)):
        if seen.still[n]:
            continue
        t.dropped[n], t.merged[n] = 0.0, 0.0
        for k in range(PLAYERS):
            if t.known[n, k]:
                paths_of(t, n, k, not seen.before[n], modes, p, room)
                t.age[n, k] += 1
                t.arms[n, k, 1] += modes.turning
        if seen.fresh[n]:
            look(t, n, seen, modes, p, room)
        for k in range(PLAYERS):
            if t.known[n, k] and (seen.before[n] or not seen.fresh[n]):
                if seen.fresh[n]:
                    paths_of(t, n, k, True, modes, p, room)
                keep(t, n, k, room.pw[k], room.pm[k], room.pc[k], room)


@kernel
def expected_places(t, modes, ahead, decay, out):
    """Expected places and velocities (N, 22, 4) of those who are known, `ahead` cycles from the last news on; 0 of the others."""
    for n in range(len(t.w)):
        for k in range(PLAYERS):
            for i in range(STATE):
                out[n, k, i] = 0.0
            if not t.known[n, k]:
                continue
            for m in range(MODES):
                kept, way = 1.0, 0.0
                for _ in range(ahead):
                    kept *= modes.keeps[m]
                    way += kept / decay
                for a in range(2):
                    out[n, k, a] += t.w[n, k, m] * (t.mu[n, k, m, a] + way * t.mu[n, k, m, 2 + a])
                    out[n, k, 2 + a] += t.w[n, k, m] * kept * t.mu[n, k, m, 2 + a]
