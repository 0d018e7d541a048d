r"""CPDs by integrating a noise model over bins.

``P(j | i, ...)`` is the mass that the noise puts into bin ``j``, averaged over parents uniform in their bins. End bins take
the tails; a circular child wraps. In one parent that enters linearly the integral is closed,

.. math:: \frac{s}{w}\left[I\!\left(\tfrac{hi-a}{s}\right)-I\!\left(\tfrac{hi-b}{s}\right)
          -I\!\left(\tfrac{lo-a}{s}\right)+I\!\left(\tfrac{lo-b}{s}\right)\right],
          \qquad I(z)=\int_{-\infty}^{z}F=z\,\Phi(z)+\varphi(z)

for normal noise of standard deviation ``s`` whose mean runs from ``a`` to ``b = a + w`` over the bin. Other parents are
averaged by Gauss-Legendre quadrature. Tables of bin centres are wrong: an object slower than one bin per step never moves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from cprm_gym.architecture.prm.domains import Bins, Domain, Labels
from cprm_gym.architecture.prm.formulas import Formula
from cprm_gym.errors import ModelError

MAX_CELLS = 4_000_000
"""Largest block of quadrature values held at once."""

Vectorised = Callable[[list[np.ndarray]], np.ndarray]
"""A function of one (N,) array per parent that returns (N, K)."""

_SQRT_3 = 1.7320508075688772
_INV_SQRT_2PI = 0.3989422804014327


def distribution(shape: str, z: np.ndarray) -> np.ndarray:
    """F(z) of the standard noise: ``"normal"``, or ``"uniform"`` on -sqrt(3) to sqrt(3) (also of deviation 1)."""
    if shape == "uniform":
        return np.clip(0.5 + z / (2.0 * _SQRT_3), 0.0, 1.0)
    return np.asarray(ndtr(z))


def integral(shape: str, z: np.ndarray) -> np.ndarray:
    """The integral of F from minus infinity to z, divided differences of which are averages of F over an interval."""
    if shape == "uniform":
        inside = np.clip(z, -_SQRT_3, _SQRT_3)
        return np.asarray((inside + _SQRT_3) ** 2 / (4.0 * _SQRT_3) + np.maximum(z - _SQRT_3, 0.0))
    return np.asarray(z * ndtr(z) + _INV_SQRT_2PI * np.exp(-0.5 * z * z))


def mean_distribution(shape: str, x: np.ndarray, low: np.ndarray, high: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """P(m + noise <= x) for m uniform between `low` and `high`, all arrays broadcast against each other.

    Differences of it in x are the cells of a CPD; computed so that far tails keep their digits.
    """
    low, high = np.minimum(low, high), np.maximum(low, high)
    width = high - low
    tiny = width <= 1e-9 * np.maximum(np.abs(high), 1.0)
    safe_width = np.where(tiny, 1.0, width)
    noisy = sd > 0
    s = np.where(noisy, sd, 1.0)
    smooth = s / safe_width * (integral(shape, (x - low) / s) - integral(shape, (x - high) / s))
    sharp = np.clip((x - low) / safe_width, 0.0, 1.0)
    spread = np.where(noisy, smooth, sharp)
    middle = 0.5 * (low + high)
    point = np.where(noisy, distribution(shape, (x - middle) / s), (x >= middle).astype(float))
    return np.where(tiny, point, spread)


def cell_masses(shape: str, edges: np.ndarray, circular: bool, low: np.ndarray, high: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Mass of each bin for a mean uniform between `low` and `high`.

    Parameters
    ----------
    shape : {"normal", "uniform"}
    edges : (K + 1,) float array
    circular : bool
    low, high, sd : float arrays of one shape S

    Returns
    -------
    S + (K,) float array, rows sum to 1
    """
    low, high, sd = (np.asarray(a, dtype=float)[..., None] for a in (low, high, sd))
    if not circular:
        # Mirrored at the right of the middle, so that both tails are small differences of small numbers.
        inner = edges[1:-1]
        middle = 0.5 * (low + high)
        below = mean_distribution(shape, inner, low, high, sd)
        above = mean_distribution(shape, -inner, -high, -low, sd)
        left = np.diff(below, axis=-1, prepend=0.0, append=1.0)
        right = -np.diff(above, axis=-1, prepend=1.0, append=0.0)
        use_left = edges[1:] <= middle
        mass = np.where(use_left, left, right)
    else:
        period = edges[-1] - edges[0]
        home = period * np.floor((0.5 * (low + high) - edges[0]) / period)
        low, high = low - home, high - home
        turns = int(np.ceil((0.5 * np.max(np.abs(high - low)) + 9.0 * np.max(sd)) / period))
        mass = np.zeros(low.shape[:-1] + (len(edges) - 1,))
        for turn in range(-turns, turns + 1):
            shifted = edges + turn * period
            below = np.diff(mean_distribution(shape, shifted, low, high, sd), axis=-1)
            above = -np.diff(mean_distribution(shape, -shifted, -high, -low, sd), axis=-1)
            mass += np.where(shifted[1:] <= 0.5 * (low + high), below, above)
    mass = np.maximum(mass, 0.0)
    return np.asarray(mass / mass.sum(axis=-1, keepdims=True))


