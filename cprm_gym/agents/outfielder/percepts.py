"""What an outfield player perceives, beyond `field_percepts`: whose ball it is, where to shoot, to whom to pass, which way is free.

All from his own observation: positions are those that he remembers. Formulas as the scripted players use them, over whole arrays; N
copies, 11 team-mates, 11 opponents. Metres, cycles, degrees from the own body, in the frame of his team.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...envs.controller import Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.players.scripted import FORMATION
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import PlayMode
from ..body import DEFAULT, Body
from ..percepts import GOAL_X, NEVER, Percepts, field_percepts
from .model import PERIOD

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
    """How clear the ways from the ball to some points are: the least of (an opponent's distance to it - what he runs meanwhile).

    Parameters
    ----------
    ball : (N, 2) array
    x, y : (N, K) arrays
        The points, m.
    speed : (N, K) array or float
        Of the ball at first, m / cycle.
    opponents : (N, 11, 2) array
    known : (N, 11) bool array
        Who counts.

    Returns
    -------
    (N, K) array
        m, 20 where nobody is near.
    """
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
    """What an outfield player perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    own : Body

    Returns
    -------
    dict of (N,) float64
        `field_percepts`, where ``goal.distance`` and ``goal.direction_deg`` are of the point of the goal with the clearest way to it, and
        ``goal.room`` says how clear (m; -20 while the ball is not at his feet); ``way.direction_deg`` (degrees, the freest way ahead);
        ``me.time``, ``meet.x``, ``meet.y`` (when and where he meets the ball); ``place.x``, ``place.y`` (his in the formation); ``line.x``
        (a team-mate beyond it would be offside); ``ball.vx``, ``ball.vy``; ``ball.placed`` (he saw it in the last `PERIOD` cycles, and knew
        where he was); ``game.ours``, ``game.theirs`` (set plays), ``game.kick_off``; for each player of both teams ``t1.seen`` (likewise),
        ``t1.x``, ``t1.y``, ``o1.seen``, ...
    """
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
    """By what he chooses players: attributes of the candidates of his object places.

    Returns
    -------
    dict of str to dict of str to (N, 11) float64
        ``Teammate``: ``x``, ``y``, ``age`` (cycles since he was seen), ``time`` (cycles until he meets the ball, as he was last seen),
        ``distance`` (m from the ball), ``ahead`` (m that a pass to him gains), ``beyond`` (m beyond the offside line), and, 0 while the
        ball is not at the own feet, ``room`` (m, how clear the way to him is) and ``free`` (m to the opponent nearest to him); himself
        and those never seen are not ``present``. ``Opponent``: ``x``, ``y``, ``age``, ``danger`` (the nearer to the ball the more, 0 for
        those not seen for two seconds), ``ball_gap`` (m; 99 for those not seen for half a second).
    """
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
