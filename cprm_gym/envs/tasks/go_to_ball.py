"""GoToBall: reach a ball that lies or rolls somewhere, through one's own senses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import ParameterError
from ..kernels import pitch as kernels
from ..kernels.starts import start_go_to_ball
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
        numbers = float(self.near), float(self.far), float(self.rolling), float(self.speed)
        start_go_to_ball(pitch.sim.world, pitch.sim.played, worlds, *numbers, self.tries, self.left)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Done when a player can kick the ball."""
        shape = (pitch.worlds, len(pitch.players))
        reward, over, won = np.empty(shape), np.empty(pitch.worlds, np.bool_), np.empty(shape, np.bool_)
        status = np.empty(pitch.worlds, np.int64)
        world, packed = pitch.sim.world, pitch.sim.packed
        kernels.race_outcome(world, packed, self.left, self.right, pitch.sides, SUCCESS, reward, over, won, status)
        return Outcome(reward, over, won, status, {"reached": reward})
