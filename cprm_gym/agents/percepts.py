"""Named quantities from observation arrays: what nets, models, state machines and hand-written code all read.

Angles are degrees here, relative to the body, because the server's commands take degrees relative to the body. What is computed is in
`kernels.percepts`.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, MutableMapping

import numpy as np

from ..architecture.cprm.percepts import PerceptNames, PerceptTable
from ..architecture.petri.execution.state import ObjectTable
from ..simulator.pitch import HALF_LENGTH
from .body import DEFAULT, Body
from .kernels import percepts as kernels

Percepts = MutableMapping[str, np.ndarray]
"""Name -> (N,) float array; NaN where there is no reading."""
_BODY, _BALL, _FIELD = PerceptNames(kernels.BODY), PerceptNames(kernels.BALL), PerceptNames(kernels.FIELD)


def parts(observation: Mapping[str, np.ndarray], *names: str) -> list[np.ndarray]:
    """Parts of an observation as kernels take them: float64, in order."""
    return [np.ascontiguousarray(observation[name], np.float64) for name in names]


def table(columns: PerceptNames, count: int) -> PerceptTable:
    """Room for the percepts of some worlds."""
    return PerceptTable(columns, np.empty((count, len(columns.names))))


def body_percepts(observation: Mapping[str, np.ndarray]) -> PerceptTable:
    """What the player feels of himself.

    Returns
    -------
    dict of (N,) float64
        ``body.stamina``, ``body.effort``, ``body.speed`` (m / cycle), ``body.speed_direction_deg`` and ``body.neck_deg`` (degrees),
        ``body.fresh`` (1 if he saw something this cycle), ``body.locked`` (cycles until the body obeys again), ``body.view_width``
        (1 narrow, 2 normal, 3 wide).
    """
    (body,) = parts(observation, "body")
    out = table(_BODY, len(body))
    kernels.bodies(body, out.table)
    return out


def ball_percepts(observation: Mapping[str, np.ndarray]) -> PerceptTable:
    """What the player sees of the ball, with `body_percepts`.

    Returns
    -------
    dict of (N,) float64
        ``ball.seen`` (1 if a ball, or something felt to be one, is in this percept), ``ball.distance`` (m), ``ball.direction_deg`` (degrees
        from the body); ``ball.moving`` (1 if its changes were told too), ``ball.distance_change`` (m / cycle),
        ``ball.direction_change_deg`` (degrees / cycle): 0 where not told.
    """
    body, ball, level = parts(observation, "body", "ball", "level")
    out = table(_BALL, len(body))
    kernels.balls(body, ball, level, out.table)
    return out


GOAL_X = HALF_LENGTH
"""x of the goal that is attacked, in the own team's frame."""
NEVER = 1000.0
"""Age of what was never seen, cycles."""
OFF_PITCH = 60.0
"""Metres that stand for a distance that is not known."""
_OF_THE_FIELD = ("body", "ball", "level", "self", "memory", "memory_age")


def field_percepts(observation: Mapping[str, np.ndarray], columns: PerceptNames = _FIELD) -> PerceptTable:
    """What the player knows of the pitch, with `ball_percepts`; needs the observation's parts ``self``, ``memory``, ``memory_age``.

    Everything is *reckoned*: seen by himself, placed by landmarks, and carried on while the eye is closed. Positions are in the own
    team's frame (x towards the opponent's goal), directions in degrees from the own body.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
    columns : PerceptNames, optional
        These and what others add to them.

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
    known = parts(observation, *_OF_THE_FIELD)
    out = table(columns, len(known[0]))
    kernels.fields(*known, GOAL_X, NEVER, OFF_PITCH, out.table)
    return out


@functools.lru_cache(maxsize=32)
def _motion_columns(mates: int) -> PerceptNames:
    return PerceptNames((*kernels.MOTION, *(f"m{k + 1}.{part}" for k in range(mates) for part in kernels.MATE)))


def motion_percepts(observation: Mapping[str, np.ndarray], percepts: Percepts, own: Body = DEFAULT) -> PerceptTable:
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
    out = table(_motion_columns(0), len(observation["body"]))
    for name, values in percepts.items():
        out[name] = values
    _move(observation, own, out)
    return out


def passer_percepts(observation: Mapping[str, np.ndarray], own: Body = DEFAULT, mates: int = 0) -> PerceptTable:
    """`field_percepts`, `motion_percepts` and `mates_percepts`."""
    out = field_percepts(observation, _motion_columns(mates))
    _move(observation, own, out)
    _see_mates(observation, mates, out.table[:, len(kernels.MOTION) :])
    return out


def _move(observation: Mapping[str, np.ndarray], own: Body, out: PerceptTable) -> None:
    kernels.motions(*parts(observation, "body", "ball", "self"), NEVER, own.kind.player_decay, out.table)


def _see_mates(observation: Mapping[str, np.ndarray], mates: int, out: np.ndarray) -> None:
    kernels.mates_seen(*parts(observation, "body", "self", "level", "memory", "memory_age", "players"), mates, out)


@functools.lru_cache(maxsize=32)
def _mate_columns(mates: int) -> PerceptNames:
    return PerceptNames(_motion_columns(mates).names[len(kernels.MOTION) :])


def mates_percepts(observation: Mapping[str, np.ndarray], mates: int) -> PerceptTable:
    """What was just seen of each team-mate, in the order of their numbers without the own.

    Returns
    -------
    dict of (N,) float64
        ``m1.seen``, ``m1.x``, ``m1.y`` (m, own team's frame), ``m1.faced`` (the way he faces was told: only of one who is seen with his
        number), ``m1.facing``: 0 his body points at the player, 1 aside of him, 2 away.
    """
    out = table(_mate_columns(mates), len(observation["body"]))
    _see_mates(observation, mates, out.table)
    return out


def mate_attributes(observation: Mapping[str, np.ndarray], mates: int) -> ObjectTable:
    """Of the same team-mates, what object places choose by.

    Returns
    -------
    dict of (N, mates) float64
        ``distance`` (m), ``age`` (cycles since he was seen), ``ball_gap`` (m from the ball; 99 when he or the ball was not seen of late).
    """
    known = parts(observation, "body", "self", "memory", "memory_age")
    out = np.empty((len(kernels.ATTRIBUTES), len(known[0]), mates))
    kernels.judgements(*known, mates, out)
    return ObjectTable(kernels.ATTRIBUTES, out)
