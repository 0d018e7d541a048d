"""Hand-written concurrent code: programs that wait for conditions, several at once for an agent; one file a task."""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from ..behaviour.player import Player
from ..behaviour.programs import Programs
from ..behaviour.scenes import make_scene
from . import go_to_ball, goalie, hike, kick_off_shot, lost_and_found, pass_and_advance

PROGRAMS = {
    "GoToBall": go_to_ball, "KickOffShot": kick_off_shot, "PassAndAdvance": pass_and_advance, "Goalie": goalie, "Goalie2v1": goalie,
    "Goalie3v2": goalie, "LostAndFound": lost_and_found, "Hike": hike,
}  # fmt: skip
"""Task -> the module with its programs."""


def make_controller(task: Task, agent: str) -> Controller:
    """The programs for a task.

    Raises
    ------
    UnknownName
        For a task that they cannot play.
    """
    if task.name not in PROGRAMS:
        raise unknown_name("task of the controller 'code':", task.name, PROGRAMS)
    scene = make_scene(task, agent)
    return Player(scene, Programs(scene, PROGRAMS[task.name].MAINS), Body.of(task))
