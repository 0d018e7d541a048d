"""Where the belief is vague, turn; where the ball is believed aside, face it; where it is believed ahead, run."""

from __future__ import annotations

from ..behaviour.regions import Region
from ..behaviour.scenes import believing_seeker as make_scene

VAGUE = 1.5
"""Nats of entropy in the ball's direction from which on it is looked for."""
BODY = (
    Region("vague", f"doubt >= {VAGUE}", order="search"),
    Region("aside", "go.off_axis >= 12", order="turn"),
    Region("ahead", "go.off_axis < 12", order="dash"),
)
NECK: tuple[Region, ...] = ()

__all__ = ["BODY", "NECK", "make_scene"]
