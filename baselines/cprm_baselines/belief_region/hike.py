"""The hiker by regions of where he is. In the middle of the way there is one command for out and home, so he never gets home."""

from __future__ import annotations

from ..behaviour.regions import Region
from ..behaviour.scenes import make_scene

BODY = (
    Region("before the view", "x < view - 1", skill="out"),
    Region("at the view", "1", skill="home"),
)
NECK: tuple[Region, ...] = ()

__all__ = ["BODY", "NECK", "make_scene"]
