"""Percepts by formulas over whole arrays, as they were before kernels computed them: the oracle of the kernels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.outfielder.model import PERIOD
from cprm_gym.envs.observations import BodyFeature, ObjectFeature, SelfFeature
from cprm_gym.envs.players.scripted import FORMATION
from cprm_gym.simulator.pitch import HALF_LENGTH, HALF_WIDTH
from cprm_gym.simulator.senses import BallLevel, PlayerLevel
from cprm_gym.simulator.state import PlayMode

Percepts = dict[str, np.ndarray]
Observation = Mapping[str, np.ndarray]


def body_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player feels of himself."""
    body = np.asarray(observation["body"], np.float64)
    neck = np.degrees(body[:, BodyFeature.NECK])
    return {
        "body.stamina": body[:, BodyFeature.STAMINA],
        "body.effort": body[:, BodyFeature.EFFORT],
        "body.speed": body[:, BodyFeature.SPEED],
        "body.speed_direction_deg": np.degrees(body[:, BodyFeature.SPEED_DIRECTION]) + neck,
        "body.neck_deg": neck,
        "body.fresh": body[:, BodyFeature.FRESH],
        "body.view_width": body[:, BodyFeature.VIEW_WIDTH],
        "body.locked": np.maximum(body[:, BodyFeature.TACKLE_EXPIRES], body[:, BodyFeature.FOUL_CHARGED]),
    }


def ball_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player sees of the ball, with `body_percepts`."""
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
    """What the player knows of the pitch, with `ball_percepts`; needs the observation's parts ``self``, ``memory``, ``memory_age``."""
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
    """How ball and player move along and across the line between them, added to `field_percepts`."""
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
    """What was just seen of each team-mate, in the order of their numbers without the own."""
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
    """Of the same team-mates, what object places choose by."""
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


def goalie_percepts(observation: Observation, opponents: int = 11) -> Percepts:
    """What the goalie feels and sees, in the frame of his team's pitch (metres, degrees, m / cycle)."""
    percepts = body_percepts(observation)
    me = np.asarray(observation["self"], np.float64)
    memory = np.asarray(observation["memory"], np.float64)
    age = np.asarray(observation["memory_age"])
    level = np.asarray(observation["level"])
    fresh = percepts["body.fresh"] > 0
    percepts["self.x"], percepts["self.y"] = me[:, SelfFeature.X], me[:, SelfFeature.Y]
    percepts["self.vx"], percepts["self.vy"] = me[:, SelfFeature.VX], me[:, SelfFeature.VY]
    percepts["self.body_deg"] = np.degrees(me[:, SelfFeature.BODY])
    mode = observation["body"][:, BodyFeature.PLAY_MODE]
    percepts["game.stopped"] = (mode != PlayMode.play_on).astype(np.float64)
    percepts["ball.seen"] = (fresh & (level[:, 0] > 0)).astype(np.float64)
    located = me[:, SelfFeature.LOCATED] > 0
    percepts["ball.placed"] = (fresh & located & (level[:, 0] > 0)).astype(np.float64)
    percepts["ball.moving"] = (fresh & located & (level[:, 0] >= BallLevel.MOVING)).astype(np.float64)
    for k, name in enumerate(("ball.x", "ball.y", "ball.vx", "ball.vy")):
        percepts[name] = memory[:, 0, k]
    percepts["ball.distance"] = np.hypot(memory[:, 0, 0] - percepts["self.x"], memory[:, 0, 1] - percepts["self.y"])
    percepts["ball.age"] = np.asarray(age[:, 0], np.float64)
    rows = slice(12, 12 + opponents)
    first = 11 if observation["body"][0, BodyFeature.SIDE] > 0 else 0
    x, y = memory[:, rows, 0], memory[:, rows, 1]
    seen = (fresh & located)[:, None] & (age[:, rows] == 0)
    faced = seen & (level[:, 1 + first : 1 + first + opponents] >= PlayerLevel.NUMBER)
    bodies = np.asarray(observation["players"][:, first : first + opponents, ObjectFeature.BODY], np.float64)
    heading = me[:, SelfFeature.FACE, None] + bodies
    off = np.degrees(heading - np.arctan2(-y, -HALF_LENGTH - x))
    off = np.abs((off + 180.0) % 360.0 - 180.0)
    facing = np.where(off < 40.0, 0.0, np.where(off > 110.0, 2.0, 1.0))
    for k in range(opponents):
        name = f"o{k + 1}"
        percepts[f"{name}.seen"], percepts[f"{name}.faced"] = seen[:, k].astype(np.float64), faced[:, k].astype(np.float64)
        percepts[f"{name}.facing"] = facing[:, k]
        percepts[f"{name}.x"], percepts[f"{name}.y"] = x[:, k], y[:, k]
    return percepts


