"""Readings that are straight lines of a state: what the engine ``"mixture"`` does with them."""

from __future__ import annotations

import math

from .....architecture.prm.inference.continuous.kernels.normals import condition_interval, condition_point
from . import kernel

PI = math.pi


@kernel
def turned_back(angle):
    """An angle in (-pi, pi]."""
    return angle - 2.0 * PI * math.ceil((angle - PI) / (2.0 * PI))


@kernel
def read(mean, cov, n, slopes, centre, variance, low, high):
    """Condition the first n columns on ``low <= centre + slopes * columns + noise <= high``; gives its log likelihood."""
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += slopes[i] * cov[i, j]
        cov[n, j] = total
        cov[j, n] = total
    total, middle = variance, centre
    for i in range(n):
        total += slopes[i] * cov[n, i]
        middle += slopes[i] * mean[i]
    cov[n, n], mean[n] = max(total, 0.0), middle
    if low == high:
        return condition_point(mean, cov, n + 1, n, low, 0.0)
    return condition_interval(mean, cov, n + 1, n, low, high, 0.0)
