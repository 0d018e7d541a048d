"""What an outfield player perceives beyond `percepts.FIELD`: whose ball it is, where to shoot, to whom to pass, which way is free.

World by world; in words in `outfielder.percepts`. Metres, cycles, degrees from the own body, in the frame of his team.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compilation import kernel_group
from ...envs.observations import BodyFeature, SelfFeature
from ...simulator.state import PlayMode
from .percepts import (
    FACING,
    FIELD,
    GOAL_DIRECTION,
    GOAL_DISTANCE,
    LOCATED,
    OURS,
    PLAYING,
    RECKONED_DIRECTION,
    RECKONED_DISTANCE,
    X,
    Y,
    degrees,
    know_field,
    one,
    turned,
)

kernel = kernel_group(_nrt=False)

_SIDE, _UNUM, _MODE = int(BodyFeature.SIDE), int(BodyFeature.UNUM), int(BodyFeature.PLAY_MODE)
_X, _Y = int(SelfFeature.X), int(SelfFeature.Y)
_FIRST_SET_PLAY, _LAST_SET_PLAY = int(PlayMode.kick_off_l), int(PlayMode.goal_kick_r)
_INDIRECT_L, _INDIRECT_R = int(PlayMode.indirect_free_kick_l), int(PlayMode.indirect_free_kick_r)
_PLAY_ON, _DROP_BALL = int(PlayMode.play_on), int(PlayMode.drop_ball)
_KICK_OFF_L, _KICK_OFF_R = int(PlayMode.kick_off_l), int(PlayMode.kick_off_r)

OUTFIELD = (
    *FIELD, "me.time", "meet.x", "meet.y", "place.x", "place.y", "line.x", "game.theirs", "game.kick_off", "goal.room",
    "way.direction_deg", "ball.vx", "ball.vy", "ball.placed",
    *(f"{team}{k}.{part}" for team in "to" for k in range(1, 12) for part in ("seen", "x", "y")),
)  # fmt: skip
TIME, MEET_X, MEET_Y, PLACE_X, PLACE_Y, LINE, THEIRS, KICK_OFF, ROOM, WAY, BALL_VX, BALL_VY, BALL_PLACED, PLAYERS = range(
    len(FIELD), len(FIELD) + 14
)
WAYS, AIMS = 9, 7
"""How many directions, and points of the goal, are looked at."""
TURN = 17.0
"""Degrees off the ball beyond which a player turns first."""


class Terms(NamedTuple):
    """What everything is judged by: of the pitch, the body and the behaviour."""

    goal_x: float
    half_length: float
    half_width: float
    never: float
    off_pitch: float
    roll: float
    fade: float
    pace: float
    near: float
    start: float
    at_feet: float
    recent: float
    forgotten: float
    period: float
    aim: float
    shot: float
    way: float
    spread: float


@kernel
def meeting(ball, x, y, t):
    """When and where a player at (x, y) meets the rolling ball: a few steps of "where is it when I am there"."""
    time = max(math.hypot(ball[0] - x, ball[1] - y) - t.near, 0.0) / t.pace
    for _ in range(3):
        rolled = (1.0 - math.exp(-t.fade * time)) / t.roll
        reach = max(math.hypot(ball[0] + ball[2] * rolled - x, ball[1] + ball[3] * rolled - y) - t.near, 0.0) / t.pace
        time = 0.5 * (time + reach)
    rolled = (1.0 - math.exp(-t.fade * time)) / t.roll
    return time, ball[0] + ball[2] * rolled, ball[1] + ball[3] * rolled


@kernel
def lane(memory, age, x, y, speed, recent):
    """How clear the way from the ball to a point is: the least of (an opponent's distance to it - what he runs meanwhile), m; 20 for those
    who are not near it."""
    dx, dy = x - memory[0, 0], y - memory[0, 1]
    length = max(math.hypot(dx, dy), 0.1)
    ux, uy = dx / length, dy / length
    pace = max(0.6, 0.8 * speed)
    least = np.inf
    for row in range(12, 23):
        ox, oy = memory[row, 0] - memory[0, 0], memory[row, 1] - memory[0, 1]
        along = ox * ux + oy * uy
        if age[row] <= recent and -1.0 <= along <= length + 3.0:
            least = min(least, abs(ox * uy - oy * ux) - 0.55 * (max(along, 0.0) / pace) - 0.8)
        else:
            least = min(least, 20.0)
    return least


@kernel
def nearest(memory, age, x, y, recent):
    """Metres from a point to the nearest opponent who was seen of late, at most 50."""
    least = np.inf
    for row in range(12, 23):
        gap = math.hypot(memory[row, 0] - x, memory[row, 1] - y) if age[row] <= recent else 50.0
        least = min(least, gap)
    return least


@kernel
def second_last(memory, age, forgotten):
    """x of the last but one opponent, 0 for those forgotten."""
    first, second = -np.inf, -np.inf
    for row in range(12, 23):
        x = memory[row, 0] if age[row] <= forgotten else 0.0
        if x > first:
            first, second = x, first
        elif x > second:
            second = x
    return second


@kernel
def aim(memory, age, t, out):
    """`GOAL_DISTANCE`, `GOAL_DIRECTION` and `ROOM`: the point of the goal with the clearest way."""
    best, at = -np.inf, 0.0
    for k in range(AIMS):
        y = (k - 3) / 3.0 * t.aim
        room = lane(memory, age, t.goal_x + 0.5, y, t.shot, t.recent) + 0.04 * abs(y)
        if room > best:
            best, at = room, y
    out[ROOM], out[GOAL_DISTANCE] = best, math.hypot(t.goal_x - out[X], at - out[Y])
    out[GOAL_DIRECTION] = turned(degrees(math.atan2(at - out[Y], t.goal_x - out[X])) - out[FACING])


@kernel
def free_way(memory, age, t, out):
    """`WAY`: the freest of some ways ahead."""
    goal = math.atan2(-0.7 * memory[0, 1], t.goal_x - memory[0, 0])
    best, way = -np.inf, 0.0
    for k in range(WAYS):
        turn = (k - 4) * t.spread
        x, y = memory[0, 0] + t.way * math.cos(goal + turn), memory[0, 1] + t.way * math.sin(goal + turn)
        worth = min(nearest(memory, age, x, y, t.recent), 6.0) + min(lane(memory, age, x, y, 1.2, t.recent), 3.0)
        off_pitch = abs(y) > t.half_width - 2.0 or x > t.half_length - 1.5
        worth = worth - 1.6 * abs(turn) / 0.35 - (20.0 if off_pitch else 0.0)
        if worth > best:
            best, way = worth, goal + turn
    out[WAY] = turned(degrees(way) - out[FACING])


@kernel
def whose_ball(body, out):
    """Whose set play it is, indirect free kicks among them."""
    mode = int(body[_MODE])
    set_play = _FIRST_SET_PLAY <= mode <= _LAST_SET_PLAY or mode == _INDIRECT_L or mode == _INDIRECT_R
    ours = (mode % 2 == 0) == (body[_SIDE] > 0)
    out[PLAYING] = one(mode == _PLAY_ON or mode == _DROP_BALL)
    out[OURS], out[THEIRS] = one(set_play and ours), one(set_play and not ours)
    out[KICK_OFF] = one(mode == _KICK_OFF_L or mode == _KICK_OFF_R)


@kernel
def know(body, ball, level, me, memory, age, formation, t, out):
    """`OUTFIELD`."""
    know_field(body, ball, level, me, memory, age, t.goal_x, t.never, t.off_pitch, out)
    time, out[MEET_X], out[MEET_Y] = meeting(memory[0], out[X], out[Y], t)
    out[TIME] = time + (t.start if abs(out[RECKONED_DIRECTION]) > TURN else 0.0)
    number = int(body[_UNUM]) - 1
    out[PLACE_X], out[PLACE_Y] = formation[number, 0], formation[number, 1]
    out[LINE] = max(second_last(memory, age, t.forgotten), max(0.0, memory[0, 0]))
    out[BALL_VX], out[BALL_VY] = memory[0, 2], memory[0, 3]
    out[BALL_PLACED] = one(age[0] < t.period and out[LOCATED] > 0)
    for row in range(1, 23):
        at = PLAYERS + 3 * (row - 1)
        out[at], out[at + 1], out[at + 2] = one(age[row] < t.period and out[LOCATED] > 0), memory[row, 0], memory[row, 1]
    whose_ball(body, out)
    out[ROOM], out[WAY] = -20.0, out[GOAL_DIRECTION]
    if out[RECKONED_DISTANCE] < t.at_feet:
        aim(memory, age, t, out)
        free_way(memory, age, t, out)


@kernel
def everybody(body, ball, level, me, memory, age, formation, t, out):
    """`know` in every world."""
    for w in range(len(out)):
        know(body[w], ball[w], level[w], me[w], memory[w], age[w], formation, t, out[w])


MATES = ("x", "y", "age", "time", "distance", "ahead", "room", "free", "beyond", "present")
RIVALS = ("x", "y", "age", "danger", "ball_gap")
"""Attributes of each team-mate and opponent."""


@kernel
def judge(body, me, memory, age, t, mates, rivals):
    """`MATES` of the eleven into (10, 11), `RIVALS` into (5, 11)."""
    ball_x, ball_y = memory[0, 0], memory[0, 1]
    feet = math.hypot(ball_x - me[_X], ball_y - me[_Y]) < t.at_feet
    line = max(second_last(memory, age, t.forgotten), max(0.0, ball_x))
    for k in range(11):
        x, y, old = memory[1 + k, 0], memory[1 + k, 1], age[1 + k]
        distance = math.hypot(x - ball_x, y - ball_y)
        mates[0, k], mates[1, k], mates[2, k], mates[3, k] = x, y, old, meeting(memory[0], x, y, t)[0]
        mates[4, k], mates[5, k] = distance, x - ball_x
        mates[6, k] = lane(memory, age, x, y, 1.0 + t.roll * distance, t.recent) if feet else 0.0
        mates[7, k] = nearest(memory, age, x, y, t.recent) if feet else 0.0
        mates[8, k] = x - line if x > 0.0 else -50.0
        mates[9, k] = one(old < t.never and k != int(body[_UNUM]) - 1)
        x, y, old = memory[12 + k, 0], memory[12 + k, 1], age[12 + k]
        gap = math.hypot(x - ball_x, y - ball_y)
        rivals[0, k], rivals[1, k], rivals[2, k] = x, y, old
        rivals[3, k] = 1.0 / (1.0 + gap) if old <= 20.0 else 0.0
        rivals[4, k] = gap if old <= 4.0 else 99.0


@kernel
def judgements(body, me, memory, age, t, mates, rivals):
    """`judge` in every world; the worlds are the second axis of `mates` and `rivals`."""
    for w in range(len(body)):
        judge(body[w], me[w], memory[w], age[w], t, mates[:, w], rivals[:, w])
