"""Intervals of probabilities from counts, with their guarantee."""

from __future__ import annotations

from collections.abc import Mapping

from scipy.stats import beta, norm

from ....errors import ModelError
from ..bounds import Bounds


def _check(successes: int, trials: int, confidence: float) -> None:
    if not 0 <= successes <= trials:
        raise ModelError(f"successes {successes} of trials {trials}: needs 0 <= successes <= trials")
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")


def clopper_pearson(successes: int, trials: int, confidence: float = 0.95) -> Bounds:
    """Clopper-Pearson interval: holds with at least the given confidence whatever the probability is.

    (The text's formula is Wilson's, which falls to 0.838 at nominal 0.95; specification/analysis.md 4.)

    Parameters
    ----------
    successes, trials : int
    confidence : float

    Raises
    ------
    ModelError

    Examples
    --------
    >>> print(clopper_pearson(0, 1000))
    [0, 0.00368208]

    References
    ----------
    C. J. Clopper, E. S. Pearson (1934), Biometrika 26:404-413.
    """
    _check(successes, trials, confidence)
    tail = (1.0 - confidence) / 2.0
    low = 0.0 if successes == 0 else float(beta.ppf(tail, successes, trials - successes + 1))
    high = 1.0 if successes == trials else float(beta.isf(tail, successes + 1, trials - successes))
    return Bounds(low, high)


def upper_limit(successes: int, trials: int, confidence: float = 0.95) -> float:
    """The most that a probability can be, one-sided (Clopper-Pearson): for failures.

    Examples
    --------
    >>> round(upper_limit(0, 1000), 5)
    0.00299
    """
    _check(successes, trials, confidence)
    return 1.0 if successes == trials else float(beta.isf(1.0 - confidence, successes + 1, trials - successes))


def lower_limit(successes: int, trials: int, confidence: float = 0.95) -> float:
    """The least that a probability can be, one-sided (Clopper-Pearson)."""
    _check(successes, trials, confidence)
    return 0.0 if successes == 0 else float(beta.ppf(1.0 - confidence, successes, trials - successes + 1))


def simultaneous(counts: Mapping[str, int], confidence: float = 0.95) -> dict[str, Bounds]:
    """Clopper-Pearson intervals of several outcomes that hold all at once (Bonferroni).

    Parameters
    ----------
    counts : mapping of str to int
        Outcome -> how often; the trials are their sum.
    confidence : float
        Of all together.

    Raises
    ------
    ModelError
    """
    if not counts:
        raise ModelError("counts: needs at least one outcome")
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")
    total = sum(counts.values())
    each = 1.0 - (1.0 - confidence) / len(counts)
    return {name: clopper_pearson(count, total, each) for name, count in counts.items()}


def wilson(successes: int, trials: int, confidence: float = 0.95) -> Bounds:
    """Wilson's score interval, the text's formula: for comparison, no guarantee.

    References
    ----------
    E. B. Wilson (1927), JASA 22:209-212; dissertation §3.3.
    """
    _check(successes, trials, confidence)
    if trials == 0:
        return Bounds(0.0, 1.0)
    z = float(norm.ppf(0.5 + confidence / 2.0))
    rate = successes / trials
    centre = (rate + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * (rate * (1 - rate) / trials + z * z / (4 * trials * trials)) ** 0.5
    return Bounds(0.0 if successes == 0 else max(0.0, centre - half), 1.0 if successes == trials else min(1.0, centre + half))