def opponent_attributes(observation: Observation, opponents: int = 11) -> Mapping[str, Mapping[str, np.ndarray]]:
    """By what the goalie chooses whom to watch: attributes of the candidates of his object places."""
    memory = np.asarray(observation["memory"], np.float64)
    age = np.asarray(observation["memory_age"])[:, 12 : 12 + opponents]
    gap = np.hypot(*(memory[:, 12 : 12 + opponents, k] - memory[:, :1, k] for k in (0, 1)))
    known = age <= 20
    return {"Opponent": {"danger": np.where(known, 1.0 / (1.0 + gap), 0.0), "ball_gap": np.where(known & (age <= 4), gap, 99.0)}}


MATES, OPPONENTS = slice(1, 12), slice(12, 23)
"""Rows of ``memory``."""
STRIDE, START = 0.95, 1.0
"""A running player's share of the top speed, and the cycles that a turn to the ball costs."""
REACHED = 0.593
"""Share of the kickable ring at which a player who runs to the ball has it."""
AT_FEET = 4.0
"""Metres from the ball within which he looks for shots and free ways."""
RECENT = 15
"""Cycles within which an opponent must have been seen to be in the way."""
FORGOTTEN = 40
"""Cycles after which an opponent no longer counts for the offside line."""
CORNER = 0.87
"""How far from its middle he aims at the goal, as a share of its half width."""
SHOT_SPEED = 0.867
"""Speed of a shot, as the lane is judged, as a share of ``ball_speed_max``."""
WAY = 6.0
"""Metres ahead that a free way is looked for."""
ANGLES = np.arange(-4, 5) * 0.35
"""Ways that are considered, radians from that to the goal."""
_AIMS = np.arange(-3, 4) / 3.0


def meeting(memory: np.ndarray, x: np.ndarray, y: np.ndarray, own: Body = DEFAULT) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """When and where players meet the rolling ball: a few steps of "where is it when I am there".

    Parameters
    ----------
    memory : (N, 23, 4) array
        Row 0 the ball: x, y, vx, vy.
    x, y : (N, K) arrays
        Where the players are, m.
    own : Body
        Everybody is taken to run as he does.

    Returns
    -------
    time, meet_x, meet_y : (N, K) arrays
    """
    ball_x, ball_y, vx, vy = (memory[:, 0, k, None] for k in range(4))
    roll, fade, stride, near = own.roll, own.fade, own.pace(STRIDE), own.within(REACHED)
    time = np.maximum(np.hypot(ball_x - x, ball_y - y) - near, 0.0) / stride
    for _ in range(3):
        rolled = (1.0 - np.exp(-fade * time)) / roll
        reach = np.maximum(np.hypot(ball_x + vx * rolled - x, ball_y + vy * rolled - y) - near, 0.0) / stride
        time = 0.5 * (time + reach)
    rolled = (1.0 - np.exp(-fade * time)) / roll
    return time, ball_x + vx * rolled, ball_y + vy * rolled


def lane(ball: np.ndarray, x: np.ndarray, y: np.ndarray, speed: np.ndarray | float, opponents: np.ndarray, known: np.ndarray) -> np.ndarray:
    """How clear the ways from the ball to some points are: the least of (an opponent's distance to it - what he runs meanwhile)."""
    dx, dy = x - ball[:, :1], y - ball[:, 1:]
    length = np.maximum(np.hypot(dx, dy), 0.1)
    ux, uy = (dx / length)[..., None], (dy / length)[..., None]
    ox, oy = (opponents[:, None, :, k] - ball[:, None, k, None] for k in (0, 1))
    along = ox * ux + oy * uy
    pace = np.maximum(0.6, 0.8 * np.broadcast_to(speed, x.shape))[..., None]
    time = np.maximum(along, 0.0) / pace
    room = np.abs(ox * uy - oy * ux) - 0.55 * time - 0.8
    counts = known[:, None, :] & (along >= -1.0) & (along <= length[..., None] + 3.0)
    out: np.ndarray = np.where(counts, room, 20.0).min(axis=2)
    return out


