"""Where a defence stands, and when it has the ball: what tasks share that can be played against opponents."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulator.state import Count
from ..pitch import Pitch
from .base import Task, within

_THEIRS, _KICKS = 6, 7
"""Columns of ``pitch.memory``: cycles since the defence kicked last, 0 while the attack did; its kicks and catches."""
_BALL = (int(Count.KICK), int(Count.CATCH))


@dataclass(frozen=True)
class Opposed(Task):
    """A task of the left side that has a defence where `right` is above 0; without one, these options change nothing.

    Attributes
    ----------
    capture : int
        Cycles after a kick of the defence, without one of the attack, at which it has the ball.
    nearest, farthest : float
        Least and largest x where a defender starts, m; he is within `HALF_BREADTH` of the middle.
    """

    capture: int = within(20, 1, 1000)
    nearest: float = within(0.0, -45.0, 45.0)
    farthest: float = within(25.0, -45.0, 45.0)

    def place_defence(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """The keeper in front of his goal, the defenders where the draw puts them, turned to the other goal."""
        if not self.right:
            return
        u = pitch.draw(worlds, 2 * self.right)
        low, high = min(self.nearest, self.farthest), max(self.nearest, self.farthest)
        for k in range(self.right):
            x, y = low + (high - low) * u[:, 2 * k], HALF_BREADTH * (2 * u[:, 2 * k + 1] - 1)
            if self.right_goalie == k + 1:
                x, y = np.full(len(worlds), KEEPER_X), 0.2 * y
            pitch.place_player(12 + k, x, y, math.pi, (0.0, 0.0), worlds=worlds)

    def captured(self, pitch: Pitch, ours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether the defence kicked in this cycle, and whether it has the ball for good, both (W,) bool.

        It has it `capture` cycles after its kick without a kick of the attack, when its keeper has caught it, and after its goal.

        Parameters
        ----------
        pitch : Pitch
        ours : (W,) bool array
            Where the attack kicked in this cycle.
        """
        if not self.right:
            nobody = np.zeros(pitch.worlds, bool)
            return nobody, nobody
        counts, memory = pitch.sim.world["counts"], pitch.memory
        theirs = counts[:, 11 : 11 + self.right, _BALL].sum(axis=(1, 2))
        kicked = theirs > memory[:, _KICKS]
        memory[:, _KICKS] = theirs
        memory[:, _THEIRS] = np.where(kicked, 1, memory[:, _THEIRS] + (memory[:, _THEIRS] > 0))
        memory[ours, _THEIRS] = 0
        caught = counts[:, 11 : 11 + self.right, Count.CATCH].any(axis=1)
        return kicked, (memory[:, _THEIRS] > self.capture) | caught | (pitch.goals_scored()[:, 1] > 0)


HALF_BREADTH = 10.0
"""Metres beside the middle up to which a defender starts."""
KEEPER_X = 50.5
"""Where the keeper starts, m."""
