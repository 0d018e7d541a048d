"""Soccer: a match, or a half of it, between two sides of any size."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...simulator.parameters import Rules, ServerParameters
from ..kernels import pitch as kernels
from ..pitch import Pitch
from ..players.scripted import FORMATION
from .base import Outcome, Status, Task

FULL_TIME = ServerParameters(auto_mode=True, kick_off_wait=30)
"""The kick-off after half-time comes by itself, after 3 seconds in which the players go to their places."""


@dataclass(frozen=True)
class Soccer(Task):
    """A match under the server's rules.

    Description
    -----------
    `left` against `right` players, kick-off by the left team, the referee on; players whom nobody controls are scripted.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

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
    FULL_TIME when the referee ends the match, success of the side with more goals; OUT_OF_TIME after `max_cycles`.

    References
    ----------
    Rules: specification/simulator.md 7 (server 19).
    """

    name: str = "Soccer"
    left: int = 11
    right: int = 11
    left_goalie: int = 1
    right_goalie: int = 1
    controlled: str = "all"
    others: str | tuple[str, str] = "medium"
    max_cycles: int = 9000
    rules: Rules = Rules.ALL
    statuses: tuple[Status, ...] = (Status.FULL_TIME, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("goal",)
    parameters: ServerParameters = field(default_factory=lambda: FULL_TIME)

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Formation, then the kick-off procedure."""
        for side, count in ((1, self.left), (-1, self.right)):
            for unum in range(1, count + 1):
                x, y = FORMATION[unum - 1]
                body = 0.0 if side == 1 else np.pi
                pitch.place_player(unum if side == 1 else 11 + unum, side * x, side * y, body, worlds=worlds)
        pitch.place_ball(0.0, 0.0, worlds=worlds)
        pitch.sim.trainer.start(worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Goals since the cycle before, from each agent's side."""
        shape = (pitch.worlds, len(pitch.players))
        reward, over, won = np.empty(shape), np.empty(pitch.worlds, np.bool_), np.empty(shape, np.bool_)
        kernels.match_outcome(pitch.sim.world, pitch.goals_scored(), pitch.sides, reward, over, won)
        return Outcome(reward, over, won, over * int(Status.FULL_TIME), {"goal": reward})
