"""The posterior of a real number: a mixture of normals for each agent, and the numbers that are read from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from .....errors import ModelError

TURNS = 4
"""Turns of an angle either way over which its normals are summed."""
REACH = 9.0
"""Deviations beyond which a normal counts as nothing."""
BISECTIONS = 80
POINTS = 2001
"""Of the grid on which entropies and modes are found."""


@dataclass(frozen=True, eq=False)
class NormalMixture:
    """Mixtures of K normals, one for each agent.

    Attributes
    ----------
    weights, means, variances : (..., K) float arrays
        Weights sum to one; a variance of 0 is a value that is known.
    period : float
        Full turn of an angle, whose values are told from minus half of it to half of it; 0 for a number on the line.
    """

    weights: np.ndarray
    means: np.ndarray
    variances: np.ndarray
    period: float = 0.0

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the agents."""
        return self.weights.shape[:-1]

    def __getitem__(self, agents: Any) -> NormalMixture:
        """The mixtures of some agents."""
        return NormalMixture(self.weights[agents], self.means[agents], self.variances[agents], self.period)

    def turned(self, x: np.ndarray) -> np.ndarray:
        """Values brought into the turn around 0; as they are on the line."""
        if not self.period:
            return np.asarray(x)
        return np.asarray(np.mod(x + 0.5 * self.period, self.period) - 0.5 * self.period)

    def phasor(self) -> np.ndarray:
        """Mean of the direction as a complex number, (...).

        Raises
        ------
        ModelError
            For a number on the line.
        """
        if not self.period:
            raise ModelError("view resultant: only an angle has one; this is a real number")
        turn = 2.0 * math.pi / self.period
        return np.asarray((self.weights * np.exp(1j * turn * self.means - 0.5 * turn**2 * self.variances)).sum(axis=-1))

    def expectation(self) -> np.ndarray:
        """Mean, (...); the mean direction of an angle."""
        if self.period:
            return np.asarray(np.angle(self.phasor()) * self.period / (2.0 * math.pi))
        return np.asarray(np.einsum("...k,...k->...", self.weights, self.means))

    def variance(self) -> np.ndarray:
        """Variance, (...); of an angle of the deviation from its mean direction, the short way round."""
        away = self.turned(self.means - self.expectation()[..., None])
        if self.period:
            away = away - np.einsum("...k,...k->...", self.weights, away)[..., None]
        return np.asarray(np.einsum("...k,...k->...", self.weights, away**2 + self.variances))

    def below(self, x: np.ndarray) -> np.ndarray:
        """Probability of values up to `x` (...) on the line."""
        return self._share(np.asarray(x)[..., None] - self.means)

    def _share(self, away: np.ndarray) -> np.ndarray:
        sd = np.sqrt(self.variances)
        with np.errstate(divide="ignore", invalid="ignore"):
            z = np.where(sd > 0.0, away / np.where(sd > 0.0, sd, 1.0), np.where(away >= 0.0, np.inf, -np.inf))
        return np.asarray(np.einsum("...k,...k->...", self.weights, ndtr(z)))

    def probability(self, low: float, high: float) -> np.ndarray:
        """Probability of values from `low` to `high`, (...); of an angle from `low` round to `high`.

        Raises
        ------
        ModelError
            For an empty interval on the line.
        """
        if not self.period:
            if low > high:
                raise ModelError(f"view probability({low:g}..{high:g}): the interval is empty")
            upper = np.ones(self.shape) if high == math.inf else self.below(np.full(self.shape, high))
            lower = np.zeros(self.shape) if low == -math.inf else self._share(np.nextafter(low, -math.inf) - self.means)
            return np.asarray(np.clip(upper - lower, 0.0, 1.0))
        width = high - low
        if width >= self.period or not math.isfinite(width):
            return np.ones(self.shape)
        width = width % self.period
        total = np.zeros(self.shape)
        start = low + self.turned(self.means - low)  # nearest to the interval's beginning
        for k in range(-TURNS, TURNS + 1):
            away = low + k * self.period - start
            total += self._share(away + width) - self._share(np.nextafter(away, -np.inf))
        return np.asarray(np.clip(total, 0.0, 1.0))

    def quantile(self, share: float) -> np.ndarray:
        """The value below which `share` lies, (...), by bisection.

        Raises
        ------
        ModelError
            For an angle, which has no order.
        """
        if self.period:
            raise ModelError(f"view quantile({share}): an angle has no order")
        low, high = self._ends()
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            less = self.below(middle) < share
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        return np.asarray(high)

    def _ends(self) -> tuple[np.ndarray, np.ndarray]:
        spread = REACH * np.sqrt(self.variances)
        there = self.weights > 0.0
        low = np.where(there, self.means - spread, np.inf).min(axis=-1)
        return low, np.where(there, self.means + spread, -np.inf).max(axis=-1)

    def density(self, x: np.ndarray) -> np.ndarray:
        """Density at `x` (..., n), (..., n); a known value counts as a normal of the smallest width that shows."""
        variances = np.maximum(self.variances, 1e-18)[..., None, :]
        away = x[..., None] - self.means[..., None, :]
        turns = range(-TURNS, TURNS + 1) if self.period else (0,)
        if self.period:
            away = self.turned(away)
        exponents = [-0.5 * (away + k * self.period) ** 2 / variances for k in turns]
        values = np.sum([np.exp(e) for e in exponents], axis=0) / np.sqrt(2.0 * math.pi * variances)
        return np.asarray(np.einsum("...k,...nk->...n", self.weights, values))

    def mode(self) -> np.ndarray:
        """Where the density is highest among the middles of the components, (...)."""
        densities = self.density(self.means)
        at = densities.argmax(axis=-1)
        return self.turned(np.take_along_axis(self.means, at[..., None], -1)[..., 0])

    def entropy(self) -> np.ndarray:
        """Differential entropy in nats, (...), by the trapezoidal rule; minus infinity for a value that is known."""
        low, high = (np.full(self.shape, -0.5 * self.period), np.full(self.shape, 0.5 * self.period)) if self.period else self._ends()
        x = low[..., None] + (high - low)[..., None] * np.linspace(0.0, 1.0, POINTS)
        p = self.density(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = np.where(p > 0.0, -p * np.log(p), 0.0)
        total = np.trapezoid(terms, x, axis=-1)
        return np.asarray(np.where((self.variances * self.weights).sum(axis=-1) > 0.0, total, -np.inf))
