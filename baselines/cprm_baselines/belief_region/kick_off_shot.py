"""The striker by regions. There is no model of his: the belief is what is reckoned, a distribution without a width.

Whether he has passed already is in no belief. That he stands at the middle with the ball says that he has not.
"""

from __future__ import annotations

from cprm_gym.agents.striker import COMING, FORGOTTEN

from ..behaviour.regions import Region
from ..behaviour.scenes import make_scene

AT_BALL = f"at_ball and ball_age < {FORGOTTEN}"
BODY = (
    Region("before the kick-off", "not_begun", skill="setup"),
    Region("the ball lies on the middle", f"{AT_BALL} and hypot(ball_x, ball_y) < 1", skill="passing"),
    Region("near the goal with the ball", f"{AT_BALL} and goal_near", skill="shoot"),
    Region("with the ball", AT_BALL, skill="dribble"),
    Region("it comes", f"approach >= {COMING} and ball_age < {FORGOTTEN}", skill="receive"),
    Region("out of sight", f"ball_age >= {FORGOTTEN}", order="sweep"),
    Region("it rolls away in the own half of the way", "approach < -0.3 and ball_x < 12", skill="advance"),
    Region("the team-mate is nearer to it", "mate_gap < ball_distance", skill="advance"),
    Region("it is aside", "off_axis >= 60", order="face"),
    Region("it is ahead", "1", skill="go"),
)
NECK = (Region("about to pass", f"{AT_BALL} and hypot(ball_x, ball_y) < 1", order="look at him"), Region("anywhere", "1", order="look"))

__all__ = ["BODY", "NECK", "make_scene"]
