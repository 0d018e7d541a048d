"""Subsumption: layers of machines, the higher ones suppressing the lower ones; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from ..behaviour.layers import Layers
from ..behaviour.player import Player
from ..behaviour.scenes import make_scene
from . import go_to_ball, goalie, hike, kick_off_shot, lost_and_found, pass_and_advance

LAYERS = {
    "GoToBall": go_to_ball, "KickOffShot": kick_off_shot, "PassAndAdvance": pass_and_advance, "Goalie": goalie, "Goalie2v1": goalie,
    "Goalie3v2": goalie, "LostAndFound": lost_and_found, "Hike": hike,
}  # fmt: skip
"""Task -> the module with its layers."""


def make_controller(task: Task, agent: str) -> Controller:
    """The layers for a task.

    Raises
    ------
    UnknownName
        For a task that they cannot play.
    """
    if task.name not in LAYERS:
        raise unknown_name("task of the controller 'subsumption':", task.name, LAYERS)
    scene, table = make_scene(task, agent), LAYERS[task.name]
    return Player(scene, Layers(scene, table.LAYERS, table.EYES), Body.of(task))
