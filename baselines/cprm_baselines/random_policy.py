"""Random: a uniformly random command in every cycle."""

from __future__ import annotations

import numpy as np

from cprm_gym.envs.actions import DISCRETE_KINDS, scaled
from cprm_gym.envs.controller import Action, Observation
from cprm_gym.envs.core import player_number
from cprm_gym.envs.others.luck import WorldLuck
from cprm_gym.envs.tasks import Task
from cprm_gym.simulator.state import CommandKind

_KINDS = np.array([int(k) for k in DISCRETE_KINDS])


class RandomPolicy:
    """Draws command, power and direction uniformly, whatever it sees.

    Each world has its own generator, so that a world's actions do not depend on how many others there are.

    Parameters
    ----------
    player : int
        Object number: players of one world differ.
    """

    def __init__(self, player: int = 1) -> None:
        self.player = player
        self._luck = WorldLuck(4)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Seed the generators of the worlds; those of worlds that begin anew go on."""
        count = len(observation["level"])
        if worlds is None:
            self._luck.begin(np.full(count, seed), np.arange(count))

    def begin(self, observation: Observation, seeds: np.ndarray, worlds: np.ndarray | None = None) -> None:
        """Seed the generators of the worlds that begin, each with its own seed."""
        self._luck.begin(seeds, self.player, worlds)

    def act(self, observation: Observation) -> Action:
        """A random command for each world."""
        u = self._luck.draw()
        kind = _KINDS[(u[:, 0] * len(_KINDS)).astype(np.int64)]
        power, direction = 100.0 * u[:, 1], 360.0 * u[:, 2] - 180.0
        powered = (kind == CommandKind.DASH) | (kind == CommandKind.KICK)
        params = scaled(kind, np.where(powered, power, direction), np.where(powered, direction, 0.0))
        return {"type": kind, "params": params, "turn_neck": u[:, 3:4] - 0.5, "view": np.zeros(len(u), np.int64)}

    def state(self) -> dict[str, np.ndarray]:
        """What decides its next commands."""
        return self._luck.state()


def make_controller(task: Task, agent: str) -> RandomPolicy:
    """The random policy; it plays every task."""
    return RandomPolicy(player_number(agent))
