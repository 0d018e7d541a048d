"""What an attacker knows: `field_percepts`, and how shots, passes and ways are judged by it.

Everything comes from the parts ``self``, ``memory`` and ``memory_age`` of the observation and from what he feels of his own body, so it is
as good as the tier of knowledge that fills them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...envs.controller import Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ..body import Body
from ..percepts import Percepts, field_percepts
from ..skills.kick import SURE
from .constants import AttackerConstants
from .kernels import FORGOTTEN, Terms, judge

NEAR = 2.5
"""Metres from the ball within which passes and pushes are judged."""
KICK = 0.93
"""Share of the speed that a kick of a ball at rest can give which a shot surely gets."""
MEETING = 0.5
"""Share of the kickable ring at which a player who runs has the ball."""
MARGIN = 2.0
"""Metres from the lines that are kept."""
NAMES = (
    "me.time", "meet.x", "meet.y", "mate.time", "support.x", "support.y", "shot.y", "shot.room",
    "way.angle", "way.speed", "way.room", "way.worth", "pass.angle", "pass.speed", "pass.room", "pass.worth",
    "rival.has_ball", "line.x", "shot.speed",
)  # fmt: skip
"""Columns of what `judge` answers."""
OPPONENTS = 12
"""First row of the opponents in ``memory``."""


class Ground(NamedTuple):
    """Where is played."""

    low_x: float = MARGIN - HALF_LENGTH
    """Metres; the lines less what is kept from them."""
    high_x: float = HALF_LENGTH - MARGIN
    side_y: float = HALF_WIDTH - MARGIN
    offside: bool = True
    """Whether the rule is in force."""


PITCH = Ground()
"""A match's."""


def terms(body: Body, c: AttackerConstants, keeper: int = -1, ground: Ground = PITCH) -> Terms:
    """What the kernels judge by.

    Parameters
    ----------
    body : Body
    c : AttackerConstants
    keeper : int
        Row of the opponents' keeper among them; -1 if there is none.
    ground : Ground
    """
    server, kind = body.server, body.kind
    own = {name: getattr(c, name) for name in Terms._fields if name in c.to_dict()}
    return Terms(**{
        **own,
        "decay": body.ball_decay, "ball_speed": server.ball_speed_max, "reach": body.within(MEETING), "pace": body.pace(c.run),
        "inertia": kind.inertia_moment, "rival_pace": body.pace(c.rival_run), "contact": body.contact, "margin": kind.kickable_margin,
        "legs": body.within(SURE) + c.tolerance,
        "kick_speed": KICK * min(server.ball_speed_max, server.ball_accel_max, server.maxpower * kind.kick_power_rate),
        "goal_x": HALF_LENGTH, "goal_half": server.goal_width / 2, "low_x": ground.low_x, "side_x": ground.high_x,
        "side_y": ground.side_y, "keeper": keeper, "offside": int(ground.offside),
    })  # fmt: skip


class Motion:
    """How far the opponents went in a cycle, from where they were seen one after the other; his own copy for each of N worlds."""

    def __init__(self, opponents: int) -> None:
        self.opponents = opponents
        self.clock = np.zeros(0, np.int64)
        self._seen = self._moved = np.zeros((0, opponents, 2))
        self._since = np.zeros((0, opponents))

    def reset(self, count: int, worlds: np.ndarray | None = None) -> None:
        """Forget, in the worlds of a mask or indices."""
        if worlds is None or len(self._seen) != count:
            self._seen, self._moved = np.zeros((count, self.opponents, 2)), np.zeros((count, self.opponents, 2))
            self._since = np.full((count, self.opponents), FORGET)
            self.clock = np.zeros(count, np.int64)
        else:
            self.clock[worlds] = 0
            self._moved[worlds], self._since[worlds] = 0.0, FORGET

    def follow(self, place: np.ndarray, age: np.ndarray) -> np.ndarray:
        """(N, O, 2) metres / cycle, 0 for who was not seen of late.

        Parameters
        ----------
        place : (N, O, 2) array
            Where they are, m.
        age : (N, O) array
            Cycles since they were seen.
        """
        self._since += 1.0
        self.clock += 1
        news = age <= np.minimum(age.min(axis=1, keepdims=True, initial=RECENT), RECENT)
        step = (place - self._seen) / self._since[..., None]
        fast = np.hypot(step[..., 0], step[..., 1])
        trusted = news & (self._since <= RECENT) & (fast < FASTEST)
        self._moved = np.where(trusted[..., None], KEPT * self._moved + (1.0 - KEPT) * step, self._moved)
        self._moved[self._since > FORGET] = 0.0
        self._seen = np.where(news[..., None], place, self._seen)
        self._since = np.where(news, 0.0, self._since)
        return self._moved


RECENT, FORGET = 4.0, 10.0
"""Cycles between two sights from which a motion is told, and after which it is forgotten."""
FASTEST = 1.5
"""m / cycle beyond which it was somebody else."""
KEPT = 0.3
"""Share of the old motion that is kept."""


