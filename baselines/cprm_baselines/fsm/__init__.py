"""Finite state machines: one state at a time, written as a table; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task

from ..behaviour.machine import Machine
from ..behaviour.maker import make_player, tables

TABLES = tables(__name__)
"""Task -> the module with its table."""


def make_controller(task: Task, agent: str) -> Controller:
    """The machine for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    if task.name == "GoToBall":  # written by hand, its skill too
        machine: Controller = TABLES[task.name].GoToBallMachine(Body.of(task))
        return machine
    return make_player("fsm", TABLES, lambda scene, table: Machine(scene, table.STATES, table.EYES), task, agent)
