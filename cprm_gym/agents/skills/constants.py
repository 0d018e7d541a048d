"""Numbers of behaviours: thresholds that are nobody's parameters, fitted to what the player knows.

What is right depends on how well he knows things: who sees the shot late has to stand deeper. So the goalie's numbers are arguments of
his net, and are tuned for a tier of knowledge by one procedure (`cprm_gym.benchmark.tuning`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np

from ...errors import ParameterError, did_you_mean


def between(default: float, low: float, high: float) -> Any:
    """A number and the extent in which it may be tuned."""
    return field(default=default, metadata={"extent": (low, high)})


@dataclass(frozen=True, kw_only=True)
class GoalieConstants:
    """Of the goalie; the defaults were set by hand.

    Raises
    ------
    ParameterError
        For a number outside its extent.
    """

    run: float = between(0.95, 0.6, 1.0)
    """Share of the top speed that a running player makes."""
    start: float = between(0.7, 0.0, 3.0)
    """Cycles that he loses by turning and getting up speed on the way to a free ball."""
    haste: float = between(1.0, -1.0, 3.0)
    """Cycles that he loses on the way to a shot."""
    at_feet: float = between(0.593, 0.0, 1.0)
    """Share of the kickable ring at which a player who runs to the ball has it."""
    dare: float = between(20.0, 0.0, 40.0)
    """Cycles by which an opponent may be nearer to a free ball for the goalie still to go for it."""
    deepest: float = between(0.5, 0.0, 2.0)
    """Metres in front of the goal line at which a shot is met at last."""
    wide: float = between(1.99, 0.0, 9.0)
    """Metres beside the post at which a ball that crosses the goal line still counts as a shot."""
    out_share: float = between(0.3, 0.1, 0.7)
    """Share of the ball's distance from the goal that the guarding place lies before it."""
    out_least: float = between(1.0, 0.2, 4.0)
    """Metres added to it, and the least."""
    out_most: float = between(8.0, 4.0, 14.0)
    """Metres that it lies before the goal at most."""
    side_on: float = between(80.0, 30.0, 110.0)
    """Degrees between body and ball while waiting."""
    displaced: float = between(1.0, 0.45, 3.0)
    """Metres from the guarding place at which he goes there again."""
    turned: float = between(30.0, 15.0, 70.0)
    """Degrees from side-on at which he turns again."""
    strafe: float = between(2.2, 0.5, 6.0)
    """Metres up to which he does not turn first."""
    ahead: float = between(40.0, 10.0, 90.0)
    """Degrees within which he runs on without turning."""
    worth: float = between(0.5, 0.2, 1.0)
    """Chance of a tackle that is worth the ten cycles on the ground, when the hands do not reach the ball."""
    close: float = between(0.12, 0.02, 0.6)
    """Metres from the ball's way at which he stands."""
    early: float = between(0.05, 0.0, 0.6)
    """Metres within the reach of his hands at which he catches at once."""
    deepening: float = between(0.15, -0.2, 0.6)
    """Metres by which the ball must come deeper into his hands in a cycle for him to wait for it."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, (low, high) = getattr(self, entry.name), entry.metadata["extent"]
            if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not low <= value <= high:
                raise ParameterError(f"goalie: {entry.name}: {value!r} given; allowed are numbers from {low:g} to {high:g}")

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> GoalieConstants:
        """Those that a mapping means; what is left out is the default.

        Raises
        ------
        ParameterError
            For a name that there is not.
        """
        known = [entry.name for entry in fields(cls)]
        for name in given:
            if name not in known:
                raise ParameterError(
                    f"goalie: there is no constant {name!r}.{did_you_mean(str(name), known)} There are: {', '.join(known)}."
                )
        return cls(**given)

    def to_dict(self) -> dict[str, float]:
        """Name -> number."""
        return asdict(self)

    @classmethod
    def extents(cls) -> dict[str, tuple[float, float]]:
        """Name -> least and largest value."""
        return {entry.name: entry.metadata["extent"] for entry in fields(cls)}


FIRST = GoalieConstants()
"""Those set by hand."""
ON_MEMORY = GoalieConstants(
    run=0.95474, start=0.85799, haste=1.0291, at_feet=0.43005, dare=20.80432, deepest=0.87002, wide=2.87063, out_share=0.32369,
    out_least=0.82052, out_most=9.0884, side_on=86.71091, displaced=1.36587, turned=34.17585, strafe=2.17292, ahead=30.07796,
    worth=0.64527, close=0.12059, early=0.05857, deepening=0.18492,
)  # fmt: skip
"""Tuned on the tier ``memory`` (`cprm_gym/benchmark/studies/goalie_memory.jsonl`)."""
