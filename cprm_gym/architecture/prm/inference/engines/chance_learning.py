"""A chance of real numbers, tilted to what a window tells: offset and scale of its log-odds.

With p what the chance says, ``log p' / (1 - p') = offset + scale log p / (1 - p)``: two numbers, which is all of a chance of two levels,
and keeps a certainty certain. Log-odds have no sums that say all of them; with Polya-Gamma variables for company the expected
log-likelihood is a square in both numbers, so five sums do, every update raises the likelihood and it stands still where that does.

References
----------
Polson, Scott and Windle 2013; Scott and Sun 2013 (expectation-maximisation for logistic regression); Platt 1999.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ....expressions import Node, parse, unparse
from ...model.cpds import Chance

SUMS = 5
"""Sums of a chance: of weights, of weights times log-odds and times their square, of ``y - 1/2`` and of that times log-odds."""
LEAST_SCALE = 1e-3
"""A chance that rises with its formula goes on rising with it."""
MOST = 40.0
"""Log-odds that are told from certainty at most, and the most by which they are moved."""
JUMPS = frozenset(
    ("if", "<", "<=", ">", ">=", "==", "!=", "and", "or", "not", "abs", "sign", "floor", "ceil", "round", "min", "max", "clip")
)
"""Operations after which a formula of one number is integrated step by step."""
STEPS, REACH = 513, 8.0
ROUNDS, CLOSE = 30, 1e-4
"""How often the normal before an outcome is sought, and how near its moments have to come: squares, as shares of what they are."""
LEAST_VARIANCE, TINY = 1e-14, 1e-280
NODES = {1: 15, 2: 15, 3: 7}
"""Gauss-Hermite nodes in each of so many numbers; of more, unscented points are taken."""


def chance_sums(chance: np.ndarray, holds: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The `SUMS` of chances, what came of them, and how much each counts; all of one shape."""
    inside = (chance > 0.0) & (chance < 1.0)
    p = np.where(inside, chance, 0.5)
    odds = np.clip(np.log(p) - np.log1p(-p), -MOST, MOST)
    weights = np.where(inside, weights, 0.0)
    flat = np.abs(odds) < 1e-4
    curve = np.where(flat, 0.25 - odds**2 / 48.0, (1.0 / (1.0 + np.exp(-odds)) - 0.5) / np.where(flat, 1.0, odds))
    off = weights * (holds - 0.5)
    curved = weights * curve
    return np.array([curved.sum(), (curved * odds).sum(), (curved * odds**2).sum(), off.sum(), (off * odds).sum()])


def tilt_of(sums: np.ndarray, count: float, prior: float) -> tuple[float, float]:
    """Offset and scale of the log-odds that fit best.

    Parameters
    ----------
    sums : (SUMS,) float array
    count : float
        Readings that they are of.
    prior : float
        Readings that there were besides, which came as the chance says.
    """
    s0, s1, s2, g0, g1 = (float(s) for s in sums)
    if not s0 > 0.0:
        return 0.0, 1.0
    more = prior / count if count > 0.0 else 0.0
    g0, g1 = g0 + more * s1, g1 + more * s2
    s0, s1, s2 = (1.0 + more) * s0, (1.0 + more) * s1, (1.0 + more) * s2
    middle, scale = s1 / s0, 1.0
    spread = s2 / s0 - middle**2
    if spread > 1e-9 * (1.0 + s2 / s0):
        scale = max((g1 - middle * g0) / (s0 * spread), LEAST_SCALE)
    return float(np.clip(g0 / s0 - scale * middle, -MOST, MOST)), scale


def tilted(chance: Chance, offset: float, scale: float) -> Chance:
    """The chance with its log-odds moved and scaled: cases of a formula each by itself, and what was tilted before is not wrapped again."""
    return Chance(unparse(_tilted(parse(chance.p), chance.floor, offset, scale)), 0.0, chance.points)


def _tilted(node: Node, floor: float, offset: float, scale: float) -> Node:
    if node.op == "if":
        condition, *cases = node.args
        return Node("if", (condition, *(_tilted(case, floor, offset, scale) for case in cases)))
    if node.op == "number":
        p = node.value * (1.0 - floor) + 0.5 * floor
        certain = not 0.0 < p < 1.0
        return _number(p if certain else 1.0 / (1.0 + math.exp(-(offset + scale * (math.log(p) - math.log1p(-p))))))
    base, factor, power = (node, 1.0, 1.0) if floor else _tilted_before(node)
    if floor:
        base = Node("+", (Node("*", (_number(1.0 - floor), base)), _number(0.5 * floor)))
    factor = math.exp(min(max(offset + scale * math.log(factor), -MOST), MOST))
    rises = Node("*", (_number(factor), Node("**", (base, _number(power * scale)))))
    return Node("/", (rises, Node("+", (rises, _falls(base, power * scale)))))


