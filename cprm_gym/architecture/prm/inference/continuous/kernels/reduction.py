"""Fewer components: the lightest left out, the likest merged, or some drawn; and what that loses."""

from __future__ import annotations

import math

import numpy as np

from ......compilation import kernel_group
from .normals import wrapped

kernel = kernel_group(_nrt=False)

FLOOR = 1e-13
"""Least pivot of a covariance, as a share of its variance: numbers that are known take part in no comparison of volumes."""


@kernel
def log_volume(cov, d, lower):
    """Log determinant of the first d columns."""
    return log_volume_between(cov, cov, 0.0, lower[d], d, lower)


@kernel
def log_volume_between(ci, cj, share, away, d, lower):
    """Log determinant of two covariances as one, `share` of the second, whose mean is `away`: by pivots, without roots (LDL').

    lower : (d + 1, d) scratch: pivot times factor below the diagonal, the factor above it; the last row may be `away`
    """
    total, product, both = 0.0, 1.0, share * (1.0 - share)
    for a in range(d):
        for b in range(a):
            rest = ci[a, b]
            if share > 0.0:
                rest += share * (cj[a, b] - ci[a, b]) + both * away[a] * away[b]
            for k in range(b):
                rest -= lower[a, k] * lower[k, b]
            lower[a, b] = rest
        whole = ci[a, a]
        if share > 0.0:
            whole += share * (cj[a, a] - ci[a, a]) + both * away[a] * away[a]
        pivot = whole
        for k in range(a):
            lower[k, a] = lower[a, k] / lower[k, k]
            pivot -= lower[a, k] * lower[k, a]
        pivot = max(pivot, FLOOR * whole + 1e-24)
        lower[a, a] = pivot
        product *= pivot
        if a % 8 == 7:  # before it leaves the range of numbers
            total, product = total + math.log(product), 1.0
    return total + math.log(product)


@kernel
def merged(wi, wj, mi, mj, ci, cj, d, periods, mean, cov):
    """First two moments of two components, into `mean` and `cov`."""
    share = wj / (wi + wj)
    for a in range(d):
        mean[a] = wrapped(mj[a] - mi[a], periods[a])
    for a in range(d):
        for b in range(d):
            cov[a, b] = (1.0 - share) * ci[a, b] + share * cj[a, b] + share * (1.0 - share) * mean[a] * mean[b]
    for a in range(d):
        mean[a] = wrapped(mi[a] + share * mean[a], periods[a])


@kernel
def alike(states, i, j):
    """Whether two components are of one mode."""
    for a in range(states.shape[1]):
        if states[i, a] != states[j, a]:
            return False
    return True


@kernel
def merge_cost(w, mu, cv, volume, i, j, d, periods, lower):
    """What merging two components loses at most: Runnalls' bound of the Kullback-Leibler divergence."""
    away = lower[d]
    for a in range(d):
        away[a] = wrapped(mu[j, a] - mu[i, a], periods[a])
    both = log_volume_between(cv[i], cv[j], w[j] / (w[i] + w[j]), away, d, lower)
    return max(0.0, 0.5 * ((w[i] + w[j]) * both - w[i] * volume[i] - w[j] * volume[j]))


@kernel
def heaviest_first(w, count, order):
    """Numbers of the components by falling weight, into `order` (heap sort: ties stand as they come)."""
    for k in range(count):
        order[k] = k
    for k in range(1, count):  # by insertion: they are few, or nearly in order
        x = order[k]
        i = k - 1
        while i >= 0 and w[order[i]] < w[x]:
            order[i + 1] = order[i]
            i -= 1
        order[i + 1] = x


