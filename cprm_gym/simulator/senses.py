"""The senses as arrays: what the server would tell every player of every world, with masks (specification/simulator.md 6).

Everything carries exactly the information of the server's messages: distances, directions and changes are quantised as they are in the
text, what is not told is zero and its level says so, and nobody is recognised by his place in an array (see `See`). Angles are
radians, but of whole degrees where the message has them. `cprm_gym.simulator.protocol.messages` makes the text from the same draws.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .kernels import audio, body, landmark_sight, senses
from .landmarks import LANDMARKS
from .state import PLAYERS, SAY_SIZE

Array = npt.NDArray[Any]
HEAR_SLOTS = 4
"""Messages per listener that `new_hear` has room for: with default parameters at most two are heard in full per cycle."""


class BallLevel(IntEnum):
    """How much is told of the ball (and, except ``FELT``'s meaning for names, of a landmark)."""

    UNSEEN = 0
    FELT = 1
    """Within 3 m, outside the view cone: distance and direction, no name."""
    SEEN = 2
    """Distance and direction."""
    MOVING = 3
    """Changes of distance and direction too."""


class PlayerLevel(IntEnum):
    """How much is told of another player."""

    UNSEEN = 0
    UNKNOWN = 1
    """Felt within 3 m, or seen (flag `PlayerFlag.IN_VIEW`) too far to know the team: distance and direction."""
    TEAM = 2
    """Team, distance, direction, arm, tackle and kick marks."""
    NUMBER = 3
    """Uniform number, changes, body and head direction too."""


class PlayerFlag(IntFlag):
    """Marks of a seen player."""

    TACKLING = 1
    KICKING = 2
    POINTING = 4
    IN_VIEW = 8


class See(NamedTuple):
    """What the see messages of a cycle tell of ball and players; rows of players who get no message are zero.

    A player seen with his number stands at his index 0..21. One of whom only the team is known stands in a free place of that team, an
    unknown one in a free place of the opponents, else of the own team; both nearest first. The own place stays empty.
    """

    fresh: Array
    """(W, 22) bool: the player gets a message in this cycle."""
    ball: Array
    """(W, 22, 4) distance (m), direction (rad, to the face), distance change (m / cycle), direction change (rad / cycle)."""
    ball_level: Array
    """(W, 22) `BallLevel`."""
    players: Array
    """(W, 22, 22, 7) the same four, then body, head and arm direction (rad, to the face)."""
    players_level: Array
    """(W, 22, 22) `PlayerLevel`."""
    players_flags: Array
    """(W, 22, 22) `PlayerFlag`."""


class Landmarks(NamedTuple):
    """What the see messages of a cycle tell of the pitch.

    A felt landmark has no name: felt flags stand in the first places of unseen flags, a felt goal in that of the right goal.
    """

    landmarks: Array
    """(W, 22, 55, 4) columns as `See.ball`, order as `cprm_gym.simulator.landmarks.LANDMARK_NAMES`."""
    level: Array
    """(W, 22, 55) `BallLevel`."""
    lines: Array
    """(W, 22, 2, 2) distance (m) and direction (rad) of the line in front: one inside the pitch, up to two outside."""
    line: Array
    """(W, 22, 2) `cprm_gym.simulator.landmarks.Line`."""


class Hear(NamedTuple):
    """What the players hear of each other after a step, in the order heard; own messages are left out."""

    sender: Array
    """(W, 22, S) 0 nothing, 1 a team-mate, 2 an opponent."""
    level: Array
    """(W, 22, S) 0 nothing, 1 only that somebody spoke, 2 the message."""
    unum: Array
    """(W, 22, S) uniform number of a team-mate; 0 for opponents, whose number is not told."""
    direction: Array
    """(W, 22, S) direction (rad) relative to the body, level 2 only."""
    length: Array
    """(W, 22, S) bytes of the message."""
    text: Array
    """(W, 22, S, 32) the message, zeros after its end."""
    heard: Array
    """(W, 22) number of messages heard, including those for which there was no slot."""


class BodyColumn(IntEnum):
    """Columns of the sense_body array (W, 22, 34): m, m / cycle, cycles, rad."""

    STAMINA = body.STAMINA
    EFFORT = body.EFFORT
    CAPACITY = body.CAPACITY
    SPEED = body.SPEED
    SPEED_DIRECTION = body.SPEED_DIRECTION
    """Relative to the face; truncated to whole degrees."""
    HEAD_ANGLE = body.HEAD_ANGLE
    """Relative to the body; truncated to whole degrees."""
    VIEW_WIDTH = body.VIEW_WIDTH
    VIEW_QUALITY = body.VIEW_QUALITY
    COUNT_KICK = body.COUNTS
    COUNT_DASH = body.COUNTS + 1
    COUNT_TURN = body.COUNTS + 2
    COUNT_CATCH = body.COUNTS + 3
    COUNT_MOVE = body.COUNTS + 4
    COUNT_TURN_NECK = body.COUNTS + 5
    COUNT_CHANGE_VIEW = body.COUNTS + 6
    COUNT_CHANGE_FOCUS = body.COUNTS + 7
    COUNT_SAY = body.COUNTS + 8
    COUNT_TACKLE = body.COUNTS + 9
    COUNT_FOUL = body.COUNTS + 10
    COUNT_ARM = body.COUNTS + 11
    COUNT_ATTENTION = body.COUNTS + 12
    ARM_MOVABLE = body.ARM_MOVABLE
    ARM_EXPIRES = body.ARM_EXPIRES
    ARM_DISTANCE = body.ARM_DISTANCE
    ARM_DIRECTION = body.ARM_DIRECTION
    ATTENTION = body.ATTENTION
    """Object number 1..22 of the attention target, 0 = none."""
    TACKLE_EXPIRES = body.TACKLE_EXPIRES
    FOUL_CHARGED = body.FOUL_CHARGED
    HIT_BALL = body.HIT_BALL
    HIT_PLAYER = body.HIT_PLAYER
    HIT_POST = body.HIT_POST
    CARD = body.CARD
    """0 none, 1 yellow, 2 red."""
    FOCUS_DISTANCE = body.FOCUS_DISTANCE
    FOCUS_DIRECTION = body.FOCUS_DIRECTION


def new_see(worlds: int) -> See:
    """Buffers for `see` of that many worlds."""
    return See(
        np.zeros((worlds, PLAYERS), np.bool_),
        np.zeros((worlds, PLAYERS, 4)),
        np.zeros((worlds, PLAYERS), np.int8),
        np.zeros((worlds, PLAYERS, PLAYERS, 7)),
        np.zeros((worlds, PLAYERS, PLAYERS), np.int8),
        np.zeros((worlds, PLAYERS, PLAYERS), np.uint8),
    )


def new_landmarks(worlds: int) -> Landmarks:
    """Buffers for `see_landmarks` of that many worlds."""
    return Landmarks(
        np.zeros((worlds, PLAYERS, LANDMARKS, 4)),
        np.zeros((worlds, PLAYERS, LANDMARKS), np.int8),
        np.zeros((worlds, PLAYERS, 2, 2)),
        np.zeros((worlds, PLAYERS, 2), np.int8),
    )


def new_hear(worlds: int, slots: int = HEAR_SLOTS) -> Hear:
    """Buffers for `hear` of that many worlds, with room for `slots` messages per listener."""
    shape = (worlds, PLAYERS, slots)
    return Hear(
        np.zeros(shape, np.int8),
        np.zeros(shape, np.int8),
        np.zeros(shape, np.int8),
        np.zeros(shape),
        np.zeros(shape, np.int8),
        np.zeros((*shape, SAY_SIZE), np.uint8),
        np.zeros((worlds, PLAYERS), np.int8),
    )


def new_body(worlds: int) -> Array:
    """A buffer for `sense_body` of that many worlds, columns `BodyColumn`."""
    return np.zeros((worlds, PLAYERS, len(BodyColumn)))


def see(worlds: Array, parameters: Array, out: See | None = None) -> See:
    """Ball and players as every player sees them.

    Parameters
    ----------
    worlds : (W,) WORLD
    parameters : (1,) PARAMETERS
    out : See, optional
        Buffers to fill; allocated when not given.
    """
    out = new_see(len(worlds)) if out is None else out
    senses.see_worlds(worlds, parameters, np.arange(len(worlds)), *out, 0, len(worlds))
    return out


def see_landmarks(worlds: Array, parameters: Array, out: Landmarks | None = None) -> Landmarks:
    """Landmarks and lines as every player sees them; arguments as `see`."""
    out = new_landmarks(len(worlds)) if out is None else out
    landmark_sight.landmarks_of_worlds(worlds, parameters, np.arange(len(worlds)), *out, 0, len(worlds))
    return out


def sense_body(worlds: Array, parameters: Array, out: Array | None = None) -> Array:
    """What every player is told of himself, (W, 22, 34) with columns `BodyColumn`; arguments as `see`."""
    out = new_body(len(worlds)) if out is None else out
    body.sense_bodies(worlds, parameters, np.arange(len(worlds)), out, 0, len(worlds))
    return out


def hear(worlds: Array, parameters: Array, out: Hear | None = None) -> Hear:
    """What every player heard after the last step; arguments as `see`."""
    out = new_hear(len(worlds)) if out is None else out
    audio.hear_worlds(worlds, parameters, np.arange(len(worlds)), *out, 0, len(worlds))
    return out