def nodes(low: float, high: float, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes in an interval and weights that sum to 1 (a mean over the interval, not an integral)."""
    x, w = np.polynomial.legendre.leggauss(points)
    return 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * w


def average_over_bins(value: Vectorised, domains: list[Domain], points: int, width: int) -> np.ndarray:
    """Average of `value` over every combination of states of some parents, uniform inside the bins.

    Parameters
    ----------
    value : callable
        Takes one (N,) array per parent, returns (N, width).
    domains : list of Labels or Bins
        Of the parents; the value of a named state is its index.
    points : int
        Gauss-Legendre nodes per bin and parent.
    width : int

    Returns
    -------
    (K_1, ..., K_n, width) float array
    """
    grids = [_grid(d, points) for d in domains]
    out = np.empty([*(len(d) for d in domains), width])
    for index in np.ndindex(out.shape[:-1]):
        out[index] = _weighted_mean(value, [grids[axis][k] for axis, k in enumerate(index)], width)
    return out


def _grid(domain: Domain, points: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Nodes and weights of every state: one node for a named state."""
    if isinstance(domain, Labels):
        return [(np.array([float(k)]), np.ones(1)) for k in range(len(domain))]
    return [nodes(a, b, points) for a, b in zip(domain.edges[:-1], domain.edges[1:])]


def _weighted_mean(value: Vectorised, grid: list[tuple[np.ndarray, np.ndarray]], width: int) -> np.ndarray:
    flat = [m.ravel() for m in np.meshgrid(*[x for x, _ in grid], indexing="ij")]
    weight = np.ones(1)
    for _, w in grid:
        weight = np.multiply.outer(weight, w).ravel()
    size = max(1, MAX_CELLS // max(1, width))
    total = np.zeros(width)
    for start in range(0, len(weight), size):
        part = slice(start, start + size)
        total += weight[part] @ value([f[part] for f in flat])
    return total


def integrate_noise(
    mean: Formula, sd: Formula, shape: str, child: Bins, parents: Sequence[tuple[str, Domain]], points: int, where: str
) -> np.ndarray:
    """P(child bin | parents' states) of ``mean(parents) + sd(parents) * standard noise``.

    The binned parent with the widest effect in which the mean is affine, and on which the deviation does not depend, is
    integrated in closed form; the others by Gauss-Legendre quadrature with `points` nodes a bin (0: chosen so that the
    error stays below 1e-10 for smooth formulas).

    Parameters
    ----------
    mean, sd : Formula
    shape : {"normal", "uniform"}
    child : Bins
    parents : sequence of (str, Labels or Bins)
    points : int
    where : str
        Start of the message of an error.

    Returns
    -------
    (K_1, ..., K_n, K) float array

    Raises
    ------
    ModelError
        If a deviation is negative, or a value not finite.
    """
    names = {n: f"p{k}" for k, (n, _) in enumerate(parents)}
    try:
        return _integrated(mean.renamed(names), sd.renamed(names), shape, child, tuple(d for _, d in parents), points)
    except ModelError as error:
        raise ModelError(f"{where}: noise of mean {mean.text!r} (parents p0, p1, ... as declared): {error}") from None


@lru_cache(maxsize=256)
def _integrated(mean_text: str, sd_text: str, shape: str, child: Bins, domains: tuple[Domain, ...], points: int) -> np.ndarray:
    mean, sd = Formula(mean_text), Formula(sd_text)
    parents = [(f"p{k}", d) for k, d in enumerate(domains)]
    edges = np.asarray(child.edges)
    closed = _closed_parent(mean, sd, parents)
    others = [(n, d) for n, d in parents if n != closed]
    bins = dict(parents).get(closed) if closed else None
    steps = np.asarray(bins.edges) if isinstance(bins, Bins) else np.zeros(2)
    count = len(steps) - 1
    nodes_per_bin = points or _points_for(mean, sd, others, closed, steps)

    def value(arrays: list[np.ndarray]) -> np.ndarray:
        size = len(arrays[0]) if arrays else 1
        known = {n: np.repeat(a, count + 1) for (n, _), a in zip(others, arrays)}
        if closed:
            known[closed] = np.tile(steps, size)
        centre = mean(known, size * (count + 1)).reshape(size, count + 1)
        deviation = sd({n: a for (n, _), a in zip(others, arrays)}, size)
        if (deviation < 0).any():
            least = float(deviation.min())
            raise ModelError(f"the deviation {sd.text!r} is {least!r} somewhere; it must not be negative")
        spread = np.broadcast_to(deviation[:, None], (size, count))
        mass = cell_masses(shape, edges, child.circular, centre[:, :-1], centre[:, 1:], spread)
        return mass.reshape(size, count * len(child))

    flat = average_over_bins(value, [d for _, d in others], nodes_per_bin, count * len(child))
    table = flat.reshape(*flat.shape[:-1], count, len(child))
    if not closed:
        return np.asarray(table[..., 0, :])
    return np.moveaxis(table, -2, [n for n, _ in parents].index(closed))


def _middle(domain: Domain) -> np.ndarray:
    return np.asarray(domain.values if isinstance(domain, Bins) else range(len(domain)), dtype=float)


def _effect(formula: Formula, name: str, parents: Sequence[tuple[str, Domain]]) -> float:
    """How far the mean moves over the widest bin of one parent, the others in the middle of a middle bin."""
    domain = dict(parents)[name]
    if not isinstance(domain, Bins):
        return 0.0
    edges = np.asarray(domain.edges)
    known = {n: np.full(len(edges), _middle(d)[len(d) // 2]) for n, d in parents if n != name}
    known[name] = edges
    return float(np.max(np.abs(np.diff(formula({n: known[n] for n in formula.names}, len(edges))))))


def _closed_parent(mean: Formula, sd: Formula, parents: Sequence[tuple[str, Domain]]) -> str:
    fit = [n for n, d in parents if isinstance(d, Bins) and n in mean.names and n not in sd.names and mean.is_affine_in(n)]
    return max(fit, key=lambda n: _effect(mean, n, parents), default="")


def _points_for(mean: Formula, sd: Formula, others: Sequence[tuple[str, Domain]], closed: str, steps: np.ndarray) -> int:
    """Nodes a bin: more where a bin moves the mean by many deviations."""
    binned = [(n, d) for n, d in others if isinstance(d, Bins)]
    if not binned:
        return 1
    known = {n: np.array([_middle(d)[len(d) // 2]]) for n, d in others}
    deviation = float(sd({n: known[n] for n in sd.names}, 1)[0])
    constant = not sd.names and all(mean.is_affine_in(n) for n, _ in binned)
    if deviation <= 0.0 or not constant:
        return 64 if len(binned) == 1 else 24
    everything = [*others] + ([(closed, Bins(tuple(steps)))] if closed else [])
    widest = max(_effect(mean, n, everything) if n in mean.names else 0.0 for n, _ in binned)
    return int(np.clip(np.ceil(4.5 + 1.4 * widest / deviation), 5, 128))


def with_floor(table: np.ndarray, floor: float) -> np.ndarray:
    """Mix a uniform share into every row: ``(1 - floor) * p + floor / K``."""
    mixed = (1.0 - floor) * table + floor / table.shape[-1]
    return np.asarray(mixed / mixed.sum(axis=-1, keepdims=True))
