"""What a window tells of the parameters of CPDs with real numbers: expected statistics of residuals, and CPDs fitted to them.

Of a `Noise` an offset of its mean and a scale of its deviation are learned, for each state on which a `Switch` turns, of a `Chance` an
offset and a scale of its log-odds (`chance_learning`); of tables their rows.
The statistics are expectations under the belief of a whole path, exact where everything is a straight line with normal noise.

References
----------
Shumway and Stoffer 1982; Ghahramani and Hinton 1996; Dempster, Laird and Rubin 1977.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ...grounding.slices import PREVIOUS, STATIC, GroundCPD
from ...model.cpds import CPD, Chance, Noise, Prior, Switch
from ...model.densities import CHANCE, NORMAL, Density, Leaf
from ...model.domains import is_continuous
from ...model.resolved import Rule
from .. import smoothing
from ..continuous.belief import MixtureBelief
from .chance_learning import JUMPS, SUMS, chance_sums, points_of_outcome, tilt_of, tilted

STATISTICS = 4
"""Of each row of a density: how often, and the sums of precision, precision times residual, and precision times its square."""
LEAST = 1e-12
"""Share of a deviation that is left at least."""


def kept_name(window: Sequence[smoothing.Slice], t: int, name: str) -> str:
    """What a variable of slice t of a window is called in the belief of the whole path."""
    last = t == len(window) - 1
    return name if last or window[t].info.static[window[t].info.row[name]] else f"{name}#{t}"


def expected_statistics(belief: MixtureBelief, window: Sequence[smoothing.Slice]) -> dict[Hashable, np.ndarray]:
    """Of every class-level CPD: counts of a table; of a density (rows, `STATISTICS`), or where its child has states (rows, `SUMS` and how
    often each state was). Readings that were not made tell nothing.

    Parameters
    ----------
    belief : MixtureBelief
        Of the whole path (`MixtureEngine.path`).
    window : sequence of Slice
    """
    found: dict[Hashable, np.ndarray] = {}
    for t in range(len(window)):
        ahead = window[t + 1].info.slice.cpds if t + 1 < len(window) else ()
        needed = {p for c in window[t].info.slice.cpds for p, lag in c.parents if lag != PREVIOUS}
        needed |= {p for c in ahead for p, lag in c.parents if lag == PREVIOUS}
        for cpd in window[t].info.slice.cpds:
            table = _Family(belief, window, t, cpd, cpd.child not in needed).statistics()
            if table is not None:
                found[cpd.key] = found[cpd.key] + table if cpd.key in found else table
    return found


class _Family:
    """A CPD of one slice with the belief of the path about its variables."""

    def __init__(self, belief: MixtureBelief, window: Sequence[smoothing.Slice], t: int, cpd: GroundCPD, leaf: bool) -> None:
        self.window, self.t, self.cpd = window, t, cpd
        self.part, self.weights, self.states, self.means, self.covs = belief.part(kept_name(window, t, cpd.child))
        info, readings = window[t].info, window[t].readings
        if leaf:
            seen = (readings.hard[info.row[cpd.child]] >= 0) | (cpd.child in readings.soft)
            self.weights = self.weights * seen[:, None]

    def statistics(self) -> np.ndarray | None:
        """Counts or sums; None of what cannot be learned."""
        density = self.cpd.density
        if density is None:
            table = np.zeros(self.cpd.table.shape)
            index = (*(self._state(k) for k in range(len(self.cpd.parents))), self._state(-1))
            there = self.weights > 0.0
            np.add.at(table, tuple(np.broadcast_to(i, there.shape)[there] for i in index), self.weights[there])
            return table
        rows = np.zeros(self.weights.shape, np.int64)
        for k in density.switches:
            rows = rows * len(density.parents[k]) + self._state(k)
        numbers = is_continuous(density.child)
        table = np.zeros((len(density.rows), STATISTICS if numbers else SUMS + len(density.child)))
        for r, row in enumerate(density.rows):
            there = (rows == r) & (self.weights > 0.0)
            if len(row) != 1 or not there.any():
                continue
            if not numbers:
                table[r] = self._chances(density, row[0][1], there)
            elif row[0][1].kind == NORMAL:
                table[r] = self._sums(row[0][1], there)
        return table

    def _where(self, k: int) -> tuple[str, int]:
        """Name of parent k (-1: the child), and its slice."""
        if k < 0:
            return self.cpd.child, self.t
        name, lag = self.cpd.parents[k]
        return name, (self.t - 1 if lag == PREVIOUS else 0 if lag == STATIC else self.t)

    def _given(self, k: int) -> bool:
        name, t = self._where(k)
        return t >= 0 and bool(self.window[t].info.given[self.window[t].info.row[name]])

    def _kept(self, k: int) -> str:
        name, t = self._where(k)
        return f"{name}#{t}" if t < 0 else kept_name(self.window, t, name)

    def _state(self, k: int) -> np.ndarray:
        """States of parent k (-1: the child), (W, K) or (W, 1)."""
        name, t = self._where(k)
        if self._given(k):
            return self.window[t].readings.hard[self.window[t].info.row[name]][:, None]
        return np.maximum(self.states[:, :, self.part.slots.index(self._kept(k))], 0)

    def _sums(self, leaf: Leaf, there: np.ndarray) -> np.ndarray:
        """The sums of a normal, by unscented points of the columns on which it depends; exact for straight lines."""
        density = self.cpd.density
        assert density is not None
        assert leaf.formula is not None
        assert leaf.deviation is not None
        numbers = {n: k for n, k in leaf.inputs.items() if is_continuous(density.parents[k]) and not self._given(k)}
        columns = list(dict.fromkeys([self._kept(-1), *(self._kept(k) for k in numbers.values())]))
        at = [self.part.columns.index(c) for c in columns]
        means, covs = self.means[there][:, at], self.covs[there][:, at][:, :, at]
        points, shares = unscented(means, covs)
        values = {n: points[:, :, columns.index(self._kept(k))].ravel() for n, k in numbers.items()}
        shape = points.shape[:2]
        for name, k in leaf.inputs.items():
            if name not in numbers:
                told = np.broadcast_to(self._number(k), there.shape)[there]
                values[name] = np.broadcast_to(told[:, None], shape).ravel()
        centre = leaf.formula(values, points[:, :, 0].size).reshape(shape)
        sd = leaf.deviation(values, points[:, :, 0].size).reshape(shape)
        if not (sd > 0.0).all():
            return np.zeros(STATISTICS)  # what is known for certain has no noise to be learned
        away = points[:, :, 0] - centre
        period = getattr(density.child, "period", 0.0)
        if period:
            away = np.mod(away + 0.5 * period, period) - 0.5 * period
        weight = self.weights[there][:, None] * shares
        return np.array([weight.sum(), *((weight * away**power / sd**2).sum() for power in range(3))])

    def _chances(self, density: Density, leaf: Leaf, there: np.ndarray) -> np.ndarray:
        """The sums of a chance, and how often each state was; the chance by points of the numbers on which it depends."""
        states = np.broadcast_to(self._state(-1), there.shape)[there]
        weights = self.weights[there]
        counts = np.bincount(states, weights, len(density.child))
        if leaf.kind != CHANCE:
            return np.array([*[0.0] * SUMS, *counts])
        formula = leaf.formula
        assert formula is not None
        numbers = {n: k for n, k in leaf.inputs.items() if is_continuous(density.parents[k]) and not self._given(k)}
        columns = list(dict.fromkeys(self._kept(k) for k in numbers.values()))
        at = [self.part.columns.index(c) for c in columns]
        jumps = any(node.op in JUMPS for node in formula.node.walk())
        floor, holds = leaf.values[0], (states == 1)[:, None]
        told = {
            name: np.broadcast_to(self._number(k), there.shape)[there][:, None] for name, k in leaf.inputs.items() if name not in numbers
        }

        def chance(points: np.ndarray) -> np.ndarray:
            values = {n: points[:, :, columns.index(self._kept(k))].ravel() for n, k in numbers.items()}
            values |= {n: np.broadcast_to(v, points.shape[:2]).ravel() for n, v in told.items()}
            found = formula(values, points.shape[0] * points.shape[1]).reshape(points.shape[:2])
            return np.asarray(found * (1.0 - floor) + 0.5 * floor)

        def outcome(points: np.ndarray) -> np.ndarray:
            p = chance(points)
            return np.where(holds, p, 1.0 - p)

        means, covs = self.means[there][:, at], self.covs[there][:, at][:, :, at]
        points, shares = points_of_outcome(means, covs, outcome, jumps, unscented)
        return np.array([*chance_sums(chance(points), holds, weights[:, None] * shares), *counts])

    def _number(self, k: int) -> np.ndarray:
        """Value in formulas of a parent that is no column, (W, K) or (W, 1)."""
        name, t = self._where(k)
        info, readings = self.window[max(t, 0)].info, self.window[max(t, 0)].readings
        variable = info.variables[name]
        if variable.quantity is not None:
            return np.asarray(readings.numbers[name].low[:, None])
        states = self._state(k)
        return states if variable.edges is None else (0.5 * (variable.edges[1:] + variable.edges[:-1]))[states]


def unscented(means: np.ndarray, covs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2 d + 1, d) with these means (n, d) and covariances (n, d, d), and their weights (2 d + 1,)."""
    d = means.shape[1]
    kappa = max(3.0 - d, 0.0)
    values, vectors = np.linalg.eigh(covs)
    away = np.sqrt((d + kappa) * np.maximum(values, 0.0))[:, None, :] * vectors
    away = np.swapaxes(away, 1, 2)
    points = means[:, None] + np.concatenate([np.zeros((len(means), 1, d)), away, -away], axis=1)
    return points, np.array([kappa, *[0.5] * (2 * d)]) / (d + kappa)


