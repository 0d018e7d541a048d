"""Named quantities from observation arrays: what nets, models, state machines and hand-written code all read.

Angles are degrees here, relative to the body, because the server's commands take degrees relative to the body.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..envs.observations import BodyFeature, ObjectFeature, SelfFeature
from ..simulator.pitch import HALF_LENGTH
from ..simulator.senses import BallLevel, PlayerLevel
from ..simulator.state import PlayMode
from .body import DEFAULT, Body

Percepts = dict[str, np.ndarray]
"""Name -> (N,) float array; NaN where there is no reading."""


def body_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player feels of himself.

    Returns
    -------
    dict of (N,) float64
        ``body.stamina``, ``body.effort``, ``body.speed`` (m / cycle), ``body.speed_direction_deg`` and ``body.neck_deg`` (degrees),
        ``body.fresh`` (1 if he saw something this cycle), ``body.locked`` (cycles until the body obeys again).
    """
    body = np.asarray(observation["body"], np.float64)
    neck = np.degrees(body[:, BodyFeature.NECK])
    return {
        "body.stamina": body[:, BodyFeature.STAMINA],
        "body.effort": body[:, BodyFeature.EFFORT],
        "body.speed": body[:, BodyFeature.SPEED],
        "body.speed_direction_deg": np.degrees(body[:, BodyFeature.SPEED_DIRECTION]) + neck,
        "body.neck_deg": neck,
        "body.fresh": body[:, BodyFeature.FRESH],
        "body.locked": np.maximum(body[:, BodyFeature.TACKLE_EXPIRES], body[:, BodyFeature.FOUL_CHARGED]),
    }


def ball_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player sees of the ball, with `body_percepts`.

    Returns
    -------
    dict of (N,) float64
        ``ball.seen`` (1 if a ball, or something felt to be one, is in this percept), ``ball.distance`` (m), ``ball.direction_deg`` (degrees
        from the body); ``ball.moving`` (1 if its changes were told too), ``ball.distance_change`` (m / cycle),
        ``ball.direction_change_deg`` (degrees / cycle): 0 where not told.
    """
    percepts = body_percepts(observation)
    ball = np.asarray(observation["ball"], np.float64)
    level = np.asarray(observation["level"])[:, 0]
    seen = level > 0
    direction = np.degrees(ball[:, ObjectFeature.DIRECTION]) + percepts["body.neck_deg"]
    percepts["ball.seen"], percepts["ball.moving"] = seen.astype(np.float64), (level >= BallLevel.MOVING).astype(np.float64)
    percepts["ball.distance"] = np.where(seen, ball[:, ObjectFeature.DISTANCE], 0.0)
    percepts["ball.direction_deg"] = np.where(seen, (direction + 180.0) % 360.0 - 180.0, 0.0)
    percepts["ball.distance_change"] = np.where(seen, ball[:, ObjectFeature.DISTANCE_CHANGE], 0.0)
    percepts["ball.direction_change_deg"] = np.where(seen, np.degrees(ball[:, ObjectFeature.DIRECTION_CHANGE]), 0.0)
    return percepts


GOAL_X = HALF_LENGTH
"""x of the goal that is attacked, in the own team's frame."""
NEVER = 1000.0
"""Age of what was never seen, cycles."""
OFF_PITCH = 60.0
"""Metres that stand for a distance that is not known."""


