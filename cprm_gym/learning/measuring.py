"""How good a policy is, in worlds that it did not learn from; and what several seeds say together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import trim_mean

from ..errors import ParameterError
from ..wrappers.sb3 import SoccerVecEnv
from .configuration import Configuration
from .policy import Policy
from .worlds import columns_of, measured_worlds

SECONDS = 0.1
"""Of a cycle."""
RESAMPLES = 2000
"""Bootstrap samples of the seeds."""


class Measured(NamedTuple):
    """Episodes of a policy, the first of each world."""

    success: np.ndarray
    """(n,) bool: of the first agent."""
    cycles: np.ndarray
    """(n,) int."""
    reward: np.ndarray
    """(n,) float: of the first agent, the task's own and what the configuration adds."""

    def figures(self, metric: str) -> np.ndarray:
        """(n,) float: what counts of each episode, 1 for success, or the seconds that it took."""
        return figures(metric, self.success, self.cycles)


def figures(metric: str, success: Sequence[int] | np.ndarray, cycles: Sequence[int] | np.ndarray) -> np.ndarray:
    """(n,) float: of each episode what a task's metric counts, 1 for a success or, of ``duration``, seconds."""
    return SECONDS * np.asarray(cycles, np.float64) if metric == "duration" else np.asarray(success, np.float64)


Choose = Callable[[np.ndarray, "np.ndarray | None"], np.ndarray]
"""Actions of all agents from their observations and what they may choose."""


def measure(policy: Policy, configuration: Configuration, drawn: bool, seed: int, episodes: int | None = None) -> Measured:
    """Play one episode in each of as many worlds.

    Parameters
    ----------
    policy : Policy
    configuration : Configuration
        Of its training.
    drawn : bool
        Draw actions, from a stream of each world; otherwise take the likeliest ones.
    seed : int
        Of the worlds.
    episodes : int, optional
        As many as the configuration says if not given.
    """
    count = configuration.episodes if episodes is None else episodes
    env = measured_worlds(configuration, count, seed)
    agents = env.agents
    given = columns_of(env)
    order = np.array([given.index(name) for name in policy.description.columns])
    streams = [np.random.default_rng([seed, k]) for k in range(count)] if drawn else []
    state = None

    def choose(observation: np.ndarray, mask: np.ndarray | None) -> np.ndarray:
        nonlocal state
        uniform = np.concatenate([s.random((agents, policy.parts)) for s in streams]) if drawn else None
        action, state = policy.act(observation[:, order], mask, uniform, state)
        return action

    def ended(dones: np.ndarray) -> None:
        if state is not None:
            state[:, dones] = 0.0

    return _played(env, configuration, count, choose, ended)


def measure_random(configuration: Configuration, seed: int, episodes: int | None = None) -> Measured:
    """The floor: what is chosen at random, of macros and options among those that can be done.

    Parameters
    ----------
    configuration : Configuration
    seed : int
        Of the worlds and of what is drawn.
    episodes : int, optional
        As many as the configuration says if not given.
    """
    count = configuration.episodes if episodes is None else episodes
    env = measured_worlds(configuration, count, seed)
    space = env.action_space
    space.seed(seed % 2**31)
    rng = np.random.default_rng([seed, count])

    def choose(observation: np.ndarray, mask: np.ndarray | None) -> np.ndarray:
        if mask is None:
            return np.stack([space.sample() for _ in range(len(observation))])
        chosen: np.ndarray = np.where(mask, rng.random(mask.shape), -1.0).argmax(axis=1)
        return chosen

    return _played(env, configuration, count, choose, lambda dones: None)


def _played(env: SoccerVecEnv, configuration: Configuration, count: int, choose: Choose, ended: Callable[[np.ndarray], None]) -> Measured:
    """The first episode of each world."""
    agents = env.agents
    masks = env.has_attr("action_masks") and configuration.kind.mode in ("macro", "option")
    observation = env.reset()
    success, cycles, reward = np.zeros(count, bool), np.zeros(count, np.int64), np.zeros(count)
    running = np.ones(count, bool)
    while running.any():
        observation, rewards, dones, infos = env.step(choose(observation, env.action_masks() if masks else None))
        ended(dones)
        reward += np.where(running, rewards[::agents], 0.0)
        for w in np.flatnonzero(dones[::agents] & running):
            info = infos[w * agents]
            success[w], cycles[w] = info["is_success"], info["episode"]["l"]
            running[w] = False
    return Measured(success, cycles, reward)


class Together(NamedTuple):
    """What several seeds reached."""

    centre: float
    """Interquartile mean: of the middle half of the seeds."""
    low: float
    high: float
    """Bootstrap interval of 95 %."""


def interquartile_mean(values: Sequence[float], seed: int = 0) -> Together:
    """The interquartile mean over seeds, with a percentile bootstrap interval.

    Parameters
    ----------
    values : sequence of float
        One for each seed.
    seed : int
        Of the bootstrap.

    Raises
    ------
    ParameterError
        When there are none.

    References
    ----------
    Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice, NeurIPS 2021.

    Examples
    --------
    >>> interquartile_mean([0.0, 0.9, 0.9, 1.0, 1.0]).centre
    0.9333333333333332
    """
    given = np.asarray(values, np.float64)
    if given.ndim != 1 or not len(given):
        raise ParameterError(f"interquartile mean: {values!r:.60} given; a number for each of at least 1 seed is needed")
    drawn = given[np.random.default_rng(seed).integers(0, len(given), (RESAMPLES, len(given)))]
    means = trim_mean(drawn, 0.25, axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return Together(float(trim_mean(given, 0.25)), float(low), float(high))
