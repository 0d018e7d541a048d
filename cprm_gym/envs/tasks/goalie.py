"""Goalie: keep the ball out of the goal (demonstration 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...simulator.state import Count, PlayMode
from .base import Outcome, Task, within

if TYPE_CHECKING:
    from ..core import SoccerCore

SAVED, CONCEDED = 1, 2
_CATCHES = 0


@dataclass(frozen=True)
class Goalie(Task):
    """One goalie against shots and shooters.

    Description
    -----------
    The agent guards the left goal. In `shots` of the episodes the ball is on its way to the goal, in the others an attacker has it in
    front of him, dribbles and shoots.

    Actions
    -------
    Any action view; ``catch`` is what goalies have.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a save, -1 for a goal.

    Start
    -----
    The goalie stands in front of the middle of the goal. A shot starts 16 to 28 m away, aimed at a point of the goal, at a speed that
    grows with `difficulty`; a shooter starts 18 to 30 m away with the ball at his feet.

    End
    ---
    SAVED: caught, or 25 m in front of the goal line or over another line; GOAL; OUT_OF_TIME after `max_cycles` (no goal: success).

    References
    ----------
    Dissertation 2.3.5 (Figs. 2.25-2.30).
    """

    name: str = "Goalie"
    left: int = 1
    right: int = 2
    left_goalie: int = 1
    controlled: str = "left_1"
    others: str | tuple[str, str] = "strong"
    max_cycles: int = 200
    statuses: tuple[str, ...] = ("IN_GAME", "SAVED", "GOAL", "OUT_OF_TIME")
    difficulty: float = within(0.5, 0.0, 1.0)
    shots: float = within(0.5, 0.0, 1.0)

    def setup(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """Draw a shot or a shooter."""
        n = len(worlds)
        core.sim.world["mode"][worlds] = PlayMode.play_on
        u = core.draw(worlds, 10)
        shot = u[:, 0] < self.shots
        distance = np.where(shot, 16.0 + 12.0 * u[:, 1], 18.0 + 12.0 * u[:, 1])
        angle = (2 * u[:, 2] - 1) * math.radians(50)
        ball = np.stack([-52.5 + distance * np.cos(angle), distance * np.sin(angle)], axis=1)
        aim = np.stack([np.full(n, -52.5), (2 * u[:, 3] - 1) * 6.0], axis=1) - ball
        length = np.hypot(aim[:, 0], aim[:, 1])
        # fast enough to arrive, at most what a kick can give
        least = 0.06 * length + 0.5
        speed = least + (2.7 - least) * np.clip(self.difficulty + 0.4 * (u[:, 4] - 0.5), 0.0, 1.0)
        velocity = np.where(shot[:, None], speed[:, None] * aim / length[:, None], 0.0)
        core.place_ball(worlds, ball, velocity)
        core.place_player(worlds, 1, np.stack([np.full(n, -50.0), 2.0 * (2 * u[:, 5] - 1)], axis=1), 0.0)
        behind = ball + np.stack([np.full(n, 0.7), np.zeros(n)], axis=1)
        away = np.stack([-20.0 + 10.0 * u[:, 6], 25.0 * np.sign(u[:, 7] - 0.5)], axis=1)
        core.place_player(worlds, 12, np.where(shot[:, None], away, behind), 180.0)
        second = np.stack([ball[:, 0] + 3.0, np.clip(ball[:, 1] + 12.0 * np.sign(u[:, 8] - 0.5), -30.0, 30.0)], axis=1)
        core.place_player(worlds, 13, np.where(shot[:, None], away + [6.0, 0.0], second), 180.0)

    def outcome(self, core: SoccerCore) -> Outcome:
        """Saved or not."""
        w = core.sim.world
        goal = core.crossed_goal_line(right=False)
        caught = (w["counts"][:, 0, Count.CATCH] > core.memory[:, _CATCHES]) & core.kickable(1)
        core.memory[:, _CATCHES] = w["counts"][:, 0, Count.CATCH]
        ball = w["pos"][:, 0]
        away = (ball[:, 0] > -52.5 + 36.0) | (np.abs(ball[:, 1]) > 34.0) | (ball[:, 0] < -52.585)
        saved = (caught | away) & ~goal
        status = np.select([goal, saved], [CONCEDED, SAVED], 0)
        late = (core.cycle >= self.max_cycles) & (status == 0)
        reward = (saved.astype(np.float64) - goal)[:, None]
        return Outcome(reward, status > 0, saved | late, status, {"saved": reward})
