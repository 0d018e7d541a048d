"""What an agent observes: names, units and bounds.

The observation is a flat `Dict` of float32 arrays (schema version `SCHEMA_VERSION`). It holds what the server would tell the
player, never the truth: what is not seen is zero *and* has level 0.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any

import numpy as np
from gymnasium import spaces

from ..simulator.state import PLAYERS
from .players.kernels.memory import NEVER

SCHEMA_VERSION = 2
"""Raised when the layout, a unit or the meaning of an observation changes."""


class BodyFeature(IntEnum):
    """Columns of ``observation["body"]``: what the player feels of himself and hears from the referee."""

    STAMINA = 0
    """0 to ``stamina_max``."""
    EFFORT = 1
    """0 to 1."""
    CAPACITY = 2
    """Stamina that can still be recovered; -1 to ``stamina_capacity``."""
    SPEED = 3
    """Own speed, m / cycle, quantised by 0.01."""
    SPEED_DIRECTION = 4
    """Direction of the own velocity relative to the face, radians."""
    NECK = 5
    """Neck relative to the body, radians."""
    VIEW_WIDTH = 6
    """1 narrow, 2 normal, 3 wide."""
    TACKLE_EXPIRES = 7
    """Cycles until the body moves again after a tackle."""
    FOUL_CHARGED = 8
    """Cycles until the body moves again after being fouled."""
    COLLIDED_BALL = 9
    """1 if the player touched the ball since the last sense."""
    COLLIDED_PLAYER = 10
    """1 if he ran into a player."""
    COLLIDED_POST = 11
    """1 if he ran into a goal post."""
    FRESH = 12
    """1 if a see message came with this observation, 0 if this cycle is blind."""
    SIDE = 13
    """+1 left team, -1 right team."""
    UNUM = 14
    """Uniform number, 1 to 11."""
    GOALIE = 15
    """1 if the player is the goalie."""
    PLAY_MODE = 16
    """Play mode id (`PlayMode`)."""
    TIME = 17
    """Game cycle."""
    SCORE_OWN = 18
    """Goals of the own team."""
    SCORE_OPPONENT = 19
    """Goals of the opponent."""
    DASH_COUNT = 20
    """Dashes the server has executed."""
    KICK_COUNT = 21
    """Kicks that had effect."""
    TURN_COUNT = 22
    """Turns the server has executed."""
    CARD = 23
    """0 none, 1 yellow, 2 red."""


class ObjectFeature(IntEnum):
    """Columns of ``observation["ball"]`` (the first four) and of the rows of ``observation["players"]``."""

    DISTANCE = 0
    """Metres, as the eye reports it."""
    DIRECTION = 1
    """Relative to the face (body + neck), radians."""
    DISTANCE_CHANGE = 2
    """m / cycle; 0 below the level that carries velocities."""
    DIRECTION_CHANGE = 3
    """radians / cycle; likewise."""
    BODY = 4
    """Players: body relative to the observer's face, radians."""
    HEAD = 5
    """Players: face relative to the observer's face, radians."""
    POINTING = 6
    """Players: where the arm points, radians; 0 when it does not."""


BALL_FEATURES = 4
PLAYER_FEATURES = 7
_PI = math.pi
_BODY_LOW = np.array([0, 0, -1, 0, -_PI, -_PI, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], np.float32)
_BODY_HIGH = np.array([1e5, 1, 1e6, 10, _PI, _PI, 3, 100, 100, 1, 1, 1, 1, 1, 11, 1, 51, 1e6, 1e4, 1e4, 1e6, 1e6, 1e6, 2], np.float32)
_OBJECT_LOW = np.array([0, -_PI, -20, -2 * _PI, -_PI, -_PI, -_PI], np.float32)
_OBJECT_HIGH = np.array([200, _PI, 20, 2 * _PI, _PI, _PI, _PI], np.float32)
MAX_AGE = float(NEVER)
"""Largest value of ``observation["age"]`` and ``observation["memory_age"]``, cycles: so old or older, or never seen."""


class SelfFeature(IntEnum):
    """Columns of ``observation["self"]`` (with ``include=("memory",)``): where the player believes himself to be.

    The frame is that of his team: x towards the opponent's goal. Computed from his own percepts alone.
    """

    X = 0
    """m"""
    Y = 1
    """m"""
    VX = 2
    """m / cycle"""
    VY = 3
    """m / cycle"""
    BODY = 4
    """radians"""
    FACE = 5
    """Body and neck, radians."""
    LOCATED = 6
    """1 if he has known his place since the episode began."""
    FREE = 7
    """1 if the body obeys (no tackle or foul lock)."""


MEMORY_FEATURES = 4
"""Columns of ``observation["memory"]``: x, y, and for the ball vx, vy."""
HEARD = 4
"""Messages kept of one cycle."""
HEAR_FEATURES = 15
"""Columns of ``observation["hear"]``: sender (0 none, 1 own team, 2 opponents), level (1 only that somebody spoke, 2 the message), unum
of a team-mate, direction from the body (radians), length, and ten bytes of the message."""
LINE_FEATURES = 3
"""Columns of ``observation["lines"]``: distance (m), direction from the face (radians), which (`Line`)."""
INCLUDES = ("memory", "landmarks", "lines", "hear", "normalised", "action_mask")
"""Parts of an observation that are computed only when asked for."""


