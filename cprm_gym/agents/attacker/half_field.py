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


def make_controller(task: Task, agent: str, constants: HalfFieldConstants | None = None) -> attacker.AttackerAgent:
    """An attacker as a controller, with the numbers tuned on his memory if no others are given.

    Raises
    ------
    ParameterError
        For a defender.
    """
    if not agent.startswith("left"):
        raise ParameterError(f"{task.name}: the attacker plays for the left side; {agent!r} defends")
    return attacker.make_controller(task, agent, constants or HalfFieldConstants(), GROUND)
