"""One player: how he moves in each mode, what a reading says of him, and what it says that he is not seen.

Columns of a state: x, y (m), vx, vy (m / cycle, as the server tells them: after the decay) in the frame of the own team. A track has a
normal for each mode; a cycle takes each into each mode, conditions all of them, and merges those of one mode.
"""

from __future__ import annotations

import math

import numpy as np

from .....architecture.prm.inference.continuous.kernels.normals import absorb, truncated
from .....architecture.prm.inference.continuous.kernels.reduction import log_volume
from ...kernels.eye import told_between
from . import kernel
from .reading import read, turned_back

STATE, MODES = 4, 3
PATHS = MODES * MODES
"""Modes before and after."""
(STEP, ROUNDING, HALF, FAR_NOISE, ANGLE_NOISE, PACE_NOISE, SWING_NOISE, BLUR, DECAY, JITTER, PLACED, TURNED, PACED, SEEN, NEAR, RATE_STEP,
 SWING_STEP, GAUSSIAN, ELSEWHERE, FRESH, STRAY, SPEED, GATE, SOFT, FIELD, ARM, TIED, AFTER, SHRUNK, EYE, COARSER) = range(31)  # fmt: skip
"""Terms: what the numbers of ``p`` are."""
LIGHTEST = 1e-60
"""Weight of a path that is left out: sums of still lighter ones lose their digits."""
FAR, ASIDE, APPROACH, SWING = 0, 1, 2, 3
LOW, HIGH, VARIANCE, SHARE = 0, 1, 2, 3


@kernel
def move(mean, cov, keep, push, jitter, decay, to_mean, to_cov):
    """One cycle in a mode: he keeps a share of his velocity, and it changes by a normal of variance `push`.

    The way of a cycle is the velocity before the decay, ``v' / decay``, and a normal of variance `jitter`.
    """
    way = keep / decay
    for a in range(2):
        to_mean[a] = mean[a] + way * mean[2 + a]
        to_mean[2 + a] = keep * mean[2 + a]
        for b in range(2):
            own = 1.0 if a == b else 0.0
            speed = cov[2 + a, 2 + b]
            to_cov[2 + a, 2 + b] = keep * keep * speed + own * push
            to_cov[a, 2 + b] = keep * (cov[a, 2 + b] + way * speed) + own * push / decay
            to_cov[2 + b, a] = to_cov[a, 2 + b]
            to_cov[a, b] = cov[a, b] + way * (cov[a, 2 + b] + cov[b, 2 + a]) + way * way * speed + own * (push / (decay * decay) + jitter)


@kernel
def copy_state(mean, cov, to_mean, to_cov):
    """A state in another room."""
    for i in range(STATE):
        to_mean[i] = mean[i]
        for j in range(STATE):
            to_cov[i, j] = cov[i, j]


@kernel
def predict(w, mu, cv, switch, keeps, pushes, p, to_w, to_mu, to_cv):
    """The paths of a track through a cycle: every mode before, every mode after.

    w : (MODES,) weights; to_w : (PATHS,)
    switch : (MODES, MODES) probabilities
    """
    for i in range(MODES):
        for j in range(MODES):
            k = i * MODES + j
            to_w[k] = w[i] * switch[i, j]
            if to_w[k] > 0.0:
                move(mu[i], cv[i], keeps[j], pushes[j], p[JITTER], p[DECAY], to_mu[k], to_cv[k])


@kernel
def stay(w, mu, cv, to_w, to_mu, to_cv):
    """The paths of a track while nothing moves: those that keep their mode."""
    for k in range(PATHS):
        to_w[k] = 0.0
    for i in range(MODES):
        to_w[i * MODES + i] = w[i]
        copy_state(mu[i], cv[i], to_mu[i * MODES + i], to_cv[i * MODES + i])


