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


STUDY = "attacker_one_defender"
"""Folder of the study for one defender at most; against more of them the numbers set by hand are better."""


def make_controller(task: Task, agent: str, constants: HalfFieldConstants | None = None, tuned: bool = False) -> attacker.AttackerAgent:
    """An attacker as a controller.

    Parameters
    ----------
    task : Task
    agent : str
    constants : HalfFieldConstants, optional
        Those set by hand if not given.
    tuned : bool
        Those of `STUDY` instead: ``cprm:tuned=true``.

    Raises
    ------
    ParameterError
        For a defender, or numbers that are both given and tuned.
    """
    if not agent.startswith("left"):
        raise ParameterError(f"{task.name}: the attacker plays for the left side; {agent!r} defends")
    if tuned and constants is not None:
        raise ParameterError("attacker: `constants` are given and `tuned` asks for others; leave out one")
    numbers = HalfFieldConstants.tuned("memory", STUDY) if tuned else constants or HalfFieldConstants()
    return attacker.make_controller(task, agent, numbers, GROUND)
