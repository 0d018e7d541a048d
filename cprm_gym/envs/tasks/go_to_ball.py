"""GoToBall: reach a ball that lies or rolls somewhere, through one's own senses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import ParameterError
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import PlayMode
from ..kernels import pitch as kernels
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

SUCCESS = int(Status.SUCCESS)


@dataclass(frozen=True)
class GoToBall(Task):
    """A player at a random place must reach the ball, moving or still, through his own senses.

    Description
    -----------
    One player (or several: ``left=2``), one ball, no referee. A player does not know where the ball is, nor where he is.

    Actions
    -------
    Any action view; see `cprm_gym.envs.actions`.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    ``reached``: 1 in the cycle in which the ball becomes kickable for a player of the own side, -1 for one of the other side, else 0;
    shared. ``to_ball_progress``: 0.25 for each 10 m that the agent came nearer to the ball in the cycle, less where it came away from him;
    0 for who stands beside a ball that lies still, and in all never more than the way that there was. ``reward="sparse"`` leaves it out.

    Start
    -----
    The player stands anywhere on the pitch looking anywhere; the ball is at `near` to `far` metres in a direction drawn
    uniformly among those that keep it on the pitch. With probability `rolling` it moves, at up to `speed` m / cycle in a direction in
    which it comes to rest on the pitch. Further players stand at a distance drawn in the same way.

    End
    ---
    SUCCESS: the ball is kickable for a player; truncated after `max_cycles`.

    References
    ----------
    Dissertation 2.2.7, Fig. 2.13 (module go_to_ball).
    """

    name: str = "GoToBall"
    terms: tuple[str, ...] = ("reached",)
    shaping: tuple[tuple[str, float], ...] = (("to_ball_progress", 0.25),)
    near: float = within(5.0, 0.0, 120.0)
    far: float = within(40.0, 0.0, 120.0)
    rolling: float = within(0.5, 0.0, 1.0)
    speed: float = within(1.5, 0.0, 3.0)
    tries: int = within(8, 1, 1000)
    """Starts that are drawn; the first one that fits on the pitch is taken."""

    def __post_init__(self) -> None:
        """Refuse distances in the wrong order."""
        super().__post_init__()
        if self.near > self.far:
            raise ParameterError(f"task {self.name!r}: near: {self.near:g} given; allowed are numbers up to far, {self.far:g}")

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Draw the start until ball and resting place of the ball are on the pitch; see the class for the distribution."""
        p = self.parameters
        half_length, half_width = HALF_LENGTH - 1.0, HALF_WIDTH - 1.0
        u = pitch.draw(worlds, 8 * self.tries).reshape(len(worlds), self.tries, 8)
        player = np.stack([(2 * u[..., 0] - 1) * half_length, (2 * u[..., 1] - 1) * half_width], axis=-1)
        distance = self.near + (self.far - self.near) * u[..., 2]
        angle = 2 * math.pi * u[..., 3]
        ball = player + distance[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        speed = np.where(u[..., 4] < self.rolling, self.speed * u[..., 5], 0.0)
        heading = 2 * math.pi * u[..., 6]
        velocity = speed[..., None] * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        rest = ball + velocity / (1.0 - p.ball_decay)
        limit = np.array([half_length, half_width])
        fits = np.all((np.abs(ball) <= limit) & (np.abs(rest) <= limit), axis=-1)
        # the first try that fits; the last one is pulled onto the pitch if none does
        pick = np.where(fits.any(axis=1), fits.argmax(axis=1), fits.shape[1] - 1)
        row = np.arange(len(worlds))
        velocity = np.where(fits[row, pick][:, None], velocity[row, pick], 0.0)
        ball = np.clip(ball[row, pick], -limit, limit)
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        pitch.place_ball(*ball.T, *velocity.T, worlds=worlds)
        pitch.place_player(1, *player[row, pick].T, math.pi * (2 * u[row, pick, 7] - 1), worlds=worlds)
        for number in range(2, self.left + 1):
            v = pitch.draw(worlds, 3)
            away, angle = self.near + (self.far - self.near) * v[:, 0], 2 * math.pi * v[:, 1]
            place = ball + away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            pitch.place_player(number, *np.clip(place, -limit, limit).T, math.pi * (2 * v[:, 2] - 1), worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Done when a player can kick the ball."""
        shape = (pitch.worlds, len(pitch.players))
        reward, over, won = np.empty(shape), np.empty(pitch.worlds, np.bool_), np.empty(shape, np.bool_)
        status = np.empty(pitch.worlds, np.int64)
        world, packed = pitch.sim.world, pitch.sim.packed
        kernels.race_outcome(world, packed, self.left, self.right, pitch.sides, SUCCESS, reward, over, won, status)
        return Outcome(reward, over, won, status, {"reached": reward})