def attacker_percepts(
    observation: Observation, judged_by: Terms, motion: Motion, mates: int = 1, stale: float = 6.0, focus: float = 0.0
) -> Percepts:
    """What an attacker perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    judged_by : Terms
    motion : Motion
        Of the opponents; follows them.
    mates : int
        How many there are.
    stale : float
        Cycles without a sight of somebody after which he is looked at.

    Returns
    -------
    dict of (N,) float64
        `field_percepts` and `NAMES`: ``me.time``, ``meet.x``, ``meet.y`` (when and where he meets the ball), ``mate.time``
        (when the first of the others does), ``support.x``, ``support.y`` (where to wait), ``shot.y``, ``shot.speed``,
        ``shot.room`` (point of the goal, speed, and worth of the shot), ``way.*`` and ``pass.*`` (the best push and the best pass: radians
        in the frame of the pitch, m / cycle, room in metres, worth), ``rival.has_ball``, ``line.x`` (the
        offside line); and as the net takes them ``meet.distance``, ``meet.direction_deg``, ``way.distance``, ``way.direction_deg``,
        ``pass.distance``, ``pass.direction_deg``, ``mate.ball_gap`` (m), ``gaze.direction_deg``; ``goal.distance`` and
        ``goal.direction_deg`` are those of the point of the goal.
    """
    percepts = field_percepts(observation)
    me = np.asarray(observation["self"], np.float64)
    memory, age = np.asarray(observation["memory"], np.float64), np.asarray(observation["memory_age"], np.float64)
    rows, own = np.arange(len(me))[:, None], np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64)[:, None]
    numbers = np.arange(1, mates + 1)[None] + np.zeros_like(own)
    numbers = numbers + (numbers >= own)
    state = np.ascontiguousarray(me[:, [SelfFeature.X, SelfFeature.Y, SelfFeature.VX, SelfFeature.VY, SelfFeature.BODY]])
    others = slice(OPPONENTS, OPPONENTS + motion.opponents)
    places, ages = memory[rows, numbers, :2], age[rows, numbers]
    rivals, rival_age = memory[:, others, :2], np.ascontiguousarray(age[:, others])
    rivals = np.concatenate([rivals, motion.follow(rivals, rival_age)], axis=2)
    out = np.zeros((len(me), len(NAMES)))
    judge(np.ascontiguousarray(memory[:, 0]), state, places, ages, rivals, rival_age, NEAR, judged_by, out)
    percepts.update(zip(NAMES, out.T))
    x, y, facing = percepts["me.x"], percepts["me.y"], np.radians(percepts["me.facing_deg"])

    def towards(to_x: np.ndarray | float, to_y: np.ndarray | float) -> np.ndarray:
        return _degrees(np.arctan2(to_y - y, to_x - x) - facing)

    percepts["meet.distance"] = np.hypot(percepts["meet.x"] - x, percepts["meet.y"] - y)
    percepts["meet.direction_deg"] = towards(percepts["meet.x"], percepts["meet.y"])
    # a push and a pass are aimed at a point of their line, from the ball
    for what in ("way", "pass"):
        angle = percepts[f"{what}.angle"]
        to_x, to_y = percepts["ball.x"] + AIM * np.cos(angle), percepts["ball.y"] + AIM * np.sin(angle)
        percepts[f"{what}.distance"], percepts[f"{what}.direction_deg"] = np.hypot(to_x - x, to_y - y), towards(to_x, to_y)
    percepts["goal.distance"] = np.hypot(HALF_LENGTH - x, percepts["shot.y"] - y)
    percepts["goal.direction_deg"] = towards(HALF_LENGTH, percepts["shot.y"])
    percepts["mate.ball_gap"] = np.hypot(percepts["mate.x"] - percepts["ball.x"], percepts["mate.y"] - percepts["ball.y"])
    percepts["gaze.direction_deg"] = _gaze(
        percepts, places, ages, rivals[..., :2], rival_age, stale, towards(percepts["ball.x"], percepts["ball.y"]), motion.clock
    )
    narrow = (percepts["gaze.at_ball"] > 0) & (percepts["ball.reckoned_distance"] < focus)
    percepts["gaze.narrow"] = narrow.astype(np.float64)
    return percepts


ASIDE, SIDE = 80.0, 6
"""Degrees from the body at which he looks for who was never seen, and cycles after which he does on the other side."""
AIM = 10.0
"""Metres from the ball to the point at which a push or pass is aimed."""


def _degrees(angle: np.ndarray) -> np.ndarray:
    return np.asarray((np.degrees(angle) + 180.0) % 360.0 - 180.0)


def _gaze(
    percepts: Percepts, mates: np.ndarray, mate_age: np.ndarray, rivals: np.ndarray, rival_age: np.ndarray, stale: float,
    ball: np.ndarray, clock: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Degrees from the body to look at: the ball, or who was not seen for the longest while the ball is known well enough."""
    who, ages = np.concatenate([mates, rivals], axis=1), np.concatenate([mate_age, rival_age], axis=1)
    away = np.hypot(who[..., 0] - percepts["me.x"][:, None], who[..., 1] - percepts["me.y"][:, None])
    ages = np.where((ages < 200.0) & (away < 35.0), ages, -1.0)
    if not who.shape[1]:
        percepts["gaze.at_ball"] = (percepts["ball.age"] < 15.0).astype(np.float64)
        return np.where(percepts["ball.age"] < 15.0, ball, 0.0)
    oldest, rows = ages.argmax(axis=1), np.arange(len(ages))
    dx, dy = who[rows, oldest, 0] - percepts["me.x"], who[rows, oldest, 1] - percepts["me.y"]
    other = _degrees(np.arctan2(dy, dx) - np.radians(percepts["me.facing_deg"]))
    sees = percepts["ball.age"] <= 1.0
    free = (ages[rows, oldest] >= stale) & sees & (np.abs(other) < 150.0)
    # the team-mate who was never seen, or not for long, can be anywhere: to one side and the other in turn
    missed = sees & ~free & (mate_age >= FORGOTTEN).any(axis=1)
    percepts["gaze.at_ball"] = (~free & ~missed & (percepts["ball.age"] < 15.0)).astype(np.float64)
    aside = np.where(clock % (2 * SIDE) < SIDE, ASIDE, -ASIDE)
    return np.where(missed, aside, np.where(free, other, np.where(percepts["ball.age"] < 15.0, ball, 0.0)))
