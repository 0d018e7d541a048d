"""What an agent may do: the canonical command, and the views of it.

The canonical action is one command per player and cycle (`hybrid`); every other action space is a pure function to it (`ActionView`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces

from ..errors import CommandError, unknown_name
from ..simulator.state import COMMAND, CommandKind
from .kernels import actions as kernels


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
    if whole and kind == "f" and not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise CommandError(f"action {name!r}: entry {at} is {array[at]}; expected finite whole numbers")
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