@kernel
def readings_of(row, level, p, placed, turned, expected, told):
    """What a row of the eye says: far, aside, approach, swing into `told` (4, 4); (how many, distance in the middle).

    Ends, variance, and of a change the share of the distance by which it is told: what is read is by how much the velocity differs from
    that share of how far he is. Errors are shares of the true distance: if those of what is told were taken, readings that are too short
    would count for more. Of an error of the logarithm the share is of what lies between both, ``log(t / d) = (t - d) / sqrt(t d)`` but for
    its third power.

    placed : variance of the own place; turned : variance of where he looks
    expected : how far he was expected to be, m; below 0 where nothing is known
    """
    coarse = 0.0 if p[GAUSSIAN] > 0.0 else 1.0
    distance = max(row[0], 0.05)
    half, rounding = 0.5 * coarse * p[STEP], coarse * p[ROUNDING]
    low, high = max(distance - rounding, 0.0) * math.exp(-half) * p[SHRUNK], (distance + rounding) * math.exp(half) * p[SHRUNK]
    if p[EYE] > 0.0:
        least, most = told_between(distance, p[EYE], p[COARSER])
        if most > least:
            low, high = least, most
    far = middle = 0.5 * (low + high)
    if expected >= 0.0:
        most = 3.0 * p[FAR_NOISE] + half
        far = min(max(expected, middle / (1.0 + most)), middle / max(1.0 - most, 0.25))
        if coarse > 0.0:
            far = math.sqrt(far * middle)
    told[FAR, LOW], told[FAR, HIGH] = low, high
    told[FAR, VARIANCE] = p[PLACED] ** 2 + placed + (p[FAR_NOISE] * far) ** 2
    told[ASIDE, LOW], told[ASIDE, HIGH] = -p[HALF] * far, p[HALF] * far
    told[ASIDE, VARIANCE] = p[PLACED] ** 2 + placed + (p[ANGLE_NOISE] ** 2 + p[TURNED] ** 2 + turned) * far * far
    if level < 3.0 or p[ARM] == 0.0:
        return 2, middle
    approach, told[APPROACH, SHARE] = row[2], 0.0
    if p[TIED] > 0.0:
        approach, told[APPROACH, SHARE] = 0.0, row[2] / distance
    pace = (0.5 * p[RATE_STEP] * far if coarse > 0.0 else 0.25 * p[RATE_STEP]) + abs(row[2]) * p[AFTER] + 0.002
    round, swing, told[SWING, SHARE] = 0.5 * p[SWING_STEP] * far + 0.002, 0.0, row[3]
    if p[SWING_NOISE] > 0.0:  # a share that is mostly noise would say that he is near
        swing, told[SWING, SHARE] = row[3] * far, 0.0
        round += abs(swing) * (half + p[FAR_NOISE])
    told[APPROACH, LOW], told[APPROACH, HIGH] = approach - pace, approach + pace
    told[APPROACH, VARIANCE] = p[PACED] ** 2 + p[PACE_NOISE] ** 2
    told[SWING, LOW], told[SWING, HIGH] = swing - round, swing + round
    told[SWING, VARIANCE] = p[PACED] ** 2 + (p[SWING_NOISE] * far) ** 2
    return 4, middle


@kernel
def condition(mean, cov, me, cos, sin, told, first, count, work_mean, work_cov, slopes):
    """Condition a state on readings `first` to `count` of `told`, seen from `me` (x, y, vx, vy) along (cos, sin); log likelihood.

    Changes are told as shares of how far he is (`readings_of`), which is a straight line of place and velocity.
    """
    copy_state(mean, cov, work_mean, work_cov)
    total = 0.0
    for r in range(first, count):
        at = 0 if r < APPROACH else 2
        along = r == FAR or r == APPROACH
        for i in range(STATE):
            slopes[i] = 0.0
        slopes[at], slopes[at + 1] = (cos, sin) if along else (-sin, cos)
        if at == 2:
            slopes[0], slopes[1] = -told[r, SHARE] * cos, -told[r, SHARE] * sin
        centre = 0.0
        for i in range(STATE):
            centre -= slopes[i] * me[i]
        total += read(work_mean, work_cov, STATE, slopes, centre, told[r, VARIANCE], told[r, LOW], told[r, HIGH])
        if not total > -np.inf:
            return -np.inf
    copy_state(work_mean, work_cov, mean, cov)
    return total