def nearest(x: np.ndarray, y: np.ndarray, opponents: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(N, K) metres from some points to the nearest opponent who counts, at most 50."""
    gap = np.hypot(opponents[:, None, :, 0] - x[..., None], opponents[:, None, :, 1] - y[..., None])
    out: np.ndarray = np.where(known[:, None, :], gap, 50.0).min(axis=2)
    return out


def outfield_percepts(observation: Observation, own: Body = DEFAULT) -> Percepts:
    """What an outfield player perceives."""
    percepts = field_percepts(observation)
    memory = np.asarray(observation["memory"], np.float64)
    age = np.asarray(observation["memory_age"], np.float64)
    body = np.asarray(observation["body"])
    x, y = percepts["me.x"], percepts["me.y"]
    turn = np.where(np.abs(percepts["ball.reckoned_direction_deg"]) > 17.0, START, 0.0)[:, None]
    time, meet_x, meet_y = meeting(memory, x[:, None], y[:, None], own)
    percepts["me.time"], percepts["meet.x"], percepts["meet.y"] = (time + turn)[:, 0], meet_x[:, 0], meet_y[:, 0]
    place = FORMATION[body[:, BodyFeature.UNUM].astype(np.int64) - 1]
    percepts["place.x"], percepts["place.y"] = place[:, 0], place[:, 1]
    last = np.sort(np.where(age[:, OPPONENTS] <= FORGOTTEN, memory[:, OPPONENTS, 0], 0.0), axis=1)
    percepts["line.x"] = np.maximum(last[:, -2], np.maximum(0.0, memory[:, 0, 0]))
    _seen(percepts, memory, age)
    _game(percepts, body)
    percepts["goal.room"] = np.full(len(x), -20.0)
    percepts["way.direction_deg"] = percepts["goal.direction_deg"]
    if (percepts["ball.reckoned_distance"] < AT_FEET).any():
        _with_ball(percepts, memory, age, own)
    return percepts


def _seen(percepts: Percepts, memory: np.ndarray, age: np.ndarray) -> None:
    """What was seen since the last slice of the model."""
    percepts["ball.vx"], percepts["ball.vy"] = memory[:, 0, 2], memory[:, 0, 3]
    now = ((age < PERIOD) & (percepts["me.located"][:, None] > 0)).astype(np.float64)
    percepts["ball.placed"] = now[:, 0]
    for row in range(1, 23):
        name = _NAMES[row - 1]
        percepts[name[0]], percepts[name[1]], percepts[name[2]] = now[:, row], memory[:, row, 0], memory[:, row, 1]


_NAMES = [tuple(f"{team}{k}.{part}" for part in ("seen", "x", "y")) for team in "to" for k in range(1, 12)]


def _game(percepts: Percepts, body: np.ndarray) -> None:
    """Whose set play it is, indirect free kicks among them."""
    mode = body[:, BodyFeature.PLAY_MODE].astype(np.int64)
    left = body[:, BodyFeature.SIDE] > 0
    indirect = (mode == PlayMode.indirect_free_kick_l) | (mode == PlayMode.indirect_free_kick_r)
    set_play = ((mode >= PlayMode.kick_off_l) & (mode <= PlayMode.goal_kick_r)) | indirect
    ours = (mode % 2 == 0) == left
    percepts["game.playing"] = ((mode == PlayMode.play_on) | (mode == PlayMode.drop_ball)).astype(np.float64)
    percepts["game.ours"] = (set_play & ours).astype(np.float64)
    percepts["game.theirs"] = (set_play & ~ours).astype(np.float64)
    percepts["game.kick_off"] = ((mode == PlayMode.kick_off_l) | (mode == PlayMode.kick_off_r)).astype(np.float64)


def _with_ball(percepts: Percepts, memory: np.ndarray, age: np.ndarray, own: Body) -> None:
    """Where to shoot and which way to drive the ball."""
    ball, opponents, known = memory[:, 0, :2], memory[:, OPPONENTS, :2], age[:, OPPONENTS] <= RECENT
    count, rows = len(memory), np.arange(len(memory))
    x, y, facing = percepts["me.x"], percepts["me.y"], percepts["me.facing_deg"]
    aims = np.broadcast_to(_AIMS * (CORNER * own.server.goal_width / 2), (count, len(_AIMS)))
    room = lane(ball, np.full(aims.shape, GOAL_X + 0.5), aims, SHOT_SPEED * own.server.ball_speed_max, opponents, known) + 0.04 * np.abs(
        aims
    )
    best = room.argmax(axis=1)
    feet = percepts["ball.reckoned_distance"] < AT_FEET
    aim = np.where(feet, aims[rows, best], 0.0)
    percepts["goal.room"] = np.where(feet, room[rows, best], -20.0)
    percepts["goal.distance"] = np.hypot(GOAL_X - x, aim - y)
    percepts["goal.direction_deg"] = (np.degrees(np.arctan2(aim - y, GOAL_X - x)) - facing + 180.0) % 360.0 - 180.0
    goal = np.arctan2(-0.7 * ball[:, 1], GOAL_X - ball[:, 0])
    angle = goal[:, None] + ANGLES
    to_x, to_y = ball[:, :1] + WAY * np.cos(angle), ball[:, 1:] + WAY * np.sin(angle)
    worth = np.minimum(nearest(to_x, to_y, opponents, known), 6.0) + np.minimum(lane(ball, to_x, to_y, 1.2, opponents, known), 3.0)
    worth = worth - 1.6 * np.abs(ANGLES) / 0.35 - 20.0 * ((np.abs(to_y) > HALF_WIDTH - 2.0) | (to_x > HALF_LENGTH - 1.5))
    way = np.where(feet, angle[rows, worth.argmax(axis=1)], np.arctan2(-y, GOAL_X - x))
    percepts["way.direction_deg"] = (np.degrees(way) - facing + 180.0) % 360.0 - 180.0


def outfield_attributes(observation: Observation, own: Body = DEFAULT) -> Mapping[str, Mapping[str, np.ndarray]]:
    """By what he chooses players: attributes of the candidates of his object places."""
    memory = np.asarray(observation["memory"], np.float64)
    age = np.asarray(observation["memory_age"], np.float64)
    body, me = np.asarray(observation["body"]), np.asarray(observation["self"], np.float64)
    rows = np.arange(len(memory))
    ball, opponents = memory[:, 0, :2], memory[:, OPPONENTS, :2]
    opponent_age, mate_age = age[:, OPPONENTS], age[:, MATES]
    x, y = memory[:, MATES, 0], memory[:, MATES, 1]
    present = mate_age < NEVER
    present[rows, body[:, BodyFeature.UNUM].astype(np.int64) - 1] = False
    ahead, aside = x - ball[:, :1], y - ball[:, 1:]
    distance = np.hypot(ahead, aside)
    time, _, _ = meeting(memory, x, y, own)
    room, free = np.zeros(x.shape), np.zeros(x.shape)
    feet = np.hypot(ball[:, 0] - me[:, SelfFeature.X], ball[:, 1] - me[:, SelfFeature.Y]) < AT_FEET
    if feet.any():
        known = opponent_age <= RECENT
        room = np.where(feet[:, None], lane(ball, x, y, 1.0 + own.roll * distance, opponents, known), 0.0)
        free = np.where(feet[:, None], nearest(x, y, opponents, known), 0.0)
    last = np.sort(np.where(opponent_age <= FORGOTTEN, opponents[..., 0], 0.0), axis=1)
    beyond = np.where(x > 0.0, x - np.maximum(last[:, -2:-1], np.maximum(0.0, ball[:, :1])), -50.0)
    gap = np.hypot(opponents[..., 0] - ball[:, :1], opponents[..., 1] - ball[:, 1:])
    seen = opponent_age <= 20.0
    return {
        "Teammate": {"x": x, "y": y, "age": mate_age, "time": time, "distance": distance, "ahead": ahead, "room": room, "free": free,
                     "beyond": beyond, "present": present.astype(np.float64)},
        "Opponent": {"x": opponents[..., 0], "y": opponents[..., 1], "age": opponent_age,
                     "danger": np.where(seen, 1.0 / (1.0 + gap), 0.0),
                     "ball_gap": np.where(seen & (opponent_age <= 4.0), gap, 99.0)},
    }  # fmt: skip
