"""KickOffShot: from the kick-off to a goal, without opponents (demonstration 1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...simulator.parameters import Rules
from ...simulator.state import PlayMode
from .base import Outcome, Task

if TYPE_CHECKING:
    from ..core import SoccerCore

_OUT = np.array(
    [PlayMode.kick_in_r, PlayMode.goal_kick_r, PlayMode.corner_kick_r, PlayMode.free_kick_r, PlayMode.offside_l, PlayMode.free_kick_fault_l,
     PlayMode.kick_in_l, PlayMode.goal_kick_l, PlayMode.corner_kick_l, PlayMode.indirect_free_kick_r]
)  # fmt: skip


@dataclass(frozen=True)
class KickOffShot(Task):
    """Kick off, pass, run forward, receive the return pass, dribble, shoot, score.

    Description
    -----------
    The agent and one team-mate, who passes back, against an empty half. The referee is on.

    Actions
    -------
    Any action view; see `cprm_gym.envs.spaces`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for the goal.

    Start
    -----
    Before the kick-off, which comes after `wait` cycles: the agent behind the ball, the team-mate some metres to a side (both drawn).

    End
    ---
    GOAL; OUT: the ball went out or a fault was called; OUT_OF_TIME after `max_cycles`.

    References
    ----------
    Dissertation 2.2.7 (Figs. 2.11-2.14).
    """

    name: str = "KickOffShot"
    left: int = 2
    right: int = 0
    controlled: str = "left_1"
    others: str | tuple[str, str] = "medium"
    max_cycles: int = 600
    rules: Rules = Rules.ALL
    statuses: tuple[str, ...] = ("IN_GAME", "GOAL", "OUT", "OUT_OF_TIME")
    wait: int = 20

    def setup(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """Both players near the centre, before the kick-off."""
        u = core.draw(worlds, 4)
        side = np.sign(u[:, 2] - 0.5)
        core.place_ball(worlds, np.zeros((len(worlds), 2)))
        core.place_player(worlds, 1, np.stack([-3.0 - 4.0 * u[:, 0], 2.0 * (2 * u[:, 1] - 1)], axis=1), 0.0)
        core.place_player(worlds, 2, np.stack([-8.0 - 6.0 * u[:, 3], side * (5.0 + 4.0 * u[:, 1])], axis=1), 0.0)

    def outcome(self, core: SoccerCore) -> Outcome:
        """The goal, or a call that gives the ball away; the kick-off is given when its time comes."""
        due = np.flatnonzero(core.cycle == self.wait)
        if len(due):
            core.sim.start(worlds=due)
        goal = core.goals_scored()[:, 0] > 0
        lost = np.isin(core.sim.world["mode"], _OUT)
        status = np.select([goal, lost], [1, 2], 0)
        reward = goal.astype(np.float64)[:, None].repeat(len(core.agents), axis=1)
        return Outcome(reward, status > 0, goal, status, {"goal": reward})
