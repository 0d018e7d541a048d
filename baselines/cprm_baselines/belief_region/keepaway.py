"""A keeper by regions of what is reckoned; he needs no memory of what he was about."""

from __future__ import annotations

from cprm_gym.agents.keeper.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.regions import Region

BODY = (
    Region("out of sight", "lost", order="sweep"),
    Region("with the ball, pressed, somebody free", "reach and can_pass", skill="give"),
    Region("with the ball", "reach", skill="shelter"),
    Region("first at the ball", "chase", skill="meet"),
    Region("off his place", f"off_place >= {OFF_PLACE}", skill="walk"),
    Region("it is aside", f"off_axis >= {OFF_AXIS}", order="face"),
)
NECK = (Region("anywhere", "1", order="look"),)
