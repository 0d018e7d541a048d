"""What players feel, see and remember, world by world.

Every kernel takes a row of each part of an observation and writes a row of percepts, whose columns are named here; in words they stand
with the functions of `agents.percepts` that call them. Angles in observations are radians, in percepts degrees.
"""

from __future__ import annotations

import math

import numpy as np

from ...compilation import kernel_group
from ...envs.observations import BodyFeature, ObjectFeature, SelfFeature
from ...simulator.senses import BallLevel, PlayerLevel
from ...simulator.state import PlayMode

kernel = kernel_group(_nrt=False)

_STAMINA, _EFFORT, _SPEED, _WAY = (int(BodyFeature[n]) for n in ("STAMINA", "EFFORT", "SPEED", "SPEED_DIRECTION"))
_NECK, _FRESH, _TACKLE, _FOUL = (int(BodyFeature[n]) for n in ("NECK", "FRESH", "TACKLE_EXPIRES", "FOUL_CHARGED"))
_WIDTH = int(BodyFeature.VIEW_WIDTH)
_SIDE, _UNUM, _MODE, _HIT = (int(BodyFeature[n]) for n in ("SIDE", "UNUM", "PLAY_MODE", "COLLIDED_BALL"))
_DISTANCE, _DIRECTION, _NEARER, _ROUND, _POSE = (
    int(ObjectFeature[n]) for n in ("DISTANCE", "DIRECTION", "DISTANCE_CHANGE", "DIRECTION_CHANGE", "BODY")
)
_X, _Y, _VX, _VY, _FACING, _EYES, _LOCATED = (int(SelfFeature[n]) for n in ("X", "Y", "VX", "VY", "BODY", "FACE", "LOCATED"))
_MOVING, _NUMBER = int(BallLevel.MOVING), int(PlayerLevel.NUMBER)
_BEFORE, _PLAY_ON, _GOAL_L, _GOAL_R = (int(PlayMode[n]) for n in ("before_kick_off", "play_on", "goal_l", "goal_r"))
_FIRST_SET_PLAY, _LAST_SET_PLAY = int(PlayMode.kick_off_l), int(PlayMode.goal_kick_r)

BODY = (
    "body.stamina", "body.effort", "body.speed", "body.speed_direction_deg", "body.neck_deg", "body.fresh", "body.locked",
    "body.view_width",
)  # fmt: skip
STAMINA, EFFORT, SPEED, SPEED_DIRECTION, NECK, FRESH, LOCKED, VIEW_WIDTH = range(8)
BALL = (
    *BODY, "ball.seen", "ball.moving", "ball.distance", "ball.direction_deg", "ball.distance_change", "ball.direction_change_deg",
)  # fmt: skip
BALL_SEEN, BALL_MOVING, BALL_DISTANCE, BALL_DIRECTION, BALL_NEARER, BALL_ROUND = range(8, 14)
FIELD = (
    *BALL, "me.x", "me.y", "me.facing_deg", "me.located", "ball.x", "ball.y", "ball.age", "ball.reckoned_distance",
    "ball.reckoned_direction_deg", "ball.speed_ahead", "ball.speed_aside", "ball.approach", "goal.distance", "goal.direction_deg",
    "mate.x", "mate.y", "mate.age", "mate.distance", "mate.direction_deg", "game.waiting", "game.playing", "game.ours",
)  # fmt: skip
(
    X, Y, FACING, LOCATED, BALL_X, BALL_Y, BALL_AGE, RECKONED_DISTANCE, RECKONED_DIRECTION, AHEAD, ASIDE, APPROACH, GOAL_DISTANCE,
    GOAL_DIRECTION, MATE_X, MATE_Y, MATE_AGE, MATE_DISTANCE, MATE_DIRECTION, WAITING, PLAYING, OURS,
) = range(len(BALL), len(FIELD))  # fmt: skip
MOTION = (
    *FIELD, "ball.bearing_deg", "ball.placed", "ball.rolling", "ball.swinging_deg", "me.met", "me.slid_deg", "me.eyes_deg", "body.hit_ball",
)  # fmt: skip
BEARING, PLACED, ROLLING, SWINGING, MET, SLID, EYES, HIT_BALL = range(len(FIELD), len(MOTION))
MATE = ("seen", "faced", "x", "y", "facing")
"""Of each player who is seen."""


@kernel
def one(truth):
    """1 for what is true."""
    return 1.0 if truth else 0.0


