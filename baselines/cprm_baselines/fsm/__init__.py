"""Finite state machines: one state at a time, written as a table; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from ..behaviour.machine import Machine
from ..behaviour.player import Player
from ..behaviour.scenes import make_scene
from . import go_to_ball, goalie, hike, kick_off_shot, lost_and_found, pass_and_advance

TABLES = {
    "KickOffShot": kick_off_shot, "PassAndAdvance": pass_and_advance, "Goalie": goalie, "Goalie2v1": goalie, "Goalie3v2": goalie,
    "LostAndFound": lost_and_found, "Hike": hike,
}  # fmt: skip
"""Task -> the module with its table."""


def make_controller(task: Task, agent: str) -> Controller:
    """The machine for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    if task.name == "GoToBall":
        return go_to_ball.GoToBallMachine(Body.of(task))
    if task.name not in TABLES:
        raise unknown_name("task of the controller 'fsm':", task.name, ("GoToBall", *TABLES))
    scene, table = make_scene(task, agent), TABLES[task.name]
    return Player(scene, Machine(scene, table.STATES, table.EYES), Body.of(task))