def observation_space(
    task_features: tuple[tuple[str, float, float], ...] = (),
    include: tuple[str, ...] = (),
    macros: int = 0,
    vector: spaces.Box | None = None,
) -> spaces.Dict:
    """Space of one agent's observation.

    Parameters
    ----------
    task_features : tuple of (name, low, high)
        What the task adds under the key ``task``; the key is absent when there is nothing.
    include : tuple of str
        Further parts, of `INCLUDES`.
    macros : int
        Entries of ``action_mask``.
    vector : Box, optional
        Space of the part ``normalised``, which is there if it is given and included.

    Returns
    -------
    gymnasium.spaces.Dict
        ``body`` (24,), ``ball`` (4,), ``players`` (22, 7), ``level`` (23,): 0 unseen, 1 felt nearby or anonymous, 2 ball seen without
        velocity / player's team known, 3 all known (entry 0 the ball); ``age`` (23,): cycles since the entry was last seen; ``task``.
        With ``memory``: ``self`` (8,) of `SelfFeature`, ``memory`` (23, 4): x, y of ball, own team and opponents as last seen, carried on
        (and vx, vy of the ball), ``memory_age`` (23,), all in the own team's frame. With ``landmarks``: ``landmarks`` (55, 4) as ``ball``,
        ``landmark_level`` (55,). With ``lines``: ``lines`` (2, 3) of `LINE_FEATURES`, the line ahead, and outside the pitch a second one.
        With ``hear``: ``hear`` (4, 15) of `HEAR_FEATURES`, the messages heard in this cycle. With ``normalised``: the vector of that
        preset (`cprm_gym.envs.vectors.normalised`). With ``action_mask``: ``action_mask`` (macros,) int8, what can be done now.
    """
    parts: dict[str, spaces.Space[Any]] = {
        "body": spaces.Box(_BODY_LOW, _BODY_HIGH, dtype=np.float32),
        "ball": spaces.Box(_OBJECT_LOW[:BALL_FEATURES], _OBJECT_HIGH[:BALL_FEATURES], dtype=np.float32),
        "players": spaces.Box(np.tile(_OBJECT_LOW, (PLAYERS, 1)), np.tile(_OBJECT_HIGH, (PLAYERS, 1)), dtype=np.float32),
        "level": spaces.Box(0.0, 3.0, (PLAYERS + 1,), np.float32),
        "age": spaces.Box(0.0, MAX_AGE, (PLAYERS + 1,), np.float32),
    }
    if "memory" in include:
        parts["self"] = spaces.Box(-200.0, 200.0, (len(SelfFeature),), np.float32)
        parts["memory"] = spaces.Box(-500.0, 500.0, (PLAYERS + 1, MEMORY_FEATURES), np.float32)
        parts["memory_age"] = spaces.Box(0.0, MAX_AGE, (PLAYERS + 1,), np.float32)
    if "landmarks" in include:
        low, high = np.tile(_OBJECT_LOW[:BALL_FEATURES], (55, 1)), np.tile(_OBJECT_HIGH[:BALL_FEATURES], (55, 1))
        parts["landmarks"] = spaces.Box(low, high, dtype=np.float32)
        parts["landmark_level"] = spaces.Box(0.0, 3.0, (55,), np.float32)
    if "lines" in include:
        low, high = np.tile(np.array([0, -_PI, 0], np.float32), (2, 1)), np.tile(np.array([500, _PI, 4], np.float32), (2, 1))
        parts["lines"] = spaces.Box(low, high, dtype=np.float32)
    if "hear" in include:
        low = np.tile(np.array([0, 0, 0, -_PI, 0] + [0] * 10, np.float32), (HEARD, 1))
        high = np.tile(np.array([2, 2, 11, _PI, 127] + [255] * 10, np.float32), (HEARD, 1))
        parts["hear"] = spaces.Box(low, high, dtype=np.float32)
    if "normalised" in include and vector is not None:
        parts["normalised"] = vector
    if task_features:
        low = np.array([f[1] for f in task_features], np.float32)
        high = np.array([f[2] for f in task_features], np.float32)
        parts["task"] = spaces.Box(low, high, dtype=np.float32)
    if "action_mask" in include:
        parts["action_mask"] = spaces.Box(0, 1, (macros,), np.int8)
    return spaces.Dict(parts)


def with_mask(vector: spaces.Box, plain: spaces.Dict) -> spaces.Space[Any]:
    """Space of a vector; of a Dict of ``observations`` and ``action_mask`` where the mask is part of the observation."""
    if "action_mask" not in plain.spaces:
        return vector
    return spaces.Dict({"observations": vector, "action_mask": plain["action_mask"]})
