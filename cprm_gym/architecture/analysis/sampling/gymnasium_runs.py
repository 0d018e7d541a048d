"""Episodes of any Gymnasium environment as runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError, UnknownName, did_you_mean
from .runs import UNFINISHED, Run

Policy = Callable[[Any, np.random.Generator], Any]
"""Observation and a generator of the episode's own -> action."""


def succeeded(info: Mapping[str, Any], terminated: bool, truncated: bool, total: float) -> str:
    """The usual outcome: ``info["is_success"]`` where there is one, else whether the episode terminated before it was cut off."""
    if "is_success" in info:
        return "success" if info["is_success"] else "failure"
    return "terminated" if terminated else "truncated"


def usual_signals(observation: Any, reward: float, info: Mapping[str, Any]) -> dict[str, float]:
    """``reward``, the numbers of a flat observation as ``obs.o0``, ``obs.o1`` ..., and the numbers in the info as ``info.name``."""
    flat = np.asarray(observation, float).ravel() if not isinstance(observation, (dict, tuple)) else np.zeros(0)
    out = {"reward": float(reward), **{f"obs.o{i}": float(x) for i, x in enumerate(flat)}}
    return {**out, **{f"info.{k}": float(v) for k, v in info.items() if isinstance(v, (int, float, np.number, np.bool_))}}


@dataclass(frozen=True)
class GymnasiumRuns:
    """Episodes of a registered environment under a policy; each carries its ``return``.

    Parameters
    ----------
    env : str
        Its id.
    policy : callable, optional
        Default: actions at random.
    outcomes : sequence of str
        All that `outcome` may say; `UNFINISHED` comes with them.
    outcome : callable
        From the last info, terminated, truncated and the sum of rewards.
    limit : int
        Steps after which an episode is cut off.
    options : mapping
        For ``gymnasium.make``.
    signals : callable
        From observation, reward and info, the numbers that properties read.
    discount : float
        Of the return: that of cycle t counts ``discount ** t``.

    Raises
    ------
    UnknownName, ModelError
        For an environment that there is not, or that cannot be made; a limit or discount that makes no sense.
    """

    env: str
    policy: Policy | None = None
    outcomes: Sequence[str] = ("success", "failure", "terminated", "truncated", UNFINISHED)
    outcome: Callable[[Mapping[str, Any], bool, bool, float], str] = succeeded
    limit: int = 10_000
    options: Mapping[str, Any] = field(default_factory=dict)
    signals: Callable[[Any, float, Mapping[str, Any]], dict[str, float]] = usual_signals
    discount: float = 1.0

    def __post_init__(self) -> None:
        if self.limit < 1 or not 0.0 <= self.discount <= 1.0:
            raise ModelError(f"limit {self.limit}, discount {self.discount}: needs a cycle, and a number from 0 to 1")
        if ":" in self.env:
            return  # the module before it is imported when the environment is made
        try:
            gymnasium.spec(self.env)
        except gymnasium.error.Error:
            raise _unknown(self.env) from None

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        """The episodes with the given numbers."""
        try:
            env = gymnasium.make(self.env, **self.options)
        except (gymnasium.error.Error, TypeError, ModuleNotFoundError) as error:
            raise ModelError(f"environment {self.env!r} with the options {dict(self.options)}: {error}") from None
        try:
            return [self._episode(env, number, seed, signals) for number in numbers]
        finally:
            env.close()

    def _episode(self, env: Any, number: int, seed: int, signals: bool) -> Run:
        sequence = np.random.SeedSequence(seed, spawn_key=(number,))
        rng = np.random.default_rng(sequence)
        first, second = (int(word) for word in sequence.generate_state(2))
        env.action_space.seed(second)
        observation, info = env.reset(seed=first)
        rows = [self.signals(observation, 0.0, info)] if signals else []
        total, discounted, factor = 0.0, 0.0, 1.0
        cycles, terminated, truncated = 0, False, False
        while not (terminated or truncated) and cycles < self.limit:
            action = env.action_space.sample() if self.policy is None else self.policy(observation, rng)
            observation, reward, terminated, truncated, info = env.step(action)
            total += float(reward)
            discounted += factor * float(reward)
            factor *= self.discount
            cycles += 1
            if signals:
                rows.append(self.signals(observation, float(reward), info))
        what = self.outcome(info, terminated, truncated, total) if terminated or truncated else UNFINISHED
        columns: dict[str, NDArray[np.float64]] = {}
        if rows:
            columns = {name: np.array([row.get(name, 0.0) for row in rows]) for name in rows[-1]}
        return Run(what, cycles, columns, {"return": discounted})


def _unknown(env: str) -> UnknownName:
    """The error for an id that is not registered, with the nearest that is."""
    wanted = env.rpartition("-v")[0] or env
    named = [name for name in gymnasium.registry if name.rpartition("-v")[0] == wanted]
    if named:
        return UnknownName(f"unknown environment {env!r}. Registered: {', '.join(named)}")
    return UnknownName(f"unknown environment {env!r}.{did_you_mean(env, gymnasium.registry)} Is the module that registers it imported?")