def _tilted_before(node: Node) -> tuple[Node, float, float]:
    """What was tilted, by which factor of its odds and by which power; the node itself, 1 and 1 if it was not."""
    if node.op == "/" and node.args[0].op == "*":
        factor, raised = node.args[0].args
        if factor.op == "number" and raised.op == "**" and raised.args[1].op == "number":
            base, power = raised.args
            if node.args[1] == Node("+", (node.args[0], _falls(base, power.value))):
                return base, factor.value, power.value
    return node, 1.0, 1.0


def _falls(base: Node, power: float) -> Node:
    return Node("**", (Node("-", (_number(1.0), base)), _number(power)))


def _number(value: float) -> Node:
    return Node("number", value=float(value))


Points = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def points_of(means: np.ndarray, covs: np.ndarray, jumps: bool, unscented: Points) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, P, d) over normals with these means (n, d) and covariances (n, d, d), and their weights (P,).

    Parameters
    ----------
    means, covs : float arrays
    jumps : bool
        Whether what is asked for at them may jump.
    unscented : callable
        What makes them where numbers are too many.
    """
    d = means.shape[1]
    if d == 0:
        return means[:, None], np.ones(1)
    if d == 1 and jumps:
        x = np.linspace(-REACH, REACH, STEPS)
        w = np.exp(-0.5 * x**2)
        grid, weights = x[:, None], w / w.sum()
    elif d in NODES:
        x, w = np.polynomial.hermite_e.hermegauss(NODES[d])
        grid = np.stack(np.meshgrid(*[x] * d, indexing="ij"), axis=-1).reshape(-1, d)
        weights = np.prod(np.stack(np.meshgrid(*[w / w.sum()] * d, indexing="ij"), axis=-1).reshape(-1, d), axis=1)
    else:
        return unscented(means, covs)
    values, vectors = np.linalg.eigh(covs)
    roots = np.sqrt(np.maximum(values, 0.0))[:, None, :] * vectors
    return means[:, None] + np.einsum("nij,pj->npi", roots, grid), weights


def points_of_outcome(
    means: np.ndarray, covs: np.ndarray, probability: Callable[[np.ndarray], np.ndarray], jumps: bool, unscented: Points
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, P, d) of the numbers on which a chance depends, and their weights (n, P), given what came of it.

    Normals that have taken in an outcome have the first two moments of what it left, and not its shape: past a jump nearly nothing is
    left. So the normal is sought from which the outcome leads to these moments, and weighed by the outcome.

    Parameters
    ----------
    means, covs : float arrays
        (n, d) and (n, d, d).
    probability : callable
        Of each one's outcome at points (n, P, d), (n, P).
    jumps, unscented
        As of `points_of`.
    """
    d = means.shape[1]
    if not (covs > LEAST_VARIANCE).any():  # all of them were read
        return means[:, None], np.ones((len(means), 1))
    told = np.linalg.eigvalsh(covs).min(axis=1) > LEAST_VARIANCE
    centre, spread = means.copy(), covs.copy()
    if not told.any() or (d not in NODES):
        points, shares = points_of(centre, spread, jumps, unscented)
        return points, np.broadcast_to(shares, points.shape[:2])
    safe = np.where(told[:, None, None], covs, np.eye(d))
    wanted = np.linalg.inv(safe)
    aimed = np.einsum("nij,nj->ni", wanted, means)
    precision, shift = wanted.copy(), aimed.copy()
    near = np.zeros(len(means), bool)
    for turn in range(ROUNDS + 1):
        points, shares = points_of(centre, spread, jumps, unscented)
        weights = probability(points) * shares
        total = weights.sum(axis=1)
        weights = weights / np.maximum(total, TINY)[:, None]
        mean = np.einsum("np,npi->ni", weights, points)
        off = points - mean[:, None]
        cov = np.einsum("np,npi,npj->nij", weights, off, off)
        away = np.einsum("ni,nij,nj->n", mean - means, wanted, mean - means) + ((cov @ wanted - np.eye(d)) ** 2).sum(axis=(1, 2))
        near = told & (total > TINY) & (away < CLOSE)
        if turn == ROUNDS or near[told].all():
            break
        left = np.linalg.inv(np.where((told & (np.linalg.eigvalsh(cov).min(axis=1) > LEAST_VARIANCE))[:, None, None], cov, safe))
        more = 0.5 * (precision + wanted - (left - precision))
        moved = 0.5 * (shift + aimed - (np.einsum("nij,nj->ni", left, mean) - shift))
        good = told & (np.linalg.eigvalsh(more).min(axis=1) > 1e-3 * np.linalg.eigvalsh(wanted).min(axis=1))
        precision, shift = np.where(good[:, None, None], more, precision), np.where(good[:, None], moved, shift)
        spread = np.where(told[:, None, None], np.linalg.inv(precision), covs)
        centre = np.where(told[:, None], np.einsum("nij,nj->ni", spread, shift), means)
    plain, shares = points_of(means, covs, jumps, unscented)
    return np.where(near[:, None, None], points, plain), np.where(near[:, None], weights, shares)
