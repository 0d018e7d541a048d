"""Which of a behaviour's conditions hold in episodes, and which fails first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...agents.worlds.conditions import Condition
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.sampling.intervals import clopper_pearson
from ...architecture.analysis.sampling.sample import Sample

FLOOR = 0.9
"""In how many of the episodes a condition has to hold where nothing is required."""


class Judged(NamedTuple):
    """A condition and how it came out."""

    condition: Condition
    interval: Bounds
    """Share of the episodes in which it holds; of all conditions at once."""
    floor: float
    first: int
    """Number of the first episode in which it does not hold, -1: none."""

    @property
    def holds(self) -> bool | None:
        """Whether it holds in at least `floor` of all episodes; None where that is undecided."""
        return True if self.interval.low >= self.floor else False if self.interval.high < self.floor else None

    def __str__(self) -> str:
        word = {True: "holds", False: "FAILS", None: "undecided"}[self.holds]
        told = f"{self.condition.kind}, {self.condition.name}: {word} ({self.interval.low:.4f} to {self.interval.high:.4f} of the episodes"
        return told + (f"; not in episode {self.first})" if self.first >= 0 and self.holds is not True else ")")


def judged(conditions: Sequence[Condition], played: Sample, confidence: float, floor: float) -> list[Judged]:
    """The conditions as they came out in episodes that were looked at with their formulas.

    Parameters
    ----------
    conditions : sequence of Condition
    played : Sample
        Its properties are named by the conditions.
    confidence : float
        Of all of them at once.
    floor : float
    """
    each = 1.0 - (1.0 - confidence) / max(len(conditions), 1)
    found = []
    for c in conditions:
        count = played.properties[c.name]
        found.append(Judged(c, clopper_pearson(count.true, played.runs, each), floor, count.first_false))
    return found
