"""Paired comparisons in the same worlds, corrected for how many there are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest, norm, ttest_1samp

LEVEL = 0.05
"""Probability of any false "better" in a family of comparisons."""


@dataclass(frozen=True)
class Comparison:
    """What one player has over another in the same worlds.

    Attributes
    ----------
    task, condition : str
    first, second : str
        Players.
    metric : str
        ``success`` (a rate), ``cycles`` or ``goals``.
    n : int
        Pairs.
    difference : float
        Of the means, first less second.
    low, high : float
        Its interval, at the level that Holm's procedure gives the comparison in its family.
    p : float
        Corrected by Holm: exact McNemar test of rates, t test of means.
    effect : float
        Cohen's h of two rates, or the mean of the differences in their standard deviations.
    better : str
        The better of the two where the corrected interval excludes zero and the corrected p is below `LEVEL`; empty otherwise.
    """

    task: str
    condition: str
    first: str
    second: str
    metric: str
    n: int
    difference: float
    low: float
    high: float
    p: float
    effect: float
    better: str = ""


@dataclass(frozen=True)
class Pair:
    """Two rows of numbers of the same worlds, to be compared."""

    task: str
    condition: str
    first: str
    second: str
    metric: str
    ones: np.ndarray
    others: np.ndarray
    more_is_better: bool = True


def compare(pairs: Sequence[Pair]) -> list[Comparison]:
    """All pairs of one family, in the order given.

    Parameters
    ----------
    pairs : sequence of Pair
        Of (n,) arrays of one length, n at least 1.

    Raises
    ------
    ValueError
        For rows that are not as long as each other.

    References
    ----------
    S. Holm (1979), Scandinavian Journal of Statistics 6:65-70. D. G. Bonett, R. M. Price (2012), British Journal of Mathematical and
    Statistical Psychology 65:430-452 (the interval of rates).
    """
    for pair in pairs:
        if pair.ones.shape != pair.others.shape or pair.ones.ndim != 1 or not len(pair.ones):
            raise ValueError(f"pairs of shapes {pair.ones.shape} and {pair.others.shape}: needs two of one length, at least 1")
    found = [_plain(pair) for pair in pairs]
    order = sorted(range(len(pairs)), key=lambda i: found[i].p)
    worst, still = 0.0, True
    for rank, i in enumerate(order):
        level = LEVEL / (len(pairs) - rank)
        worst = max(worst, min(1.0, (len(pairs) - rank) * found[i].p))
        difference, low, high = interval(pairs[i], level)
        still = still and worst < LEVEL and (low > 0 or high < 0)
        ahead = (difference > 0) == pairs[i].more_is_better
        better = (pairs[i].first if ahead else pairs[i].second) if still else ""
        found[i] = replace(found[i], low=low, high=high, p=worst, better=better)
    return found


def _plain(pair: Pair) -> Comparison:
    a, b = pair.ones.astype(float), pair.others.astype(float)
    differences = a - b
    if pair.metric == "success":
        won, lost = int((differences > 0).sum()), int((differences < 0).sum())
        p = 1.0 if won + lost == 0 else float(binomtest(won, won + lost).pvalue)
        effect = float(2 * np.arcsin(np.sqrt(a.mean())) - 2 * np.arcsin(np.sqrt(b.mean())))
    else:
        spread = float(differences.std(ddof=1)) if len(differences) > 1 else 0.0
        p = float(ttest_1samp(differences, 0.0).pvalue) if spread > 0 else 1.0
        effect = float(differences.mean()) / spread if spread > 0 else 0.0
    return Comparison(pair.task, pair.condition, pair.first, pair.second, pair.metric, len(a), float(differences.mean()), 0, 0, p, effect)


def interval(pair: Pair, level: float) -> tuple[float, float, float]:
    """The difference of the means and its interval: of rates after Bonett and Price, else normal."""
    differences = pair.ones.astype(float) - pair.others.astype(float)
    n, z = len(differences), float(norm.ppf(1 - level / 2))
    mean = float(differences.mean())
    if pair.metric != "success":
        half = z * (float(differences.std(ddof=1)) if n > 1 else 0.0) / n**0.5
        return mean, mean - half, mean + half
    won, lost = ((differences > 0).sum() + 1) / (n + 2), ((differences < 0).sum() + 1) / (n + 2)
    half = z * float(np.sqrt((won + lost - (won - lost) ** 2) / (n + 2)))
    middle = float(won - lost)
    return mean, max(-1.0, min(middle - half, mean)), min(1.0, max(middle + half, mean))
