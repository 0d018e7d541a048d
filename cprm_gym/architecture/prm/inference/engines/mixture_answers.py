"""What a step of a Gaussian engine answers, now and looking back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cprm_gym.errors import ModelError, did_you_mean

from .. import smoothing
from ..compiled.slice_info import SliceInfo
from ..continuous.belief import MixtureBelief
from ..continuous.normal_mixture import NormalMixture
from ..evidence import Readings, one_hot
from ..factors import Factor
from .engine import StepResult
from .noise_learning import kept_name


@dataclass
class MixtureResult(StepResult):
    """What one step gave.

    Attributes
    ----------
    belief : MixtureBelief
    again : callable
        Makes the step again and keeps some variables besides.
    """

    belief: Any
    info: SliceInfo
    readings: Readings
    status: np.ndarray
    increment: np.ndarray
    loss: np.ndarray
    again: Callable[[frozenset[str]], MixtureBelief]
    engine: str = "mixture"
    exact: bool = False
    report: dict[str, Any] = field(default_factory=dict)

    def marginal(self, name: str) -> Any:
        """P(variable | all readings so far): (W, card) of states, a `NormalMixture` of a number."""
        variable, row = self.info.variables[name], self.info.row[name]
        seen = self.readings.hard[row]
        if variable.quantity is not None and name in self.readings.numbers and (seen >= 0).all():
            low, high = self.readings.numbers[name]
            if (low == high).all() or self.info.given[row]:
                return NormalMixture(np.ones((len(low), 1)), low[:, None], np.zeros((len(low), 1)), variable.quantity.period)
        belief = self.belief_with(name)
        if variable.quantity is not None:
            return belief.number(name, variable.quantity.period)
        if (seen >= 0).all():
            return one_hot(seen, variable.card)
        return belief.states((name,), (variable.card,))

    def belief_with(self, name: str) -> MixtureBelief:
        """The belief, with a variable in it that is there to be read only."""
        belief: MixtureBelief = self.belief
        known = self.info.given[self.info.row[name]] or belief.find(name)[0] >= 0
        return belief if known else self.again(frozenset({name}))

    def joint(self, names: Sequence[str]) -> np.ndarray:
        for name in names:
            if name not in self.info.row:
                raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, self.info.names)}")
            if self.info.variables[name].quantity is not None:
                raise ModelError(f"{name!r} is a real number and has no table; `moments` gives means and covariances")
        if len(set(names)) != len(names):
            raise ModelError(f"a variable is named twice in {tuple(names)}")
        belief = self.belief if all(self.belief.find(n)[0] >= 0 for n in names) else self.again(frozenset(names))
        out = np.ones((self.batch,) + (1,) * len(names))
        parts: dict[tuple[int, int], list[str]] = {}
        for name in names:
            parts.setdefault(belief.find(name), []).append(name)
        for place, inside in parts.items():
            cards = [self.info.variables[n].card for n in inside]
            table = belief.states(inside, cards) if place[0] >= 0 else one_hot(self.readings.hard[self.info.row[inside[0]]], cards[0])
            if place[0] < 0:
                for name, card in zip(inside[1:], cards[1:]):
                    table = table[..., None] * one_hot(self.readings.hard[self.info.row[name]], card).reshape(
                        len(table), *(1,) * (table.ndim - 1), card
                    )
            order = sorted(range(len(inside)), key=lambda k: names.index(inside[k]))
            table = np.transpose(table, [0, *(k + 1 for k in order)])
            shape = [len(table), *(self.info.variables[n].card if n in inside else 1 for n in names)]
            out = out * table.reshape(shape)
        return np.asarray(out)

    def moments(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Mean (W, n) and covariance (W, n, n) of some numbers; an angle about its mean direction."""
        for name in names:
            if name not in self.info.row or self.info.variables[name].quantity is None:
                raise ModelError(f"moments are of real numbers of the slice, got {name!r}.{did_you_mean(name, self.info.names)}")
        belief = self.belief if all(self.belief.find(n)[0] >= 0 for n in names) else self.again(frozenset(names))
        marginals = [self.marginal(n) for n in names]
        mean = np.stack([m.expectation() for m in marginals], axis=1)
        cov = np.zeros((self.batch, len(names), len(names)))
        places = [belief.find(n) for n in names]
        for place in set(places):
            inside = [k for k, p in enumerate(places) if p == place]
            if place[0] < 0:
                continue
            part, weights, _, means, covs = belief.part(names[inside[0]])
            at = [part.columns.index(names[k]) for k in inside]
            away = np.where(weights[..., None] > 0.0, means[:, :, at] - mean[:, None, inside], 0.0)
            for i, k in enumerate(inside):
                away[..., i] = marginals[k].turned(away[..., i])
            spread = np.where(weights[..., None, None] > 0.0, covs[:, :, at][..., at], 0.0)
            cov[np.ix_(range(self.batch), inside, inside)] = np.einsum(
                "wk,wkij->wij", weights, spread + away[..., :, None] * away[..., None, :]
            )
        return mean, cov

    def components(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Weights (W, K), means (W, K, n) and covariances (W, K, n, n) of the normals over numbers of one part."""
        for name in names:
            if name not in self.info.row or self.info.variables[name].quantity is None:
                raise ModelError(f"normals are over real numbers of the slice, got {name!r}.{did_you_mean(name, self.info.names)}")
        belief = self.belief if all(self.belief.find(n)[0] >= 0 for n in names) else self.again(frozenset(names))
        if len({belief.find(n) for n in names}) != 1:
            raise ModelError(f"{', '.join(names)} do not hang together; ask for each alone")
        part, weights, _, means, covs = belief.part(names[0])
        at = [part.columns.index(n) for n in names]
        there = weights > 0.0
        return weights, np.where(there[..., None], means[:, :, at], 0.0), np.where(there[..., None, None], covs[:, :, at][..., at], 0.0)

    def hidden_factors(self, names: Sequence[str]) -> list[Factor]:
        return [Factor((n,), self.marginal(n)) for n in names]

    def suspects(self, agent: int) -> list[str]:
        hard, info = self.readings.hard, self.info
        dead = {self.info.names[r] for rows in self.report["impossible"].get(agent, ()) for r in rows}
        return [n for n, r in info.row.items() if n in dead and not info.given[r] and (hard[r, agent] >= 0 or n in self.readings.soft)]


class SmoothedNumbers(Mapping[str, Any]):
    """Posteriors of one slice given the whole window: a mapping from variable to (W, card) array or `NormalMixture`."""

    def __init__(self, belief: MixtureBelief, window: Sequence[smoothing.Slice], t: int) -> None:
        self._belief, self._window, self._t = belief, window, t

    def __getitem__(self, name: str) -> Any:
        info, readings = self._window[self._t].info, self._window[self._t].readings
        if name not in info.row:
            raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, info.names)}")
        variable = info.variables[name]
        if info.given[info.row[name]]:
            if variable.quantity is None:
                return one_hot(readings.hard[info.row[name]], variable.card)
            low = readings.numbers[name].low[:, None]
            return NormalMixture(np.ones(low.shape), low, np.zeros(low.shape), variable.quantity.period)
        kept = kept_name(self._window, self._t, name)
        if variable.quantity is not None:
            return self._belief.number(kept, variable.quantity.period)
        return self._belief.states((kept,), (variable.card,))

    def __contains__(self, name: object) -> bool:
        return name in self._window[self._t].info.row

    def __iter__(self) -> Iterator[str]:
        return iter(self._window[self._t].info.names)

    def __len__(self) -> int:
        return len(self._window[self._t].info.names)
