"""Goalie: keep the ball out of the goal (demonstration 2); alone against shots and a shooter, or against attackers who mix."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import ParameterError
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import Count, PlayerBit, PlayMode
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

_CATCHES = 0


@dataclass(frozen=True)
class GoalKeeping(Task):
    """Base of the tasks in which player 1 of the left side guards the goal: how an episode ends, and for whom it is good."""

    left: int = 1
    left_goalie: int = 1
    controlled: str = "left_1"
    max_cycles: int = 200
    statuses: tuple[Status, ...] = (Status.SAVED, Status.GOAL, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("saved",)

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


@dataclass(frozen=True)
class Goalie(GoalKeeping):
    """One goalie against shots and shooters.

    Description
    -----------
    The agent guards the left goal. In `shots` of the episodes the ball is on its way to the goal, in the others an attacker has it in
    front of him, dribbles and shoots; with ``others="mixing"`` he mixes dribbles, feints, passes and shots (`mix`).

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
    right: int = 2
    others: str | tuple[str, str] = "strong"
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


@dataclass(frozen=True)
class GoalieAgainstAttack(GoalKeeping):
    """One goalie, alone or with scripted defenders, against attackers who mix.

    Description
    -----------
    The agent guards the left goal against `right` attackers; every other player of his side is a scripted defender. What an attacker has
    in mind (dribble, feint, pass, shoot) is hidden, drawn by the world's own luck, and held for a while (`mix`).

    Actions
    -------
    Any action view; ``catch`` is what goalies have.

    Observations
    ------------
    The common schema; nothing is added. Nobody is told what an attacker has in mind.

    Rewards
    -------
    1 for a save, -1 for a goal; the opposite for the attackers.

    Start
    -----
    The goalie stands in front of the middle of the goal. The first attacker has the ball at his feet, `near` to `far` metres from the goal
    and within `spread` degrees of the middle; the others stand 7 to 14 m beside him, on either side in turn, up to 4 m before or behind.
    Defenders stand on the way from the ball to the goal, at 0.3 to 0.7 of it, up to 6 m aside.

    End
    ---
    SAVED: caught (a ball in his hands is dead, as with a referee), or 36 m in front of the goal line or over another line; GOAL;
    OUT_OF_TIME after `max_cycles`. Without a goal it is the goalie's success, with one the attackers'.
    """

    name: str = "Goalie2v1"
    right: int = 2
    others: str | tuple[str, str] = ("weak", "mixing")
    near: float = within(20.0, 5.0, 35.0)
    far: float = within(30.0, 5.0, 35.0)
    spread: float = within(40.0, 0.0, 60.0)

    def __post_init__(self) -> None:
        """Refuse distances in the wrong order."""
        super().__post_init__()
        if self.near > self.far:
            raise ParameterError(f"task {self.name!r}: near: {self.near:g} given; allowed are numbers up to far, {self.far:g}")

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Draw ball, attackers and defenders."""
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        u = pitch.draw(worlds, 4 + 2 * (self.left + self.right))
        distance = self.near + (self.far - self.near) * u[:, 0]
        angle = (2 * u[:, 1] - 1) * math.radians(self.spread)
        ball = np.stack([-HALF_LENGTH + distance * np.cos(angle), distance * np.sin(angle)], axis=1)
        pitch.place_ball(*ball.T, worlds=worlds)
        pitch.place_player(1, -50.0, 2.0 * (2 * u[:, 2] - 1), 0.0, worlds=worlds)
        first = np.where(u[:, 3] < 0.5, 1.0, -1.0)
        for k in range(self.right):
            a, b = u[:, 4 + 2 * k], u[:, 5 + 2 * k]
            aside = first * (-1.0) ** k * (7.0 + 7.0 * a) * (k > 0)
            x = ball[:, 0] + (0.7 if k == 0 else 4.0 * (2 * b - 1))
            y = np.clip(ball[:, 1] + aside, 1.0 - HALF_WIDTH, HALF_WIDTH - 1.0)
            pitch.place_player(12 + k, x, y, math.pi, worlds=worlds)
        for k in range(1, self.left):
            a, b = u[:, 4 + 2 * (self.right + k)], u[:, 5 + 2 * (self.right + k)]
            share = 0.3 + 0.4 * a
            x, y = ball[:, 0] - share * (ball[:, 0] + HALF_LENGTH), (1.0 - share) * ball[:, 1] + 6.0 * (2 * b - 1)
            pitch.place_player(1 + k, x, y, np.arctan2(ball[:, 1] - y, ball[:, 0] - x), worlds=worlds)


def against_attack(attackers: int, defenders: int) -> GoalieAgainstAttack:
    """The goalie and the defenders beside him against that many attackers."""
    return GoalieAgainstAttack(name=f"Goalie{attackers}v{defenders}", left=defenders, right=attackers)
