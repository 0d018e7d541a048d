"""Macro actions that last: semi-Markov decisions, of one agent, of one agent in many worlds, of several agents in one world."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from pettingzoo.utils.wrappers import BaseParallelWrapper

from ..envs.soccer_v2 import SoccerParallelEnv
from ..envs.vector import SoccerVectorEnv
from ..errors import ParameterError

ONE_CYCLE = ("noop", "catch", "shoot")
"""Macros that are over after one cycle, as are the passes."""


def at_once(name: str) -> bool:
    """Whether a macro is over after one cycle."""
    return name in ONE_CYCLE or name.startswith("pass_")


def _macros(wrapper: str, env: Any, longest: int) -> tuple[str, ...]:
    """Names of the macros of an environment that has them.

    Raises
    ------
    ParameterError
        Where there are none, or `longest` is below 1.
    """
    macros = getattr(getattr(env, "core", None), "macros", None)
    if macros is None:
        mode = getattr(getattr(env, "options", None), "action_mode", type(env).__name__)
        raise ParameterError(f"{wrapper}: needs an environment of ours with action_mode='macro'; this one has {mode}")
    if longest < 1:
        raise ParameterError(f"{wrapper}: longest is {longest!r}; allowed is 1 and more")
    return tuple(macros.names)


class MacroSteps(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Each step carries a macro on until it ends; the reward is the sum over its cycles.

    A macro ends when the episode does, when it cannot be done any more (its mask is 0), when another kind of decision becomes possible
    (the player gets or loses the ball), or after `longest` cycles. ``info["macro_steps"]`` is its length k: discount with gamma ** k.

    Parameters
    ----------
    env : gymnasium.Env
        With ``action_mode="macro"``.
    longest : int
        Cycles after which the agent decides anew in any case.
    gamma : float
        Discounts the cycles within a macro; 1 sums them.

    Raises
    ------
    ParameterError
        For another action mode, or `longest` below 1.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], longest: int = 10, gamma: float = 1.0) -> None:
        super().__init__(env)
        self.names: tuple[str, ...] = _macros("MacroSteps", env.unwrapped, longest)
        self.longest, self.gamma = longest, gamma
        self._ball = self.names.index("hold")
        self._mask = np.ones(len(self.names), np.int8)

    def action_masks(self) -> np.ndarray:
        """What can be done now, (macros,) bool: the method that MaskablePPO calls."""
        return self._mask.astype(bool)

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**kwargs)
        self._mask = info["action_mask"]
        return observation, {**info, "macro_steps": 0}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry a macro on until it ends."""
        total, factor = 0.0, 1.0
        terms: dict[str, float] = {}
        with_ball = self._mask[self._ball]
        k = 0
        while True:
            observation, reward, terminated, truncated, info = self.env.step(action)
            total += factor * float(reward)
            for name, value in info.items():
                if name.startswith("reward_"):
                    terms[name] = terms.get(name, 0.0) + factor * value
            factor *= self.gamma
            k += 1
            self._mask = mask = info["action_mask"]
            over = at_once(self.names[int(action)]) or not mask[int(action)] or mask[self._ball] != with_ball
            if terminated or truncated or over or k >= self.longest:
                break
        return observation, total, terminated, truncated, {**info, **terms, "macro_steps": k}


class VectorMacroSteps(gymnasium.vector.VectorWrapper[Any, Any, Any, Any, Any]):
    """`MacroSteps` in many worlds: each step carries on the macro of each world until it ends, and no further.

    Worlds whose macros end early wait for the others: they are played on with them, and set back to where their macro ended. World k is bit
    for bit what it is alone. ``info["macro_steps"]``: (W,) lengths, 0 for a world that has just begun anew.

    Parameters
    ----------
    env : SoccerVectorEnv
        With ``action_mode="macro"``, and next-step or same-step autoreset.
    longest, gamma
        As for `MacroSteps`.

    Raises
    ------
    ParameterError
        For another environment, another autoreset mode, or `longest` below 1.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv[Any, Any, Any], longest: int = 10, gamma: float = 1.0) -> None:
        super().__init__(env)
        inner = env.unwrapped
        self.names: tuple[str, ...] = _macros("VectorMacroSteps", inner, longest)
        if not isinstance(inner, SoccerVectorEnv) or inner.autoreset_mode == AutoresetMode.DISABLED:
            raise ParameterError("VectorMacroSteps: needs a SoccerVectorEnv whose autoreset_mode is NextStep or SameStep")
        self.longest, self.gamma = longest, gamma
        self._inner = inner
        self._ball = self.names.index("hold")
        self._at_once = np.array([at_once(name) for name in self.names])
        self._mask = np.ones((inner.num_envs, len(self.names)), bool)
        self._over = np.zeros(inner.num_envs, bool)

    def action_masks(self) -> np.ndarray:
        """What can be done now, (W, macros) bool."""
        return self._mask.copy()

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start episodes."""
        observation, info = self.env.reset(**kwargs)
        self._mask = info["action_mask"].astype(bool)
        self._over[:] = False
        return observation, {**info, "macro_steps": np.zeros(self._inner.num_envs, np.int64)}

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Carry each world's macro on until it ends."""
        count, inner = self._inner.num_envs, self._inner
        chosen = np.asarray(actions)
        rows = np.arange(count)
        running, with_ball = np.ones(count, bool), self._mask[:, self._ball].copy()
        total, steps, factor = np.zeros(count), np.zeros(count, np.int64), 1.0
        ended_of, late_of = np.zeros(count, bool), np.zeros(count, bool)
        told: dict[str, Any] = {}
        terms: dict[str, np.ndarray] = {}
        kept: dict[str, np.ndarray] = {}
        while True:
            _, reward, terminated, truncated, info = self.env.step(actions)
            steps[running & ~self._over] += 1
            total[running] += factor * reward[running]
            for name, value in info.items():
                if name.startswith("reward_"):
                    terms.setdefault(name, np.zeros(count))[running] += factor * value[running]
            factor *= self.gamma
            mask = info["action_mask"].astype(bool)
            over = terminated | truncated | self._over | self._at_once[chosen] | ~mask[rows, chosen] | (mask[:, self._ball] != with_ball)
            ended = running & (over | (steps >= self.longest))
            _merge(told, info, ended, count)
            ended_of[ended], late_of[ended] = terminated[ended], truncated[ended]
            self._mask[ended] = mask[ended]
            running &= ~ended
            if not running.any():
                break
            if ended.any():
                now = inner.save_state()
                if not kept:
                    kept = now
                else:
                    for name, values in now.items():
                        kept[name][ended] = values[ended]
        early = np.flatnonzero(~ended) if kept else np.zeros(0, np.int64)
        if len(early):
            inner.core.load_state(kept, early)
            inner._over[early] = kept["over"][early]
        self._over = inner._over.copy()
        return inner._observation(), total, ended_of, late_of, {**told, **terms, "macro_steps": steps, "_macro_steps": np.ones(count, bool)}


