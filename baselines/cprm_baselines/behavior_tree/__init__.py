"""Behaviour trees (py_trees): one tree a world, ticked once a cycle; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from ..behaviour.player import Player
from ..behaviour.scenes import make_scene
from ..behaviour.trees import Trees
from . import go_to_ball, goalie, hike, kick_off_shot, lost_and_found, pass_and_advance

TREES = {
    "GoToBall": go_to_ball, "KickOffShot": kick_off_shot, "PassAndAdvance": pass_and_advance, "Goalie": goalie, "Goalie2v1": goalie,
    "Goalie3v2": goalie, "LostAndFound": lost_and_found, "Hike": hike,
}  # fmt: skip
"""Task -> the module with its tree."""


def make_controller(task: Task, agent: str) -> Controller:
    """The tree for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    if task.name not in TREES:
        raise unknown_name("task of the controller 'behavior_tree':", task.name, TREES)
    scene = make_scene(task, agent)
    return Player(scene, Trees(scene, TREES[task.name].grow), Body.of(task))
