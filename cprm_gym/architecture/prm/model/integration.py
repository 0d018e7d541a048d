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

import itertools
import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from ....errors import ModelError
from .domains import Bins, Domain, Labels
from .formulas import Formula

MAX_CELLS = 4_000_000
"""Largest block of quadrature values held at once."""

MAX_TURNS = 500
"""Most turns of a circle that the mean and the noise of one CPD may span."""

MAX_VALUES = 20_000_000
"""Most values that are computed for one CPD: nodes of all combinations of bins, times what is computed at each. A second or two."""

Vectorised = Callable[[list[np.ndarray]], np.ndarray]
"""A function of one (N,) array per parent that returns (N, K)."""

_SQRT_3 = 1.7320508075688772
_INV_SQRT_2PI = 0.3989422804014327


def tail(shape: str, z: np.ndarray) -> np.ndarray:
    """F(-abs(z)) of the standard noise, ``"normal"`` or ``"uniform"`` on -sqrt(3) to sqrt(3) (also of deviation 1)."""
    if shape == "uniform":
        return np.clip(0.5 - np.abs(z) / (2.0 * _SQRT_3), 0.0, 0.5)
    return np.asarray(ndtr(-np.abs(z)))


def tail_integral(shape: str, z: np.ndarray) -> np.ndarray:
    """The integral I of F from minus infinity to -abs(z); for symmetric noise ``I(z) = max(z, 0) + tail_integral(z)``."""
    t = np.minimum(np.abs(z), 40.0)
    if shape == "uniform":
        return np.asarray(np.square(np.maximum(_SQRT_3 - t, 0.0)) / (4.0 * _SQRT_3))
    return np.asarray(np.maximum(_INV_SQRT_2PI * np.exp(-0.5 * t * t) - t * ndtr(-t), 0.0))


