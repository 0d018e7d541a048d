"""The belief on bins: the expectation of the goalie's first model, for the reckoned ball and the opponent he watches most.

The first version, after Fig. 2.25 of the dissertation; `belief` is the better one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from ...envs.controller import Action, Observation
from ...envs.tasks import Task
from ...errors import UnknownName
from .. import goalie
from ..percepts import NEVER


class BinsTier:
    """The goalie's CPRM runs beside the controller and is read; what its net would do is not done.

    Parameters
    ----------
    task : Task
    agent : str

    Raises
    ------
    UnknownName
        For a task in which there is no such model.
    """

    name: ClassVar[str] = "bins"
    oracle: ClassVar[bool] = False

    def __init__(self, task: Task, agent: str) -> None:
        if task.right_goalie + task.left_goalie == 0 or task.controlled != "left_1":
            raise UnknownName(f"tier 'bins': there is no goalie to believe in task {task.name!r}; it knows Goalie")
        self._believer = goalie.make_controller(task, agent)
        self._opponents = task.right

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Begin to believe."""
        self._believer.reset(observation, 0, worlds)

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """The expectations."""
        self._believer.act(observation)
        runner = self._believer.controller
        assert runner is not None
        memory = np.array(observation["memory"])
        known = np.asarray(observation["memory_age"])[:, 0] < NEVER
        read = runner.executor.read
        memory[known, 0] = np.stack([read(f"ball_{name}") for name in ("x", "y", "vx", "vy")], axis=1)[known]
        danger = np.asarray(goalie.opponent_attributes(observation, self._opponents)["Opponent"]["danger"])
        rows, nearest = np.arange(len(danger)), danger.argmax(axis=1)
        watched = danger[rows, nearest] > 0
        place = np.stack([read("watched_x"), read("watched_y")], axis=1)
        memory[rows[watched], 12 + nearest[watched], :2] = place[watched]
        return {"memory": memory}
