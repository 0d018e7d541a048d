"""One of two who attack against a defence by regions of what is reckoned, the count of passes and what the referee minds among it."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.regions import Region

_HAS = "reach and not offside"
BODY = (
    Region("before the kick-off", "waiting", skill="setup"),
    Region("somebody else's turn", "barred", order="stand"),
    Region("out of sight", "lost or seeks", order="sweep"),
    Region("a set play", f"{_HAS} and ours", skill="give"),
    Region("with the ball, the goal free", f"{_HAS} and can_shoot", skill="shoot"),
    Region("with the ball, somebody free", f"{_HAS} and can_pass", skill="give"),
    Region("with the ball", _HAS, skill="push"),
    Region("first at the ball", "chase", skill="meet"),
    Region("off his place", f"off_place >= {OFF_PLACE}", skill="walk"),
    Region("it is aside", f"off_axis >= {OFF_AXIS}", order="face"),
)
NECK = (Region("anywhere", "1", order="look"),)
