"""What became of every episode."""

from __future__ import annotations

from collections import Counter, deque
from typing import Any

import gymnasium

from ..envs.tasks.base import Status


class EpisodeStatistics(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Return, length, status, success and reward terms of every episode, in ``info["episode"]`` of its last step and in `episodes`.

    Parameters
    ----------
    env : gymnasium.Env
    keep : int
        How many of the last episodes are kept.

    Attributes
    ----------
    episodes : deque of dict
        ``r`` return, ``l`` steps, ``cycles`` (with `MacroSteps` more than steps), ``status``, ``is_success``, and the sum of every
        ``reward_<term>``.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], keep: int = 1000) -> None:
        super().__init__(env)
        self.episodes: deque[dict[str, Any]] = deque(maxlen=keep)
        self._begin()

    def _begin(self) -> None:
        self._return, self._steps = 0.0, 0
        self._terms: Counter[str] = Counter()

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        self._begin()
        return self.env.reset(**kwargs)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play on and count."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._return += float(reward)
        self._steps += 1
        for name, value in info.items():
            if name.startswith("reward_"):
                self._terms[name] += value
        if terminated or truncated:
            episode = {
                "r": self._return, "l": self._steps, "cycles": info.get("cycle", self._steps), "status": int(info.get("status", 0)),
                "is_success": bool(info.get("is_success", False)), **self._terms,
            }  # fmt: skip
            self.episodes.append(episode)
            info = {**info, "episode": episode}
        return observation, reward, terminated, truncated, info

    def summary(self) -> dict[str, Any]:
        """Means over the episodes kept: ``episodes``, ``success_rate``, ``return``, ``cycles``, how often each ``status``."""
        n = len(self.episodes)
        mean = {k: sum(float(e[k]) for e in self.episodes) / n if n else float("nan") for k in ("is_success", "r", "cycles")}
        return {
            "episodes": n, "success_rate": mean["is_success"], "return": mean["r"], "cycles": mean["cycles"],
            "status": dict(Counter(Status(e["status"]).name for e in self.episodes)),
        }  # fmt: skip