@kernel
def condition_paths(w, mu, cv, me, cos, sin, told, count, to_w, to_mu, to_cv, work_mean, work_cov, slopes):
    """Paths of a track conditioned on readings, into another room, weights summing to 1; the log likelihood."""
    best = -np.inf
    for k in range(PATHS):
        to_w[k] = -np.inf
        if w[k] > 0.0:
            copy_state(mu[k], cv[k], to_mu[k], to_cv[k])
            to_w[k] = math.log(w[k]) + condition(to_mu[k], to_cv[k], me, cos, sin, told, 0, count, work_mean, work_cov, slopes)
            best = max(best, to_w[k])
    return weights_of(to_w, best)


@kernel
def weights_of(logs, best):
    """Log weights as weights that sum to 1, in place; the log of their sum."""
    if not best > -np.inf:
        for k in range(PATHS):
            logs[k] = 0.0
        return -np.inf
    total = 0.0
    for k in range(PATHS):
        logs[k] = math.exp(logs[k] - best)
        total += logs[k]
    for k in range(PATHS):
        logs[k] /= total
    return best + math.log(total)


@kernel
def unseen(mean, cov, me, face, half, seen, near, turned, work_mean, work_cov, slopes):
    """Condition a state on that he is not seen, who within `half` rad of the face or `near` m is seen with probability `seen`.

    Two moments of the angle off the face, a straight line around the state's mean; gives the log probability.
    """
    dx, dy = mean[0] - me[0], mean[1] - me[1]
    far = max(0.3, math.sqrt(dx * dx + dy * dy))
    nx, ny = -dy / (far * far), dx / (far * far)
    for i in range(STATE):
        slopes[i] = 0.0
    slopes[0], slopes[1] = nx, ny
    off = turned_back(math.atan2(dy, dx) - face)
    for j in range(STATE):
        work_mean[j] = mean[j]
        work_cov[STATE, j] = nx * cov[0, j] + ny * cov[1, j]
        work_cov[j, STATE] = work_cov[STATE, j]
        for i in range(STATE):
            work_cov[i, j] = cov[i, j]
    variance = nx * work_cov[STATE, 0] + ny * work_cov[STATE, 1] + turned
    work_cov[STATE, STATE], work_mean[STATE] = variance, off
    sd = math.sqrt(variance)
    log_in, first, second = truncated((-half - off) / sd, (half - off) / sd)
    inside = math.exp(log_in)
    close = 0.0
    if near > 0.0:
        reach = math.sqrt((dx * dx * cov[0, 0] + 2.0 * dx * dy * cov[0, 1] + dy * dy * cov[1, 1]) / (far * far) + 1e-9)
        close = 0.5 * math.erfc((far - near) / reach / math.sqrt(2.0))
    within, beyond = inside * (1.0 - seen), (1.0 - inside) * (1.0 - seen * close)
    total = within + beyond
    if not total > 1e-300:
        return -700.0
    if 1e-9 < inside < 1.0 - 1e-9:
        spread = second + first * first
        share = within / total
        outer_first = -inside * first / (1.0 - inside)
        outer_spread = (1.0 - inside * spread) / (1.0 - inside)
        mean_u = share * first + (1.0 - share) * outer_first
        var_u = max(1e-6, share * spread + (1.0 - share) * outer_spread - mean_u * mean_u)
        absorb(work_mean, work_cov, STATE + 1, STATE, mean_u * sd, var_u * variance)
        copy_state(work_mean, work_cov, mean, cov)
    return math.log(total)


@kernel
def unseen_paths(w, mu, cv, me, face, half, turned, p, to_w, to_mu, to_cv, work_mean, work_cov, slopes):
    """Paths of a track that was not seen, into another room; the log probability."""
    best = -np.inf
    for k in range(PATHS):
        to_w[k] = -np.inf
        if w[k] > 0.0:
            copy_state(mu[k], cv[k], to_mu[k], to_cv[k])
            to_w[k] = math.log(w[k]) + unseen(to_mu[k], to_cv[k], me, face, half, p[SEEN], p[NEAR], turned, work_mean, work_cov, slopes)
            best = max(best, to_w[k])
    return weights_of(to_w, best)


