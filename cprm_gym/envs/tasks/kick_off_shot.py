"""KickOffShot: from the kick-off to a goal (demonstration 1), also against a keeper and defenders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulator.parameters import Rules
from ...simulator.state import Count, PlayMode
from ..pitch import Pitch
from .base import Outcome, Status
from .opposed import Opposed

_OUT = np.array(
    [PlayMode.kick_in_r, PlayMode.goal_kick_r, PlayMode.corner_kick_r, PlayMode.free_kick_r, PlayMode.offside_l, PlayMode.free_kick_fault_l,
     PlayMode.kick_in_l, PlayMode.goal_kick_l, PlayMode.corner_kick_l, PlayMode.indirect_free_kick_r]
)  # fmt: skip

_LAST = 0
"""Column of ``pitch.memory``: who kicked last; columns 1 and 2: the kicks of both."""


@dataclass(frozen=True)
class KickOffShot(Opposed):
    """Kick off, pass, run forward, receive the return pass, dribble, shoot, score.

    Description
    -----------
    The agent and one team-mate, who passes back, against an empty half; in KickOffShot2v2 against a keeper and a defender. The referee
    is on.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a goal of the agent; -1 for opponents, if there are any.

    Start
    -----
    Before the kick-off, which comes after `wait` cycles: the agent some metres behind the ball. At the kick-off the team-mate stands
    8 to 14 m behind the halfway line, 5 to 9 m to a side (all drawn); a keeper in front of his goal, other defenders between `nearest`
    and `farthest`.

    End
    ---
    GOAL; MATES_GOAL: the team-mate kicked last; CAPTURED_BY_DEFENSE: the keeper caught the ball, opponents scored, or the attack did not
    kick it for `capture` cycles after they did; OUT_OF_BOUNDS: the ball went out or a fault was called; OUT_OF_TIME after `max_cycles`.

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
    statuses: tuple[Status, ...] = (Status.GOAL, Status.CAPTURED_BY_DEFENSE, Status.MATES_GOAL, Status.OUT_OF_BOUNDS, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("goal",)
    wait: int = 20

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Both players near the centre, before the kick-off."""
        u = pitch.draw(worlds, 2)
        pitch.place_ball(0.0, 0.0, worlds=worlds)
        pitch.place_player(1, -3.0 - 4.0 * u[:, 0], 2.0 * (2 * u[:, 1] - 1), 0.0, worlds=worlds)
        self._place_others(pitch, worlds)

    def _place_others(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """The team-mate behind the halfway line, on either side, and the defence."""
        u = pitch.draw(worlds, 3)
        side = np.sign(u[:, 0] - 0.5)
        pitch.place_player(2, -8.0 - 6.0 * u[:, 1], side * (5.0 + 4.0 * u[:, 2]), 0.0, (0.0, 0.0), worlds=worlds)
        self.place_defence(pitch, worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """The goal, or a call that gives the ball away; the kick-off is given when its time comes."""
        due = np.flatnonzero(pitch.cycle == self.wait)
        if len(due):
            self._place_others(pitch, due)
            pitch.sim.trainer.start(worlds=due)
        kicks = pitch.sim.world["counts"][:, :2, Count.KICK]
        ours = np.asarray((kicks > pitch.memory[:, 1:3]).any(axis=1))
        for player in (1, 2):
            kicked = kicks[:, player - 1] > pitch.memory[:, player]
            pitch.memory[:, _LAST] = np.where(kicked, player, pitch.memory[:, _LAST])
            pitch.memory[:, player] = kicks[:, player - 1]
        scored = pitch.goals_scored()[:, 0] > 0
        goal = scored & (pitch.memory[:, _LAST] == 1)
        _, captured = self.captured(pitch, ours)
        lost = np.isin(pitch.sim.world["mode"], _OUT)
        ends = int(Status.GOAL), int(Status.MATES_GOAL), int(Status.CAPTURED_BY_DEFENSE), int(Status.OUT_OF_BOUNDS)
        status = np.select([goal, scored, captured, lost], ends, 0)
        over = status > 0
        reward = goal[:, None] * pitch.sides
        return Outcome(reward, over, pitch.of_sides(goal, (over | pitch.late) & ~goal), status, {"goal": reward})
