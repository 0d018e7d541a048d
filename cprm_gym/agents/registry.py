"""The CPRM agents by the task that they play."""

from __future__ import annotations

import inspect
from typing import Any

from ..envs.controller import Controller
from ..envs.tasks import Task
from ..envs.tasks.half_field import LADDER
from ..errors import ParameterError, unknown_name

AGENTS: dict[str, str] = {
    "GoToBall": "seeker", "KickOffShot": "striker", "KickOffShot2v2": "striker", "PassAndAdvance": "passer",
    **dict.fromkeys(("PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"), "passer"), "Goalie": "goalie", "Goalie2v1": "goalie",
    "Goalie3v2": "goalie", "LostAndFound": "finder.agent", "Hike": "hiker.agent",
    **dict.fromkeys(("HFO1v0", "HFO1v1", "HFO2v1", *LADDER), "attacker.half_field"),
    "Soccer": "eleven", "Soccer5v5": "eleven", "Soccer11v11": "eleven",
}  # fmt: skip
"""Task -> module of this package that has ``make_controller(task, agent)``."""


def make_controller(task: Task, agent: str, tier: str = "", **options: Any) -> Controller:
    """The CPRM agent that plays a task.

    Parameters
    ----------
    task : Task
    agent : str
    tier : str
        On which tier of knowledge, if not on what the environment tells: ``belief``, ``tracker`` ... Where there is a player for tiers
        (`knowledge.players.PLAYERS`) it is he, whose net reads the tier alone: no model of his own filters once more what is filtered.
    **options
        Of agents with a model, those of `CPRMRunner`: ``t_b``, ``latency``, ``demand``, ``engine``, ``deep``, ``every`` ...

    Raises
    ------
    UnknownName
        Listing the tasks for which there is an agent, or the tiers.
    ParameterError
        For options that the agent does not take.
    """
    if task.name not in AGENTS:
        raise unknown_name("task of the controller 'cprm':", task.name, AGENTS)
    if tier:
        return _on_tier(task, agent, tier, options)
    from importlib import import_module

    factory = import_module(f".{AGENTS[task.name]}", __package__)
    taken = inspect.signature(factory.make_controller).parameters
    for option in options:
        if option not in taken and "options" not in taken:
            raise ParameterError(f"the agent of {task.name} has no model: there is no option {option!r}")
    controller: Controller = factory.make_controller(task, agent, **options)
    return controller


def _on_tier(task: Task, agent: str, tier: str, options: dict[str, Any]) -> Controller:
    from .knowledge import TIERS, informed
    from .knowledge.players import PLAYERS
    from .knowledge.registry import ORACLES

    known = [name for name in TIERS if name not in ORACLES]
    if tier not in known:
        raise unknown_name("tier", str(tier), known)
    if task.name not in PLAYERS:
        return informed(lambda task, agent: make_controller(task, agent, **options), tier)(task, agent)
    if options:
        raise ParameterError(f"on a tier the agent of {task.name} has no model: there is no option {next(iter(options))!r}")
    return PLAYERS[task.name].on(tier)(task, agent)
