"""The least and the most that a number can be: what bounded and sampled analysis answer."""

from __future__ import annotations

from typing import NamedTuple


class Bounds(NamedTuple):
    """The least and the most that a number can be."""

    low: float
    high: float

    @property
    def width(self) -> float:
        """How far they are apart."""
        return self.high - self.low

    def holds(self, value: float) -> bool:
        """Whether a number lies within them."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        return f"[{self.low:.6g}, {self.high:.6g}]"
