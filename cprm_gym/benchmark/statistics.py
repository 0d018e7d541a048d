"""The few statistics a benchmark needs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, norm


class Interval(NamedTuple):
    """A confidence interval of a rate."""

    low: float
    high: float


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> Interval:
    """Wilson score interval of a binomial rate.

    Parameters
    ----------
    successes, trials : int
        0 <= successes <= trials.
    confidence : float
        Between 0 and 1, exclusive.

    Returns
    -------
    Interval
        (0, 1) when there are no trials.

    Raises
    ------
    ValueError
        When the numbers do not make sense; the message names them.

    References
    ----------
    E. B. Wilson (1927), JASA 22:209-212; dissertation 3.3.

    Examples
    --------
    >>> low, high = wilson_interval(95, 100)
    >>> round(low, 4), round(high, 4)
    (0.8882, 0.9785)
    """
    if not 0 <= successes <= trials:
        raise ValueError(f"successes {successes} and trials {trials}: needs 0 <= successes <= trials")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence {confidence}: needs a number between 0 and 1")
    if trials == 0:
        return Interval(0.0, 1.0)
    z = float(norm.ppf(0.5 + confidence / 2.0))
    rate = successes / trials
    centre = (rate + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * (rate * (1 - rate) / trials + z * z / (4 * trials * trials)) ** 0.5
    low = 0.0 if successes == 0 else max(0.0, centre - half)
    high = 1.0 if successes == trials else min(1.0, centre + half)
    return Interval(low, high)


class Difference(NamedTuple):
    """A paired difference of two rates."""

    mean: float
    low: float
    high: float
    """Normal interval of 95 %."""
    p: float
    """Of the exact McNemar test that there is none."""


def paired_difference(first: np.ndarray, second: np.ndarray) -> Difference:
    """The rate of `first` less that of `second`, episode by episode in the same worlds.

    Parameters
    ----------
    first, second : (n,) bool arrays

    Raises
    ------
    ValueError
        When they are not as long as each other, or empty.

    References
    ----------
    Q. McNemar (1947), Psychometrika 12:153-157.

    Examples
    --------
    >>> d = paired_difference(np.array([True] * 6 + [False] * 4), np.array([False] * 5 + [True] + [False] * 4))
    >>> round(d.mean, 3), round(d.p, 4)
    (0.5, 0.0625)
    """
    first, second = np.asarray(first, bool), np.asarray(second, bool)
    if first.shape != second.shape or first.ndim != 1 or not len(first):
        raise ValueError(f"pairs of shapes {first.shape} and {second.shape}: needs two of one length, at least 1")
    difference = first.astype(float) - second
    mean = float(difference.mean())
    half = float(norm.ppf(0.975)) * float(difference.std()) / len(difference) ** 0.5
    won, lost = int((difference > 0).sum()), int((difference < 0).sum())
    p = 1.0 if won + lost == 0 else float(binomtest(won, won + lost).pvalue)
    return Difference(mean, max(-1.0, mean - half), min(1.0, mean + half), p)