def refitted(rule: Rule, sums: np.ndarray, prior: float) -> CPD | None:
    """The CPD with offsets and scales that fit the statistics best; None where nothing can be learned.

    Parameters
    ----------
    rule : Rule
        With a density.
    sums : (rows, n) float array
        Of `expected_statistics`.
    prior : float
        Readings that there were besides, without offset and of scale 1, and of every state so many.
    """
    density = rule.density
    assert density is not None
    nodes: dict[tuple[int, ...], np.ndarray] = {}
    names = [slot.text for slot in rule.parents]
    for r, states in enumerate(product(*(range(len(density.parents[k])) for k in density.switches))):
        at = {names[k]: density.parents[k].states[s] for k, s in zip(density.switches, states)}
        path, node = chosen_case(rule.cpd, at)
        if isinstance(node, Noise if is_continuous(density.child) else Chance | Prior):
            nodes[path] = nodes.get(path, np.zeros(sums.shape[1])) + sums[r]
    often = slice(0, 1) if is_continuous(density.child) else slice(SUMS, None)
    learned = {path: found for path, found in nodes.items() if found[often].sum() > 0.0}
    return _replaced(rule.cpd, learned, prior, ()) if learned else None


def chosen_case(cpd: CPD, states: Mapping[str, str]) -> tuple[tuple[int, ...], CPD]:
    """What switches lead to in these states of their parents, and by which cases."""
    path: tuple[int, ...] = ()
    while isinstance(cpd, Switch):
        state = states[cpd.parent]
        k = next(i for i, (s, _) in enumerate(cpd.cases) if s in (state, "*"))
        path, cpd = (*path, k), cpd.cases[k][1]
    return path, cpd


