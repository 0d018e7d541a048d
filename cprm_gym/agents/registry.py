"""The CPRM agents by the task that they play."""

from __future__ import annotations

import inspect
from importlib import import_module
from typing import Any

from ..envs.controller import Controller, ControllerFactory
from ..envs.tasks import Task
from ..envs.tasks.half_field import LADDER
from ..errors import ParameterError, unknown_name

AGENTS: dict[str, str] = {
    "GoToBall": "seeker", "KickOffShot": "striker", "KickOffShot2v2": "striker", "PassAndAdvance": "passer",
    **dict.fromkeys(("PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"), "passer"), "Goalie": "goalie", "Goalie2v1": "goalie",
    "Goalie3v2": "goalie", "LostAndFound": "finder.agent", "Hike": "hiker.agent",
    **dict.fromkeys(("HFO1v0", "HFO1v1", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5", *LADDER), "attacker.half_field"),
    **dict.fromkeys(("Keepaway3v2", "Keepaway4v3", "Keepaway5v4"), "keeper.agent"),
    **dict.fromkeys(("Soccer", "Soccer5v5", "Soccer11v11"), "match.agent"),
}  # fmt: skip
"""Task -> module of this package that has ``make_controller(task, agent)``."""
OTHER_SIDE = {
    **dict.fromkeys(("HFO1v1", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5", *(name for name, (_, d) in LADDER.items() if d)),
                    "match.half_field"),
    **dict.fromkeys(("Keepaway3v2", "Keepaway4v3", "Keepaway5v4"), "taker.agent"),
}  # fmt: skip
"""The same for the right side, of tasks where it does something else; it plays on what the environment tells, if no tier is named."""
WITH_MODEL = dict.fromkeys(("Soccer", "Soccer5v5", "Soccer11v11"), "eleven")
"""The same, of tasks where the agent with a model of his own is another one."""
MODELLED = ("GoToBall", "PassAndAdvance", "Goalie", "Goalie2v1", "Goalie3v2", "Soccer", "Soccer5v5", "Soccer11v11")
"""Tasks whose agent has a model of his own, on bins (dissertation Fig. 2.25 to 2.28)."""
ON_OTHERS = ("GoToBall", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5", "Soccer", "Soccer5v5", "Soccer11v11")
"""Tasks whose agent has a model of his own or reads what the environment reckons: the seeker with the dissertation's first model, who plays
matches, and attackers of half fields who have team-mates."""
ON_BELIEF = tuple(task for task in AGENTS if task not in ON_OTHERS)
"""Tasks whose agent plays on the tier `TIER`, if neither a tier nor a model is named."""
TIER, BINS, INTENTION = "belief", "bins", "intention"


def make_controller(task: Task, agent: str, tier: str = "", model: str = "", **options: Any) -> Controller:
    """The CPRM agent that plays a task.

    Parameters
    ----------
    task : Task
    agent : str
    tier : str
        On which tier of knowledge: ``belief``, ``tracker``, ``memory`` ...; in `ON_BELIEF` tasks `TIER` if none is named, elsewhere what
        the environment tells. Where there is a player for tiers (`knowledge.players.PLAYERS`) it is he, with his numbers for that tier:
        his net reads the tier alone, and no model of his own filters once more what is filtered.
    model : str
        ``bins``: the agent with the model that he had first, if he had one, on what the environment tells, or on a tier that is named
        besides. ``intention``: the goalie on the belief who expects shots (`intention.agent`).
    **options
        Of agents with a model of their own, those of `CPRMRunner`: ``t_b``, ``latency``, ``demand``, ``engine``, ``deep``, ``every`` ...

    Raises
    ------
    UnknownName
        Listing the tasks for which there is an agent, the tiers, or the models.
    ParameterError
        For options that the agent does not take.
    """
    if task.name not in AGENTS:
        raise unknown_name("task of the controller 'cprm':", task.name, AGENTS)
    if model not in ("", BINS, INTENTION):
        raise unknown_name("model", str(model), (BINS, INTENTION))
    if model == INTENTION:
        return _expecting(task, agent, tier, options)
    other = _other_side(task, agent)
    if not tier and not model and task.name in ON_BELIEF and not other:
        tier = TIER
    if not tier:
        return _own(task, agent, options, model)
    from .knowledge import informed

    reading = None if other else _reading(task, tier)
    if reading is None or model:
        return informed(lambda task, agent: _own(task, agent, options, model), tier)(task, agent)
    if options:
        raise ParameterError(f"on a tier {_no_option(task, next(iter(options)))}")
    return reading(task, agent)


def _expecting(task: Task, agent: str, tier: str, options: dict[str, Any]) -> Controller:
    """Who expects shots; he is on the tier `TIER` alone."""
    from .intention.agent import make_controller as expecting

    if tier not in ("", TIER) or options:
        given = next(iter(options)) if options else f"tier={tier}"
        raise ParameterError(f"model={INTENTION}: he plays on {TIER!r} and has no options: {given!r} given")
    return expecting(task, agent)


def _no_option(task: Task, option: str) -> str:
    """What is said of an option of agents with a model to one without."""
    instead = f"; write model={BINS} for the one who has" if task.name in MODELLED else ""
    return f"the agent of {task.name} has no model: there is no option {option!r}{instead}"


def _other_side(task: Task, agent: str) -> bool:
    """Whether somebody else plays there than on the left side."""
    return agent.startswith("right") and task.name in OTHER_SIDE


def _own(task: Task, agent: str, options: dict[str, Any], model: str) -> Controller:
    """Net and, where there is one, model of his own."""
    other = OTHER_SIDE if _other_side(task, agent) else WITH_MODEL if model else {}
    where = {**AGENTS, **other}[task.name]
    factory = import_module(f".{where}", __package__).make_controller
    taken = inspect.signature(factory).parameters
    for option in options:
        if option not in taken and "options" not in taken:
            raise ParameterError(_no_option(task, option))
    controller: Controller = factory(task, agent, **options)
    return controller


def _reading(task: Task, tier: str) -> ControllerFactory | None:
    """Whose net reads a tier and nothing else; None where only the one with a model of his own plays."""
    from .knowledge import TIERS, informed
    from .knowledge.players import PLAYERS
    from .knowledge.registry import ORACLES
    from .seeker import make_reckoning

    known = [name for name in TIERS if name not in ORACLES]
    if tier not in known:
        raise unknown_name("tier", str(tier), known)
    if task.name in PLAYERS:
        return PLAYERS[task.name].on(tier)
    if task.name == "GoToBall":
        return informed(make_reckoning, tier)
    return None
