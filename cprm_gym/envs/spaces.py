"""What an agent observes and what it may do: names, units, bounds and the views of both.

The observation is a flat `Dict` of float32 arrays (schema version `SCHEMA_VERSION`). It holds what the server would tell the
player, never the truth: what is not seen is zero *and* has level 0. The canonical action is one command per player and cycle
(`hybrid`); every other action space is a pure function to it (`ActionView`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from gymnasium import spaces

from ..errors import CommandError, unknown_name
from ..simulator.state import COMMAND, PLAYERS, CommandKind
from . import kernels

SCHEMA_VERSION = 1
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
MAX_AGE = 10_000.0
"""Largest value of ``observation["age"]``; also "never seen"."""


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
INCLUDES = ("memory", "landmarks", "hear")
"""Parts of an observation that are computed only when asked for."""


def observation_space(task_features: tuple[tuple[str, float, float], ...] = (), include: tuple[str, ...] = ()) -> spaces.Dict:
    """Space of one agent's observation.

    Parameters
    ----------
    task_features : tuple of (name, low, high)
        What the task adds under the key ``task``; the key is absent when there is nothing.
    include : tuple of str
        Further parts, of `INCLUDES`.

    Returns
    -------
    gymnasium.spaces.Dict
        ``body`` (24,), ``ball`` (4,), ``players`` (22, 7), ``level`` (23,): 0 unseen, 1 felt nearby or anonymous, 2 ball seen without
        velocity / player's team known, 3 all known (entry 0 the ball); ``age`` (23,): cycles since the entry was last seen; ``task``.
        With ``memory``: ``self`` (8,) of `SelfFeature`, ``memory`` (23, 4): x, y of ball, own team and opponents as last seen, carried on
        (and vx, vy of the ball), ``memory_age`` (23,), all in the own team's frame. With ``landmarks``: ``landmarks`` (55, 4) as ``ball``,
        ``landmark_level`` (55,). With ``hear``: ``hear`` (4, 15) of `HEAR_FEATURES`, the messages heard in this cycle.
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
        parts["memory_age"] = spaces.Box(0.0, 1000.0, (PLAYERS + 1,), np.float32)
    if "landmarks" in include:
        low, high = np.tile(_OBJECT_LOW[:BALL_FEATURES], (55, 1)), np.tile(_OBJECT_HIGH[:BALL_FEATURES], (55, 1))
        parts["landmarks"] = spaces.Box(low, high, dtype=np.float32)
        parts["landmark_level"] = spaces.Box(0.0, 3.0, (55,), np.float32)
    if "hear" in include:
        low = np.tile(np.array([0, 0, 0, -_PI, 0] + [0] * 10, np.float32), (HEARD, 1))
        high = np.tile(np.array([2, 2, 11, _PI, 127] + [255] * 10, np.float32), (HEARD, 1))
        parts["hear"] = spaces.Box(low, high, dtype=np.float32)
    if task_features:
        low = np.array([f[1] for f in task_features], np.float32)
        high = np.array([f[2] for f in task_features], np.float32)
        parts["task"] = spaces.Box(low, high, dtype=np.float32)
    return spaces.Dict(parts)


def hybrid_space() -> spaces.Dict:
    """The canonical action of one agent.

    ``type`` Discrete(8): a `CommandKind`; ``params`` (4,): its arguments a, b, c, d as shares of `PARAMETER_SCALES` (`scaled` makes
    them from the server's units); ``turn_neck`` (1,): share of 180 degrees, 0 = none; ``view`` Discrete(4): `ViewWidth`, 0 keeps
    the width.
    """
    return spaces.Dict(
        {
            "type": spaces.Discrete(len(CommandKind)),
            "params": spaces.Box(-1.0, 1.0, (4,), np.float32),
            "turn_neck": spaces.Box(-1.0, 1.0, (1,), np.float32),
            "view": spaces.Discrete(4),
        }
    )


SAY_CHARACTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 ().+*/?<>_-"
"""Characters that a player may say; in a message 0 ends it and k is the k-th of these."""
SAY_LENGTH = 10
ATTENTION_OFF = 23
POINT_REACH = 60.0
"""Metres that 1 means for the distance of ``point``."""


