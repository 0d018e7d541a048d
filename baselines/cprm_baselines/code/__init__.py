"""Hand-written concurrent code: programs that wait for conditions, several at once for an agent; one file a task."""

from __future__ import annotations

from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task

from ..behaviour.maker import make_player, tables
from ..behaviour.programs import Programs

PROGRAMS = tables(__name__)
"""Task -> the module with its programs."""


def make_controller(task: Task, agent: str) -> Controller:
    """The programs for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    return make_player("code", PROGRAMS, lambda scene, table: Programs(scene, table.MAINS), task, agent)
