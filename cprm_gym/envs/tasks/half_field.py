"""Half field offence: attackers against defenders and a goalie in one half (HFO), and the front-of-goal ladder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulator.pitch import HALF_WIDTH
from ...simulator.state import LEFT, RIGHT, Count, PlayMode
from ..pitch import Pitch, wrapped
from .base import Outcome, Status, Task, within

_CAPTURE, _CATCHES = 0, 1


@dataclass(frozen=True)
class HalfField(Task):
    """Score against the defence in the right half.

    Description
    -----------
    The left team attacks the right goal; the right team defends, its player 1 being the goalie. No referee: the episode ends
    instead.

    Actions
    -------
    Any action view; the literature uses macros (``action_mode="macro"``) or parameterised low-level actions (``box``).

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 for a goal (-1 for the defence), else 0.

    Start
    -----
    The ball lies between `ball_x` in the right half, the attackers around it, the defenders between it and the goal, the goalie in
    front of the goal.

    End
    ---
    GOAL; CAPTURED_BY_DEFENSE: the goalie holds the ball, or a defender and no attacker could kick it for `capture` cycles in a row;
    OUT_OF_BOUNDS: it left the half; OUT_OF_TIME after `max_cycles`. A goal is the
    success of the attackers, every other end that of the defence.

    References
    ----------
    Hausknecht et al., Half Field Offense, ALA 2016; Kalyanakrishnan, Liu, Stone, RoboCup 2006.
    """

    name: str = "HFO1v1"
    left: int = 1
    right: int = 1
    right_goalie: int = 1
    controlled: str = "left"
    others: str | tuple[str, str] = "medium"
    max_cycles: int = 500
    statuses: tuple[Status, ...] = (Status.GOAL, Status.CAPTURED_BY_DEFENSE, Status.OUT_OF_BOUNDS, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("goal",)
    ball_x: tuple[float, float] = (0.0, 26.0)
    ball_y: float = within(27.0, 0.0, HALF_WIDTH)
    capture: int = within(3, 1, 1000)

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Draw ball, attackers and defenders."""
        n = len(worlds)
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        u = pitch.draw(worlds, 2 + 3 * (self.left + self.right))
        ball = np.stack([self.ball_x[0] + (self.ball_x[1] - self.ball_x[0]) * u[:, 0], self.ball_y * (2 * u[:, 1] - 1)], axis=1)
        pitch.place_ball(*ball.T, worlds=worlds)
        for k in range(self.left):
            a, b, c = u[:, 2 + 3 * k], u[:, 3 + 3 * k], u[:, 4 + 3 * k]
            near = 1.5 if k == 0 else 6.0
            x = np.clip(ball[:, 0] - near - (3.0 if k == 0 else 6.0) * a + (0.0 if k == 0 else 6.0), -5.0, 45.0)
            y = np.clip(ball[:, 1] + (2 * b - 1) * (1.0 if k == 0 else 16.0), -32.0, 32.0)
            facing = wrapped(np.arctan2(ball[:, 1] - y, ball[:, 0] - x) + np.radians(20.0) * (c - 0.5))
            pitch.place_player(1 + k, x, y, facing, worlds=worlds)
        for k in range(self.right):
            j = 2 + 3 * (self.left + k)
            a, b = u[:, j], u[:, j + 1]
            if k == 0 and self.right_goalie:
                place = np.stack([np.full(n, 51.0), 4.0 * (2 * b - 1)], axis=1)
            else:
                share = 0.35 + 0.45 * a
                x = ball[:, 0] + share * (48.0 - ball[:, 0])
                y = (1 - share) * ball[:, 1] + (2 * b - 1) * 10.0
                place = np.stack([x, np.clip(y, -32.0, 32.0)], axis=1)
            facing = np.arctan2(ball[:, 1] - place[:, 1], ball[:, 0] - place[:, 0])
            pitch.place_player(12 + k, *place.T, facing, worlds=worlds)
        pitch.memory[worlds, _CATCHES] = 0

    def outcome(self, pitch: Pitch) -> Outcome:
        """Goal, capture, out of bounds."""
        w = pitch.sim.world
        goal = pitch.crossed_goal_line(right=True)
        ours, held = pitch.kickable_by(LEFT), pitch.kickable_by(RIGHT)
        pitch.memory[:, _CAPTURE] = np.where(held & ~ours, pitch.memory[:, _CAPTURE] + 1, 0)
        caught = w["counts"][:, 11, Count.CATCH] > pitch.memory[:, _CATCHES] if self.right_goalie else np.zeros(pitch.worlds, bool)
        captured = caught & held | (pitch.memory[:, _CAPTURE] >= self.capture)
        if self.right_goalie:
            pitch.memory[:, _CATCHES] = w["counts"][:, 11, Count.CATCH]
        ball = w["pos"][:, 0]
        out = (ball[:, 0] < -1.0) | (ball[:, 0] > pitch.packed["out_x"]) | (np.abs(ball[:, 1]) > pitch.packed["out_y"])
        ends = int(Status.GOAL), int(Status.CAPTURED_BY_DEFENSE), int(Status.OUT_OF_BOUNDS)
        status = np.select([goal, captured, out], ends, 0)
        over = status > 0
        reward = goal[:, None] * pitch.sides
        return Outcome(reward, over, pitch.of_sides(goal, (over | pitch.late) & ~goal), status, {"goal": reward})


def hfo(attackers: int, defenders: int) -> HalfField:
    """HFO with that many attackers and defenders (the goalie among them); the ball starts anywhere in the half."""
    return HalfField(name=f"HFO{attackers}v{defenders}", left=attackers, right=defenders, right_goalie=1 if defenders else 0)


LADDER = {
    "FrontGoalEmptyGoal": (1, 0), "FrontGoalBlockedShot": (1, 1), "FrontGoalSupportOption": (2, 1), "FrontGoalPassingLane": (3, 2),
    "FrontGoalCompactDefense": (4, 3),
}  # fmt: skip
"""The five steps of the front-of-goal ladder: attackers and defenders."""


def front_goal(name: str) -> HalfField:
    """A step of the ladder: the ball starts 14 to 24 m in front of the goal."""
    attackers, defenders = LADDER[name]
    return HalfField(name=name, left=attackers, right=defenders, right_goalie=1 if defenders else 0, ball_x=(28.5, 38.5), ball_y=10.0,
                     max_cycles=200)  # fmt: skip