def full_space() -> spaces.Dict:
    """The canonical action with all free side commands.

    The parts of `hybrid_space`, and ``say`` MultiDiscrete (10,) of `SAY_CHARACTERS`; ``attention`` Discrete(24): 0 unchanged, 1 to 11 own
    team, 12 to 22 opponents, 23 off; ``point`` (3,): points if the first is > 0, distance as a share of `POINT_REACH` (from its absolute
    value), direction as a share of 180 degrees.
    """
    return spaces.Dict(
        {
            **hybrid_space().spaces,
            "say": spaces.MultiDiscrete([len(SAY_CHARACTERS) + 1] * SAY_LENGTH),
            "attention": spaces.Discrete(ATTENTION_OFF + 1),
            "point": spaces.Box(-1.0, 1.0, (3,), np.float32),
        }
    )


PARAMETER_SCALES = np.array(
    [
        [1.0, 1.0, 1.0, 1.0],  # none
        [100.0, 180.0, 1.0, 1.0],  # dash: power, direction
        [180.0, 1.0, 1.0, 1.0],  # turn: moment
        [100.0, 180.0, 1.0, 1.0],  # kick: power, direction
        [180.0, 1.0, 1.0, 1.0],  # tackle: direction, foul
        [180.0, 1.0, 1.0, 1.0],  # catch: direction
        [60.0, 40.0, 1.0, 1.0],  # move: x, y
        [100.0, 180.0, 100.0, 180.0],  # dash of the legs: power, direction, power, direction
    ]
)
"""What 1 means for each parameter of each `CommandKind`, in the server's units (power, degrees, metres)."""
NECK_SCALE = 180.0
"""Degrees that 1 means for ``turn_neck``."""


def scaled(kind: np.ndarray | int, *parameters: np.ndarray | float) -> np.ndarray:
    """``params`` of a hybrid action from arguments in the server's units, clipped to what the space allows.

    Parameters
    ----------
    kind : (N,) int array or int
        `CommandKind` of each action.
    *parameters : (N,) arrays or numbers
        At most four; the rest is 0.

    Returns
    -------
    (N, 4) float array, or (4,) for numbers
    """
    scale = PARAMETER_SCALES[kind]
    values = np.zeros(scale.shape)
    for i, parameter in enumerate(parameters):
        values[..., i] = parameter
    return np.clip(values / scale, -1.0, 1.0)


@dataclass(frozen=True)
class ActionView:
    """A named action space and the pure function from its actions to commands.

    Attributes
    ----------
    name : str
        ``hybrid``, ``full``, ``discrete`` or ``box``.
    space : gymnasium.spaces.Space
        Action space of one agent.
    """

    name: str
    space: spaces.Space[Any]

    def commands(self, action: Any, out: np.ndarray, rows: np.ndarray | None = None) -> None:
        """Write the commands of a batch of actions.

        Parameters
        ----------
        action : dict of array or array
            Actions with the leading shape (worlds, agents).
        out : (worlds, players) array of `COMMAND`
            The rows of the agents are overwritten.
        rows : (agents,) int array, optional
            Row of each agent; all rows if not given.

        Raises
        ------
        CommandError
            When the action has the wrong type or shape, or holds NaN or infinity; the message names the entry.
        """
        if rows is None:
            rows = np.arange(out.shape[1])
        shape = (len(out), len(rows))
        if self.name in ("hybrid", "full"):
            _hybrid_commands(action, out, rows, shape)
        elif self.name == "discrete":
            index = _array("discrete", action, (*shape, 4), whole=True)
            bad = kernels.write_discrete(index, _KIND_TABLE, _POWER_TABLE, _DIRECTION_TABLE, _NECK_TABLE, NO_COMMAND, rows, out)
            if bad >= 0:
                name, most = _DISCRETE_PARTS[bad % 4]
                _refuse(f"discrete {name}", index, bad, 0, most)
        else:
            values = _array("box", action, (*shape, len(BOX_KINDS) + 3))
            bad = kernels.write_box(values, _BOX_TABLE, NO_COMMAND, rows, out)
            if bad >= 0:
                _refuse("box", values, bad, -1, 1)


_WHOLE, _REAL = np.dtype(np.int64), np.dtype(np.float64)


