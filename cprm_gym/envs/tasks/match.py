"""Soccer: a match, or a half of it, between two sides of any size."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...simulator.parameters import Rules
from .base import Outcome, Task

if TYPE_CHECKING:
    from ..core import SoccerCore

FORMATION = (
    (-50.0, 0.0), (-36.0, -6.0), (-36.0, 6.0), (-34.0, -18.0), (-34.0, 18.0), (-22.0, 0.0),
    (-18.0, -12.0), (-18.0, 12.0), (-11.0, -22.0), (-11.0, 22.0), (-10.5, 0.0),
)  # fmt: skip
"""Where the players 1 to 11 stand before a kick-off, metres in the own team's frame."""


@dataclass(frozen=True)
class Soccer(Task):
    """A match under the server's rules.

    Description
    -----------
    `left` against `right` players, kick-off by the left team, the referee on.

    Actions
    -------
    Any action view; see `cprm_gym.envs.spaces`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    +1 for a goal of the agent's own team, -1 for one of the opponent.

    Start
    -----
    All players in formation, the left team about to kick off.

    End
    ---
    Terminated when the referee ends the match; truncated after `max_cycles`.

    References
    ----------
    Rules: SIMULATOR.md 7 (server 19).
    """

    name: str = "Soccer"
    left: int = 11
    right: int = 11
    left_goalie: int = 1
    right_goalie: int = 1
    controlled: str = "all"
    max_cycles: int = 6000
    rules: Rules = Rules.ALL
    statuses: tuple[str, ...] = ("IN_GAME", "TIME_UP", "OUT_OF_TIME")
    formation: tuple[tuple[float, float], ...] = field(default=FORMATION)

    def setup(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """Formation, then the kick-off procedure."""
        for side, count in ((1, self.left), (-1, self.right)):
            for unum in range(1, count + 1):
                x, y = self.formation[unum - 1]
                position = np.tile([side * x, side * y], (len(worlds), 1))
                core.place_player(worlds, unum if side == 1 else 11 + unum, position, 0.0 if side == 1 else 180.0)
        core.place_ball(worlds, np.zeros((len(worlds), 2)))
        core.sim.start(worlds=worlds)

    def outcome(self, core: SoccerCore) -> Outcome:
        """Goals since the cycle before, from each agent's side."""
        w = core.sim.world
        gained = core.goals_scored()
        sides = np.where(core.players <= 11, 1.0, -1.0)
        reward = (gained[:, 0] - gained[:, 1])[:, None] * sides[None, :]
        over = w["mode"] == 2
        won = over & (w["score"][:, 0] > w["score"][:, 1])
        return Outcome(reward, over, won, over.astype(np.int64), {"goal": reward})
