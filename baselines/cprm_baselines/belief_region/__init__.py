"""Belief regions (dissertation Fig. 5.2): what is believed now decides, and nothing else; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from ..behaviour.player import Player
from ..behaviour.regions import Regions
from . import go_to_ball, goalie, hike, kick_off_shot, lost_and_found, pass_and_advance

POLICIES = {
    "GoToBall": go_to_ball, "KickOffShot": kick_off_shot, "PassAndAdvance": pass_and_advance, "Goalie": goalie, "Goalie2v1": goalie,
    "Goalie3v2": goalie, "LostAndFound": lost_and_found, "Hike": hike,
}  # fmt: skip
"""Task -> the module with its regions."""


def make_controller(task: Task, agent: str) -> Controller:
    """The policy for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    if task.name not in POLICIES:
        raise unknown_name("task of the controller 'belief_region':", task.name, POLICIES)
    policy = POLICIES[task.name]
    scene = policy.make_scene(task, agent)
    return Player(scene, Regions(scene, policy.BODY, policy.NECK), Body.of(task))
