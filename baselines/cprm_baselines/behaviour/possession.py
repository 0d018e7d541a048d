"""Whose ball it is, kept beside whoever decides: passes made, offside, and whether the ball is somebody else's to play next.

The attacker's net has tokens for it (`cprm_gym.agents.attacker.agent`), by the same rules. It says what the referee says, not what to do,
so every structure is told it as it is told where the ball is.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.agents.attacker.agent import PATIENCE, PLAYED

from .scene import Scene
from .skill import Mask

NOBODYS, MINE, HIS = 0, 1, 2


class Possession:
    """In all worlds.

    Parameters
    ----------
    passes : int
        How many are counted.
    """

    columns = ("his", "swaps", "offside", "barred")
    """Quantities that it writes: 1 where the team-mate kicked last, passes made, 1 where he himself is offside, 1 where nobody else has
    touched his own set play yet."""

    def __init__(self, passes: int) -> None:
        self.passes = passes

    def begin(self, worlds: int) -> None:
        """Nobody has kicked yet."""
        self._whose = np.zeros(worlds, np.int64)
        self._swaps, self._played, self._barred = (np.zeros(worlds, np.int64) for _ in range(3))
        self._offside, self._taking = (np.zeros(worlds, np.bool_) for _ in range(2))

    def restart(self, worlds: Mask) -> None:
        """The same in some worlds."""
        self._whose[worlds] = self._swaps[worlds] = self._played[worlds] = self._barred[worlds] = 0
        self._offside[worlds] = self._taking[worlds] = False

    def update(self, scene: Scene) -> None:
        """One cycle, by what is seen in it and what was sent in the last one."""
        mates, theirs, his_ball, his_feet, beyond, released, ours = (
            scene.quantity(name) > 0 for name in ("mates", "theirs", "his_ball", "his_feet", "beyond", "released", "ours")
        )
        kicking = scene.kicked("push", "give")
        self._pass_on(kicking, mates & ~kicking, theirs)
        self._offside &= self._played <= PLAYED
        self._offside |= his_ball & beyond
        self._offside &= ~(his_feet & ~beyond)
        self._played = np.where(self._offside & theirs & ~his_ball, self._played + 1, 0)
        self._barred = np.where(scene.kicked("give") & self._taking, PATIENCE, np.maximum(self._barred - 1, 0))
        self._barred[released] = 0
        self._taking = ours
        for name, value in zip(self.columns, (self._whose == HIS, self._swaps, self._offside, self._barred > 0)):
            scene.quantity(name)[:] = value

    def _pass_on(self, kicking: Mask, mates: Mask, theirs: Mask) -> None:
        """Who kicked last, and how often that has changed."""
        room = self._swaps < self.passes if self.passes else np.ones_like(kicking)
        free = ~theirs
        first = (self._whose == NOBODYS) & free & (kicking | mates)
        swaps = free & room & (((self._whose == MINE) & mates) | ((self._whose == HIS) & kicking))
        self._swaps[swaps] += 1 if self.passes else 0
        self._whose = np.where(first | swaps, np.where(kicking, MINE, HIS), np.where(theirs, NOBODYS, self._whose))
