"""The attacker of half field offence and of the front-of-goal ladder: one to four of them, against a goalie and defenders or nobody.

The net is that of `agent`, without the offside rule, which is not in force there, and without the parts of the pitch in which the ball is
out.
"""

from __future__ import annotations

from ...envs.tasks import Task
from ...errors import ParameterError
from . import agent as attacker
from .constants import HalfFieldConstants
from .percepts import MARGIN, Ground

GROUND = Ground(low_x=MARGIN, offside=False)
"""The right half."""
STUDY = {
    **dict.fromkeys(
        ("HFO1v0", "HFO1v1", "HFO2v1", "FrontGoalEmptyGoal", "FrontGoalBlockedShot", "FrontGoalSupportOption"), "attacker_one_defender"
    ),
    **dict.fromkeys(("HFO2v2", "HFO3v2"), "attacker_two_defenders"),
    "FrontGoalPassingLane": "attacker_passing_lane",
    "FrontGoalCompactDefense": "attacker_compact_defence",
}
"""Task -> folder of the study whose numbers he plays it with; in the others nothing better was found than what was set by hand."""


def numbers_of(task: str) -> HalfFieldConstants:
    """The attacker's numbers in a task if no others are given."""
    return HalfFieldConstants.tuned("memory", STUDY[task]) if task in STUDY else HalfFieldConstants()


def make_controller(task: Task, agent: str, constants: HalfFieldConstants | None = None) -> attacker.AttackerAgent:
    """An attacker as a controller.

    Parameters
    ----------
    task : Task
    agent : str
    constants : HalfFieldConstants, optional
        Those of `numbers_of` the task if not given.

    Raises
    ------
    ParameterError
        For a defender.
    """
    if not agent.startswith("left"):
        raise ParameterError(f"{task.name}: the attacker plays for the left side; {agent!r} defends")
    return attacker.make_controller(task, agent, constants or numbers_of(task.name), GROUND)
