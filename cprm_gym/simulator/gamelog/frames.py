"""What a game log (``.rcg``) holds: one picture of the field per cycle, whatever version it is written in.

A `Frame` keeps the numbers as they stand in the log: metres and degrees in the server's frame, already rounded by whoever wrote it
(specification/protocol.md 10 and 11). What a version does not record is NaN or -1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..parameter_fields import ParameterSet
from ..parameters import ServerParameters
from ..player_types import PlayerParameters, PlayerType
from ..state import LEFT, PLAYERS, RIGHT, PlayMode
from .streams import MOST_PENDING, MOST_TYPES

LOG_COUNTS = (
    "kick",
    "dash",
    "turn",
    "catch",
    "move",
    "turn_neck",
    "change_view",
    "say",
    "tackle",
    "pointto",
    "attentionto",
    "change_focus",
)
"""The command counters of a player in a log, in the order of the text log."""

PLAYER_FRAME = np.dtype(
    [
        ("side", "i1"),
        ("unum", "i1"),
        ("type", "i2"),
        ("state", "u4"),
        ("pos", "f8", (2,)),
        ("vel", "f8", (2,)),
        ("body", "f8"),
        ("neck", "f8"),  # degrees; neck relative to the body
        ("point", "f8", (2,)),  # global target of the arm; NaN = not pointing
        ("view_quality", "i1"),
        ("view_width", "f8"),  # 1 high, 2 low; whole cone in degrees
        ("focus", "f8", (2,)),  # distance, direction in degrees
        ("stamina", "f8"),
        ("effort", "f8"),
        ("recovery", "f8"),
        ("capacity", "f8"),
        ("attention", "i1"),  # object number 1..22, 0 = nobody
        ("counts", "i4", (len(LOG_COUNTS),)),
    ],
    align=True,
)
"""One player in one frame of a game log; rows of `Frame.players` are left 1..11, right 1..11."""

SIDES = {"l": LEFT, "r": RIGHT}
_MOST = 2**31 - 1


def whole(value: Any) -> int:
    """A whole number that a log may hold: of 32 bits; ValueError for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, str)):
        raise ValueError(f"a whole number was expected, got {str(value)[:40]!r}")
    number = int(value)
    if abs(number) > _MOST:
        raise ValueError(f"a number is at most {_MOST}, got {str(value)[:40]}")
    return number


@dataclass(frozen=True, slots=True)
class Team:
    """Name and scores of one side; `name` is empty when no team was connected (``null`` in the log)."""

    name: str = ""
    score: int = 0
    pen_score: int = 0
    pen_miss: int = 0


@dataclass(frozen=True, slots=True)
class Message:
    """A text on the board of the viewer: ``board`` 1 is the message board, 2 the log."""

    time: int
    board: int
    text: str
    stoppage: int = 0


@dataclass(slots=True)
class Frame:
    """One cycle of a game log.

    Attributes
    ----------
    time, stoppage : int
        The server's clock and the steps since it stopped.
    mode : PlayMode
    left, right : Team
    ball : ndarray (4,)
        x, y (m), vx, vy (m/cycle, after decay).
    players : ndarray (22,) of `PLAYER_FRAME`
    messages : tuple of Message
        Messages written since the frame before.
    """

    time: int
    stoppage: int = 0
    mode: PlayMode = PlayMode.null
    left: Team = field(default_factory=Team)
    right: Team = field(default_factory=Team)
    ball: npt.NDArray[np.float64] = field(default_factory=lambda: np.full(4, np.nan))
    players: npt.NDArray[Any] = field(default_factory=lambda: empty_players())
    messages: tuple[Message, ...] = ()


@dataclass(slots=True)
class GameLogHeader:
    """What a game log says before its first frame; values as in the log (numbers, booleans or text)."""

    version: int
    server_param: dict[str, Any] = field(default_factory=dict)
    player_param: dict[str, Any] = field(default_factory=dict)
    player_types: list[dict[str, Any]] = field(default_factory=list)
    remarks: dict[str, str] = field(default_factory=dict)

    def add(self, kind: str, values: Any) -> None:
        """Add what a ``server_param``, ``player_param`` or ``player_type`` says; ValueError when it cannot be one."""
        if not isinstance(values, dict):
            raise ValueError(f"names and values were expected, got {str(values)[:40]!r}")
        if kind == "player_type":
            if not isinstance(values.get("id"), int):
                raise ValueError(f"a player type has a whole number as its id, got {str(values.get('id'))[:40]!r}")
            if len(self.player_types) == MOST_TYPES:
                raise ValueError(f"more than {MOST_TYPES} player types")
            self.player_types.append(values)
        else:
            setattr(self, kind, values)

    def parameters(self) -> ServerParameters:
        """The server's parameters; what the log does not tell has the default, names of other servers are passed over."""
        return ServerParameters.from_mapping(_known(self.server_param, ServerParameters))

    def player_parameters(self) -> PlayerParameters:
        """The parameters of heterogeneous players, in the same way."""
        return PlayerParameters.from_mapping(_known(self.player_param, PlayerParameters))

    def types(self) -> tuple[PlayerType, ...]:
        """The player types in the order of their ids; empty when the log has none."""
        ordered = sorted(self.player_types, key=lambda values: values["id"])
        return tuple(PlayerType.from_mapping(_known(values, PlayerType)) for values in ordered)


def _known(values: dict[str, Any], kind: type[ParameterSet]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name in kind.names()}


def empty_players() -> npt.NDArray[Any]:
    """Twenty-two `PLAYER_FRAME` rows with sides and numbers filled in and everything else unknown."""
    return np.frombuffer(bytearray(_EMPTY), PLAYER_FRAME)  # records are copied field by field, bytes at once


def _empty_players() -> npt.NDArray[Any]:
    rows = np.zeros(PLAYERS, PLAYER_FRAME)
    for name in ("pos", "vel", "body", "neck", "point", "view_width", "focus", "stamina", "effort", "recovery", "capacity"):
        rows[name] = np.nan
    rows["counts"] = -1
    rows["side"] = np.repeat((LEFT, RIGHT), 11)
    rows["unum"] = np.tile(np.arange(1, 12), 2)
    return rows


_EMPTY = _empty_players().tobytes()


def player_row(side: int, unum: int) -> int:
    """Row 0..21 of a player in `Frame.players`; ValueError for a player that cannot be."""
    if side not in (LEFT, RIGHT) or not 1 <= unum <= 11:
        raise ValueError(f"no player {unum} of side {side}")
    return unum - 1 if side == LEFT else 10 + unum


class Pending:
    """The messages written since the last frame; ValueError when they are more than a log can need."""

    def __init__(self) -> None:
        self._messages: list[Message] = []
        self._size = 0

    def add(self, message: Message) -> None:
        """One more."""
        self._size += len(message.text) + 100
        if self._size > MOST_PENDING:
            raise ValueError(f"more than {MOST_PENDING} bytes of messages without a cycle between them")
        self._messages.append(message)

    def take(self) -> tuple[Message, ...]:
        """All of them; none are left."""
        taken, self._messages, self._size = tuple(self._messages), [], 0
        return taken


class Clock:
    """Keeps the stoppage count of a log: frames of one time after its first one are the steps while the clock stood.

    Only a stopped mode repeats a time, so the count agrees with the server's except for stoppage before the first frame.
    """

    def __init__(self) -> None:
        self.time: int | None = None
        self.stoppage = 0

    def tick(self, time: int) -> int:
        """Stoppage of the next frame, whose time is `time`."""
        self.stoppage = self.stoppage + 1 if time == self.time else 0
        self.time = time
        return self.stoppage
