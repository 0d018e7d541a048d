"""Intervals of a mean: of returns, lengths, any number that runs have.

Within a stated range they hold with at least their confidence whatever the distribution is: one bets against each mean in turn, and a mean
stays in the interval while no bet against it has won too much (Ville). Without a range nothing can be guaranteed, one far run may be yet to
come; then Student's interval and its any-time counterpart hold approximately, the better the more runs there are.

==================  ===============================================  =========================================
                    a number of runs fixed beforehand                at every moment at once
==================  ===============================================  =========================================
range stated        `mean_interval`: bets follow the variance        `mean_sequence`: a mixture of bets
no range            `mean_interval`: Student's t (approximately)     `mean_sequence` (approximately)
==================  ===============================================  =========================================

References
----------
I. Waudby-Smith, A. Ramdas (2024), Estimating means of bounded random variables by betting, JRSS B 86:1-27. I. Waudby-Smith, D. Arbour,
R. Sinha, E. H. Kennedy, A. Ramdas (2024), Time-uniform central limit theory and asymptotic confidence sequences, Ann. Statist. 52.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.stats import t as student

from ....errors import ModelError
from ..bounds import Bounds

SHARES = np.append(np.geomspace(1e-4, 0.5, 24), (0.7, 0.85, 0.95, 0.999))
"""Shares of what may be lost that are bet at once."""
BOLDEST = 0.75
"""Most that is bet of what may be lost where bets follow the variance."""
VALUES = 20_000
"""Different values from which on they are rounded outward to a grid before betting."""
TUNED_FOR = 500
"""Number of runs at which the any-time interval without a range is narrowest."""
Range = tuple[float, float]
"""Least and largest value that there can be."""


def mean_interval(values: ArrayLike, confidence: float = 0.95, within: Range | None = None) -> Bounds:
    """Interval of a mean from independent values whose number was fixed beforehand.

    Parameters
    ----------
    values : (n,) array_like
        In the order in which they came.
    confidence : float
    within : (low, high), optional
        Range of the values: then it holds for certain with this confidence, and never reaches outside.

    Returns
    -------
    Bounds
        Everything (the range, or infinite) where there are too few values.

    Raises
    ------
    ModelError
        For a value outside of the range, or none that is finite.

    Examples
    --------
    >>> print(mean_interval([0.0, 1.0] * 200, within=(0, 1)))
    [0.432838, 0.568047]
    >>> print(mean_interval([0.0, 1.0] * 200))
    [0.45079, 0.54921]
    """
    x = checked(values, confidence, within)
    if within is None:
        if len(x) < 2:
            return Bounds(-math.inf, math.inf)
        half = float(student.ppf(0.5 + confidence / 2, len(x) - 1)) * float(x.std(ddof=1)) / len(x) ** 0.5
        return Bounds(float(x.mean()) - half, float(x.mean()) + half)
    low, span = _scale(within)
    if not len(x) or span == 0.0:
        return Bounds(*within)
    y = np.clip((x - low) / span, 0.0, 1.0)
    goal = math.log(2.0 / (1.0 - confidence))
    ends = (_least(_follow(y, goal), goal, float(y.mean())), _least(_follow(1.0 - y, goal), goal, 1.0 - float(y.mean())))
    return _outward(low, span, ends, x)


def mean_sequence(values: ArrayLike, confidence: float = 0.95, within: Range | None = None) -> Bounds:
    """Interval of a mean that holds at every moment at once: one may look after each value, and stop when one likes.

    Parameters
    ----------
    values, confidence, within
        As of `mean_interval`; without a range it holds approximately.

    Raises
    ------
    ModelError

    Examples
    --------
    >>> print(mean_sequence([0.0, 1.0] * 200, within=(0, 1)))
    [0.41233, 0.58767]
    """
    x = checked(values, confidence, within)
    n = len(x)
    if within is None:
        if n < 2:
            return Bounds(-math.inf, math.inf)
        alpha = 1.0 - confidence
        tuned = (-2 * math.log(alpha) + math.log(-2 * math.log(alpha) + 1)) / TUNED_FOR  # rho squared
        grown = n * tuned + 1.0
        half = float(x.std(ddof=1)) * math.sqrt(2 * grown / (n * n * tuned) * math.log(math.sqrt(grown) / alpha))
        return Bounds(float(x.mean()) - half, float(x.mean()) + half)
    low, span = _scale(within)
    if not n or span == 0.0:
        return Bounds(*within)
    y = np.clip((x - low) / span, 0.0, 1.0)
    goal = math.log(2.0 / (1.0 - confidence))
    return _outward(low, span, (_least(_mixture(y), goal, float(y.mean())), _least(_mixture(1.0 - y), goal, 1.0 - float(y.mean()))), x)


def checked(values: ArrayLike, confidence: float, within: Range | None) -> NDArray[np.float64]:
    """The values, where they and the range make sense.

    Raises
    ------
    ModelError
    """
    x = np.asarray(values, np.float64).ravel()
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")
    if not np.isfinite(x).all():
        k = int(np.flatnonzero(~np.isfinite(x))[0])
        raise ModelError(f"mean: value {k} is {x[k]}; it has to be finite")
    if within is not None:
        low, high = within
        if not (math.isfinite(low) and math.isfinite(high) and low <= high):
            raise ModelError(f"mean: the range {within} needs two finite numbers that do not fall")
        out = np.flatnonzero((x < low) | (x > high))
        if out.size:
            raise ModelError(f"mean: value {int(out[0])} is {x[out[0]]:g}, outside of the stated range from {low:g} to {high:g}")
    return x


def _scale(within: Range) -> tuple[float, float]:
    return float(within[0]), float(within[1]) - float(within[0])


def _outward(low: float, span: float, ends: tuple[float, float], x: NDArray[np.float64]) -> Bounds:
    """From shares of the range, with the mean inside whatever rounding does."""
    mean = float(x.mean())
    return Bounds(min(low + span * ends[0], mean), max(low + span * (1.0 - ends[1]), mean))


Wealth = Callable[[float], float]
"""Logarithm of what was won by betting that the mean is greater than the given one; it falls with the given one."""


def _least(wealth: Wealth, goal: float, mean: float) -> float:
    """The least mean against which not too much was won, a little outward."""
    near = mean * 1e-9
    if mean <= 0.0 or wealth(near) <= goal or wealth(mean) >= goal:
        return 0.0
    root = float(brentq(lambda m: wealth(m) - goal, near, mean, xtol=1e-10, rtol=1e-10))
    return max(0.0, root - 1e-9)


def _follow(y: NDArray[np.float64], goal: float) -> Wealth:
    """Bets that follow mean and variance of what came before, sized for as many values as there are."""
    n = len(y)
    before = np.arange(n)
    sums, squares = np.concatenate(([0.0], np.cumsum(y)[:-1])), np.concatenate(([0.0], np.cumsum(y * y)[:-1]))
    mean = (0.5 + sums) / (before + 1)
    variance = (0.25 + squares - 2 * mean * sums + before * mean * mean) / (before + 1)
    bets = np.sqrt(2 * goal / (n * np.maximum(variance, 1e-12)))

    def wealth(m: float) -> float:
        return float(np.log1p(np.minimum(bets, BOLDEST / m) * (y - m)).sum())

    return wealth


def _mixture(y: NDArray[np.float64]) -> Wealth:
    """Fixed shares of what may be lost, bet side by side: the order of the values does not matter."""
    value, count = np.unique(y, return_counts=True)
    if len(value) > VALUES:
        value, count = np.unique(np.floor(y * VALUES) / VALUES, return_counts=True)  # less is won

    def wealth(m: float) -> float:
        won = np.log1p(SHARES[:, None] * (value / m - 1.0)) @ count
        top = float(won.max())
        return top + math.log(float(np.exp(won - top).mean()))

    return wealth