def _merge(into: dict[str, Any], info: dict[str, Any], worlds: np.ndarray, count: int) -> None:
    """Take over what an info says of some worlds, (W,) bool; nested infos too."""
    for name, value in info.items():
        if isinstance(value, dict):
            _merge(into.setdefault(name, {}), value, worlds, count)
        else:
            if name not in into:
                into[name] = np.zeros_like(value) if value.dtype != object else np.full(value.shape, None, object)
            into[name][worlds] = value[worlds]


class ParallelMacroSteps(BaseParallelWrapper[str, Any, Any]):  # type: ignore[misc]
    """Macros of several agents that last: a step goes on until the macro of one of them ends.

    Who is in the middle of a macro carries it on, whatever action is given for him: his ``info["action_mask"]`` allows that macro alone,
    and ``info["decides"]`` is 0. Rewards are summed over the cycles of the step, ``info["macro_steps"]`` is their number k: discount with
    ``gamma ** k``.

    Parameters
    ----------
    env : SoccerParallelEnv
        With ``action_mode="macro"``.
    longest, gamma
        As for `MacroSteps`.

    Raises
    ------
    ParameterError
        For another environment, or `longest` below 1.
    """

    def __init__(self, env: SoccerParallelEnv, longest: int = 10, gamma: float = 1.0) -> None:
        super().__init__(env)
        self.names: tuple[str, ...] = _macros("ParallelMacroSteps", env.unwrapped, longest)
        self.longest, self.gamma = longest, gamma
        self._ball = self.names.index("hold")
        self._doing: dict[str, int] = {}
        self._since: dict[str, int] = {}
        self._with_ball: dict[str, int] = {}
        self._masks: dict[str, np.ndarray] = {}

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Start an episode: everybody decides."""
        observations, infos = self.env.reset(seed=seed, options=options)
        self._doing = {}
        self._masks = {agent: info["action_mask"] for agent, info in infos.items()}
        return observations, self._told(infos, 0)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Carry all macros on until one of them ends."""
        total: dict[str, float] = {}
        factor, k = 1.0, 0
        for agent in self.env.agents:
            if agent not in self._doing and agent in actions:
                self._doing[agent], self._since[agent] = actions[agent], 0
                self._with_ball[agent] = self._masks[agent][self._ball]
        while True:
            sent = {agent: self._doing.get(agent, action) for agent, action in actions.items()}
            observations, rewards, terminated, truncated, infos = self.env.step(sent)
            k += 1
            for agent, reward in rewards.items():
                total[agent] = total.get(agent, 0.0) + factor * reward
            factor *= self.gamma
            ended = []
            for agent, info in infos.items():
                mask, macro = info["action_mask"], int(self._doing[agent])
                self._since[agent] += 1
                over = at_once(self.names[macro]) or not mask[macro] or mask[self._ball] != self._with_ball[agent]
                if over or self._since[agent] >= self.longest:
                    ended.append(agent)
            if ended or not self.env.agents:
                break
        self._masks = {agent: info["action_mask"] for agent, info in infos.items()}
        for agent in ended:
            del self._doing[agent]
        return observations, total, terminated, truncated, self._told(infos, k)

    def _told(self, infos: dict[str, dict[str, Any]], k: int) -> dict[str, dict[str, Any]]:
        """The infos of a step of `k` cycles."""
        told = {}
        for agent, info in infos.items():
            mask = info["action_mask"]
            if agent in self._doing:
                mask = np.zeros_like(mask)
                mask[self._doing[agent]] = 1
            told[agent] = {**info, "action_mask": mask, "macro_steps": k, "decides": int(agent not in self._doing)}
        return told