@kernel
def add_paths(share, w, mu, cv, sums, means, spreads):
    """Add paths of weight `share` to sums by mode: weights, weighted means, weighted second moments around the place that each began with.

    sums : (MODES,); means : (2, MODES, STATE), row 1 the place that all is told from; spreads : (MODES, STATE, STATE)
    """
    for k in range(PATHS):
        weight = share * w[k]
        if weight <= LIGHTEST:
            continue
        m = k % MODES
        if sums[m] == 0.0:
            for i in range(STATE):
                means[1, m, i] = mu[k, i]
        sums[m] += weight
        for i in range(STATE):
            off = mu[k, i] - means[1, m, i]
            means[0, m, i] += weight * off
            for j in range(i + 1):
                spreads[m, i, j] += weight * (cv[k, i, j] + off * (mu[k, j] - means[1, m, j]))


@kernel
def clear(sums, means, spreads):
    """Sums of nothing."""
    for m in range(MODES):
        sums[m] = 0.0
        for i in range(STATE):
            means[0, m, i] = 0.0
            for j in range(STATE):
                spreads[m, i, j] = 0.0


@kernel
def settle(sums, means, spreads, w, mu, cv):
    """A track from its sums: one normal for each mode with the first two moments."""
    total = 0.0
    for m in range(MODES):
        total += sums[m]
    for m in range(MODES):
        w[m] = sums[m] / total
        if sums[m] <= 0.0:
            continue
        for i in range(STATE):
            means[0, m, i] /= sums[m]
            mu[m, i] = means[1, m, i] + means[0, m, i]
        for i in range(STATE):
            for j in range(i + 1):
                cv[m, i, j] = spreads[m, i, j] / sums[m] - means[0, m, i] * means[0, m, j]
                cv[m, j, i] = cv[m, i, j]


@kernel
def volumes(share, w, cv, lower):
    """Weighted log volumes of paths, by which merging is judged (Runnalls 2007)."""
    total = 0.0
    for k in range(PATHS):
        if share * w[k] > 0.0:
            total += share * w[k] * log_volume(cv[k], STATE, lower)
    return total


@kernel
def begin_track(me, cos, sin, told, count, far, shares, p, w, mu, cv, work_mean, work_cov, slopes):
    """A track from one reading alone."""
    along = (told[FAR, HIGH] - told[FAR, LOW]) ** 2 / 12.0 + told[FAR, VARIANCE]
    aside = (told[ASIDE, HIGH] - told[ASIDE, LOW]) ** 2 / 12.0 + told[ASIDE, VARIANCE]
    for m in range(MODES):
        w[m] = shares[m]
        for i in range(STATE):
            mu[m, i] = 0.0
            for j in range(STATE):
                cv[m, i, j] = 0.0
        mu[m, 0], mu[m, 1] = me[0] + far * cos, me[1] + far * sin
        cv[m, 0, 0] = along * cos * cos + aside * sin * sin
        cv[m, 1, 1] = along * sin * sin + aside * cos * cos
        cv[m, 0, 1] = (along - aside) * cos * sin
        cv[m, 1, 0] = cv[m, 0, 1]
        cv[m, 2, 2] = cv[m, 3, 3] = p[SPEED] ** 2
        if count == 4:
            condition(mu[m], cv[m], me, cos, sin, told, 2, 4, work_mean, work_cov, slopes)


@kernel
def place_of(w, mu, cv, out):
    """Mean and covariance of a place of which there are several normals, as one: x, y, xx, xy, yy into `out`."""
    for i in range(5):
        out[i] = 0.0
    for m in range(len(w)):
        if w[m] > 0.0:
            out[0] += w[m] * mu[m, 0]
            out[1] += w[m] * mu[m, 1]
    for m in range(len(w)):
        if w[m] > 0.0:
            dx, dy = mu[m, 0] - out[0], mu[m, 1] - out[1]
            out[2] += w[m] * (cv[m, 0, 0] + dx * dx)
            out[3] += w[m] * (cv[m, 0, 1] + dx * dy)
            out[4] += w[m] * (cv[m, 1, 1] + dy * dy)
