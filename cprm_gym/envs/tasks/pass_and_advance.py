"""PassAndAdvance: two players pass back and forth, advance and shoot (demonstration 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...simulator.parameters import Rules
from ...simulator.state import Count, PlayMode
from .base import Outcome, Task
from .kick_off_shot import _OUT

if TYPE_CHECKING:
    from ..core import SoccerCore

_LAST, _PASSES, _KICKS_1, _KICKS_2 = 0, 1, 2, 3


@dataclass(frozen=True)
class PassAndAdvance(Task):
    """Advance by passing, then score.

    Description
    -----------
    Two agents and a ball in their own half, no opponents, the referee on. A pass is a change of the kicker.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a goal after at least `passes` passes, shared; a goal before that ends the episode without reward.

    Start
    -----
    The agents side by side, 10 to 16 m apart, 30 to 40 m before the halfway line; the ball in front of the first.

    End
    ---
    GOAL, TOO_EARLY (a goal without enough passes), OUT, OUT_OF_TIME after `max_cycles`.

    References
    ----------
    Dissertation 4.3 (Figs. 4.3-4.6).
    """

    name: str = "PassAndAdvance"
    left: int = 2
    right: int = 0
    controlled: str = "left"
    max_cycles: int = 1000
    rules: Rules = Rules.ALL
    statuses: tuple[str, ...] = ("IN_GAME", "GOAL", "TOO_EARLY", "OUT", "OUT_OF_TIME")
    passes: int = 3

    def setup(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """The two abreast in their half, the ball at the feet of the first."""
        u = core.draw(worlds, 4)
        core.sim.world["mode"][worlds] = PlayMode.play_on
        x, apart = -40.0 + 10.0 * u[:, 0], 10.0 + 6.0 * u[:, 1]
        middle = 6.0 * (2 * u[:, 2] - 1)
        core.place_player(worlds, 1, np.stack([x, middle - apart / 2], axis=1), 0.0)
        core.place_player(worlds, 2, np.stack([x, middle + apart / 2], axis=1), -45.0)
        core.place_ball(worlds, np.stack([x + 3.0 + 2.0 * u[:, 3], middle - apart / 2], axis=1))

    def outcome(self, core: SoccerCore) -> Outcome:
        """Counts passes; a goal counts when there were enough."""
        kicks = core.sim.world["counts"][:, :2, Count.KICK]
        memory = core.memory
        for player, column in ((1, _KICKS_1), (2, _KICKS_2)):
            kicked = kicks[:, player - 1] > memory[:, column]
            memory[:, _PASSES] += kicked & (memory[:, _LAST] == 3 - player)
            memory[:, _LAST] = np.where(kicked, player, memory[:, _LAST])
            memory[:, column] = kicks[:, player - 1]
        scored = core.goals_scored()[:, 0] > 0
        enough = memory[:, _PASSES] >= self.passes
        lost = np.isin(core.sim.world["mode"], _OUT)
        status = np.select([scored & enough, scored, lost], [1, 2, 3], 0)
        won = status == 1
        reward = won.astype(np.float64)[:, None].repeat(len(core.agents), axis=1)
        return Outcome(reward, status > 0, won, status, {"goal": reward})
