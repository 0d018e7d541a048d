"""The CPRM agents by the task that they play."""

from __future__ import annotations

import inspect
from typing import Any

from ..envs.controller import Controller
from ..envs.tasks import Task
from ..errors import ParameterError, unknown_name

AGENTS: dict[str, str] = {
    "GoToBall": "seeker", "KickOffShot": "striker", "KickOffShot2v2": "striker", "PassAndAdvance": "passer",
    **dict.fromkeys(("PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"), "passer"), "Goalie": "goalie", "Goalie2v1": "goalie",
    "Goalie3v2": "goalie", "LostAndFound": "finder.agent", "Hike": "hiker.agent",
    "Soccer": "eleven", "Soccer5v5": "eleven", "Soccer11v11": "eleven",
}  # fmt: skip
"""Task -> module of this package that has ``make_controller(task, agent)``."""


def make_controller(task: Task, agent: str, **options: Any) -> Controller:
    """The CPRM agent that plays a task.

    Parameters
    ----------
    task : Task
    agent : str
    **options
        Of agents with a model, those of `CPRMRunner`: ``t_b``, ``latency``, ``demand``, ``engine``, ``deep``, ``every`` ...

    Raises
    ------
    UnknownName
        Listing the tasks for which there is an agent.
    ParameterError
        For options that the agent does not take.
    """
    if task.name not in AGENTS:
        raise unknown_name("task of the controller 'cprm':", task.name, AGENTS)
    from importlib import import_module

    factory = import_module(f".{AGENTS[task.name]}", __package__)
    taken = inspect.signature(factory.make_controller).parameters
    for option in options:
        if option not in taken and "options" not in taken:
            raise ParameterError(f"the agent of {task.name} has no model: there is no option {option!r}")
    controller: Controller = factory.make_controller(task, agent, **options)
    return controller
