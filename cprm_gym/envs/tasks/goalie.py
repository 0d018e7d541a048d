"""Goalie: keep the ball out of the goal (demonstration 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import Count, PlayerBit, PlayMode
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

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
    1 for a save, -1 for a goal; the opposite for the attackers.

    Start
    -----
    The goalie stands in front of the middle of the goal. A shot starts 16 to 28 m away, aimed at a point of the goal, at a speed that
    grows with `difficulty`; a shooter starts 18 to 30 m away with the ball at his feet.

    End
    ---
    SAVED: caught (a ball in his hands is dead, as with a referee), or 36 m in front of the goal line or over another line; GOAL;
    OUT_OF_TIME after `max_cycles`. Without a goal it is the goalie's success, with one the attackers'.

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
    statuses: tuple[Status, ...] = (Status.SAVED, Status.GOAL, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("saved",)
    difficulty: float = within(0.5, 0.0, 1.0)
    shots: float = within(0.5, 0.0, 1.0)

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Draw a shot or a shooter."""
        n, p = len(worlds), self.parameters
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        u = pitch.draw(worlds, 10)
        shot = u[:, 0] < self.shots
        distance = np.where(shot, 16.0 + 12.0 * u[:, 1], 18.0 + 12.0 * u[:, 1])
        angle = (2 * u[:, 2] - 1) * math.radians(50)
        ball = np.stack([-HALF_LENGTH + distance * np.cos(angle), distance * np.sin(angle)], axis=1)
        aim = np.stack([np.full(n, -HALF_LENGTH), (2 * u[:, 3] - 1) * 6.0], axis=1) - ball
        length = np.hypot(aim[:, 0], aim[:, 1])
        # fast enough to arrive, at most what a kick can give
        least = (1.0 - p.ball_decay) * length + 0.5
        speed = least + (min(p.ball_accel_max, p.ball_speed_max) - least) * np.clip(self.difficulty + 0.4 * (u[:, 4] - 0.5), 0.0, 1.0)
        velocity = np.where(shot[:, None], speed[:, None] * aim / length[:, None], 0.0)
        pitch.place_ball(*ball.T, *velocity.T, worlds=worlds)
        pitch.place_player(1, -50.0, 2.0 * (2 * u[:, 5] - 1), 0.0, worlds=worlds)
        behind = ball + np.stack([np.full(n, 0.7), np.zeros(n)], axis=1)
        away = np.stack([-20.0 + 10.0 * u[:, 6], 25.0 * np.sign(u[:, 7] - 0.5)], axis=1)
        pitch.place_player(12, *np.where(shot[:, None], away, behind).T, math.pi, worlds=worlds)
        second = np.stack([ball[:, 0] + 3.0, np.clip(ball[:, 1] + 12.0 * np.sign(u[:, 8] - 0.5), -30.0, 30.0)], axis=1)
        pitch.place_player(13, *np.where(shot[:, None], away + [6.0, 0.0], second).T, math.pi, worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Saved or not."""
        w = pitch.sim.world
        goal = pitch.crossed_goal_line(right=False)
        # with a referee a caught ball is dead, whatever an attacker does to it in the same cycle; a punch is a fault
        held = (w["bits_shown"][:, 0] & (PlayerBit.CATCH | PlayerBit.CATCH_FAULT)) == PlayerBit.CATCH
        caught = held & (w["counts"][:, 0, Count.CATCH] > pitch.memory[:, _CATCHES])
        pitch.memory[:, _CATCHES] = w["counts"][:, 0, Count.CATCH]
        goal = goal & ~caught
        ball = w["pos"][:, 0]
        away = (ball[:, 0] > -HALF_LENGTH + 36.0) | (np.abs(ball[:, 1]) > HALF_WIDTH) | (ball[:, 0] < -pitch.packed["out_x"])
        saved = (caught | away) & ~goal
        status = np.select([goal, saved], [int(Status.GOAL), int(Status.SAVED)], 0)
        reward = (saved.astype(np.float64) - goal)[:, None] * pitch.sides
        success = pitch.of_sides(saved | (pitch.late & ~goal), goal)
        return Outcome(reward, status > 0, success, status, {"saved": reward})