def spread_masses(shape: str, edges: np.ndarray, circular: bool, means: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Mass of each bin for a mean uniform between neighbouring values.

    The part without noise is an overlap of intervals; what noise changes is a double difference of `tail_integral`, so that
    the far tails keep their digits.

    Parameters
    ----------
    shape : {"normal", "uniform"}
    edges : (K + 1,) float array
    circular : bool
    means : (N, M + 1) float array
        The mean is uniform between ``means[:, j]`` and ``means[:, j + 1]``.
    sd : (N,) float array

    Returns
    -------
    (N, M, K) float array, rows sum to 1
    """
    low = np.minimum(means[:, :-1], means[:, 1:])[..., None]
    high = np.maximum(means[:, :-1], means[:, 1:])[..., None]
    width = high - low
    scale = np.where(sd > 0.0, sd, 1.0)[:, None, None]
    noisy = (sd > 0.0)[:, None, None]
    narrow = width <= np.where(noisy, 1e-5 * scale, 1e-12 * np.maximum(np.abs(high), 1.0))
    safe = np.where(narrow, 1.0, width)
    sign = np.where(means[:, :-1] <= means[:, 1:], 1.0, -1.0)[..., None]
    mass = np.zeros((*low.shape[:2], len(edges) - 1))
    for at in _images(edges, circular, means, sd):
        inside = np.clip(np.minimum(at[1:], high) - np.maximum(at[:-1], low), 0.0, None) / safe
        corner = tail_integral(shape, _over(at - means[..., None], scale))
        twice = np.diff(np.diff(corner, axis=2), axis=1)
        mass += inside - np.where(noisy, sign * twice * scale / safe, 0.0)
    if narrow.any():
        points = point_masses(shape, edges, circular, 0.5 * (means[:, :-1] + means[:, 1:]), sd)
        mass = np.where(narrow, points, mass)
    mass = np.maximum(mass, 0.0)
    return np.asarray(mass / mass.sum(axis=-1, keepdims=True))


def point_masses(shape: str, edges: np.ndarray, circular: bool, mean: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Mass of each bin for a known mean.

    Parameters
    ----------
    shape, edges, circular
        As in `spread_masses`.
    mean : (N, M) float array
    sd : (N,) float array

    Returns
    -------
    (N, M, K) float array, rows sum to 1
    """
    noisy = (sd > 0.0)[:, None, None]
    scale = np.where(sd > 0.0, sd, 1.0)[:, None, None]
    mass = np.zeros((*mean.shape, len(edges) - 1))
    for at in _images(edges, circular, mean, sd):
        z = at - mean[..., None]
        beyond = z > 0.0
        outside = np.where(noisy, tail(shape, _over(z, scale)), 0.0)
        mass += np.diff(beyond.astype(float), axis=2) + np.diff(np.where(beyond, -outside, outside), axis=2)
    mass = np.maximum(mass, 0.0)
    return np.asarray(mass / mass.sum(axis=-1, keepdims=True))


def _over(distance: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Distances in deviations; beyond all numbers where the deviation is next to nothing."""
    with np.errstate(over="ignore"):
        return np.asarray(distance / scale)


def _images(edges: np.ndarray, circular: bool, means: np.ndarray, sd: np.ndarray) -> list[np.ndarray]:
    """The edges with the tails in the end bins, or all turns of a circle that the noise can reach."""
    if not circular:
        return [np.concatenate([[-np.inf], edges[1:-1], [np.inf]])]
    period = edges[-1] - edges[0]
    reach = 9.0 * float(np.max(sd, initial=0.0))
    low, high = float(np.min(means)) - reach, float(np.max(means)) + reach
    if not (high - low) / period <= MAX_TURNS:
        raise ModelError(f"a mean and noise from {low!r} to {high!r} go round a circle of {period!r} more than {MAX_TURNS} times")
    first, last = (int(np.floor((x - edges[0]) / period)) for x in (low, high))
    return [edges + turn * period for turn in range(first, last + 1)]


PANEL = 64
"""Most nodes of one Gauss-Legendre rule; more are made of panels side by side, which suits steps and kinks."""


@lru_cache(maxsize=256)
def _unit_nodes(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes in 0 to 1 and weights that sum to 1."""
    panels = -(-points // PANEL)
    x, w = np.polynomial.legendre.leggauss(-(-points // panels))
    at = (np.arange(panels)[:, None] + 0.5 * (1.0 + x)) / panels
    return at.ravel(), np.tile(0.5 * w / panels, panels)


def nodes(low: float, high: float, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes in an interval and weights that sum to 1 (a mean over the interval, not an integral)."""
    x, w = _unit_nodes(points)
    return low + (high - low) * x, w


def average_over_bins(value: Vectorised, domains: list[Domain], points: Sequence[int], width: int, most: int = MAX_VALUES) -> np.ndarray:
    """Average of `value` over every combination of states of some parents, uniform inside the bins.

    Parameters
    ----------
    value : callable
        Takes one (N,) array per parent, returns (N, width).
    domains : list of Labels or Bins
        Of the parents; the value of a named state is its index.
    points : sequence of int
        Gauss-Legendre nodes per bin, for each parent.
    width : int
    most : int
        Values that may be computed.

    Returns
    -------
    (K_1, ..., K_n, width) float array
    """
    total = math.prod(len(d) * (n if isinstance(d, Bins) else 1) for d, n in zip(domains, points)) * width
    if total > most:
        nodes_ = " x ".join(str(n) for d, n in zip(domains, points) if isinstance(d, Bins))
        raise ModelError(f"{total} values would be computed ({nodes_} nodes a bin); at most {most}: set fewer `points` or bins")
    grids = [_grid(d, n) for d, n in zip(domains, points)]
    out = np.empty([*(len(d) for d in domains), width])
    for index in np.ndindex(out.shape[:-1]):
        out[index] = _weighted_mean(value, [grids[axis][k] for axis, k in enumerate(index)], width)
    return out


def _grid(domain: Domain, points: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Nodes and weights of every state: one node for a named state."""
    if isinstance(domain, Labels):
        return [(np.array([float(k)]), np.ones(1)) for k in range(len(domain))]
    assert isinstance(domain, Bins)
    return [nodes(a, b, points) for a, b in zip(domain.edges[:-1], domain.edges[1:])]


def _weighted_mean(value: Vectorised, grid: list[tuple[np.ndarray, np.ndarray]], width: int) -> np.ndarray:
    flat = [m.ravel() for m in np.meshgrid(*[x for x, _ in grid], indexing="ij")]
    weight = np.ones(1)
    for _, w in grid:
        weight = np.multiply.outer(weight, w).ravel()
    return _in_parts(value, flat, weight, width)


def sum_nodes(first: float, second: float, points: Callable[[float], int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes for the mean of a function of ``first * u + second * v``, with u and v uniform on 0 to 1 and independent.

    The sum has a density in the form of a trapezoid, so that one quadrature along a path of growing sums does for two.

    Parameters
    ----------
    first, second : float
    points : callable
        Nodes for a stretch over which the sum changes by so much.

    Returns
    -------
    u, v, weights : (M,) float array
        Weights sum to 1.
    """
    a, b = abs(first), abs(second)
    narrow, wide = min(a, b), max(a, b)
    if narrow <= 1e-12 * wide:
        narrow = 0.0
    total = narrow + wide
    knots = sorted({0.0, narrow, wide, total})
    at, weights = [np.zeros(0)], [np.zeros(0)]
    for low, high in itertools.pairwise(knots):
        t, w = nodes(low, high, points(high - low))
        density = np.minimum(np.minimum(t, total - t), narrow) / (narrow * wide) if narrow else np.full(len(t), 1.0 / total)
        at.append(t)
        weights.append(w * (high - low) * density)
    if total == 0.0:
        return np.full(1, 0.5), np.full(1, 0.5), np.ones(1)
    t, lead = np.concatenate(at), a if a > 1e-12 * wide else 0.0
    u = np.clip(t / lead, 0.0, 1.0) if lead else np.full(len(t), 0.5)
    v = np.clip((t - lead) / b, 0.0, 1.0) if b > 1e-12 * wide else np.full(len(t), 0.5)
    return u if first >= 0 else 1.0 - u, v if second >= 0 else 1.0 - v, np.concatenate(weights)


def _average_over_pair(
    value: Vectorised, mean: Formula, parents: Sequence[tuple[str, Domain]], others: list[str], pair: tuple[int, int],
    per_bin: Sequence[int], points: Callable[[float], int], width: int,
) -> np.ndarray:  # fmt: skip
    """As `average_over_bins`, where two of the parents enter by a sum: one quadrature for both."""
    domains = [dict(parents)[n] for n in others]
    grids = [_grid(d, n) for d, n in zip(domains, per_bin)]
    middle = {n: _middle(d)[len(d) // 2] for n, d in parents}
    out = np.empty([*(len(d) for d in domains), width])
    spent = 0
    for index in np.ndindex(out.shape[:-1]):
        here = {**middle, **{n: float(_middle(d)[k]) for n, d, k in zip(others, domains, index)}}
        ends = {axis: (domains[axis].edges[index[axis]], domains[axis].edges[index[axis] + 1]) for axis in pair}  # type: ignore[union-attr]
        change = []
        for axis in pair:
            known = {n: np.full(2, x) for n, x in here.items()} | {others[axis]: np.array(ends[axis])}
            low, high = mean({n: known[n] for n in mean.names}, 2)
            change.append(float(high - low))
        *shares, weight = sum_nodes(change[0], change[1], points)
        rest = [axis for axis in range(len(others)) if axis not in pair]
        picks = np.meshgrid(np.arange(len(weight)), *[grids[axis][index[axis]][0] for axis in rest], indexing="ij")
        for axis in rest:
            weight = np.multiply.outer(weight, grids[axis][index[axis]][1])
        columns = [np.zeros(0)] * len(others)
        for axis, share in zip(pair, shares):
            columns[axis] = (ends[axis][0] + (ends[axis][1] - ends[axis][0]) * share)[picks[0].ravel()]
        for axis, pick in zip(rest, picks[1:]):
            columns[axis] = pick.ravel()
        spent += weight.size * width
        if spent > MAX_VALUES:
            raise ModelError(f"more than {MAX_VALUES} values would be computed, at most as many: set fewer `points` or bins")
        out[index] = _in_parts(value, columns, weight.ravel(), width)
    return out


def _in_parts(value: Vectorised, columns: list[np.ndarray], weight: np.ndarray, width: int) -> np.ndarray:
    size = max(1, MAX_CELLS // max(1, width))
    total = np.zeros(width)
    for start in range(0, len(weight), size):
        part = slice(start, start + size)
        total += weight[part] @ value([c[part] for c in columns])
    return total


def integrate_noise(
    mean: Formula, sd: Formula, shape: str, child: Bins, parents: Sequence[tuple[str, Domain]], points: int, where: str
) -> np.ndarray:
    """P(child bin | parents' states) of ``mean(parents) + sd(parents) * standard noise``.

    The binned parent with the widest effect in which the mean is affine, and on which the deviation does not depend, is
    integrated in closed form; the others by Gauss-Legendre quadrature with `points` nodes a bin (0: chosen so that the
    error stays below 1e-10 for smooth formulas). Two of them take one quadrature together where the mean is a sum of the parents.

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


@lru_cache(maxsize=64)
def _integrated(mean_text: str, sd_text: str, shape: str, child: Bins, domains: tuple[Domain, ...], points: int) -> np.ndarray:
    mean, sd = Formula(mean_text), Formula(sd_text)
    parents = [(f"p{k}", d) for k, d in enumerate(domains)]
    edges = np.asarray(child.edges)
    closed = _closed_parent(mean, sd, parents)
    others = [(n, d) for n, d in parents if n != closed]
    bins = dict(parents).get(closed) if closed else None
    steps = np.asarray(bins.edges) if isinstance(bins, Bins) else np.zeros(2)
    count = len(steps) - 1
    per_bin = [points] * len(others) if points else _points_for(mean, sd, others, closed, steps)

    spent = 0

    def spend(means: np.ndarray, deviation: np.ndarray) -> None:
        """Each turn of a circle takes the work again."""
        nonlocal spent
        spent += means.size * len(child) * len(_images(edges, child.circular, means, deviation))
        if spent > MAX_VALUES:
            raise ModelError(
                f"more than {MAX_VALUES} values would be computed for the turns of a circle, at most as many: set fewer `points` or bins"
            )

    def value(arrays: list[np.ndarray]) -> np.ndarray:
        size = len(arrays[0]) if arrays else 1
        deviation = sd({n: a for (n, _), a in zip(others, arrays)}, size)
        if (deviation < 0).any():
            least = float(deviation.min())
            raise ModelError(f"the deviation {sd.text!r} is {least!r} somewhere; it must not be negative")
        if not closed:
            centre = mean({n: a for (n, _), a in zip(others, arrays)}, size)[:, None]
            spend(centre, deviation)
            return point_masses(shape, edges, child.circular, centre, deviation).reshape(size, len(child))
        known = {n: np.repeat(a, count + 1) for (n, _), a in zip(others, arrays)}
        known[closed] = np.tile(steps, size)
        centres = mean(known, size * (count + 1)).reshape(size, count + 1)
        spend(centres, deviation)
        return spread_masses(shape, edges, child.circular, centres, deviation).reshape(size, count * len(child))

    pair = _summed_pair(mean, sd, parents, closed, [n for n, _ in others])
    if pair is None:
        flat = average_over_bins(value, [d for _, d in others], per_bin, count * len(child))
    else:
        deviation = float(sd({n: np.array([_middle(d)[len(d) // 2]]) for n, d in parents if n in sd.names}, 1)[0])
        fixed = points or (24 if sd.names or deviation <= 0.0 else 0)
        least = 64 if shape == "uniform" else 5  # uniform noise has kinks

        def stretch(length: float) -> int:
            return fixed or int(np.clip(np.ceil(4.5 + 1.4 * length / deviation), least, 128))

        names = [n for n, _ in others]
        flat = _average_over_pair(value, mean, parents, names, pair, per_bin, stretch, count * len(child))
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


def _summed_pair(
    mean: Formula, sd: Formula, parents: Sequence[tuple[str, Domain]], closed: str, others: list[str]
) -> tuple[int, int] | None:
    """The two binned parents of widest effect besides the closed one, where the mean is a sum of them all and the deviation not theirs."""
    binned = [n for n, d in parents if isinstance(d, Bins) and n in mean.names]
    fit = sorted((n for n in binned if n != closed and n not in sd.names), key=lambda n: -_effect(mean, n, parents))[:2]
    if len(fit) < 2 or not mean.is_affine_in(*binned):
        return None
    return others.index(fit[0]), others.index(fit[1])


def _points_for(mean: Formula, sd: Formula, others: Sequence[tuple[str, Domain]], closed: str, steps: np.ndarray) -> list[int]:
    """Nodes a bin of each parent: more where a bin moves the mean by many deviations."""
    binned = [n for n, d in others if isinstance(d, Bins)]
    known = {n: np.array([_middle(d)[len(d) // 2]]) for n, d in others}
    deviation = float(sd({n: known[n] for n in sd.names}, 1)[0])
    if deviation <= 0.0 or sd.names or not all(mean.is_affine_in(n) for n in binned):
        return [(64 if len(binned) == 1 else 24) if n in binned else 1 for n, _ in others]
    everything = [*others] + ([(closed, Bins(tuple(steps)))] if closed else [])
    effects = [_effect(mean, n, everything) if n in mean.names else 0.0 for n, _ in others]
    return [int(np.clip(np.ceil(4.5 + 1.4 * effect / deviation), 5, 128)) for effect in effects]


def with_floor(table: np.ndarray, floor: float) -> np.ndarray:
    """Mix a uniform share into every row: ``(1 - floor) * p + floor / K``."""
    mixed = (1.0 - floor) * table + floor / table.shape[-1]
    return np.asarray(mixed / mixed.sum(axis=-1, keepdims=True))
