"""Binary game logs, versions 1 to 3, of old servers; read only.

All numbers are big-endian. Version 1 is a row of records of 2052 bytes without a header. Versions 2 and 3 begin with ``ULG`` and
the version byte; version 2 keeps the frames of version 1 (positions in 1/16 m, whole degrees, no velocities), version 3 has reals
as 32-bit fixed point with 16 binary digits and angles in radians.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ..state import LEFT, RIGHT, PlayMode
from .frames import LOG_COUNTS, Clock, Frame, GameLogHeader, Message, Pending, Team, empty_players, player_row
from .streams import DAMAGED, undamaged

SHOW, MESSAGE, DRAW, MODE, TEAM, PLAYER_TYPE, SERVER_PARAM, PLAYER_PARAM = 1, 2, 3, 5, 6, 7, 8, 9

_TEAM = struct.Struct(">16sh")
_OLD_OBJECT = struct.Struct(">6h")
_OLD_SHOW = 2 + 2 * _TEAM.size + 23 * _OLD_OBJECT.size + 2
_PLAYER = struct.Struct(">hh7ih2x3i8h")
_SHOW = 16 + 22 * _PLAYER.size + 4  # two bytes of padding behind the time
_FIXED = 65536.0
_COUNTS = [LOG_COUNTS.index(name) for name in ("kick", "dash", "turn", "say", "turn_neck", "catch", "move", "change_view")]

# (names, format of each): i = real in fixed point, h = integer; x = two bytes of padding
SERVER_LAYOUT = (
    (
        "goal_width inertia_moment player_size player_decay player_rand player_weight player_speed_max player_accel_max stamina_max "
        "stamina_inc_max recover_init recover_dec_thr recover_min recover_dec effort_init effort_dec_thr effort_min effort_dec "
        "effort_inc_thr effort_inc kick_rand",
        "i",
    ),
    ("team_actuator_noise", "hx"),
    (
        "prand_factor_l prand_factor_r kick_rand_factor_l kick_rand_factor_r ball_size ball_decay ball_rand ball_weight "
        "ball_speed_max ball_accel_max dash_power_rate kick_power_rate kickable_margin control_radius control_radius_width "
        "maxpower minpower maxmoment minmoment maxneckmoment minneckmoment maxneckang minneckang visible_angle visible_distance "
        "wind_dir wind_force wind_ang wind_rand kickable_area catchable_area_l catchable_area_w catch_probability",
        "i",
    ),
    ("goalie_max_moves", "hx"),
    ("ckick_margin offside_active_area_size", "i"),
    (
        "wind_none wind_random say_coach_cnt_max say_coach_msg_size clang_win_size clang_define_win clang_meta_win clang_advice_win "
        "clang_info_win clang_mess_delay clang_mess_per_cycle half_time simulator_step send_step recv_step sense_body_step lcm_step "
        "say_msg_size hear_max hear_inc hear_decay catch_ban_cycle slow_down_factor use_offside forbid_kick_off_offside",
        "h",
    ),
    ("padding", "h"),
    ("offside_kick_margin audio_cut_dist quantize_step quantize_step_l", "i"),
)
PLAYER_LAYOUT = (
    ("player_types subs_max pt_max", "h"),
    ("padding", "h"),
    (
        "player_speed_max_delta_min player_speed_max_delta_max stamina_inc_max_delta_factor player_decay_delta_min "
        "player_decay_delta_max inertia_moment_delta_factor dash_power_rate_delta_min dash_power_rate_delta_max "
        "player_size_delta_factor kickable_margin_delta_min kickable_margin_delta_max kick_rand_delta_factor "
        "extra_stamina_delta_min extra_stamina_delta_max effort_max_delta_factor effort_min_delta_factor",
        "i",
    ),
)
TYPE_LAYOUT = (
    ("id", "hx"),
    (
        "player_speed_max stamina_inc_max player_decay inertia_moment dash_power_rate player_size kickable_margin kick_rand "
        "extra_stamina effort_max effort_min",
        "i",
    ),
)
_SERVER_SIZE, _PLAYER_PARAM_SIZE, _TYPE_SIZE = 396, 132, 88


def _unpack(layout: tuple[tuple[str, str], ...], data: bytes) -> dict[str, Any]:
    """The leading fields of a parameter record; what servers added behind them is not read."""
    values: dict[str, Any] = {}
    at = 0
    for names, code in layout:
        for name in names.split():
            if code == "i":
                values[name] = struct.unpack_from(">i", data, at)[0] / _FIXED
                at += 4
            else:
                values[name] = struct.unpack_from(">h", data, at)[0]
                at += 4 if code == "hx" else 2
    values.pop("padding", None)
    return values


class BinaryParser:
    """Reads one binary log; `stream` stands behind the four bytes of the header, if the version has one."""

    def __init__(self, path: Path, stream: io.BufferedReader, version: int) -> None:
        self.path = path
        self.trailing: tuple[Message, ...] = ()
        self.header = GameLogHeader(version)
        self._stream = stream
        self._at = 0 if version == 1 else 4
        self._pending: int | None = None
        self._read_header()

    def _error(self, what: str) -> FormatError:
        return FormatError(f"{self.path}, byte {self._at}: {what}")

    def _read(self, size: int) -> bytes:
        try:
            data = self._stream.read(size)
        except DAMAGED as error:
            raise undamaged(self.path, error) from error
        if len(data) != size:
            raise self._error(f"ends inside a record ({len(data)} of {size} bytes)")
        self._at += size
        return data

    def _kind(self) -> int | None:
        """The kind of the next record, None at the end."""
        try:
            start = self._stream.read(2)
        except DAMAGED as error:
            raise undamaged(self.path, error) from error
        if not start:
            return None
        if len(start) == 1:
            raise self._error("ends inside a record")
        self._at += 2
        return int.from_bytes(start, "big", signed=True)

    def _read_header(self) -> None:
        kind = self._kind()
        header = self.header
        while self.header.version == 3 and kind in (SERVER_PARAM, PLAYER_PARAM, PLAYER_TYPE):
            if kind == SERVER_PARAM:
                header.add("server_param", _unpack(SERVER_LAYOUT, self._read(_SERVER_SIZE)))
            elif kind == PLAYER_PARAM:
                header.add("player_param", _unpack(PLAYER_LAYOUT, self._read(_PLAYER_PARAM_SIZE)))
            else:
                try:
                    header.add("player_type", _unpack(TYPE_LAYOUT, self._read(_TYPE_SIZE)))
                except ValueError as error:
                    raise self._error(str(error)) from None
            kind = self._kind()
        self._pending = kind

    def frames(self) -> Iterator[Frame]:
        """The frames in order, each with the messages written since the frame before."""
        clock = Clock()
        mode, teams = PlayMode.null, (Team(), Team())
        messages = Pending()
        time = 0
        old = self.header.version < 3
        kind = self._pending
        while kind is not None:
            if kind == MESSAGE:
                self._add(messages, self._message(time))
            elif kind == SHOW:
                if self.header.version == 1:
                    frame = self._old_show(self._read(2050))
                else:
                    frame = self._old_show(self._read(_OLD_SHOW)) if old else self._show(self._read(_SHOW))
                if not old:
                    frame.mode, (frame.left, frame.right) = mode, teams
                time = frame.time
                frame.stoppage, frame.messages = clock.tick(time), messages.take()
                yield frame
            elif kind == MODE and not old:
                mode = self._mode(self._read(1)[0])
            elif kind == TEAM and not old:
                data = self._read(2 * _TEAM.size)
                teams = _team(data, 0), _team(data, _TEAM.size)
            else:
                raise self._error(f"record of unknown kind {kind}")
            kind = self._kind()
        self.trailing = messages.take()

    def _add(self, messages: Pending, message: Message) -> None:
        try:
            messages.add(message)
        except ValueError as error:
            raise self._error(str(error)) from None

    def _mode(self, number: int) -> PlayMode:
        try:
            return PlayMode(number)
        except ValueError:
            raise self._error(f"unknown play mode {number}") from None

    def _message(self, time: int) -> Message:
        if self.header.version == 1:
            data = self._read(2050)
            board, text = int.from_bytes(data[:2], "big"), data[2:].split(b"\0")[0]
        else:
            board, size = struct.unpack(">hh", self._read(4))
            if size < 0:
                raise self._error(f"a message of {size} bytes")
            text = self._read(size).rstrip(b"\0")
        return Message(time, board, text.decode("utf-8", "surrogateescape"))

    def _old_show(self, data: bytes) -> Frame:
        """Versions 1 and 2: mode, teams, 23 objects in 1/16 m, time."""
        frame = Frame(0)
        frame.mode = self._mode(data[0])
        frame.left, frame.right = _team(data, 2), _team(data, 2 + _TEAM.size)
        at = 2 + 2 * _TEAM.size
        rows = frame.players = empty_players()
        for index in range(23):
            state, side, unum, angle, x, y = _OLD_OBJECT.unpack_from(data, at)
            at += _OLD_OBJECT.size
            if index == 0:
                frame.ball[:2] = x / 16, y / 16
                continue
            if side not in (LEFT, RIGHT) or not 1 <= unum <= 11:
                raise self._error(f"object {index} is player {unum} of side {side}")
            row = rows[player_row(side, unum)]
            row["state"], row["type"], row["body"], row["pos"] = state & 0xFFFF, -1, angle, (x / 16, y / 16)
        (frame.time,) = struct.unpack_from(">h", data, at)
        return frame

    def _show(self, data: bytes) -> Frame:
        """Version 3: ball, 22 players, time."""
        frame = Frame(struct.unpack_from(">h", data, _SHOW - 4)[0])
        frame.ball = np.array(struct.unpack_from(">4i", data)) / _FIXED
        rows = frame.players = empty_players()
        for index in range(22):
            values = _PLAYER.unpack_from(data, 16 + index * _PLAYER.size)
            row = rows[index]
            row["state"], row["type"] = values[0] & 0xFFFF, values[1]
            x, y, vx, vy, body, neck, width = (value / _FIXED for value in values[2:9])
            row["pos"], row["vel"] = (x, y), (vx, vy)
            row["body"], row["neck"], row["view_width"] = np.degrees((body, neck, width))
            row["view_quality"] = 1 if values[9] else 2
            row["stamina"], row["effort"], row["recovery"] = (value / _FIXED for value in values[10:13])
            row["counts"][_COUNTS] = values[13:21]
        return frame


def _team(data: bytes, at: int) -> Team:
    name, score = _TEAM.unpack_from(data, at)
    return Team(name.split(b"\0")[0].decode("utf-8", "surrogateescape"), score)
