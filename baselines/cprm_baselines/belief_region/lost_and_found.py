"""The finder by regions of what is reckoned. Where he has looked in vain he does not remember, so he looks there again."""

from __future__ import annotations

from ..behaviour.regions import Region
from ..behaviour.scenes import make_scene

BODY = (Region("anywhere", "1", skill="legs"),)
NECK = (Region("anywhere", "1", skill="eyes"),)

__all__ = ["BODY", "NECK", "make_scene"]
