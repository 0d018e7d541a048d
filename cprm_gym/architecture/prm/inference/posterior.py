"""What a filter answers, and what it remembers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..grounding.slices import GroundVariable
from .compiled.steps import SliceInfo
from .evidence import Readings


class Past(NamedTuple):
    """What is remembered of a step: the belief before it, the slice, the readings, who began anew and the relations."""

    before: Any
    info: SliceInfo
    readings: Readings
    fresh: np.ndarray
    relations: Any


@dataclass(frozen=True)
class Snapshot:
    """A filter's state, to be given to `Filter.restore`."""

    belief: Any
    step: int
    log_likelihood: np.ndarray
    fresh: np.ndarray
    history: tuple[Past, ...]
    relations: Any
    impossible: np.ndarray
    exact: bool
    static: dict[str, GroundVariable]
    owners: frozenset[str]
    engine: Any


class Result(Mapping[str, np.ndarray]):
    """The answer of one step: a mapping from variable to posterior, shape (W, card).

    Attributes
    ----------
    step : int
        Number of the slice, from 0.
    increment : (W,) float array
        ln P(readings of this slice | earlier ones).
    log_likelihood : (W,) float array
        Sum of the increments. What is given has no prior and no part in it.
    loss : (W,) float array
        Kullback-Leibler divergence, in nats, of what a projection threw away in this step; 0 if nothing was projected.
    exact : bool
        Whether no step so far has approximated anything.
    engine : str
        Which engine gave the answer.
    impossible : (W,) bool array
        Where the readings had probability zero and the policy (drop, soften, restart) was applied.
    report : dict
        What else the engine has to say: effective sample size, clusters, time.
    """

    def __init__(self, outcome: Any, step: int, log_likelihood: np.ndarray, exact: bool, impossible: np.ndarray) -> None:
        self._outcome = outcome
        self._cache: dict[str, np.ndarray] = {}
        self.step = step
        self.increment: np.ndarray = outcome.increment
        self.log_likelihood = log_likelihood
        self.loss: np.ndarray = outcome.loss
        self.exact = exact
        self.engine: str = outcome.engine
        self.impossible = impossible
        self.report: dict[str, Any] = getattr(outcome, "report", {})

    @property
    def variables(self) -> Mapping[str, GroundVariable]:
        """The variables of the slice."""
        return self._outcome.info.variables  # type: ignore[no-any-return]

    def __getitem__(self, name: str) -> np.ndarray:
        found = self._cache.get(name)
        if found is None:
            found = self._cache[name] = self._outcome.marginal(name)
        return found

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    def hidden(self, agent: int = 0) -> tuple[str, ...]:
        """Names of the variables that an agent did not observe."""
        hard = self._outcome.readings.hard
        return tuple(n for i, n in enumerate(self._outcome.info.names) if hard[i, agent] < 0)

    def joint(self, *names: str) -> np.ndarray:
        """Joint posterior of some variables, shape (W, card, card, ...)."""
        found: np.ndarray = self._outcome.joint(names)
        return found

    def index_mean(self, name: str) -> np.ndarray:
        """Expectation of the state index, (W,)."""
        p = self[name]
        return p @ np.arange(p.shape[1])
