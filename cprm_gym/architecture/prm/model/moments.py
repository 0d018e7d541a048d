"""Numbers of a distribution over a domain: mean, variance, quantile, and their forms for angles."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ....errors import ModelError
from .domains import Bins, Domain


def is_angle(domain: Domain) -> bool:
    """The states are the bins of an angle."""
    return isinstance(domain, Bins) and domain.circular


def mean(p: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean of values under each distribution; not a matrix product, whose last digit depends on how many there are."""
    return np.asarray(np.einsum("...k,k->...", p, values))


@lru_cache(maxsize=1024)
def points(domain: Domain) -> np.ndarray:
    """Mid-points of bins, or the indices of named states, (K,), read only."""
    values = np.array(domain.values if isinstance(domain, Bins) else range(len(domain)), dtype=float)
    values.flags.writeable = False
    return values


def variance(p: np.ndarray, domain: Domain, within_bins: bool = True) -> np.ndarray:
    """Variance of each distribution, in squared units.

    Parameters
    ----------
    p : (..., K) float array
    domain : Labels or Bins
    within_bins : bool
        Add the variance ``w**2 / 12`` of a value uniform in a bin of width w.

    Returns
    -------
    (...) float array
        For an angle, of the deviation from the circular mean, taken the short way round.
    """
    at = points(domain)
    if isinstance(domain, Bins) and domain.circular:
        half = 0.5 * domain.period
        away = at - circular_mean(p, domain)[..., None]
        away = np.mod(away + half, domain.period) - half
        away = away - np.sum(p * away, axis=-1, keepdims=True)
    else:
        away = at - mean(p, at)[..., None]
    out = np.sum(p * away**2, axis=-1)
    if within_bins and isinstance(domain, Bins):
        out = out + mean(p, np.square(domain.widths) / 12.0)
    return np.asarray(out)


def _phasor(p: np.ndarray, domain: Domain, what: str) -> np.ndarray:
    if not isinstance(domain, Bins) or not domain.circular:
        raise ModelError(f"view {what}: only an angle has one; the states are {domain.states[:3]} ...")
    turn = 2.0 * math.pi / domain.period
    return mean(p, np.exp(1j * turn * points(domain)))


def circular_mean(p: np.ndarray, domain: Domain) -> np.ndarray:
    """Mean direction of an angle, in its unit, between the first and the last edge.

    Undefined (any direction) when the resultant is 0.
    """
    phasor = _phasor(p, domain, "expectation")
    assert isinstance(domain, Bins)
    angle = np.angle(phasor) * domain.period / (2.0 * math.pi)
    return np.asarray(domain.edges[0] + np.mod(angle - domain.edges[0], domain.period))


def resultant(p: np.ndarray, domain: Domain) -> np.ndarray:
    """Length of the mean direction of an angle, 0 to 1."""
    return np.asarray(np.abs(_phasor(p, domain, "resultant")))


def quantile(p: np.ndarray, domain: Domain, share: float) -> np.ndarray:
    """The value below which `share` of each distribution lies; for named states the index of the state that reaches it.

    Parameters
    ----------
    p : (..., K) float array
    domain : Labels or Bins
    share : float
        0 to 1.

    Returns
    -------
    (...) float array

    Raises
    ------
    ModelError
        For an angle, which has no order.
    """
    if is_angle(domain):
        raise ModelError(f"view quantile({share}): an angle has no order")
    total = np.cumsum(p, axis=-1)
    wanted = share * total[..., -1:]
    at = np.minimum(np.sum(total < wanted, axis=-1), len(domain) - 1)
    if not isinstance(domain, Bins):
        return np.asarray(at, dtype=float)
    mass = np.take_along_axis(p, at[..., None], -1)[..., 0]
    before = np.take_along_axis(total, at[..., None], -1)[..., 0] - mass
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = np.where(mass > 0.0, (wanted[..., 0] - before) / np.where(mass > 0.0, mass, 1.0), 0.0)
    edges = np.asarray(domain.edges)
    return np.asarray(edges[at] + np.clip(inside, 0.0, 1.0) * np.diff(edges)[at])
