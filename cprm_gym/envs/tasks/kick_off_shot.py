"""KickOffShot: from the kick-off to a goal, without opponents (demonstration 1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...simulator.parameters import Rules
from ...simulator.state import Count, PlayMode
from .base import Outcome, Task

if TYPE_CHECKING:
    from ..core import SoccerCore

_OUT = np.array(
    [PlayMode.kick_in_r, PlayMode.goal_kick_r, PlayMode.corner_kick_r, PlayMode.free_kick_r, PlayMode.offside_l, PlayMode.free_kick_fault_l,
     PlayMode.kick_in_l, PlayMode.goal_kick_l, PlayMode.corner_kick_l, PlayMode.indirect_free_kick_r]
)  # fmt: skip

_LAST = 0
"""Column of ``core.memory``: who kicked last; columns 1 and 2: the kicks of both."""


@dataclass(frozen=True)
class KickOffShot(Task):
    """Kick off, pass, run forward, receive the return pass, dribble, shoot, score.

    Description
    -----------
    The agent and one team-mate, who passes back, against an empty half. The referee is on.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a goal of the agent.

    Start
    -----
    Before the kick-off, which comes after `wait` cycles: the agent some metres behind the ball. At the kick-off the team-mate stands
    8 to 14 m behind the halfway line, 5 to 9 m to a side (all drawn).

    End
    ---
    GOAL; MATES_GOAL: the team-mate kicked last; OUT: the ball went out or a fault was called; OUT_OF_TIME after `max_cycles`.

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
    statuses: tuple[str, ...] = ("IN_GAME", "GOAL", "MATES_GOAL", "OUT", "OUT_OF_TIME")
    wait: int = 20

    def setup(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """Both players near the centre, before the kick-off."""
        u = core.draw(worlds, 2)
        core.place_ball(worlds, np.zeros((len(worlds), 2)))
        core.place_player(worlds, 1, np.stack([-3.0 - 4.0 * u[:, 0], 2.0 * (2 * u[:, 1] - 1)], axis=1), 0.0)
        self._place_mate(core, worlds)

    def _place_mate(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """The team-mate behind the halfway line, on either side."""
        u = core.draw(worlds, 3)
        side = np.sign(u[:, 0] - 0.5)
        core.place_player(worlds, 2, np.stack([-8.0 - 6.0 * u[:, 1], side * (5.0 + 4.0 * u[:, 2])], axis=1), 0.0)

    def outcome(self, core: SoccerCore) -> Outcome:
        """The goal, or a call that gives the ball away; the kick-off is given when its time comes."""
        due = np.flatnonzero(core.cycle == self.wait)
        if len(due):
            self._place_mate(core, due)
            core.sim.trainer.start(worlds=due)
        kicks = core.sim.world["counts"][:, :2, Count.KICK]
        for player in (1, 2):
            kicked = kicks[:, player - 1] > core.memory[:, player]
            core.memory[:, _LAST] = np.where(kicked, player, core.memory[:, _LAST])
            core.memory[:, player] = kicks[:, player - 1]
        scored = core.goals_scored()[:, 0] > 0
        goal = scored & (core.memory[:, _LAST] == 1)
        lost = np.isin(core.sim.world["mode"], _OUT)
        status = np.select([goal, scored, lost], [1, 2, 3], 0)
        reward = goal.astype(np.float64)[:, None].repeat(len(core.agents), axis=1)
        return Outcome(reward, status > 0, goal, status, {"goal": reward})
