"""In what steps the eye tells, and what a told distance says."""

from __future__ import annotations

import math

import numpy as np

from . import kernel

RATE_STEP, SWING_STEP, ROUNDING = 0.02, 0.1, 0.1
"""Steps of the eye: of a change as a share of the distance, of a change of direction (degrees), of a distance (m)."""


@kernel
def told_between(told, step, factor):
    """Between what distances (m) one lies whom the eye tells at `told`: the ends of the bands that it tells so.

    A band is a `step` of the logarithm, told in whole decimetres; by a `factor` above 1 those are put together once more. The bands of one
    told distance do not lie evenly around it. (0, 0) for a distance that no band is told at.

    References
    ----------
    specification/simulator.md 6.1.4.
    """
    coarse, which = factor * step, 0.0
    if factor > 1.0:
        which = round(math.log(told) / coarse)
        if abs(math.exp(which * coarse) - told) > 1e-3 * told:
            return 0.0, 0.0
        first, last = math.floor((which - 0.5) * factor) - 2.0, math.ceil((which + 0.5) * factor) + 2.0
    else:
        first, last = math.floor(math.log(max(told - ROUNDING, 0.01)) / step), math.ceil(math.log(told + ROUNDING) / step)
    low, high = np.inf, 0.0
    band = first
    while band <= last:
        distance = ROUNDING * np.rint(math.exp(band * step) / ROUNDING)
        if distance > 0.0:
            same = round(math.log(distance) / coarse) == which if factor > 1.0 else abs(distance - told) < 0.1 * ROUNDING
            if same:
                low, high = min(low, math.exp((band - 0.5) * step)), max(high, math.exp((band + 0.5) * step))
        band += 1.0
    if high > low:
        return low, high
    return 0.0, 0.0


@kernel
def all_told_between(told, step, factor, low, high):
    """`told_between` of many, into `low` and `high`; NaN of NaN, and what stands there already where no band is told so."""
    for n in range(len(told)):
        if told[n] > 0.0:
            least, most = told_between(told[n], step, factor)
            if most > least:
                low[n], high[n] = least, most
