"""Is it at least so likely? Wald's test looks at each run and stops as soon as it is decided."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from ....errors import ModelError


@dataclass
class ProbabilityRatioTest:
    """Sequential probability ratio test of ``p >= theta + margin`` against ``p <= theta - margin``.

    Between the two either answer may come.

    Parameters
    ----------
    theta, margin : float
        ``0 < theta - margin < theta + margin < 1``.
    alpha : float
        Probability of "below" although p >= theta + margin.
    beta : float
        Probability of "above" although p <= theta - margin.

    Attributes
    ----------
    successes, trials : int

    Raises
    ------
    ModelError

    Examples
    --------
    >>> test = ProbabilityRatioTest(0.9, 0.05)
    >>> while test.verdict == "undecided":
    ...     test.observe(True)
    >>> test.verdict, test.trials
    ('above', 27)

    References
    ----------
    A. Wald (1945), Ann. Math. Statist. 16:117-186.
    """

    theta: float
    margin: float
    alpha: float = 0.05
    beta: float = 0.05
    successes: int = field(default=0, init=False)
    trials: int = field(default=0, init=False)
    verdict: Literal["undecided", "above", "below"] = field(default="undecided", init=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.theta - self.margin < self.theta + self.margin < 1.0:
            raise ModelError(f"theta {self.theta} +- {self.margin}: needs 0 < theta - margin < theta + margin < 1")
        if not (0.0 < self.alpha < 0.5 and 0.0 < self.beta < 0.5):
            raise ModelError(f"alpha {self.alpha}, beta {self.beta}: need numbers between 0 and 0.5")

    @property
    def ratio(self) -> float:
        """Logarithm of how much likelier what was seen is with the smaller probability."""
        high, low = self.theta + self.margin, self.theta - self.margin
        return self.successes * math.log(low / high) + (self.trials - self.successes) * math.log((1.0 - low) / (1.0 - high))

    def observe(self, success: bool) -> None:
        """One more run; after a verdict nothing changes any more."""
        if self.verdict != "undecided":
            return
        self.trials += 1
        self.successes += bool(success)
        if self.ratio >= math.log((1.0 - self.beta) / self.alpha):
            self.verdict = "below"
        elif self.ratio <= math.log(self.beta / (1.0 - self.alpha)):
            self.verdict = "above"
