"""Ratings from games: the Bradley-Terry model by maximum likelihood, on the scale of Elo."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from ...errors import ParameterError

ELO = 400.0 / math.log(10.0)
"""Points for a factor of e in the odds: 400 points are odds of ten to one."""
MIDDLE = 1000.0
"""Mean of all ratings."""


class Ratings(NamedTuple):
    """What the games say."""

    points: np.ndarray
    """(n,) Elo."""
    low: np.ndarray
    """(n,) lower end of each 95 % interval."""
    high: np.ndarray
    """(n,) upper end."""
    advantage: float
    """Points by which the left side is better off; 0 where it was not asked for."""


def rate(won: np.ndarray, played: np.ndarray, advantage: bool = False, prior: float = 1.0, confidence: float = 0.95) -> Ratings:
    """Maximum likelihood of ``P(i beats j) = 1 / (1 + exp(t_j - t_i - a))``, i on the left side and `a` its advantage.

    Everybody also draws `prior` games against an average player, so that who has won or lost all games has a rating, too. Intervals, of the
    distance to the mean of all, come from the curvature of the likelihood at its maximum.

    Parameters
    ----------
    won : (n, n) float array
        ``won[i, j]``: points of i on the left against j on the right; a draw is half a point.
    played : (n, n) float array
        Games of i on the left against j on the right.
    advantage : bool
        Whether the side's advantage is estimated; otherwise it is 0.
    prior : float
        Above 0.
    confidence : float

    Raises
    ------
    ParameterError
        For arrays of other shapes, points that the games do not give, or a prior that is not positive.

    References
    ----------
    Bradley and Terry, Rank analysis of incomplete block designs, Biometrika 39, 1952; Hunter, Annals of Statistics 32, 2004.

    Examples
    --------
    >>> ratings = rate(np.array([[0.0, 75.0], [0.0, 0.0]]), np.array([[0.0, 100.0], [0.0, 0.0]]), prior=1e-9)
    >>> round(float(ratings.points[0] - ratings.points[1]))  # 400 log10(3)
    191
    """
    won, played = np.asarray(won, np.float64), np.asarray(played, np.float64)
    n = len(played)
    if won.shape != (n, n) or played.shape != (n, n):
        raise ParameterError(f"rate: expected two square arrays of one size, got {won.shape} and {played.shape}")
    if not (np.isfinite(won).all() and np.isfinite(played).all() and (won >= 0).all() and (won <= played).all()):
        raise ParameterError("rate: points have to be finite numbers from 0 to the games played")
    if not prior > 0:
        raise ParameterError(f"rate: prior: {prior!r} given, a number above 0 is needed")
    theta = np.zeros(n + 1)
    for _ in range(200):
        gradient, hessian = _slopes(theta, won, played, advantage, prior)
        step = np.linalg.solve(hessian, gradient)
        theta += np.clip(step, -2.0, 2.0)
        if np.abs(step).max() < 1e-10:
            break
    centred = np.eye(n) - 1.0 / n
    covariance = centred @ np.linalg.inv(_slopes(theta, won, played, advantage, prior)[1])[:n, :n] @ centred
    half = float(norm.ppf(0.5 + confidence / 2.0)) * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    points, width = MIDDLE + ELO * (centred @ theta[:n]), ELO * half
    return Ratings(points, points - width, points + width, float(ELO * theta[n]))


def _slopes(theta: np.ndarray, won: np.ndarray, played: np.ndarray, advantage: bool, prior: float) -> tuple[np.ndarray, np.ndarray]:
    """Gradient of the log-likelihood, (n + 1,), and minus its Hessian."""
    n = len(played)
    t, a = theta[:n], theta[n]
    p = 1.0 / (1.0 + np.exp(t[None, :] - t[:, None] - a))
    off, weight = won - played * p, played * p * (1.0 - p)
    q = 1.0 / (1.0 + np.exp(-t))
    gradient = np.append(off.sum(axis=1) - off.sum(axis=0) + prior * (0.5 - q), off.sum() if advantage else 0.0)
    hessian = np.zeros((n + 1, n + 1))
    hessian[:n, :n] = np.diag(weight.sum(axis=1) + weight.sum(axis=0) + prior * q * (1.0 - q)) - weight - weight.T
    if advantage:
        hessian[:n, n] = hessian[n, :n] = weight.sum(axis=1) - weight.sum(axis=0)
        hessian[n, n] = weight.sum() + 1e-9
    else:
        hessian[n, n] = 1.0
    return gradient, hessian
