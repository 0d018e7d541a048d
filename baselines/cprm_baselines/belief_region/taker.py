"""A taker by regions of what is reckoned; he needs no memory of what he was about."""

from __future__ import annotations

from cprm_gym.agents.taker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.regions import Region

BODY = (
    Region("out of sight", "lost", order="sweep"),
    Region("with the ball", "reach", skill="oust"),
    Region("a keeper has it, near", "tackles", order="tackle"),
    Region("of the first at the ball", "chase", skill="meet"),
    Region("off his place", f"off_place >= {OFF_PLACE}", skill="walk"),
    Region("it is aside", f"off_axis >= {OFF_AXIS}", order="face"),
)
NECK = (Region("anywhere", "1", order="look"),)
