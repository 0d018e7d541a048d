"""Random: a uniformly random command in every cycle."""

from __future__ import annotations

import numpy as np

from cprm_gym.envs.actions import DISCRETE_KINDS, scaled
from cprm_gym.envs.controller import Action, Observation
from cprm_gym.envs.tasks import Task
from cprm_gym.simulator.state import CommandKind

_KINDS = np.array([int(k) for k in DISCRETE_KINDS])


class RandomPolicy:
    """Draws command, power and direction uniformly, whatever it sees.

    Each world has its own generator, so that a world's actions do not depend on how many others there are.
    """

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Seed the generators of the worlds that begin."""
        count = len(observation["level"])
        if worlds is None:
            self._generators = [np.random.default_rng([seed, k]) for k in range(count)]

    def act(self, observation: Observation) -> Action:
        """A random command for each world."""
        u = np.array([g.random(4) for g in self._generators])
        kind = _KINDS[(u[:, 0] * len(_KINDS)).astype(np.int64)]
        power, direction = 100.0 * u[:, 1], 360.0 * u[:, 2] - 180.0
        powered = (kind == CommandKind.DASH) | (kind == CommandKind.KICK)
        params = scaled(kind, np.where(powered, power, direction), np.where(powered, direction, 0.0))
        return {"type": kind, "params": params, "turn_neck": u[:, 3:4] - 0.5, "view": np.zeros(len(u), np.int64)}


def make_controller(task: Task, agent: str) -> RandomPolicy:
    """The random policy; it plays every task."""
    return RandomPolicy()