def _replaced(cpd: CPD, learned: Mapping[tuple[int, ...], np.ndarray], prior: float, path: tuple[int, ...]) -> CPD:
    if isinstance(cpd, Switch):
        return Switch(cpd.parent, [(s, _replaced(c, learned, prior, (*path, k))) for k, (s, c) in enumerate(cpd.cases)])
    if path not in learned:
        return cpd
    if isinstance(cpd, Prior):
        pseudo = learned[path][SUMS:] + prior
        return Prior(tuple(float(p) for p in pseudo / pseudo.sum()))
    if isinstance(cpd, Chance):
        return tilted(cpd, *tilt_of(learned[path][:SUMS], float(learned[path][SUMS:].sum()), prior))
    assert isinstance(cpd, Noise)
    count, precision, first, second = learned[path]
    offset = first / (precision * (1.0 + prior / count))
    rest = second - 2.0 * offset * first + offset**2 * precision
    scale = np.sqrt(max((rest + prior) / (count + prior), LEAST**2))
    return replace(cpd, mean=moved(cpd.mean, float(offset)), sd=scaled(cpd.sd, float(scale)))


NUMBER = r"[0-9][0-9.e+-]*"


def moved(mean: str, offset: float) -> str:
    """The text of a mean with an offset; one that it has already is added to."""
    try:
        return repr(float(mean) + offset)
    except ValueError:
        pass
    found = re.fullmatch(rf"\((?P<base>.*)\) (?P<sign>[+-]) (?P<number>{NUMBER})", mean)
    if found and _balanced(found["base"]):
        mean, offset = found["base"], offset + float(found["sign"] + found["number"])
    return f"({mean}) {'-' if offset < 0.0 else '+'} {abs(offset)!r}"


def scaled(sd: Any, scale: float) -> Any:
    """A deviation, number or text, times a scale; one that it has already is multiplied."""
    try:
        return float(sd) * scale
    except ValueError:
        pass
    found = re.fullmatch(rf"(?P<number>{NUMBER}) \* \((?P<base>.*)\)", sd)
    if found and _balanced(found["base"]):
        sd, scale = found["base"], scale * float(found["number"])
    return f"{scale!r} * ({sd})"


def _balanced(text: str) -> bool:
    """Whether no bracket closes that the text has not opened."""
    depth = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        if depth < 0:
            return False
    return depth == 0
