"""Episodes of one task, one of its agents played by a controller, in given worlds and with given senses."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..agents.knowledge import Informed
from ..envs.controller import Controller, check_action
from ..envs.core import SoccerCore
from ..envs.players.senses import Senses
from ..envs.tasks import Task


class Episodes(NamedTuple):
    """What became of each."""

    success: np.ndarray
    """(n,) bool."""
    cycles: np.ndarray
    """(n,) int."""


def play_episodes(
    task: Task, make: Callable[[Task, str], Controller], count: int, seed: int, first_world: int = 0, senses: Senses | None = None
) -> Episodes:
    """Play ``count`` worlds from `first_world` on, at once; every controller meets the same worlds.

    Parameters
    ----------
    task : Task
    make : callable
        (task, agent) -> controller, for each of the task's agents; those on an oracle's tier are shown the worlds.
    count, seed, first_world : int
    senses : Senses, optional
    """
    core = SoccerCore(task, count, seed=seed, first_world=first_world, include=("memory",), senses=senses or Senses())
    controllers = [make(task, agent) for agent in core.agents]
    observation = core.reset(seed)
    for i, (agent, controller) in enumerate(zip(core.agents, controllers)):
        if isinstance(controller, Informed):
            controller.connect(core, agent)
        controller.reset({key: value[:, i] for key, value in observation.items()}, seed)
    running, success, cycles = np.ones(count, bool), np.zeros(count, bool), np.zeros(count, np.int64)
    while running.any():
        actions = [
            check_action(type(controller).__name__, controller.act({key: value[:, i] for key, value in observation.items()}), count)
            for i, controller in enumerate(controllers)
        ]
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        cycles += running
        success |= running & step.success.any(axis=1)
        running &= ~(step.terminated | step.truncated)
    return Episodes(success, cycles)
