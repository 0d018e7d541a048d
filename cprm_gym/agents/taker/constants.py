"""The taker's numbers: what is nobody's parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..skills.constants import Constants, between


@dataclass(frozen=True, kw_only=True)
class TakerConstants(Constants):
    """Of a taker; the defaults were set by hand."""

    whose: ClassVar[str] = "taker"

    hunters: float = between(2.0, 1.0, 4.0)
    """How many of the takers run at the ball."""
    share: float = between(0.6, 0.2, 0.9)
    """Where one of the others stands on the way from the ball to the keeper whom he covers, as a share of it."""
    lunge: float = between(0.8, 0.3, 1.0)
    """Chance of a tackle that is worth the cycles on the ground."""
    held: float = between(1.3, 0.5, 2.5)
    """Metres from the ball within which a keeper has it, and is tackled."""