def _array(name: str, value: Any, shape: tuple[int, ...], whole: bool = False) -> np.ndarray:
    """`value` as an array of exactly `shape` (int64 or float64), or an error that names `name`."""
    try:
        array = np.asarray(value)
        if array.dtype != (_WHOLE if whole else _REAL):
            array = _converted(name, array, whole)
    except (TypeError, ValueError) as error:
        if isinstance(error, CommandError):
            raise
        raise CommandError(f"action {name!r}: expected numbers of shape {shape}, got {type(value).__name__} {value!r:.60}") from None
    if array.shape != shape:
        if array.shape[:2] == shape[:2]:
            raise CommandError(f"action {name!r}: expected shape {shape[2:]} for every agent, got {array.shape[2:]}")
        raise CommandError(f"action {name!r}: expected shape {shape}, worlds and agents first, got {array.shape}")
    return np.ascontiguousarray(array)


def _converted(name: str, array: np.ndarray, whole: bool) -> np.ndarray:
    """`array` as int64 or float64, if it holds such numbers."""
    kind = array.dtype.kind
    if kind not in "iuf" or (whole and kind == "f" and not (array == np.rint(array)).all()):
        raise CommandError(f"action {name!r}: expected {'whole ' if whole else ''}numbers, got {array.dtype} {array.tolist()!r:.60}")
    return array.astype(_WHOLE if whole else _REAL)


def _refuse(name: str, array: np.ndarray, flat: int, low: float, high: float) -> None:
    """Raise the error for the entry of `array` with the flat index `flat`."""
    at = tuple(int(i) for i in np.unravel_index(flat, array.shape))
    finite = "finite numbers from " if array.dtype.kind == "f" and not np.isfinite(array[at]) else ""
    verb = "are" if finite else "is"
    raise CommandError(f"action {name!r}: entry {at} is {array[at]}; allowed {verb} {finite}{low:g} to {high:g}")


NO_COMMAND = np.zeros(1, COMMAND)
"""(1,) A command that does nothing."""
for _field in ("a", "b", "c", "d", "turn_neck", "focus", "point"):
    NO_COMMAND[_field] = np.nan

_HYBRID_KEYS = ("type", "params", "turn_neck", "view")
_KEYS = (*_HYBRID_KEYS, "say", "attention", "point")
_SIDE_KEYS = frozenset(_KEYS[4:])


def _hybrid_commands(action: Any, out: np.ndarray, rows: np.ndarray, shape: tuple[int, int]) -> None:
    if not isinstance(action, Mapping):
        given = action.tolist() if isinstance(action, np.ndarray) else action
        raise CommandError(f"hybrid action: expected a dict with the keys {', '.join(_HYBRID_KEYS)}; got {given!r:.60}")
    for key in action:
        if key not in _KEYS:
            raise CommandError(f"hybrid action: unknown key {key!r}; allowed are {', '.join(_KEYS)}")
    for key in ("type", "params"):
        if key not in action:
            raise CommandError(f"hybrid action: key {key!r} is missing; needed are type and params")
    kind = _array("type", action["type"], shape, whole=True)
    params = _array("params", action["params"], (*shape, 4))
    neck = _array("turn_neck", action["turn_neck"], (*shape, 1)) if "turn_neck" in action else np.zeros((*shape, 1))
    view = _array("view", action["view"], shape, whole=True) if "view" in action else np.zeros(shape, np.int64)
    part, bad = kernels.write_hybrid(kind, params, neck, view, PARAMETER_SCALES, NECK_SCALE, NO_COMMAND, rows, out)
    if part >= 0:
        array, low, high = ((kind, 0, len(CommandKind) - 1), (params, -1, 1), (neck, -1, 1), (view, 0, 3))[part]
        _refuse(_HYBRID_KEYS[part], array, bad, low, high)
    if not _SIDE_KEYS.isdisjoint(action):
        _side_commands(action, out, rows, shape)


_SAY_BYTES = np.array([0, *SAY_CHARACTERS.encode()], np.uint8)


