"""Subsumption: layers of machines, the higher ones suppressing the lower ones; one file a task."""

from __future__ import annotations

from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task

from ..behaviour.layers import Layers
from ..behaviour.maker import make_player, tables

LAYERS = tables(__name__)
"""Task -> the module with its layers."""


def make_controller(task: Task, agent: str) -> Controller:
    """The layers for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    return make_player("subsumption", LAYERS, lambda scene, table: Layers(scene, table.LAYERS, table.EYES), task, agent)
