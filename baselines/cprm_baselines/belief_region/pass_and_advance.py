"""One of the passing pair by regions of what is reckoned: who is nearer to the ball plays it, the other one runs free."""

from __future__ import annotations

from cprm_gym.agents.passer import FORGOTTEN, IN_RANGE, ONSIDE

from ..behaviour.regions import Region
from ..behaviour.scenes import make_scene

HAS = "at_ball and ball_age < 3 and his < 0.3"
BODY = (
    Region("near the goal with the ball", f"{HAS} and goal_distance < {IN_RANGE}", skill="shoot"),
    Region("with the ball, the team-mate onside", f"{HAS} and onside >= {ONSIDE}", skill="passing"),
    Region("with the ball", HAS, order="stand"),
    Region("it comes", "coming", skill="receive"),
    Region("out of sight", f"ball_age >= {2 * FORGOTTEN}", order="sweep"),
    Region("it lies nearer to him", "mine >= 0 and ball_speed < 0.3", skill="go"),
    Region("off his place", "off_place >= 1.8", skill="advance"),
    Region("it is aside", "off_axis >= 60", order="face"),
)
NECK = (Region("about to pass", HAS, order="look at him"), Region("anywhere", "1", order="look"))

__all__ = ["BODY", "NECK", "make_scene"]
