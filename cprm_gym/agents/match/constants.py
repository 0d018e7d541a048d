"""The numbers of an outfield player of a match: what is nobody's parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..attacker.constants import HalfFieldConstants
from ..skills.constants import between


@dataclass(frozen=True, kw_only=True)
class MatchConstants(HalfFieldConstants):
    """Of an outfield player of a match: with the ball those of the attacker before the goal; the defaults were set by hand."""

    whose: ClassVar[str] = "match"

    shift: float = between(0.55, 0.2, 0.9)
    """Share of the ball's way along the pitch by which the formation shifts with it."""
    sway: float = between(0.35, 0.0, 0.8)
    """The same across the pitch."""
    forward: float = between(22.0, 5.0, 40.0)
    """Metres ahead of the ball up to which forwards wait at the offside line."""
    margin: float = between(1.0, 0.0, 4.0)
    """Metres that are kept from the offside line."""
    marks: float = between(9.0, 0.0, 20.0)
    """Metres from his place within which an opponent is marked."""
    cover: float = between(5.0, 0.0, 15.0)
    """Metres behind the ball, on the way to the own goal, at which the second defender stands."""
    supporters: float = between(2.0, 0.0, 9.0)
    """How many of those without the ball support who has it."""
    supports: float = between(30.0, 5.0, 60.0)
    """Metres from the ball within which he does."""
    lunge: float = between(0.8, 0.3, 1.0)
    """Chance of a tackle that is worth the cycles on the ground."""
    held: float = between(1.3, 0.5, 2.5)
    """Metres from the ball within which an opponent has it, and is tackled."""
    rest: float = between(0.45, 0.0, 1.0)
    """Share of the full stamina below which he rests while his team has the ball."""
    near: float = between(12.0, 0.0, 40.0)
    """Metres off his place up to which he does."""
