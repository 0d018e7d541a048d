"""What a model believes, appended to the observation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import gymnasium
import numpy as np
from gymnasium import spaces

from ..errors import ParameterError


class Belief(Protocol):
    """Filters the observations of one agent: any probabilistic model will do.

    Attributes
    ----------
    size : int
        Numbers of one posterior.
    """

    size: int

    def reset(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """The posterior after the first observation of an episode, (size,), entries in [0, 1]."""

    def update(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """The posterior after one more observation, (size,)."""


class BeliefObservation(gymnasium.Wrapper[Any, Any, Any, Any]):
    """The observation with a part ``belief``: the posteriors of a model that is filtered alongside.

    Parameters
    ----------
    env : gymnasium.Env
        With Dict observations.
    belief : Belief
        The filter; `FilterBelief` makes one of a model's filter.

    Raises
    ------
    ParameterError
        For an environment with other observations, or one that has a part ``belief`` already.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], belief: Belief) -> None:
        super().__init__(env)
        if not isinstance(env.observation_space, spaces.Dict):
            raise ParameterError(f"BeliefObservation: needs Dict observations; this environment has {env.observation_space}")
        if "belief" in env.observation_space.spaces:
            raise ParameterError("BeliefObservation: the observation has a part 'belief' already")
        self.belief = belief
        parts = {**env.observation_space.spaces, "belief": spaces.Box(0.0, 1.0, (belief.size,), np.float32)}
        self.observation_space = spaces.Dict(parts)

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode; the belief begins with the first observation."""
        observation, info = self.env.reset(**kwargs)
        return self._with(observation, self.belief.reset(observation)), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play one cycle and filter its observation."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._with(observation, self.belief.update(observation)), reward, terminated, truncated, info

    def _with(self, observation: dict[str, np.ndarray], posterior: np.ndarray) -> dict[str, np.ndarray]:
        posterior = np.asarray(posterior, np.float32)
        if posterior.shape != (self.belief.size,):
            raise ParameterError(f"belief: gave shape {posterior.shape}, promised ({self.belief.size},)")
        return {**observation, "belief": np.clip(posterior, 0.0, 1.0)}


class FilterBelief:
    """A `Belief` from the filter of a probabilistic relational model (`cprm_gym.architecture.prm.inference.filter.Filter` of one agent).

    Parameters
    ----------
    filter : object
        With ``reset()`` and ``step(evidence)``, whose result maps a variable to its posterior, (1, states).
    variables : mapping of str to int
        Variables whose posteriors are given, and their numbers of states.
    read : callable
        ``read(observation) -> evidence``: what an observation says in the model's terms.
    """

    def __init__(self, filter: Any, variables: Mapping[str, int], read: Callable[[Mapping[str, np.ndarray]], Mapping[str, Any]]) -> None:
        self.filter, self.read = filter, read
        self.variables = dict(variables)
        self.size = sum(self.variables.values())

    def reset(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """Forget, then take in the first observation."""
        self.filter.reset()
        return self.update(observation)

    def update(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """Take in one observation."""
        result = self.filter.step(self.read(observation))
        return np.concatenate([np.ravel(result[name]) for name in self.variables])
