"""The goalie by regions of what his model believes."""

from __future__ import annotations

from ..behaviour.regions import Region
from ..behaviour.scenes import believing_goalie as make_scene

BODY = (
    Region("a shot, or a ball that he gets first", "coming", skill="save"),
    Region("a ball at his feet", "at_hand", skill="away"),
    Region("out of place", "1", skill="post"),
)
NECK = (Region("anywhere", "1", skill="eyes"),)

__all__ = ["BODY", "NECK", "make_scene"]
