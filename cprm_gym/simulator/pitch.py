"""The pitch: its lengths in metres, goals and posts (specification/simulator.md 0.1, 3.3).

The origin is the centre, x points to the goal of the right team, y downwards. These are the server's constants; only the width of
the goals is a parameter (``goal_width``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .parameters import ServerParameters

PITCH_LENGTH, PITCH_WIDTH = 105.0, 68.0
HALF_LENGTH, HALF_WIDTH = PITCH_LENGTH / 2, PITCH_WIDTH / 2
PITCH_MARGIN = 5.0
"""Nobody is allowed farther outside the lines."""
PENALTY_AREA_LENGTH, PENALTY_AREA_WIDTH = 16.5, 40.32
PENALTY_X, PENALTY_Y = HALF_LENGTH - PENALTY_AREA_LENGTH, PENALTY_AREA_WIDTH / 2
"""|x| of the penalty areas' fronts, |y| of their sides."""
GOAL_AREA_LENGTH, GOAL_AREA_WIDTH = 5.5, 18.32
GOAL_AREA_X, GOAL_AREA_Y = HALF_LENGTH - GOAL_AREA_LENGTH, GOAL_AREA_WIDTH / 2
CENTRE_RADIUS = 9.15
"""Centre circle, and the distance kept from the ball at set plays."""
GOAL_DEPTH = 2.44
GOAL_POST_RADIUS = 0.06


def post_centre(parameters: ServerParameters) -> tuple[float, float]:
    """|x| and |y| of the centres of the four goal posts.

    Parameters
    ----------
    parameters : ServerParameters
        ``goal_width``, between the posts' inner edges.
    """
    return HALF_LENGTH - GOAL_POST_RADIUS, parameters.goal_width / 2 + GOAL_POST_RADIUS
