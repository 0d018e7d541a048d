"""The keeper's numbers: what is nobody's parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..skills.constants import Constants, between


@dataclass(frozen=True, kw_only=True)
class KeeperConstants(Constants):
    """Of a keeper; the defaults were set by hand."""

    whose: ClassVar[str] = "keeper"

    pressed: float = between(3.0, 1.0, 8.0)
    """Metres within which a taker makes him think of passing."""
    room: float = between(1.8, -1.0, 4.0)
    """Metres that the way to a receiver must be clear."""
    arriving: float = between(0.6, 0.2, 1.4)
    """m / cycle with which a pass arrives."""
    edge: float = between(2.5, 0.5, 4.0)
    """Metres from the lines of the square that he keeps while he runs free."""
    stale: float = between(2.0, 1.0, 15.0)
    """Cycles without a sight of somebody after which he is looked at while the ball is at the feet."""
