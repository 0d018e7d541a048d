"""PassAndAdvance: two players pass back and forth, advance and shoot (demonstration 3), also against defenders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulator.parameters import Rules
from ...simulator.state import Count, PlayMode
from ..pitch import Pitch
from .base import Outcome, Status
from .kick_off_shot import _OUT
from .opposed import Opposed

_LAST, _PASSES, _KICKS_1, _KICKS_2 = 0, 1, 2, 3


@dataclass(frozen=True)
class PassAndAdvance(Opposed):
    """Advance by passing, then score.

    Description
    -----------
    Two agents and a ball in their own half, the referee on; no opponents, or in PassAndAdvance2v1, 2v2, 2v3 so many defenders and no
    keeper. A pass is a change of the kicker without a kick of the defence between.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a goal after at least `passes` passes, shared (-1 for opponents, if there are any); a goal before that ends the episode
    without reward.

    Start
    -----
    The agents side by side, 10 to 16 m apart, 30 to 40 m before the halfway line; the ball in front of the first;
    defenders between `nearest` and `farthest`.

    End
    ---
    GOAL, TOO_EARLY (a goal without enough passes), CAPTURED_BY_DEFENSE (opponents scored, or the attack did not kick the ball for `capture`
    cycles after they did), OUT_OF_BOUNDS (or a fault), OUT_OF_TIME after `max_cycles`.

    References
    ----------
    Dissertation 4.3 (Figs. 4.3-4.6).
    """

    name: str = "PassAndAdvance"
    left: int = 2
    right: int = 0
    controlled: str = "left"
    others: str | tuple[str, str] = ("hold", "medium")
    max_cycles: int = 1000
    rules: Rules = Rules.ALL
    statuses: tuple[Status, ...] = (Status.GOAL, Status.CAPTURED_BY_DEFENSE, Status.TOO_EARLY, Status.OUT_OF_BOUNDS, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("goal",)
    passes: int = 3

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """The two abreast in their half, the ball at the feet of the first."""
        u = pitch.draw(worlds, 4)
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        x, apart = -40.0 + 10.0 * u[:, 0], 10.0 + 6.0 * u[:, 1]
        middle = 6.0 * (2 * u[:, 2] - 1)
        pitch.place_ball(x + 3.0 + 2.0 * u[:, 3], middle - apart / 2, worlds=worlds)
        pitch.place_player(1, x, middle - apart / 2, 0.0, worlds=worlds)
        pitch.place_player(2, x, middle + apart / 2, -np.pi / 4, worlds=worlds)
        self.place_defence(pitch, worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Counts passes; a goal counts when there were enough."""
        kicks = pitch.sim.world["counts"][:, :2, Count.KICK]
        memory = pitch.memory
        theirs, captured = self.captured(pitch, np.asarray((kicks > memory[:, _KICKS_1 : _KICKS_2 + 1]).any(axis=1)))
        for player, column in ((1, _KICKS_1), (2, _KICKS_2)):
            kicked = kicks[:, player - 1] > memory[:, column]
            memory[:, _PASSES] += kicked & (memory[:, _LAST] == 3 - player)
            memory[:, _LAST] = np.where(kicked, player, memory[:, _LAST])
            memory[:, column] = kicks[:, player - 1]
        memory[theirs, _LAST] = 0
        scored = pitch.goals_scored()[:, 0] > 0
        enough = memory[:, _PASSES] >= self.passes
        lost = np.isin(pitch.sim.world["mode"], _OUT)
        ends = int(Status.GOAL), int(Status.TOO_EARLY), int(Status.CAPTURED_BY_DEFENSE), int(Status.OUT_OF_BOUNDS)
        status = np.select([scored & enough, scored, captured, lost], ends, 0)
        won, over = status == Status.GOAL, status > 0
        reward = won[:, None] * pitch.sides
        return Outcome(reward, over, pitch.of_sides(won, (over | pitch.late) & ~won), status, {"goal": reward})
