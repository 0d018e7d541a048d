"""From a task to its player: each structure is a package with one file a task, or a few tasks, named alike in all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.envs.tasks.half_field import LADDER
from cprm_gym.errors import unknown_name

from .player import Player, Structure
from .scene import Scene
from .scenes import DEFENDED, HALF_FIELD, KEEPAWAY, make_scene

FILES = {
    "GoToBall": "go_to_ball", "KickOffShot": "kick_off_shot", "PassAndAdvance": "pass_and_advance",
    **dict.fromkeys(("Goalie", "Goalie2v1", "Goalie3v2"), "goalie"), "LostAndFound": "lost_and_found", "Hike": "hike",
    **dict.fromkeys((*HALF_FIELD, *LADDER), "half_field"), **dict.fromkeys(KEEPAWAY, "keepaway"), **dict.fromkeys(DEFENDED, "defended"),
}  # fmt: skip
"""Task -> file of a structure that plays it."""
OTHER_SIDE = dict.fromkeys(KEEPAWAY, "taker")
"""Task -> file for the players of the right side, where they do something else."""


def tables(package: str) -> dict[str, ModuleType]:
    """Task -> module of a structure's package, of those that it has."""
    return {task: import_module(f"{package}.{file}") for task, file in FILES.items() if find_spec(f"{package}.{file}") is not None}


def make_player(
    structure: str, modules: Mapping[str, ModuleType], build: Callable[[Scene, ModuleType], Structure], task: Task, agent: str
) -> Controller:
    """The player of a task in a structure.

    Parameters
    ----------
    structure : str
        Name of the controller.
    modules : mapping of str to module
        Of `tables`; where a module has a ``make_scene`` of its own, that is taken.
    build : callable
        Scene and module of a task -> who decides.
    task : Task
    agent : str

    Raises
    ------
    UnknownName
        For a task that the structure does not play.
    """
    if task.name not in modules:
        raise unknown_name(f"task of the controller {structure!r}:", task.name, modules)
    module = modules[task.name]
    if agent.startswith("right") and task.name in OTHER_SIDE:
        module = import_module(f"{module.__package__}.{OTHER_SIDE[task.name]}")
    scene = getattr(module, "make_scene", make_scene)(task, agent)
    return Player(scene, build(scene, module), Body.of(task), module.__name__)
