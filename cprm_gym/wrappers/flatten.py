"""One vector instead of a dict of arrays."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from ..errors import ParameterError


class Flatten(gymnasium.ObservationWrapper[np.ndarray, Any, Any]):
    """The parts of a flat Dict observation, in the order of the space's keys, as one vector.

    Parameters
    ----------
    env : gymnasium.Env
        Its observations are a flat Dict of boxes (or one box).
    normalise : bool
        Scale every entry from its bounds to [-1, 1].

    Raises
    ------
    ParameterError
        For an environment with other observations, or to normalise what has no bounds.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], normalise: bool = False) -> None:
        super().__init__(env)
        space = env.observation_space
        parts = dict(space.spaces) if isinstance(space, spaces.Dict) else {"": space}
        for name, part in parts.items():
            if not isinstance(part, spaces.Box):
                raise ParameterError(f"Flatten: part {name!r} of the observation is {part}; a flat Dict of boxes is needed")
        self.slices: dict[str, slice] = {}
        start = 0
        for name, part in parts.items():
            size = int(np.prod(part.shape or (1,)))
            self.slices[name] = slice(start, start + size)
            start += size
        low = np.concatenate([np.ravel(p.low) for p in parts.values()]).astype(np.float64)  # type: ignore[attr-defined]
        high = np.concatenate([np.ravel(p.high) for p in parts.values()]).astype(np.float64)  # type: ignore[attr-defined]
        self.normalise = normalise
        if normalise:
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                raise ParameterError("Flatten: normalise=True needs finite bounds of every entry")
            self._middle, self._half = (low + high) / 2, np.maximum((high - low) / 2, 1e-12)
            low, high = np.full(start, -1.0), np.full(start, 1.0)
        self.observation_space = spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)

    def observation(self, observation: Any) -> np.ndarray:
        """The vector."""
        values = [observation[name] for name in self.slices] if isinstance(observation, dict) else [observation]
        vector = np.concatenate([np.ravel(v) for v in values])
        if self.normalise:
            vector = np.clip((vector - self._middle) / self._half, -1.0, 1.0)
        return vector.astype(np.float32)
