"""Writing the binary forms of old servers: game logs 1 to 3, and datagrams of monitors 1 and 2 (specification/protocol.md 10.3, 11.1)."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...files import AtomicFile
from ..parameters import ServerParameters
from ..player_types import PlayerParameters, PlayerType
from .binary import PLAYER_LAYOUT, SERVER_LAYOUT, TYPE_LAYOUT
from .frames import LOG_COUNTS, Frame, Team

SIZES = {1: 2052, 2: 2056}
MODE, TEAM = 5, 6
_LOG_SIZES = {8: 396, 9: 132, 7: 88}
SHOW, MESSAGE, PLAYER_TYPE, SERVER_PARAM, PLAYER_PARAM = 1, 2, 7, 8, 9
_FIXED = 65536.0
_TEAM = struct.Struct(">16sh")
_OLD_OBJECT = struct.Struct(">6h")
_PLAYER = struct.Struct(">hh7ih2x3i8h")
_COUNTS = [LOG_COUNTS.index(name) for name in ("kick", "dash", "turn", "say", "turn_neck", "catch", "move", "change_view")]


def period(server: ServerParameters) -> int:
    """Milliseconds after which the schedule of the server repeats (specification/simulator.md 1.2)."""
    see = max(server.synch_see_offset, 1)
    steps = (server.simulator_step, server.send_step, server.recv_step, server.sense_body_step, server.send_vi_step, see)
    return math.lcm(*steps)


def binary_frame(frame: Frame, version: int) -> bytes:
    """`frame` for a monitor of version 1 or 2."""
    head = b"\0\1" if version == 1 else b"\0\1\0\0"
    head += bytes((int(frame.mode), 0)) + _team(frame.left) + _team(frame.right)
    data = head + (_old_objects(frame) if version == 1 else b"\0\0" + _objects(frame)) + struct.pack(">h", _short(frame.time))
    return data.ljust(SIZES[version], b"\0")


def binary_message(text: str, board: int, version: int) -> bytes:
    """A text for the message board of a monitor of version 1 or 2."""
    head = struct.pack(">hh" if version == 1 else ">hxxh", MESSAGE, board)
    return (head + text.encode("latin-1", "replace"))[: SIZES[version] - 1].ljust(SIZES[version], b"\0")


def binary_parameters(
    server: ServerParameters, player: PlayerParameters, types: Sequence[PlayerType], log: bool = False
) -> tuple[bytes, ...]:
    """What a monitor of version 2 gets first, or a log of version 3 begins with: the parameters of server and players, then the types."""
    derived = {
        "control_radius_width": server.control_radius - server.player_size,
        "kickable_area": server.kickable_margin + server.ball_size + server.player_size,
        "half_time": server.half_cycles,
        "lcm_step": period(server),
    }
    return (
        _record(SERVER_PARAM, SERVER_LAYOUT, server, derived, log),
        _record(PLAYER_PARAM, PLAYER_LAYOUT, player, {}, log),
        *(_record(PLAYER_TYPE, TYPE_LAYOUT, kind, {"id": number}, log) for number, kind in enumerate(types)),
    )


def _record(kind: int, layout: tuple[tuple[str, str], ...], source: object, derived: dict[str, float], log: bool = False) -> bytes:
    """A set of parameters, as a datagram or as it stands in a log."""
    data = struct.pack(">h" if log else ">hxx", kind)
    for names, code in layout:
        for name in names.split():
            value = 0 if name == "padding" else derived[name] if name in derived else getattr(source, name)
            data += struct.pack(">i", _fixed(value)) if code == "i" else struct.pack(">" + code.replace("x", "xx"), _short(int(value)))
    return data.ljust(2 + _LOG_SIZES[kind] if log else SIZES[2], b"\0")


def _fixed(value: float) -> int:
    """A real as 16.16 fixed point; what does not fit is cut."""
    return max(-(2**31), min(round(float(value) * _FIXED) if value == value else 0, 2**31 - 1))


def _short(value: int) -> int:
    """The lowest 16 bits as a signed number."""
    return (int(value) + 2**15) % 2**16 - 2**15


def _team(team: Team) -> bytes:
    return _TEAM.pack(team.name.encode("latin-1", "replace")[:15], _short(team.score))


def _old_objects(frame: Frame) -> bytes:
    """Ball and players in 1/16 m and whole degrees."""
    parts = [_OLD_OBJECT.pack(0, 0, 0, 0, *(_short(round(value * 16)) for value in frame.ball[:2]))]
    for row in frame.players:
        x, y = (_short(round(float(value) * 16)) for value in row["pos"])
        parts.append(
            _OLD_OBJECT.pack(_short(int(row["state"])), int(row["side"]), int(row["unum"]), _short(round(float(row["body"]))), x, y)
        )
    return b"".join(parts)


def _objects(frame: Frame) -> bytes:
    """Ball and players in fixed point, angles in radians."""
    parts = [struct.pack(">4i", *(_fixed(value) for value in frame.ball))]
    for row in frame.players:
        angles = np.radians((row["body"], row["neck"], row["view_width"]))
        reals = [_fixed(value) for value in (*row["pos"], *row["vel"], *angles)]
        energy = [_fixed(row[name]) for name in ("stamina", "effort", "recovery")]
        counts = [_short(max(int(count), 0)) for count in row["counts"][_COUNTS]]
        quality = int(row["view_quality"] == 1)
        parts.append(_PLAYER.pack(_short(int(row["state"])), _short(int(row["type"])), *reals, quality, *energy, *counts))
    return b"".join(parts)


class BinaryLogWriter:
    """Writes a log of version 1, 2 or 3, for old viewers. Use it in a ``with`` block, as `GameLogWriter`.

    Versions 1 and 2 have places in 1/16 m and whole degrees, no velocities and no counts.

    Parameters
    ----------
    path : path
    version : int
        1, 2 or 3.
    parameters, player_parameters, player_types
        Only version 3 keeps them.

    Raises
    ------
    CprmError
        For a place that cannot be written to.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        version: int,
        parameters: ServerParameters | None = None,
        player_parameters: PlayerParameters | None = None,
        player_types: Sequence[PlayerType] = (),
    ) -> None:
        self.version = version
        self._file = AtomicFile(path)
        self._mode: int | None = None
        self._teams: tuple[Team, Team] | None = None
        if version > 1:
            self._file.write_bytes(b"ULG" + bytes((version,)))
        if version == 3:
            server = parameters or ServerParameters()
            types = player_types or (PlayerType.default(server),)
            for data in binary_parameters(server, player_parameters or PlayerParameters(), types, log=True):
                self._file.write_bytes(data)

    def write(self, frame: Frame) -> None:
        """Write a frame, and what changed before it."""
        for message in frame.messages:
            self.message(message.text, message.board)
        if self.version == 1:
            self._file.write_bytes(binary_frame(frame, 1))
        elif self.version == 2:
            teams = _team(frame.left) + _team(frame.right)
            time = struct.pack(">h", _short(frame.time))
            self._file.write_bytes(b"\0\1" + bytes((int(frame.mode), 0)) + teams + _old_objects(frame) + time)
        else:
            self._write_changes(frame)
            self._file.write_bytes(b"\0\1" + _objects(frame) + struct.pack(">hxx", _short(frame.time)))

    def _write_changes(self, frame: Frame) -> None:
        if self._mode != frame.mode:
            self._mode = int(frame.mode)
            self._file.write_bytes(struct.pack(">hB", MODE, self._mode))
        if self._teams != (frame.left, frame.right):
            self._teams = frame.left, frame.right
            self._file.write_bytes(struct.pack(">h", TEAM) + _team(frame.left) + _team(frame.right))

    def message(self, text: str, board: int = 1) -> None:
        """Write a text for the message board."""
        if self.version == 1:
            self._file.write_bytes(binary_message(text, board, 1))
            return
        data = text.encode("latin-1", "replace")[:2047] + b"\0"
        self._file.write_bytes(struct.pack(">hhh", MESSAGE, board, len(data)) + data)

    def __enter__(self) -> BinaryLogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: Any) -> None:
        if kind is None:
            self._file.close()
        else:
            self._file.abort()
