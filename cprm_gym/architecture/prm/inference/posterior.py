"""What a step of a filter answers: posteriors by variable, and numbers read from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from ..grounding.slices import GroundSlice, GroundVariable
from .engines.engine import StepResult
from .views import View


class Posterior(Mapping[str, Any]):
    """The answer of one step: a mapping from variable to posterior, shape (W, card), or to a `NormalMixture` for a real number.

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
        No step so far has approximated anything.
    engine : str
        Which engine gave the answer.
    impossible : (W,) bool array
        Where the readings had probability zero and the policy (drop, soften, restart) was applied.
    relations : grounding's own kind
        What held in the slice, for a `Grounding` a `Situation`.
    report : dict
        What else the engine has to say: effective sample size, clusters, time.
    """

    def __init__(
        self,
        result: StepResult,
        step: int,
        log_likelihood: np.ndarray,
        exact: bool,
        impossible: np.ndarray,
        relations: Any,
        places: Mapping[str, str] | None = None,
        ground: Callable[[], GroundSlice] | None = None,
    ) -> None:
        self._result = result
        self._places = places  # what the result calls each object, if it has other names, and the slice with the right ones
        self._ground = ground
        self._cache: dict[str, Any] = {}
        self.step = step
        self.increment = result.increment
        self.log_likelihood = log_likelihood
        self.loss = result.loss
        self.exact = exact
        self.engine = result.engine
        self.impossible = impossible
        self.relations = relations

    @property
    def result(self) -> StepResult:
        """What the engine gave."""
        return self._result

    @property
    def report(self) -> dict[str, Any]:
        """What else the engine has to say."""
        return self._result.report

    @property
    def slice(self) -> GroundSlice:
        """The ground slice."""
        return self._result.info.slice if self._ground is None else self._ground()

    @property
    def variables(self) -> Mapping[str, GroundVariable]:
        """The variables of the slice."""
        return self._result.info.variables

    def __getitem__(self, name: str) -> Any:
        found = self._cache.get(name)
        if found is None:
            found = self._cache[name] = self._result.marginal(self._placed(name))
        return found

    def _placed(self, name: str) -> str:
        """What the result calls a variable."""
        if self._places is None:
            return name
        owner, dot, attribute = name.partition(".")
        return self._places.get(owner, owner) + dot + attribute

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    def hidden(self, agent: int = 0) -> tuple[str, ...]:
        """Names of the variables that an agent did not observe."""
        hard = self._result.readings.hard
        row = self._result.info.row
        return tuple(n for n in self._result.info.names if hard[row[self._placed(n)], agent] < 0)

    def joint(self, *names: str) -> np.ndarray:
        """Joint posterior of some variables, shape (W, card, card, ...)."""
        return self._result.joint(names if self._places is None else tuple(map(self._placed, names)))

    def moments(self, *names: str) -> tuple[np.ndarray, np.ndarray]:
        """Mean (W, n) and covariance (W, n, n) of some real numbers; an angle about its mean direction.

        Raises
        ------
        ModelError
            For variables with states.
        """
        return self._result.moments(tuple(map(self._placed, names)))

    def components(self, *names: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Weights (W, K), means (W, K, n) and covariances (W, K, n, n) of the normals over some real numbers that hang together.

        Raises
        ------
        ModelError
            For variables with states, or numbers that do not hang together.
        """
        return self._result.components(tuple(map(self._placed, names)))

    def index_mean(self, name: str) -> np.ndarray:
        """Expectation of the state index, (W,)."""
        p = self[name]
        return np.asarray(p @ np.arange(p.shape[1]))

    def read(self, variable: str, view: str | View = "expectation") -> np.ndarray:
        """A number from the belief about one variable, for each agent.

        Parameters
        ----------
        variable : str
        view : str or View
            ``"expectation"``, ``"probability(0..2)"``, ...: see `views`.

        Returns
        -------
        (W,) float array

        Raises
        ------
        ModelError
            For an unknown variable, or a view that it does not have.
        """
        made = View.parse(view) if isinstance(view, str) else view
        return made(self[variable], self.variables[variable])

    def read_all(self, places: Mapping[str, tuple[str, str | View]]) -> dict[str, np.ndarray]:
        """The numbers for many places, ``{"near": ("ball.dist", "probability(..2)")}``."""
        return {place: self.read(variable, view) for place, (variable, view) in places.items()}
