"""Belief regions (dissertation Fig. 5.2): what is believed now decides, and nothing else; one file a task."""

from __future__ import annotations

from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task

from ..behaviour.maker import make_player, tables
from ..behaviour.regions import Regions

POLICIES = tables(__name__)
"""Task -> the module with its regions."""


def make_controller(task: Task, agent: str) -> Controller:
    """The policy for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    return make_player("belief_region", POLICIES, lambda scene, table: Regions(scene, table.BODY, table.NECK), task, agent)
