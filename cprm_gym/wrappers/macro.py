"""Macro actions that last: semi-Markov decisions."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from ..errors import ParameterError

ONE_CYCLE = ("noop", "catch", "shoot")
"""Macros that are over after one cycle, as are the passes."""


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
        macros = getattr(getattr(env.unwrapped, "core", None), "macros", None)
        if macros is None:
            raise ParameterError(f"MacroSteps: needs an environment with action_mode='macro'; this one has {env.action_space}")
        if longest < 1:
            raise ParameterError(f"MacroSteps: longest is {longest!r}; allowed is 1 and more")
        self.names: tuple[str, ...] = macros.names
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
            name = self.names[int(action)]
            over = name in ONE_CYCLE or name.startswith("pass_") or not mask[int(action)] or mask[self._ball] != with_ball
            if terminated or truncated or over or k >= self.longest:
                break
        return observation, total, terminated, truncated, {**info, **terms, "macro_steps": k}