@kernel
def merge_down(w, st, mu, cv, count, limit, threshold, periods, cost, volume, mean, cov, lower):
    """Merge components of one mode, the likest pair first, while they are too many or merging loses less than `threshold`.

    Gives how many are left and the loss. Those that go have weight 0 until the end, then the others close up.
    """
    d, loss, left = len(periods), 0.0, count
    for i in range(count):
        volume[i] = log_volume(cv[i], d, lower)
        for j in range(i):
            cost[i, j] = merge_cost(w, mu, cv, volume, i, j, d, periods, lower) if alike(st, i, j) else np.inf
    while left > 1:
        best, a, b = np.inf, -1, -1
        for i in range(count):
            if w[i] <= 0.0:
                continue
            for j in range(i):
                if w[j] > 0.0 and cost[i, j] < best:
                    best, a, b = cost[i, j], i, j
        if a < 0 or (left <= limit and best >= threshold):
            break
        merged(w[b], w[a], mu[b], mu[a], cv[b], cv[a], d, periods, mean, cov)
        for i in range(d):
            mu[b, i] = mean[i]
            for j in range(d):
                cv[b, i, j] = cov[i, j]
        w[b] += w[a]
        w[a] = 0.0
        loss += best
        left -= 1
        volume[b] = log_volume(cv[b], d, lower)
        for i in range(count):
            if w[i] > 0.0 and i != b:
                i1, j1 = (i, b) if i > b else (b, i)
                cost[i1, j1] = merge_cost(w, mu, cv, volume, i1, j1, d, periods, lower) if alike(st, i1, j1) else np.inf
    return left, loss


@kernel
def resample(w, count, limit, uniform):
    """Draw which components stay, in place: those that weigh more than a share stay as they are, the others by systematic resampling.

    The optimal resampling of Fearnhead and Clifford (2003): unbiased, and no two components are the same.
    """
    if count <= limit:
        return
    kept = 0
    rest = 1.0
    while True:  # the weight from which on all stay
        share = rest / (limit - kept)
        more, mass = 0, 0.0
        for k in range(count):
            if w[k] > share:
                more += 1
                mass += w[k]
        if more == kept:
            break
        kept, rest = more, max(1.0 - mass, 0.0)
        if kept >= limit:
            break
    share = rest / max(limit - kept, 1)
    at = uniform * share
    for k in range(count):
        if w[k] > share:
            continue
        at -= w[k]
        if at < 0.0:
            w[k] = share
            at += share
        else:
            w[k] = 0.0


@kernel
def renew(w, st, mu, cv, count, uniform, times):
    """Systematic resampling in place, where the weights are worth less than half of the components: those that go make room for copies."""
    squares = 0.0
    for k in range(count):
        squares += w[k] * w[k]
    if squares * count < 2.0:
        return
    total, drawn = 0.0, 0
    for k in range(count):
        total += w[k]
        times[k] = 0
        while drawn < count and (drawn + uniform) / count < total:
            times[k] += 1
            drawn += 1
    times[count - 1] += count - drawn  # what rounding left
    free = 0
    for k in range(count):
        for _ in range(times[k] - 1):
            while times[free] > 0:
                free += 1
            for a in range(st.shape[1]):
                st[free, a] = st[k, a]
            for a in range(mu.shape[1]):
                mu[free, a] = mu[k, a]
                for b in range(mu.shape[1]):
                    cv[free, a, b] = cv[k, a, b]
            free += 1
    for k in range(count):
        w[k] = 1.0 / count


@kernel
def keep_heaviest(w, count, limit, order):
    """Leave out all but the heaviest, in place; gives the weight that is gone."""
    if count <= limit:
        return 0.0
    heaviest_first(w, count, order)
    gone = 0.0
    for k in range(limit, count):
        gone += w[order[k]]
        w[order[k]] = 0.0
    return gone


@kernel
def close_up(w, st, mu, cv, count):
    """Move components of weight above 0 to the front and let them sum to 1; how many."""
    total, left = 0.0, 0
    for k in range(count):
        if w[k] > 0.0:
            total += w[k]
    for k in range(count):
        if w[k] <= 0.0:
            continue
        w[left] = w[k] / total
        if left != k:
            for a in range(st.shape[1]):
                st[left, a] = st[k, a]
            for a in range(mu.shape[1]):
                mu[left, a] = mu[k, a]
                for b in range(mu.shape[1]):
                    cv[left, a, b] = cv[k, a, b]
        left += 1
    return left
