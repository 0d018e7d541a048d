"""The few statistics a benchmark needs."""

from __future__ import annotations

from typing import NamedTuple

from scipy.stats import norm


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
