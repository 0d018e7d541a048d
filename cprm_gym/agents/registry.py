"""The CPRM agents by the task that they play."""

from __future__ import annotations

from ..envs.controller import Controller
from ..envs.tasks import Task
from ..errors import unknown_name

AGENTS: dict[str, str] = {
    "GoToBall": "seeker", "KickOffShot": "striker", "KickOffShot2v2": "striker", "PassAndAdvance": "passer",
    **dict.fromkeys(("PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"), "passer"), "Goalie": "goalie", "Goalie2v1": "goalie",
    "Goalie3v2": "goalie", "LostAndFound": "finder.agent", "Hike": "hiker.agent",
    "Soccer": "eleven", "Soccer5v5": "eleven", "Soccer11v11": "eleven",
}  # fmt: skip
"""Task -> module of this package that has ``make_controller(task, agent)``."""


def make_controller(task: Task, agent: str) -> Controller:
    """The CPRM agent that plays a task.

    Raises
    ------
    UnknownName
        Listing the tasks for which there is an agent.
    """
    if task.name not in AGENTS:
        raise unknown_name("task of the controller 'cprm':", task.name, AGENTS)
    from importlib import import_module

    factory = import_module(f".{AGENTS[task.name]}", __package__)
    controller: Controller = factory.make_controller(task, agent)
    return controller
