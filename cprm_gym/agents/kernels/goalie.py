"""What the goalie feels, sees and remembers, world by world."""

from __future__ import annotations

import math

from ...compilation import kernel_group
from ...envs.observations import BodyFeature, ObjectFeature, SelfFeature
from ...simulator.senses import BallLevel, PlayerLevel
from ...simulator.state import PlayMode
from .percepts import BODY, FRESH, degrees, faces, feel, one

kernel = kernel_group(_nrt=False)

_SIDE, _MODE = int(BodyFeature.SIDE), int(BodyFeature.PLAY_MODE)
_POSE, _MOVING, _NUMBER, _PLAY_ON = int(ObjectFeature.BODY), int(BallLevel.MOVING), int(PlayerLevel.NUMBER), int(PlayMode.play_on)
_X, _Y, _VX, _VY, _FACING, _EYES, _LOCATED = (int(SelfFeature[n]) for n in ("X", "Y", "VX", "VY", "BODY", "FACE", "LOCATED"))

GOALIE = (
    *BODY, "self.x", "self.y", "self.vx", "self.vy", "self.body_deg", "game.stopped", "ball.seen", "ball.placed",
    "ball.moving", "ball.x", "ball.y", "ball.vx", "ball.vy", "ball.distance", "ball.age",
)  # fmt: skip
X, Y, VX, VY, FACING, STOPPED, BALL_SEEN, BALL_PLACED, BALL_MOVING = range(8, 17)
BALL_X, BALL_Y, BALL_VX, BALL_VY, BALL_DISTANCE, BALL_AGE = range(17, 23)
OPPONENT = ("seen", "faced", "facing", "x", "y")
"""Of each opponent, behind `GOALIE`."""


@kernel
def guard(body, me, level, memory, age, players, opponents, goal_x, out):
    """`GOALIE` and `OPPONENT` of each opponent."""
    feel(body, out)
    out[X], out[Y], out[VX], out[VY], out[FACING] = me[_X], me[_Y], me[_VX], me[_VY], degrees(me[_FACING])
    out[STOPPED] = one(int(body[_MODE]) != _PLAY_ON)
    fresh = out[FRESH] > 0
    sure = fresh and me[_LOCATED] > 0
    out[BALL_SEEN] = one(fresh and level[0] > 0)
    out[BALL_PLACED], out[BALL_MOVING] = one(sure and level[0] > 0), one(sure and level[0] >= _MOVING)
    out[BALL_X], out[BALL_Y], out[BALL_VX], out[BALL_VY] = memory[0, 0], memory[0, 1], memory[0, 2], memory[0, 3]
    out[BALL_DISTANCE], out[BALL_AGE] = math.hypot(memory[0, 0] - me[_X], memory[0, 1] - me[_Y]), age[0]
    first = 11 if body[_SIDE] > 0 else 0
    for k in range(opponents):
        at, index, x, y = BALL_AGE + 1 + 5 * k, first + k, memory[12 + k, 0], memory[12 + k, 1]
        seen = sure and age[12 + k] == 0
        out[at], out[at + 1] = one(seen), one(seen and level[1 + index] >= _NUMBER)
        out[at + 2] = faces(me[_EYES] + players[index, _POSE], math.atan2(-y, goal_x - x))
        out[at + 3], out[at + 4] = x, y


@kernel
def guards(body, me, level, memory, age, players, opponents, goal_x, out):
    """`guard` in every world."""
    for w in range(len(out)):
        guard(body[w], me[w], level[w], memory[w], age[w], players[w], opponents, goal_x, out[w])


ATTRIBUTES = ("danger", "ball_gap")
"""Of each opponent, as `dangers` gives them."""


@kernel
def dangers(memory, age, opponents, danger, gaps):
    """Danger of each opponent, (W, opponents), and his metres from the ball."""
    for w in range(len(danger)):
        for k in range(opponents):
            gap = math.hypot(memory[w, 12 + k, 0] - memory[w, 0, 0], memory[w, 12 + k, 1] - memory[w, 0, 1])
            danger[w, k] = 1.0 / (1.0 + gap) if age[w, 12 + k] <= 20 else 0.0
            gaps[w, k] = gap if age[w, 12 + k] <= 4 else 99.0
