"""Datagrams of the binary monitor protocols 1 and 2 (specification/protocol.md 10.3)."""

from __future__ import annotations

import struct

import numpy as np

from ...simulator.gamelog.binary import PLAYER_LAYOUT, SERVER_LAYOUT, TYPE_LAYOUT
from ...simulator.gamelog.frames import LOG_COUNTS, Frame, Team
from ...simulator.parameters import ServerParameters
from ...simulator.player_types import PlayerParameters, PlayerType
from .parameter_texts import period

SIZES = {1: 2052, 2: 2056}
SHOW, MESSAGE, PLAYER_TYPE, SERVER_PARAM, PLAYER_PARAM = 1, 2, 7, 8, 9
_FIXED = 65536.0
_TEAM = struct.Struct(">16sh")
_OLD_OBJECT = struct.Struct(">6h")
_PLAYER = struct.Struct(">hh7ih2x3i8h")
_COUNTS = [LOG_COUNTS.index(name) for name in ("kick", "dash", "turn", "say", "turn_neck", "catch", "move", "change_view")]


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


def binary_parameters(server: ServerParameters, player: PlayerParameters, types: tuple[PlayerType, ...]) -> tuple[bytes, ...]:
    """What a monitor of version 2 gets first: the parameters of server and players, then the types."""
    derived = {
        "control_radius_width": server.control_radius - server.player_size,
        "kickable_area": server.kickable_margin + server.ball_size + server.player_size,
        "half_time": server.half_cycles,
        "lcm_step": period(server),
    }
    return (
        _record(SERVER_PARAM, SERVER_LAYOUT, server, derived),
        _record(PLAYER_PARAM, PLAYER_LAYOUT, player, {}),
        *(_record(PLAYER_TYPE, TYPE_LAYOUT, kind, {"id": number}) for number, kind in enumerate(types)),
    )


def _record(kind: int, layout: tuple[tuple[str, str], ...], source: object, derived: dict[str, float]) -> bytes:
    data = struct.pack(">hxx", kind)
    for names, code in layout:
        for name in names.split():
            value = 0 if name == "padding" else derived[name] if name in derived else getattr(source, name)
            data += struct.pack(">i", _fixed(value)) if code == "i" else struct.pack(">" + code.replace("x", "xx"), _short(int(value)))
    return data.ljust(SIZES[2], b"\0")


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
