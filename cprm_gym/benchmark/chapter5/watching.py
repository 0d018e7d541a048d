"""What is measured of an episode beside its end: what a disturbance did, and how long it took to answer an event."""

from __future__ import annotations

import numpy as np

from ...envs.core import SoccerCore, Step
from ...simulator.pitch import HALF_LENGTH
from ...simulator.state import Count
from ...wrappers.disturbances import Disturbance, Disturber

SHOT = 1.2
"""m / cycle towards the goal from which a ball is a shot."""
ON_THE_WAY = 0.08
"""m / cycle towards where the ball will pass: who moves so has answered."""
IN_THE_WAY = 0.6
"""Metres from the ball's way within which he has nothing to answer."""
MOST = 40
"""Cycles after which an event that was not answered never is."""


class Disturbing:
    """Lets a disturbance happen once in each episode; the strike of an episode depends on the seed and its world alone.

    Attributes
    ----------
    struck : (n,) bool array
    again : (n,) float array
        Cycles from the strike until an agent had the ball again, kicked or caught; NaN where nobody did.
    """

    def __init__(self, disturbance: Disturbance, count: int, seed: int) -> None:
        self.disturbance, self.seed = disturbance, seed
        self.struck, self.again = np.zeros(count + 1, bool), np.full(count + 1, np.nan)
        self._disturber: Disturber | None = None

    def begin(self, core: SoccerCore, slots: np.ndarray, episodes: np.ndarray) -> None:
        """Draw when it strikes."""
        if self._disturber is None:
            self._disturber = Disturber(core, self.disturbance, self.seed)
            self._first = core.sim.first_world
        self._disturber.reset(slots, self._first + episodes)

    def before(self, core: SoccerCore) -> None:
        """Strike where it is due."""
        assert self._disturber is not None
        self._disturber()
        self._had = self._touches(core)

    def after(self, core: SoccerCore, step: Step, playing: np.ndarray) -> None:
        """Who was struck, and who has the ball again."""
        assert self._disturber is not None
        struck = self._disturber.struck
        self.struck[playing] |= struck >= 0
        since = core.cycle - struck
        now = (struck >= 0) & (since >= self.disturbance.duration) & (self._touches(core) > self._had) & np.isnan(self.again[playing])
        self.again[playing[now]] = since[now]

    @staticmethod
    def _touches(core: SoccerCore) -> np.ndarray:
        counts = core.sim.world["counts"][:, core.players - 1]
        return np.asarray(counts[..., Count.KICK].sum(axis=1) + counts[..., Count.CATCH].sum(axis=1))

    def found(self, count: int) -> dict[str, list[float | None]]:
        """For `BlockResult.more`."""
        return {
            "struck": [float(v) for v in self.struck[:count]],
            "again": [None if np.isnan(v) else float(v) for v in self.again[:count]],
        }


class Answering:
    """How many cycles a goalie takes from a shot to the first command that answers it.

    The event is a ball that begins to roll at the goal faster than `SHOT` while he is not in its way; the answer is the first cycle after
    which he moves towards the point of its way that is nearest to him, or is within reach of it.

    Attributes
    ----------
    cycles : (n,) float array
        NaN where there was no such event, or no answer within `MOST` cycles.
    asked : (n,) bool array
    """

    def __init__(self, count: int) -> None:
        self.cycles, self.asked = np.full(count + 1, np.nan), np.zeros(count + 1, bool)

    def begin(self, core: SoccerCore, slots: np.ndarray, episodes: np.ndarray) -> None:
        """Nothing has happened."""
        if not hasattr(self, "_since"):
            self._since = np.full(core.worlds, -1, np.int64)
            self._over = np.zeros(core.worlds, bool)
        self._since[slots], self._over[slots] = -1, False

    def before(self, core: SoccerCore) -> None:
        """Where he is before his command."""

    def after(self, core: SoccerCore, step: Step, playing: np.ndarray) -> None:
        """Whether the event has come, and the answer."""
        world, goalie = core.sim.world, int(core.players[0])
        ball, velocity = world["pos"][:, 0], world["vel"][:, 0]
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = np.where(speed[:, None] > 0, velocity / speed[:, None], 0.0)
            height = ball[:, 1] + velocity[:, 1] / velocity[:, 0] * (-HALF_LENGTH - ball[:, 0])
        shot = (velocity[:, 0] < -SHOT) & (np.abs(height) < 9.0)
        gap = world["pos"][:, goalie] - ball
        aside = gap - (gap * unit).sum(axis=1, keepdims=True) * unit  # from the ball's way to him
        away = np.hypot(aside[:, 0], aside[:, 1])
        towards = -(world["vel"][:, goalie] * aside).sum(axis=1) / np.maximum(away, 1e-9)
        waiting = (self._since >= 0) & ~self._over
        self._since[waiting] += 1
        answered = waiting & ((towards > ON_THE_WAY) | (away < IN_THE_WAY))
        self.cycles[playing[answered]] = self._since[answered]
        self._over |= answered | (self._since > MOST)
        fresh = shot & (self._since < 0) & (away > IN_THE_WAY)
        self._since[fresh] = 0
        self.asked[playing[fresh]] = True

    def found(self, count: int) -> dict[str, list[float | None]]:
        """For `BlockResult.more`."""
        return {
            "asked": [float(v) for v in self.asked[:count]],
            "answer": [None if np.isnan(v) else float(v) for v in self.cycles[:count]],
        }