@kernel
def degrees(radians):
    """Degrees of an angle."""
    return radians * (180.0 / math.pi)


@kernel
def turned(angle):
    """Degrees, -180 to less than 180."""
    return (angle + 180.0) % 360.0 - 180.0


@kernel
def feel(body, out):
    """`BODY`."""
    out[STAMINA], out[EFFORT], out[SPEED] = body[_STAMINA], body[_EFFORT], body[_SPEED]
    out[NECK] = degrees(body[_NECK])
    out[SPEED_DIRECTION] = degrees(body[_WAY]) + out[NECK]
    out[FRESH], out[LOCKED] = body[_FRESH], max(body[_TACKLE], body[_FOUL])
    out[VIEW_WIDTH] = body[_WIDTH]


@kernel
def see_ball(body, ball, level, out):
    """`BALL`."""
    feel(body, out)
    seen = level[0] > 0
    out[BALL_SEEN], out[BALL_MOVING] = one(seen), one(level[0] >= _MOVING)
    out[BALL_DISTANCE] = ball[_DISTANCE] if seen else 0.0
    out[BALL_DIRECTION] = turned(degrees(ball[_DIRECTION]) + out[NECK]) if seen else 0.0
    out[BALL_NEARER] = ball[_NEARER] if seen else 0.0
    out[BALL_ROUND] = degrees(ball[_ROUND]) if seen else 0.0


@kernel
def direction(me, x, y):
    """Direction to a point, degrees from the body."""
    return turned(degrees(math.atan2(y - me[_Y], x - me[_X]) - me[_FACING]))


@kernel
def nearest_mate(body, me, memory, age, never):
    """Row of the team-mate who is nearest of those ever seen; 0 for none."""
    found, least = 0, np.inf
    for row in range(1, 12):
        if row != int(body[_UNUM]) and age[row] < never:
            apart = math.hypot(memory[row, 0] - me[_X], memory[row, 1] - me[_Y])
            if apart < least:
                found, least = row, apart
    return found


@kernel
def know_field(body, ball, level, me, memory, age, goal_x, never, off_pitch, out):
    """`FIELD`."""
    see_ball(body, ball, level, out)
    x, y, facing = me[_X], me[_Y], me[_FACING]
    out[X], out[Y], out[FACING], out[LOCATED] = x, y, degrees(facing), me[_LOCATED]
    ball_x, ball_y, vx, vy = memory[0, 0], memory[0, 1], memory[0, 2], memory[0, 3]
    if body[_HIT] > 0 and age[0] > 0:  # what was seen of its motion before is no longer true (specification/simulator.md 3.4)
        vx, vy = -0.1 * vx, -0.1 * vy
    out[BALL_X], out[BALL_Y], out[BALL_AGE] = ball_x, ball_y, age[0]
    out[RECKONED_DISTANCE], out[RECKONED_DIRECTION] = math.hypot(ball_x - x, ball_y - y), direction(me, ball_x, ball_y)
    out[AHEAD] = vx * math.cos(facing) + vy * math.sin(facing)
    out[ASIDE] = vy * math.cos(facing) - vx * math.sin(facing)
    out[APPROACH] = -(vx * (ball_x - x) + vy * (ball_y - y)) / max(out[RECKONED_DISTANCE], 0.1)
    out[GOAL_DISTANCE], out[GOAL_DIRECTION] = math.hypot(goal_x - x, 0.0 - y), direction(me, goal_x, 0.0)
    mate = nearest_mate(body, me, memory, age, never)
    out[MATE_X], out[MATE_Y], out[MATE_AGE], out[MATE_DISTANCE], out[MATE_DIRECTION] = x, y, never, off_pitch, 0.0
    if mate > 0:
        out[MATE_X], out[MATE_Y], out[MATE_AGE] = memory[mate, 0], memory[mate, 1], age[mate]
        out[MATE_DISTANCE] = math.hypot(out[MATE_X] - x, out[MATE_Y] - y)
        out[MATE_DIRECTION] = direction(me, out[MATE_X], out[MATE_Y])
    mode = int(body[_MODE])
    out[WAITING] = one(mode == _GOAL_L or mode == _GOAL_R or mode == _BEFORE)
    out[PLAYING] = one(mode == _PLAY_ON)
    out[OURS] = one(_FIRST_SET_PLAY <= mode <= _LAST_SET_PLAY and (mode % 2 == 0) == (body[_SIDE] > 0))