def field_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player knows of the pitch, with `ball_percepts`; needs the observation's parts ``self``, ``memory``, ``memory_age``.

    Everything is *reckoned*: seen by himself, placed by landmarks, and carried on while the eye is closed. Positions are in the own
    team's frame (x towards the opponent's goal), directions in degrees from the own body.

    Returns
    -------
    dict of (N,) float64
        ``me.located`` (he has known his place since the episode began), ``me.x``, ``me.y``, ``me.facing_deg`` (degrees);
        ``ball.reckoned_distance`` (m), ``ball.reckoned_direction_deg``, ``ball.age`` (cycles since it was seen), ``ball.x``, ``ball.y``,
        ``ball.speed_ahead`` and ``ball.speed_aside`` (m / cycle along the body and to its right), ``ball.approach`` (m / cycle at which it
        comes nearer by its own motion); ``goal.distance``, ``goal.direction_deg``; of the nearest team-mate ``mate.distance``,
        ``mate.direction_deg``, ``mate.age``, ``mate.x``, ``mate.y``; ``game.waiting`` (before a kick-off), ``game.playing``, ``game.ours``
        (a set play of the own team).
    """
    percepts = ball_percepts(observation)
    me = np.asarray(observation["self"], np.float64)
    memory = np.asarray(observation["memory"], np.float64)
    age = np.asarray(observation["memory_age"], np.float64)
    body = np.asarray(observation["body"], np.float64)
    x, y, facing = me[:, SelfFeature.X], me[:, SelfFeature.Y], me[:, SelfFeature.BODY]

    def polar(to_x: np.ndarray | float, to_y: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """Distance, and direction from the body in degrees."""
        dx, dy = to_x - x, to_y - y
        angle = np.degrees(np.arctan2(dy, dx) - facing)
        return np.hypot(dx, dy), (angle + 180.0) % 360.0 - 180.0

    percepts["me.x"], percepts["me.y"], percepts["me.facing_deg"] = x, y, np.degrees(facing)
    percepts["me.located"] = me[:, SelfFeature.LOCATED]
    ball_x, ball_y, vx, vy = (memory[:, 0, k] for k in range(4))
    # what was seen of its motion before it hit the body is no longer true (specification/simulator.md 3.4: velocity times -0.1)
    bounced = (body[:, BodyFeature.COLLIDED_BALL] > 0) & (age[:, 0] > 0)
    vx, vy = np.where(bounced, -0.1 * vx, vx), np.where(bounced, -0.1 * vy, vy)
    distance, direction = polar(ball_x, ball_y)
    percepts["ball.x"], percepts["ball.y"], percepts["ball.age"] = ball_x, ball_y, age[:, 0]
    percepts["ball.reckoned_distance"], percepts["ball.reckoned_direction_deg"] = distance, direction
    percepts["ball.speed_ahead"] = vx * np.cos(facing) + vy * np.sin(facing)
    percepts["ball.speed_aside"] = vy * np.cos(facing) - vx * np.sin(facing)
    percepts["ball.approach"] = -(vx * (ball_x - x) + vy * (ball_y - y)) / np.maximum(distance, 0.1)
    percepts["goal.distance"], percepts["goal.direction_deg"] = polar(GOAL_X, 0.0)
    _mate_percepts(percepts, body, memory, age, polar)
    mode = body[:, BodyFeature.PLAY_MODE].astype(np.int64)
    left = body[:, BodyFeature.SIDE] > 0
    set_play = (mode >= PlayMode.kick_off_l) & (mode <= PlayMode.goal_kick_r)
    scored = (mode == PlayMode.goal_l) | (mode == PlayMode.goal_r)
    percepts["game.waiting"] = (scored | (mode == PlayMode.before_kick_off)).astype(np.float64)
    percepts["game.playing"] = (mode == PlayMode.play_on).astype(np.float64)
    percepts["game.ours"] = (set_play & ((mode % 2 == 0) == left)).astype(np.float64)
    return percepts


def _mate_percepts(percepts: Percepts, body: np.ndarray, memory: np.ndarray, age: np.ndarray, polar: Callable[..., Any]) -> None:
    """Adds the team-mate that was seen of late and is nearest; `OFF_PITCH` metres away when none has ever been seen."""
    own, rows = body[:, BodyFeature.UNUM].astype(np.int64), np.arange(len(body))
    known = age[:, 1:12] < NEVER
    known[rows, own - 1] = False
    apart = np.hypot(memory[:, 1:12, 0] - percepts["me.x"][:, None], memory[:, 1:12, 1] - percepts["me.y"][:, None])
    nearest = np.where(known, apart, np.inf).argmin(axis=1)
    found = known[rows, nearest]
    mate = memory[rows, 1 + nearest]
    distance, direction = polar(mate[:, 0], mate[:, 1])
    percepts["mate.x"] = np.where(found, mate[:, 0], percepts["me.x"])
    percepts["mate.y"] = np.where(found, mate[:, 1], percepts["me.y"])
    percepts["mate.age"] = np.where(found, age[rows, 1 + nearest], NEVER)
    percepts["mate.distance"] = np.where(found, distance, OFF_PITCH)
    percepts["mate.direction_deg"] = np.where(found, direction, 0.0)


def motion_percepts(observation: Mapping[str, np.ndarray], percepts: Percepts, own: Body = DEFAULT) -> Percepts:
    """How ball and player move along and across the line between them, added to `field_percepts`.

    Returns
    -------
    dict of (N,) float64
        `percepts`, with ``ball.placed`` (it was seen, and he knows where he looks), ``ball.bearing_deg`` (degrees in the frame of the own
        team's pitch, where placed), ``ball.rolling`` (m / cycle towards the player, where moving) and ``ball.swinging_deg`` (degrees /
        cycle) by its own motion; ``me.met`` (metres that the player went towards the ball in the last cycle; 0 while he has never seen it),
        ``me.slid_deg`` (degrees by which his own way moved its bearing, with the opposite sign), ``me.eyes_deg`` (degrees in the frame of
        the pitch); ``body.hit_ball`` (1 where the ball hit the body in the last cycle).
    """
    me = np.asarray(observation["self"], np.float64)
    ball = np.asarray(observation["ball"], np.float64)
    located = percepts["me.located"] > 0
    moving, seen = (percepts["ball.moving"] > 0) & located, percepts["ball.seen"] > 0
    facing = percepts["me.facing_deg"]
    bearing = np.where(seen, percepts["ball.direction_deg"], percepts["ball.reckoned_direction_deg"]) + facing
    distance = np.maximum(np.where(seen, percepts["ball.distance"], percepts["ball.reckoned_distance"]), 0.3)
    cos, sin = np.cos(np.radians(bearing)), np.sin(np.radians(bearing))
    vx, vy = me[:, SelfFeature.VX], me[:, SelfFeature.VY]
    ahead, aside = vx * cos + vy * sin, vy * cos - vx * sin
    percepts["ball.bearing_deg"] = (bearing + 180.0) % 360.0 - 180.0
    percepts["ball.placed"], percepts["ball.moving"] = (seen & located).astype(np.float64), moving.astype(np.float64)
    percepts["ball.rolling"] = np.where(moving, -(ball[:, ObjectFeature.DISTANCE_CHANGE] + ahead), 0.0)
    swinging = np.degrees(ball[:, ObjectFeature.DIRECTION_CHANGE] + aside / distance)
    percepts["ball.swinging_deg"] = np.where(moving, swinging, 0.0)
    known, decay = percepts["ball.age"] < NEVER, own.kind.player_decay  # the speed that is felt is what the decay has left
    percepts["me.met"] = np.where(known, ahead / decay, 0.0)
    percepts["me.slid_deg"] = np.where(known, np.degrees(np.arctan2(aside / decay, distance)), 0.0)
    percepts["body.hit_ball"] = np.asarray(observation["body"], np.float64)[:, BodyFeature.COLLIDED_BALL]
    percepts["me.eyes_deg"] = (np.degrees(me[:, SelfFeature.FACE]) + 180.0) % 360.0 - 180.0
    return percepts


def _mates(observation: Mapping[str, np.ndarray], mates: int) -> tuple[np.ndarray, np.ndarray]:
    """(N, 1) rows and (N, mates) uniform numbers of the team-mates, in order and without the own."""
    own = np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64)[:, None]
    numbers = np.arange(1, mates + 1)[None] + np.zeros_like(own)
    return np.arange(len(own))[:, None], numbers + (numbers >= own)


def mates_percepts(observation: Mapping[str, np.ndarray], mates: int) -> Percepts:
    """What was just seen of each team-mate, in the order of their numbers without the own.

    Returns
    -------
    dict of (N,) float64
        ``m1.seen``, ``m1.x``, ``m1.y`` (m, own team's frame), ``m1.faced`` (the way he faces was told: only of one who is seen with his
        number), ``m1.facing``: 0 his body points at the player, 1 aside of him, 2 away.
    """
    rows, numbers = _mates(observation, mates)
    me = np.asarray(observation["self"], np.float64)
    place = np.asarray(observation["memory"], np.float64)[rows, numbers]
    body = np.asarray(observation["body"])
    seen = (np.asarray(observation["memory_age"])[rows, numbers] == 0) & (body[:, BodyFeature.FRESH, None] > 0)
    seen &= me[:, SelfFeature.LOCATED, None] > 0
    # the rows of `players` are left 1 to 11, right 1 to 11
    index = numbers - 1 + np.where(body[:, BodyFeature.SIDE, None] > 0, 0, 11)
    heading = me[:, SelfFeature.FACE, None] + np.asarray(observation["players"], np.float64)[rows, index, ObjectFeature.BODY]
    faced = seen & (np.asarray(observation["level"])[rows, 1 + index] >= PlayerLevel.NUMBER)
    off = heading - np.arctan2(me[:, SelfFeature.Y, None] - place[..., 1], me[:, SelfFeature.X, None] - place[..., 0])
    off = np.abs((np.degrees(off) + 180.0) % 360.0 - 180.0)
    facing = np.select([off < 40.0, off > 110.0], [0.0, 2.0], 1.0)
    percepts: Percepts = {}
    for k in range(mates):
        percepts[f"m{k + 1}.seen"], percepts[f"m{k + 1}.faced"] = seen[:, k].astype(np.float64), faced[:, k].astype(np.float64)
        percepts[f"m{k + 1}.x"], percepts[f"m{k + 1}.y"] = place[:, k, 0], place[:, k, 1]
        percepts[f"m{k + 1}.facing"] = facing[:, k]
    return percepts


def mate_attributes(observation: Mapping[str, np.ndarray], mates: int) -> dict[str, np.ndarray]:
    """Of the same team-mates, what object places choose by.

    Returns
    -------
    dict of (N, mates) float64
        ``distance`` (m), ``age`` (cycles since he was seen), ``ball_gap`` (m from the ball; 99 when he or the ball was not seen of late).
    """
    rows, numbers = _mates(observation, mates)
    me, memory = np.asarray(observation["self"], np.float64), np.asarray(observation["memory"], np.float64)
    ages = np.asarray(observation["memory_age"], np.float64)
    place, age = memory[rows, numbers], ages[rows, numbers]
    gap = np.hypot(place[..., 0] - memory[:, :1, 0], place[..., 1] - memory[:, :1, 1])
    return {
        "distance": np.hypot(place[..., 0] - me[:, SelfFeature.X, None], place[..., 1] - me[:, SelfFeature.Y, None]),
        "age": age,
        "ball_gap": np.where((age <= 4) & (ages[:, :1] <= 4), gap, 99.0),
    }