def _side_commands(action: Mapping[str, Any], out: np.ndarray, rows: np.ndarray, shape: tuple[int, int]) -> None:
    """Write what the agents say, whom they attend to and where they point."""
    if "say" in action:
        index = _array("say", action["say"], (*shape, SAY_LENGTH), whole=True)
        _within("say", index, 0, len(SAY_CHARACTERS))
        length = np.where((index == 0).any(axis=-1), (index == 0).argmax(axis=-1), SAY_LENGTH)
        text = np.zeros((*shape, out["say"].shape[-1]), np.uint8)
        text[..., :SAY_LENGTH] = np.where(np.arange(SAY_LENGTH) < length[..., None], _SAY_BYTES[index], 0)
        out["say"][:, rows], out["say_length"][:, rows] = text, length
    if "attention" in action:
        whom = _array("attention", action["attention"], shape, whole=True)
        _within("attention", whom, 0, ATTENTION_OFF)
        out["attention_side"][:, rows] = np.select([whom == 0, whom == ATTENTION_OFF, whom <= 11], [0, 3, 1], 2)
        out["attention_unum"][:, rows] = np.where((whom > 0) & (whom < ATTENTION_OFF), (whom - 1) % 11 + 1, 0)
    if "point" in action:
        point = _array("point", action["point"], (*shape, 3))
        _within("point", point, -1, 1)
        target = np.stack([np.abs(point[..., 1]) * POINT_REACH, point[..., 2] * 180.0], axis=-1)
        out["point"][:, rows] = np.where(point[..., :1] > 0.0, target, np.nan)


def _within(name: str, array: np.ndarray, low: float, high: float) -> None:
    """Refuse the first entry of `array` outside `low` to `high`."""
    good = (array >= low) & (array <= high)
    if not good.all():
        _refuse(name, array, int(np.flatnonzero(~good.ravel())[0]), low, high)


DISCRETE_KINDS = (CommandKind.NONE, CommandKind.DASH, CommandKind.TURN, CommandKind.KICK, CommandKind.TACKLE, CommandKind.CATCH)
DISCRETE_POWERS = (20.0, 40.0, 60.0, 80.0, 100.0)
DISCRETE_DIRECTIONS = tuple(float(d) for d in range(-165, 181, 15))
DISCRETE_NECKS = (0.0, -60.0, -30.0, 30.0, 60.0)


def discrete_space() -> spaces.MultiDiscrete:
    """MultiDiscrete([command, power, direction, neck]); the values are `DISCRETE_KINDS`, `DISCRETE_POWERS`, ..."""
    return spaces.MultiDiscrete([len(DISCRETE_KINDS), len(DISCRETE_POWERS), len(DISCRETE_DIRECTIONS), len(DISCRETE_NECKS)])


_KIND_TABLE = np.array([int(k) for k in DISCRETE_KINDS])
_POWER_TABLE, _DIRECTION_TABLE, _NECK_TABLE = np.array(DISCRETE_POWERS), np.array(DISCRETE_DIRECTIONS), np.array(DISCRETE_NECKS)
_DISCRETE_PARTS = tuple(
    (name, len(values) - 1)
    for name, values in (
        ("command", _KIND_TABLE),
        ("power", _POWER_TABLE),
        ("direction", _DIRECTION_TABLE),
        ("neck", _NECK_TABLE),
    )
)


BOX_KINDS = (CommandKind.DASH, CommandKind.TURN, CommandKind.KICK)


def box_space() -> spaces.Box:
    """Box(-1, 1, (6,)): preferences for dash, turn, kick (the largest is done), power, direction, neck moment.

    Power -1..1 becomes 0..100, direction and neck -1..1 become -180..180 and -90..90 degrees. After parameterised-action DDPG
    (Hausknecht and Stone, ICLR 2016).
    """
    return spaces.Box(-1.0, 1.0, (len(BOX_KINDS) + 3,), np.float32)


_BOX_TABLE = np.array([int(k) for k in BOX_KINDS])

_VIEWS = {"hybrid": hybrid_space, "full": full_space, "discrete": discrete_space, "box": box_space}
MACRO = "macro"
"""The view whose actions need a memory; `cprm_gym.envs.core.SoccerCore` carries them out."""
VIEWS = (*_VIEWS, MACRO)


def action_view(name: str) -> ActionView:
    """The action view of that name (all but ``macro``, whose size depends on who plays).

    Raises
    ------
    UnknownName
        Listing the views there are.
    """
    if name not in _VIEWS:
        raise unknown_name("action view", name, VIEWS)
    return ActionView(name, _VIEWS[name]())
