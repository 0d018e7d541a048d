"""Keepaway: the keepers keep the ball from the takers inside a square."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...simulator.state import LEFT, RIGHT, PlayMode
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

_TAKEN = 0


@dataclass(frozen=True)
class Keepaway(Task):
    """Keep the ball as long as possible.

    Description
    -----------
    `left` keepers against `right` takers in a square of `size` metres around the centre of the pitch. The metric is the duration of
    the episode.

    Actions
    -------
    Any action view. In the macro view with `automatic` (default) the decisions are those of the literature: ``hold`` or ``pass_k`` for
    the keeper who can kick the ball, and ``receive`` (go to the ball if fastest, else get open) for the others, whatever they choose.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 per cycle for the keepers, -1 for the takers.

    Start
    -----
    Three keepers near three corners (further ones in the centre), the takers at the fourth, the ball 4 m from the first keeper's
    corner.

    End
    ---
    TAKEN: a taker could kick the ball for 4 cycles, not counting those in which a keeper could too; OUT_OF_BOUNDS: it left the
    square: the takers' success. OUT_OF_TIME: `max_cycles` are reached, the keepers' success.

    References
    ----------
    Stone, Sutton, Kuhlmann, Adaptive Behavior 13(3), 2005; specification/simulator.md 7.13.
    """

    name: str = "Keepaway3v2"
    left: int = 3
    right: int = 2
    controlled: str = "left"
    others: str | tuple[str, str] = ("keep_hand", "take")
    max_cycles: int = 1000
    metric: str = "duration"
    statuses: tuple[Status, ...] = (Status.TAKEN, Status.OUT_OF_BOUNDS, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("cycles",)
    size: float = within(20.0, 5.0, 60.0)
    takes: int = within(4, 1, 1000)
    automatic: bool = True

    @property
    def region(self) -> tuple[float, float]:
        """The square."""
        return self.size / 2, self.size / 2

    def restrict(self, names: tuple[str, ...], mask: np.ndarray) -> None:
        """Leave ``hold`` and ``pass_k`` to who has the ball, ``receive`` to the others."""
        if self.automatic:
            with_ball = mask[..., names.index("hold")].copy()
            for k, name in enumerate(names):
                if name == "hold" or name.startswith("pass_"):
                    mask[..., k] &= with_ball
                else:
                    mask[..., k] = ~with_ball if name == "receive" else False

    def decide(self, names: tuple[str, ...], mask: np.ndarray, action: Any) -> Any:
        """Who has no ball receives."""
        if not self.automatic or np.shape(action) != mask.shape[:2]:
            return action
        return np.where(mask[..., names.index("receive")], names.index("receive"), action)

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Keepers at three corners, takers at the fourth (specification/simulator.md 7.13); who stands where is drawn."""
        half = self.size / 2
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        u = pitch.draw(worlds, 1 + 2 * (self.left + self.right))
        pitch.place_ball(-half + 4.0, -half + 4.0, worlds=worlds)
        corners = np.array([[-half, -half], [half, -half], [half, half]])
        first = (u[:, 0] * min(3, self.left)).astype(int)
        for k in range(self.left):
            a, b = u[:, 1 + 2 * k], u[:, 2 + 2 * k]
            if k < 3:
                corner = corners[(first + k) % min(3, self.left)]
                inside = -np.sign(corner) * 3.0 * np.stack([a, b], axis=1)
                place = corner + inside
            else:
                place = np.stack([2 * a - 1, 2 * b - 1], axis=1)
            self._face_ball(pitch, worlds, 1 + k, place)
        for k in range(self.right):
            a, b = u[:, 1 + 2 * (self.left + k)], u[:, 2 + 2 * (self.left + k)]
            self._face_ball(pitch, worlds, 12 + k, np.stack([-half + 3.0 * a, half - 3.0 * b], axis=1))

    @staticmethod
    def _face_ball(pitch: Pitch, worlds: np.ndarray, player: int, place: np.ndarray) -> None:
        ball = pitch.sim.world["pos"][worlds, 0]
        pitch.place_player(player, *place.T, np.arctan2(ball[:, 1] - place[:, 1], ball[:, 0] - place[:, 0]), worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Taken, out, or on it goes."""
        keeper, taker = pitch.kickable_by(LEFT), pitch.kickable_by(RIGHT)
        taken = pitch.memory[:, _TAKEN]
        pitch.memory[:, _TAKEN] = np.where(taker, taken + 1, np.where(keeper, 0, taken))
        lost = pitch.memory[:, _TAKEN] >= self.takes
        out = (np.abs(pitch.sim.world["pos"][:, 0]) >= self.size / 2).any(axis=1)
        status = np.select([lost, out], [int(Status.TAKEN), int(Status.OUT_OF_BOUNDS)], 0)
        over = status > 0
        reward = np.ones(pitch.worlds)[:, None] * pitch.sides
        return Outcome(reward, over, pitch.of_sides(pitch.late & ~over, over), status, {"cycles": reward})


def keepaway(keepers: int, takers: int, size: float) -> Keepaway:
    """Keepaway with that many keepers and takers in a square of `size` metres."""
    return Keepaway(name=f"Keepaway{keepers}v{takers}", left=keepers, right=takers, size=size)
