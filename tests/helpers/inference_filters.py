"""Small filters and slices made by hand."""

from __future__ import annotations

from inference_cases import Schedule, load

from cprm_gym.architecture.prm.grounding.slices import Grounds, GroundSlice
from cprm_gym.architecture.prm.inference.filter import Filter


def umbrella(**options) -> Filter:
    """Rain and umbrella, the relation says whether the chain goes on."""
    return Filter(Schedule(load("d01_umbrella")), **options)


class Fixed(Grounds):
    """Two slices, made by hand."""

    def __init__(self, first: GroundSlice, later: GroundSlice) -> None:
        self.slices = {True: first, False: later}

    def ground(self, relations=(), first=False):
        return relations if isinstance(relations, GroundSlice) else self.slices[first]


def rotation() -> Fixed:
    """A token that goes round four places, each step for certain, and a reading that may be one place off."""
    case = load("d12_impossible")
    schedule = Schedule(case)
    return Fixed(schedule.slices["prior"], schedule.slices["step"])
