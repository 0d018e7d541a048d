"""The last observations together."""

from __future__ import annotations

from collections import deque
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from ..errors import ParameterError


class FrameStack(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Observations with the last `frames` values of every part, oldest first, along a new first axis; zeros before the start.

    Parameters
    ----------
    env : gymnasium.Env
        With a Box or a flat Dict of boxes.
    frames : int
        How many.

    Raises
    ------
    ParameterError
        For less than one frame or other observations.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], frames: int = 4) -> None:
        super().__init__(env)
        if not isinstance(frames, int) or frames < 1:
            raise ParameterError(f"FrameStack: frames is {frames!r}; allowed are whole numbers from 1")
        self.frames = frames
        self._last: deque[Any] = deque(maxlen=frames)
        space = env.observation_space
        parts = space.spaces if isinstance(space, spaces.Dict) else {"": space}
        for name, part in parts.items():
            if not isinstance(part, spaces.Box):
                raise ParameterError(f"FrameStack: part {name!r} of the observation is {part}; boxes are needed")
        stacked: dict[str, spaces.Space[Any]] = {name: self._stacked(part) for name, part in parts.items()}  # type: ignore[arg-type]
        self.observation_space = spaces.Dict(stacked) if isinstance(space, spaces.Dict) else stacked[""]

    def _stacked(self, box: spaces.Box) -> spaces.Box:
        low = np.minimum(np.repeat(box.low[None], self.frames, 0), 0)
        high = np.maximum(np.repeat(box.high[None], self.frames, 0), 0)
        return spaces.Box(low.astype(box.dtype), high.astype(box.dtype), dtype=box.dtype)  # type: ignore[arg-type]

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode; earlier frames are zero."""
        observation, info = self.env.reset(**kwargs)
        empty = {k: np.zeros_like(v) for k, v in observation.items()} if isinstance(observation, dict) else np.zeros_like(observation)
        self._last.extend([empty] * (self.frames - 1) + [observation])
        return self._observation(), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play one cycle."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._last.append(observation)
        return self._observation(), reward, terminated, truncated, info

    def _observation(self) -> Any:
        if isinstance(self._last[-1], dict):
            return {k: np.stack([frame[k] for frame in self._last]) for k in self._last[-1]}
        return np.stack(self._last)
