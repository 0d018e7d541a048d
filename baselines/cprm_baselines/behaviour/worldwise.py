"""The same scene for structures whose users write one program for one agent: each world is asked on its own, and acted for together."""

from __future__ import annotations

import numpy as np

from .scene import Scene
from .skill import Mask


class Moment:
    """One cycle of a scene, asked world by world.

    What a skill would do is computed for all worlds once; which of them want it is gathered and done at the end of the cycle (`close`).

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._wanted: dict[tuple[str, bool], list[int]] = {}
        self._orders: dict[str, list[int]] = {}

    def open(self) -> None:
        """Begin a cycle."""
        self._wanted.clear()
        self._orders.clear()

    def holds(self, text: str, world: int) -> bool:
        """Whether a condition holds in a world."""
        return bool(self.scene.holds(text)[world])

    def run(self, skill: str, world: int, fresh: bool) -> str:
        """Let a skill work for a cycle; the name of its outcome, or nothing while it goes on."""
        outcome = self.scene.step(skill, fresh).outcome[world]
        self._wanted.setdefault((skill, fresh), []).append(world)
        return "" if outcome < 0 else self.scene.skills[skill].outcomes[outcome]

    def order(self, name: str, world: int) -> None:
        """Send a command that is no skill."""
        self._orders.setdefault(name, []).append(world)

    def flag(self, name: str, world: int, value: float) -> None:
        """Write a constant of the sheet."""
        self.scene.flag(name, self._mask([world]), value)

    def close(self) -> None:
        """Do what was wanted: those who go on before those who begin, since who begins may have just ended."""
        for fresh in (False, True):
            for (skill, begun), worlds in list(self._wanted.items()):
                if begun == fresh:
                    self.scene.run(skill, self._mask(worlds), fresh)
        for name, worlds in self._orders.items():
            self.scene.order(name, self._mask(worlds))

    def _mask(self, worlds: list[int]) -> Mask:
        mask = np.zeros(self.scene.worlds, np.bool_)
        mask[worlds] = True
        return mask
