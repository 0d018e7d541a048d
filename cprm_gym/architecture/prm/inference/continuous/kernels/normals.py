"""One component: a normal over columns of numbers, conditioned on what was read. Covariances are changed in place, the first n columns."""

from __future__ import annotations

import math

import numpy as np

from ......compilation import kernel_group

kernel = kernel_group(_nrt=False)

LOG_TWO_PI = math.log(2.0 * math.pi)
ROOT_HALF = math.sqrt(0.5)
ROOT_TWO_PI = math.sqrt(2.0 * math.pi)
CERTAIN = 1e-22
"""Variance, as a share of the squared value or of 1, below which a number counts as known."""
SAME = 1e-9
"""How far a reading of a known number may be off, as a share of the value or of 1."""
NARROW = 0.02
"""Width in deviations below which an interval's moments are taken from their series."""
FAR = 30.0
"""Deviations beyond which the tail is taken from its expansion."""
TINY = 1e-12
"""Pivot, as a share of its variance, below which a column adds nothing to those before it."""


@kernel
def wrapped(x, period):
    """`x` brought into the half-open turn around 0; as it is on the line (period 0)."""
    if period == 0.0:
        return x
    return x - period * math.floor(x / period + 0.5)


@kernel
def absorb(mean, cov, n, c, shift, variance):
    """Move the mean of column c by `shift`, give it this variance, and the other columns what follows from that."""
    old = cov[c, c]
    ratio = (variance - old) / (old * old)
    for i in range(n):
        if i != c:
            mean[i] += cov[i, c] * (shift / old)
    mean[c] += shift
    for i in range(n):
        if i == c:
            continue
        gain = cov[i, c] * ratio
        if gain == 0.0:
            continue
        for j in range(i + 1):
            if j != c:
                cov[i, j] += gain * cov[j, c]
                cov[j, i] = cov[i, j]
        if cov[i, i] < 0.0:
            cov[i, i] = 0.0
    for i in range(n):
        if i != c:
            cov[i, c] *= variance / old
            cov[c, i] = cov[i, c]
    cov[c, c] = variance


@kernel
def known(value, variance):
    """Whether a number is known but for rounding."""
    return variance <= CERTAIN * max(1.0, value * value)


@kernel
def condition_point(mean, cov, n, c, value, period):
    """Log density of a reading of column c, on which the component is conditioned; of a known number 0 or minus infinity."""
    away = wrapped(value - mean[c], period)
    variance = cov[c, c]
    if known(mean[c], variance):
        return 0.0 if abs(away) <= SAME * max(1.0, abs(mean[c])) else -np.inf
    density = -0.5 * (away * away / variance + math.log(variance) + LOG_TWO_PI)
    absorb(mean, cov, n, c, away, 0.0)
    return density


@kernel
def truncated(a, b):
    """Log probability, mean and variance of a standard normal between `a` and `b`."""
    mirrored = a < 0.0 and b < 0.0
    low, high = (-b, -a) if mirrored else (a, b)
    middle, width = 0.5 * (low + high), high - low
    if width < NARROW and abs(middle) * width < 0.1:
        log_z = math.log(width) - 0.5 * (middle * middle + LOG_TWO_PI) + math.log1p((middle * middle - 1.0) * width * width / 24.0)
        mean, variance = middle - middle * width * width / 12.0, width * width / 12.0
    elif low > FAR:
        log_z = -0.5 * (low * low + LOG_TWO_PI) - math.log(low)
        share = 0.0 if high == np.inf else math.exp(-low * (high - low))
        log_z += math.log1p(-share)
        mean = low + 1.0 / low - (0.0 if share == 0.0 else (high - low) * share / (1.0 - share))
        variance = 1.0 / (low * low)
        if share > 0.0:
            variance = max(variance - (high - low) ** 2 * share / (1.0 - share) ** 2, 1e-3 * (high - low) ** 2)
    else:
        if low >= 0.0:
            z = 0.5 * (math.erfc(low * ROOT_HALF) - (0.0 if high == np.inf else math.erfc(high * ROOT_HALF)))
        else:
            z = 1.0 - 0.5 * math.erfc(-low * ROOT_HALF) if low > -np.inf else 1.0
            z -= 0.5 * math.erfc(high * ROOT_HALF) if high < np.inf else 0.0
        at_low = math.exp(-0.5 * low * low) / ROOT_TWO_PI if low > -np.inf else 0.0
        at_high = math.exp(-0.5 * high * high) / ROOT_TWO_PI if high < np.inf else 0.0
        log_z = math.log(z)
        mean = (at_low - at_high) / z
        variance = 1.0 - mean * mean
        if low > -np.inf:
            variance += low * at_low / z
        if high < np.inf:
            variance -= high * at_high / z
        variance = max(variance, 1e-6)
    return log_z, -mean if mirrored else mean, variance


@kernel
def condition_interval(mean, cov, n, c, low, high, period):
    """Log probability of an interval of column c, on which the component is conditioned (first two moments)."""
    if period > 0.0:
        middle = mean[c] + wrapped(0.5 * (low + high) - mean[c], period)
        half = 0.5 * (high - low)
        low, high = middle - half, middle + half
    variance = cov[c, c]
    if known(mean[c], variance):
        room = SAME * max(1.0, abs(mean[c]))
        return 0.0 if low - room <= mean[c] <= high + room else -np.inf
    sd = math.sqrt(variance)
    log_z, shift, rest = truncated((low - mean[c]) / sd, (high - mean[c]) / sd)
    absorb(mean, cov, n, c, shift * sd, rest * variance)
    return log_z


@kernel
def factor(cov, columns, d, lower):
    """Cholesky factor of the covariance of `columns`, into `lower`; zeros below a pivot that adds nothing."""
    for i in range(d):
        for j in range(i + 1, d):
            lower[i, j] = 0.0
        for j in range(i + 1):
            total = cov[columns[i], columns[j]]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                lower[i, i] = math.sqrt(total) if total > TINY * cov[columns[i], columns[i]] and total > 0.0 else 0.0
            else:
                lower[i, j] = total / lower[j, j] if lower[j, j] > 0.0 else 0.0


@kernel
def backward(lower, d, x):
    """Solve ``lower.T @ a = x`` in place, zero where the factor is."""
    for i in range(d - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, d):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0


@kernel
def forward(lower, d, x):
    """Solve ``lower @ a = x`` in place, zero where the factor is."""
    for i in range(d):
        total = x[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i] if lower[i, i] > 0.0 else 0.0
