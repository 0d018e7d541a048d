"""Behaviour trees (py_trees): one tree a world, ticked once a cycle; one file a task."""

from __future__ import annotations

from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task

from ..behaviour.maker import make_player, tables
from ..behaviour.trees import Trees

TREES = tables(__name__)
"""Task -> the module with its tree."""


def make_controller(task: Task, agent: str) -> Controller:
    """The tree for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    return make_player("behavior_tree", TREES, lambda scene, table: Trees(scene, table.grow), task, agent)
