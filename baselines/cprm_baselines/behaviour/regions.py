"""Belief regions (dissertation Fig. 5.2): a posterior, regions of the space of distributions, and a command for each.

The policy has no state: what it does follows from what is believed now, so that the same belief leads to the same commands. Regions may
overlap; then several commands go out at once, one to the body and one to the neck, those of the first region that has one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cprm_gym.errors import ModelError

from .scene import Scene
from .skill import Mask


@dataclass(frozen=True)
class Region:
    """A region and what is done in it.

    Parameters
    ----------
    name : str
    where : str
        Condition over views of the posterior and what follows from them.
    skill, order : str
        One of both: a skill, of which the first command goes out, or a command.
    """

    name: str
    where: str
    skill: str = ""
    order: str = ""


class Regions:
    """Regions in all worlds.

    Parameters
    ----------
    scene : Scene
    body, neck : sequence of Region
        For each in this order of precedence.

    Raises
    ------
    ModelError
        For a region without a command.
    """

    def __init__(self, scene: Scene, body: Sequence[Region], neck: Sequence[Region] = ()) -> None:
        self.body, self.neck = tuple(body), tuple(neck)
        for region in (*self.body, *self.neck):
            if bool(region.skill) == bool(region.order):
                raise ModelError(f"region {region.name!r} takes a skill or an order, and one of both")

    def begin(self, worlds: int, seed: int) -> None:
        """There is nothing to remember."""

    def restart(self, worlds: Mask) -> None:
        """There is nothing to forget."""

    def decide(self, scene: Scene) -> None:
        """One cycle."""
        for regions in (self.body, self.neck):
            free = np.ones(scene.worlds, np.bool_)
            for region in regions:
                here = free & scene.holds(region.where)
                if not here.any():
                    continue
                if region.skill:
                    here &= scene.run(region.skill, here, fresh=True) < 0
                else:
                    scene.order(region.order, here)
                free &= ~here
