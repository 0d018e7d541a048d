"""Record logs (version 0): everything that a `Frame` holds, unrounded, as bytes that are copied and not formatted.

A log begins with ``CPRMLOG`` and a zero byte. Items follow, each a byte that says what it is, four bytes with the length of its content
(little-endian, as all numbers here) and the content: the header (JSON), what stands of mode and teams (JSON, written when it changes), a
message (JSON), or a frame: time and stoppage as 32-bit whole numbers, four reals of the ball, 22 rows of `PLAYER_FRAME`. Nothing in it is
executed, and all of it is checked when it is read.
"""

from __future__ import annotations

import dataclasses
import datetime
import io
import json
import os
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ...files import AtomicFile, parse_json
from ..parameters import ServerParameters
from ..player_types import PlayerParameters, PlayerType
from ..state import PLAYERS, PlayMode
from .frames import PLAYER_FRAME, Frame, GameLogHeader, Message, Pending, Team, empty_players, whole
from .streams import DAMAGED, LONGEST_ITEM, undamaged
from .writer import HasWorlds, frame_of, is_logged

RECORD = 0
"""The version number of record logs."""
MARK = b"CPRMLOG\0"
HEADER, STANDING, MESSAGE, FRAME = 1, 2, 3, 4
_ITEM = struct.Struct("<BI")
_HEAD = struct.Struct("<ii4d")
_ROW = PLAYER_FRAME.newbyteorder("<")
_SIZE = _HEAD.size + PLAYERS * _ROW.itemsize
_REALS = [name for name in PLAYER_FRAME.names or () if PLAYER_FRAME[name].base == np.float64]
_COLUMNS = [
    _ROW.fields[name][1] // 8 + k  # type: ignore[index]
    for name in _REALS
    for k in range(PLAYER_FRAME[name].itemsize // 8)
]
"""Columns of the real numbers where a row is taken as reals."""


class RecordLogWriter:
    """Writes one game to a record log. Use it in a ``with`` block, as `GameLogWriter`.

    Parameters
    ----------
    path : path
        A name that ends in ``.gz`` is compressed.
    parameters, player_parameters, player_types
        What the game is played with.
    teams : two str
        Names of the teams.
    date : datetime, optional
        When the game is played, for the result; now if not given.

    Raises
    ------
    CprmError
        For a place that cannot be written to.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        parameters: ServerParameters | None = None,
        player_parameters: PlayerParameters | None = None,
        player_types: Sequence[PlayerType] = (),
        *,
        teams: Sequence[str] = ("Left", "Right"),
        date: datetime.datetime | None = None,
    ) -> None:
        self.parameters = parameters or ServerParameters()
        self.teams = tuple(teams)
        self.date = date or datetime.datetime.now(datetime.timezone.utc)
        self._standing: tuple[Any, ...] = ()
        self._last = Frame(0, left=Team(self.teams[0]), right=Team(self.teams[1]))
        self._file = AtomicFile(path)
        self._file.write_bytes(MARK)
        types = tuple(player_types) or (PlayerType.default(self.parameters),)
        header = {
            "server_param": dataclasses.asdict(self.parameters),
            "player_param": dataclasses.asdict(player_parameters or PlayerParameters()),
            "player_types": [{"id": number, **dataclasses.asdict(kind)} for number, kind in enumerate(types)],
        }
        self._write_json(HEADER, header)

    @classmethod
    def for_simulator(cls, path: str | os.PathLike[str], simulator: HasWorlds, **options: Any) -> RecordLogWriter:
        """A writer with the parameters, types and team names of `simulator`; `options` as in the constructor."""
        return cls(path, simulator.parameters, simulator.player_parameters, simulator.types, **{"teams": simulator.team_names, **options})

    def record(self, simulator: HasWorlds, world: int = 0) -> bool:
        """Write the cycle that world number `world` of `simulator` has just finished, if a server would; whether it was written."""
        record = simulator.world[world]
        if not is_logged(PlayMode(int(record["mode"])), self._last.mode if self._standing else None):
            return False
        self.write(frame_of(record, self.parameters, self.teams))
        return True

    def write(self, frame: Frame) -> None:
        """Write `frame` and its messages before it."""
        for message in frame.messages:
            self.message(message.text, message.board, message.time, message.stoppage)
        standing = (frame.mode, frame.left, frame.right)
        if standing != self._standing:
            self._standing = standing
            teams = [dataclasses.astuple(team) for team in (frame.left, frame.right)]
            self._write_json(STANDING, {"mode": int(frame.mode), "teams": teams})
        self._last = frame
        content = _HEAD.pack(frame.time, frame.stoppage, *frame.ball) + frame.players.astype(_ROW, copy=False).tobytes()
        self._file.write_bytes(_ITEM.pack(FRAME, len(content)) + content)

    def message(self, text: str, board: int = 1, time: int | None = None, stoppage: int = 0) -> None:
        """Write a text for the message board (1) or the log (2) of the viewer, at `time` or that of the last frame."""
        self._write_json(MESSAGE, [self._last.time if time is None else time, board, text, stoppage])

    def close(self) -> None:
        """Write the result and finish the file."""
        shown = [f"{team.name}_{team.score}" if team.name else "null" for team in (self._last.left, self._last.right)]
        self.message(f"(result {self.date:%Y%m%d%H%M} {shown[0]}-vs-{shown[1]})")
        self._file.close()

    def _write_json(self, kind: int, value: Any) -> None:
        content = json.dumps(value).encode("ascii")
        self._file.write_bytes(_ITEM.pack(kind, len(content)) + content)

    def __enter__(self) -> RecordLogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: Any) -> None:
        if kind is None:
            self.close()
        else:
            self._file.abort()


class RecordParser:
    """Reads one record log from `stream`; the header at once, the frames on demand."""

    def __init__(self, path: Path, stream: io.BufferedReader) -> None:
        self.path = path
        self.trailing: tuple[Message, ...] = ()
        self.header = GameLogHeader(RECORD)
        self._stream, self._at = stream, 0
        self._read(len(MARK))
        kind, content = next(self._items(), (0, b""))
        if kind != HEADER:
            raise self._error("a header was expected")
        self._read_header(self._json(content))

    def _error(self, what: str) -> FormatError:
        return FormatError(f"{self.path}, byte {self._at}: {what}")

    def _read(self, size: int) -> bytes:
        try:
            data = self._stream.read(size)
        except DAMAGED as error:
            raise undamaged(self.path, error) from error
        self._at += len(data)
        return data

    def _items(self) -> Iterator[tuple[int, bytes]]:
        """What each item is, and its content."""
        while head := self._read(_ITEM.size):
            kind, size = _ITEM.unpack(head) if len(head) == _ITEM.size else (0, 0)
            if not HEADER <= kind <= FRAME or size > LONGEST_ITEM:
                raise self._error(f"no item begins with {head!r}")
            content = self._read(size)
            if len(content) < size:
                raise self._error(f"the log ends inside an item of {size} bytes")
            yield kind, content

    def _json(self, content: bytes) -> Any:
        return parse_json(content.decode("ascii", "replace"), f"{self.path}, byte {self._at}")

    def _read_header(self, told: Any) -> None:
        try:
            self.header.add("server_param", told["server_param"])
            self.header.add("player_param", told["player_param"])
            for kind in told["player_types"]:
                self.header.add("player_type", kind)
        except (ValueError, KeyError, TypeError) as error:
            raise self._error(f"the header cannot be read ({type(error).__name__}: {str(error)[:100]})") from error

    def frames(self) -> Iterator[Frame]:
        """The frames in order, each with the messages written since the frame before."""
        mode, teams, messages = PlayMode.null, (Team(), Team()), Pending()
        for kind, content in self._items():
            try:
                if kind == FRAME:
                    frame = _frame(content)
                    frame.mode, (frame.left, frame.right), frame.messages = mode, teams, messages.take()
                    yield frame
                elif kind == STANDING:
                    told = self._json(content)
                    mode = PlayMode(whole(told["mode"]))
                    left, right = told["teams"]
                    teams = _team(left), _team(right)
                elif kind == MESSAGE:
                    time, board, text, stoppage = self._json(content)
                    messages.add(Message(whole(time), whole(board), _text(text), whole(stoppage)))
                else:
                    raise ValueError("a second header")
            except (ValueError, KeyError, TypeError) as error:
                if isinstance(error, FormatError):
                    raise
                raise self._error(f"an item cannot be read ({type(error).__name__}: {str(error)[:100]})") from error
        self.trailing = messages.take()


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"a text was expected, got {str(value)[:40]!r}")
    return value


def _team(told: Any) -> Team:
    name, *scores = told
    return Team(_text(name), *(whole(score) for score in scores))


_EMPTY = empty_players()


def _frame(content: bytes) -> Frame:
    """The frame of an item; ValueError for what no log can hold."""
    if len(content) != _SIZE:
        raise ValueError(f"a frame has {_SIZE} bytes, got {len(content)}")
    time, stoppage, *ball = _HEAD.unpack_from(content)
    rows = np.frombuffer(bytearray(content[_HEAD.size :]), _ROW).astype(PLAYER_FRAME, copy=False)
    reals = np.frombuffer(content, "<f8", offset=_HEAD.size).reshape(PLAYERS, -1)[:, _COLUMNS]
    if np.isinf(reals).any() or np.isinf(ball).any():
        raise ValueError("a number is infinite")
    if not (np.array_equal(rows["side"], _EMPTY["side"]) and np.array_equal(rows["unum"], _EMPTY["unum"])):
        raise ValueError("players stand out of order")
    attention = rows["attention"]
    if attention.min() < 0 or attention.max() > PLAYERS:
        raise ValueError(f"attention to a player beyond {PLAYERS}")
    return Frame(time, stoppage, ball=np.array(ball), players=rows)