@kernel
def know_motion(body, ball, me, never, decay, out):
    """The rest of `MOTION`, after `know_field`."""
    located, seen = out[LOCATED] > 0, out[BALL_SEEN] > 0
    moving = out[BALL_MOVING] > 0 and located
    bearing = (out[BALL_DIRECTION] if seen else out[RECKONED_DIRECTION]) + out[FACING]
    distance = max(out[BALL_DISTANCE] if seen else out[RECKONED_DISTANCE], 0.3)
    cos, sin = math.cos(bearing * (math.pi / 180.0)), math.sin(bearing * (math.pi / 180.0))
    ahead, aside = me[_VX] * cos + me[_VY] * sin, me[_VY] * cos - me[_VX] * sin
    out[BEARING], out[PLACED], out[BALL_MOVING] = turned(bearing), one(seen and located), one(moving)
    out[ROLLING] = -(ball[_NEARER] + ahead) if moving else 0.0
    out[SWINGING] = degrees(ball[_ROUND] + aside / distance) if moving else 0.0
    known = out[BALL_AGE] < never
    out[MET] = ahead / decay if known else 0.0  # the speed that is felt is what the decay has left
    out[SLID] = degrees(math.atan2(aside / decay, distance)) if known else 0.0
    out[EYES], out[HIT_BALL] = turned(degrees(me[_EYES])), body[_HIT]


@kernel
def faces(heading, to):
    """0 for one whose body points that way, 1 aside of it, 2 away from it."""
    off = abs(turned(degrees(heading - to)))
    return 0.0 if off < 40.0 else (2.0 if off > 110.0 else 1.0)


@kernel
def see_mates(body, me, level, memory, age, players, mates, out):
    """`MATE` of each of some team-mates, in the order of their numbers without the own."""
    k = 0
    for number in range(1, mates + 2):
        if number == int(body[_UNUM]) or k == mates:
            continue
        index = number - 1 if body[_SIDE] > 0 else number + 10  # the rows of `players` are left 1 to 11, right 1 to 11
        x, y = memory[number, 0], memory[number, 1]
        seen = age[number] == 0 and body[_FRESH] > 0 and me[_LOCATED] > 0
        to = math.atan2(me[_Y] - y, me[_X] - x)
        out[5 * k], out[5 * k + 1] = one(seen), one(seen and level[1 + index] >= _NUMBER)
        out[5 * k + 2], out[5 * k + 3] = x, y
        out[5 * k + 4] = faces(me[_EYES] + players[index, _POSE], to)
        k += 1


@kernel
def bodies(body, out):
    """`feel` in every world."""
    for w in range(len(out)):
        feel(body[w], out[w])


@kernel
def balls(body, ball, level, out):
    """`see_ball` in every world."""
    for w in range(len(out)):
        see_ball(body[w], ball[w], level[w], out[w])


@kernel
def fields(body, ball, level, me, memory, age, goal_x, never, off_pitch, out):
    """`know_field` in every world."""
    for w in range(len(out)):
        know_field(body[w], ball[w], level[w], me[w], memory[w], age[w], goal_x, never, off_pitch, out[w])


@kernel
def motions(body, ball, me, never, decay, out):
    """`know_motion` in every world."""
    for w in range(len(out)):
        know_motion(body[w], ball[w], me[w], never, decay, out[w])


@kernel
def mates_seen(body, me, level, memory, age, players, mates, out):
    """`see_mates` in every world."""
    for w in range(len(out)):
        see_mates(body[w], me[w], level[w], memory[w], age[w], players[w], mates, out[w])


ATTRIBUTES = ("distance", "age", "ball_gap")
"""By what team-mates are chosen."""


@kernel
def judgements(body, me, memory, age, mates, out):
    """`ATTRIBUTES` of each of some team-mates, in the order of their numbers without the own, into (3, W, mates)."""
    for w in range(len(body)):
        k = 0
        for number in range(1, mates + 2):
            if number == int(body[w, _UNUM]) or k == mates:
                continue
            x, y = memory[w, number, 0], memory[w, number, 1]
            gap = math.hypot(x - memory[w, 0, 0], y - memory[w, 0, 1])
            out[0, w, k] = math.hypot(x - me[w, _X], y - me[w, _Y])
            out[1, w, k] = age[w, number]
            out[2, w, k] = gap if age[w, number] <= 4 and age[w, 0] <= 4 else 99.0
            k += 1
