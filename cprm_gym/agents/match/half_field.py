"""The defence of half field offence and of the front-of-goal ladder: the goalie, and the outfield players of a match beside him."""

from __future__ import annotations

from ...envs.tasks import Task
from ...errors import ParameterError
from ..body import Body
from ..goalie import ReckoningGoalie
from ..play import SoccerAgent
from ..skills.constants import AttackedConstants
from .agent import make_outfielder
from .constants import MatchConstants

STUDY = "defence"
"""Folder of the study of defenders."""


def make_controller(task: Task, agent: str, constants: MatchConstants | None = None) -> SoccerAgent:
    """The goalie, with the numbers tuned against several attackers, or a defender, as a controller.

    Parameters
    ----------
    task : Task
    agent : str
    constants : MatchConstants, optional
        Of defenders.

    Raises
    ------
    ParameterError
        For an attacker.
    """
    if not agent.startswith("right"):
        raise ParameterError(f"{task.name}: the defence plays for the right side; {agent!r} attacks")
    if int(agent.partition("_")[2]) == task.right_goalie:
        return ReckoningGoalie(task.left, Body.of(task), AttackedConstants.tuned("memory", "goalie_2v1"))
    return make_outfielder(task, agent, constants)
