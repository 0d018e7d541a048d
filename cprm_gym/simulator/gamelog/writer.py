"""Writing game logs that today's viewers play: text versions 5 and 6 and JSON (specification/protocol.md 11.1)."""

from __future__ import annotations

import dataclasses
import datetime
import json
import math
import os
from collections.abc import Sequence
from types import TracebackType
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ...errors import FormatError
from ...files import AtomicFile
from ..parameter_fields import ParameterSet, word_of
from ..parameters import ServerParameters
from ..player_types import PlayerParameters, PlayerType
from ..state import BALL, LEFT, Count, PlayMode
from .frames import LOG_COUNTS, Frame, Team
from .kernels import show, show_json
from .kernels.frame import fill_players
from .kernels.show import ANGLE_STEP, POSITION_STEP

_COUNTS = np.array(
    [
        Count.KICK,
        Count.DASH,
        Count.TURN,
        Count.CATCH,
        Count.MOVE,
        Count.TURN_NECK,
        Count.CHANGE_VIEW,
        Count.SAY,
        Count.TACKLE,
        Count.ARM,
        Count.ATTENTION,
        Count.CHANGE_FOCUS,
    ]
)
_SIDES = "l", "r"
JSON = -1
"""The version number of JSON logs."""


class HasWorlds(Protocol):
    """What the writer needs of a `Simulator`."""

    parameters: ServerParameters
    player_parameters: PlayerParameters
    types: tuple[PlayerType, ...]
    team_names: tuple[str, str]

    @property
    def world(self) -> npt.NDArray[Any]: ...


def number(value: float) -> str:
    """C's ``%g``: six significant digits, ``-0`` for a negative zero; 0 for what is not known (NaN)."""
    return "0" if value != value else f"{value:g}"


def quantised(value: float, step: float) -> str:
    """`value` on the grid of `step` (ties to even), as `number`."""
    if not math.isfinite(value):
        return number(value)
    steps = round(value / step)
    return f"{steps * step if steps else math.copysign(0.0, value):g}"


def frame_of(world: Any, parameters: ServerParameters, names: Sequence[str] = ("Left", "Right")) -> Frame:
    """What a log shows of one world, unrounded.

    Parameters
    ----------
    world : record of `WORLD`
    parameters : ServerParameters
    names : two str
        The teams' names; an empty one is written as ``null``.
    """
    teams = [Team(names[side], int(world["score"][side]), int(world["pen_score"][side]), int(world["pen_miss"][side])) for side in (0, 1)]
    frame = Frame(int(world["time"]), int(world["stoppage"]), PlayMode(int(world["mode"])), teams[0], teams[1])
    frame.ball = np.concatenate([world["pos"][BALL], world["vel"][BALL]])
    worlds = np.atleast_1d(np.asarray(world))
    fill_players(worlds, parameters.visible_angle, parameters.point_to_duration, _COUNTS, frame.players)
    return frame


def is_logged(mode: PlayMode, before: PlayMode | None) -> bool:
    """Whether a server writes a cycle of that mode, `before` being that of the last one written, None where there is none."""
    return mode != PlayMode.before_kick_off and not (mode == PlayMode.time_over and before in (PlayMode.time_over, None))


class GameLogWriter:
    """Writes one game to a log. Use it in a ``with`` block: the file appears when the block ends, and not at all if it fails.

    Parameters
    ----------
    path : path
        Name of the file, usually ending in ``.rcg``, or ``.rcg.gz`` to compress.
    parameters, player_parameters, player_types
        What the game is played with; viewers draw with them.
    teams : two str
        Names of the teams; without blanks.
    version : int
        6, 5 or 4 (text; 5 has no focus points, 4 no stamina capacity either), or -1 (JSON).
    date : datetime, optional
        When the game is played, for the result line and the JSON header; now if not given.

    Raises
    ------
    FormatError
        For another version, or a team name a log cannot hold.
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
        version: int = 6,
        date: datetime.datetime | None = None,
    ) -> None:
        if version not in (4, 5, 6, -1):
            raise FormatError(f"game logs are written in version 4, 5, 6 (text) or -1 (JSON), not {version!r}")
        if len(teams) != 2:
            raise FormatError(f"a game has 2 teams, got {list(teams)}")
        for name in teams:
            if any(c in ' ()"\\' or not c.isprintable() for c in name) or name == "null":
                raise FormatError(f"team name {name!r}: a log holds printable names without blanks, quotes or parentheses")
        self.parameters = parameters or ServerParameters()
        self.player_parameters = player_parameters or PlayerParameters()
        self.player_types = tuple(player_types) or (PlayerType.default(self.parameters),)
        self.teams = tuple(teams)
        self.version = version
        self.date = date or datetime.datetime.now(datetime.timezone.utc)
        self._mode: PlayMode | None = None
        self._shown_teams: tuple[Team, Team] | None = None
        self._last: Frame | None = None
        self._line = np.empty(show.LONGEST_LINE, np.uint8)
        self._file = AtomicFile(path)
        self._write_header()

    @classmethod
    def for_simulator(cls, path: str | os.PathLike[str], simulator: HasWorlds, **options: Any) -> GameLogWriter:
        """A writer with the parameters, types and team names of `simulator`; `options` as in the constructor."""
        return cls(path, simulator.parameters, simulator.player_parameters, simulator.types, **{"teams": simulator.team_names, **options})

    # --- what is written

    def record(self, simulator: HasWorlds, world: int = 0) -> bool:
        """Write the cycle that world number `world` of `simulator` has just finished, if the server would.

        A server logs nothing before the kick-off of a half and one last frame when time is over.

        Returns
        -------
        bool
            Whether a frame was written.
        """
        record = simulator.world[world]
        mode = PlayMode(int(record["mode"]))
        if not is_logged(mode, self._mode):
            return False
        self.write(frame_of(record, self.parameters, self.teams))
        return True

    def write(self, frame: Frame) -> None:
        """Write `frame`, with the lines about play mode and teams that changed and its messages before it."""
        for message in frame.messages:
            self.message(message.text, message.board, message.time, message.stoppage)
        if frame.mode != self._mode:
            self._mode = frame.mode
            self._write_mode(frame)
        if (frame.left, frame.right) != self._shown_teams:
            self._shown_teams = frame.left, frame.right
            self._write_team(frame.time)
        self._last = frame
        if self.version != JSON:
            size = show.write_show(frame.time, frame.ball, frame.players, self.version > 5, self._line) if self.version > 4 else -1
            self._file.write(self._line[:size].tobytes().decode("ascii") if size > 0 else text_show(frame, self.version))
            return
        size = show_json.write_show(frame.time, frame.stoppage, frame.ball, frame.players, self._line)
        self._file.write((self._line[:size].tobytes().decode("ascii") if size > 0 else json_show(frame)) + ",\n")

    def message(self, text: str, board: int = 1, time: int | None = None, stoppage: int = 0) -> None:
        """Write a text for the message board (1) or the log (2) of the viewer, at `time` or that of the last frame."""
        if time is None:
            time = self._last.time if self._last else 0
        if self.version != JSON:
            if "\n" in text or "\0" in text:
                raise FormatError(f"message {text!r}: a text log cannot hold a line break in a message")
            self._file.write(f'(msg {time} {board} "{text}")\n')
        else:
            self._file.write(f'{{"msg":{{{json_time(time, stoppage)},"board":{board},"message":{json.dumps(text)}}}}},\n')

    def close(self) -> None:
        """Write the result and finish the file. Without a frame the result is that of a game which did not begin."""
        time = self._last.time if self._last else 0
        teams = self._shown_teams or (Team(self.teams[0]), Team(self.teams[1]))
        shown = [f"{team.name}_{team.score}" if team.name else "null" for team in teams]
        self.message(f"(result {self.date:%Y%m%d%H%M} {shown[0]}-vs-{shown[1]})", 1, time)
        self._shown_teams = teams
        self._write_team(time, last=True)
        if self.version == JSON:
            self._file.write("]\n")
        self._file.close()

    def abort(self) -> None:
        """Forget the game; no file appears."""
        self._file.abort()

    def __enter__(self) -> GameLogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    # --- the pieces

    def _write_header(self) -> None:
        if self.version != JSON:
            lines = [f"ULG{self.version}", self.parameters.to_text(), self.player_parameters.to_text()]
            lines += [kind.to_text(number) for number, kind in enumerate(self.player_types)]
        else:
            lines = [
                "[",
                '{"version":"19.0.0"},',
                f'{{"timestamp":"{self.date:%Y-%m-%dT%H:%M:%S+0000}"}},',
                f'{{"server_param":{json_parameters(self.parameters, alphabetical=True)}}},',
                f'{{"player_param":{json_parameters(self.player_parameters, alphabetical=True)}}},',
            ]
            for number_, kind in enumerate(self.player_types):
                lines.append(f'{{"player_type":{{"id":{number_},{json_parameters(kind)[1:]}}},')
        self._file.write("\n".join(lines) + "\n")

    def _write_mode(self, frame: Frame) -> None:
        if self.version != JSON:
            self._file.write(f"(playmode {frame.time} {frame.mode.name})\n")
        else:
            time = json_time(frame.time, frame.stoppage)
            self._file.write(f'{{"playmode":{{{time},"mode":"{frame.mode.name}"}}}},\n')

    def _write_team(self, time: int, last: bool = False) -> None:
        assert self._shown_teams is not None
        left, right = self._shown_teams
        penalties = any((left.pen_score, left.pen_miss, right.pen_score, right.pen_miss))
        if self.version != JSON:
            text = f"(team {time} {left.name or 'null'} {right.name or 'null'} {left.score} {right.score}"
            if penalties:
                text += f" {left.pen_score} {left.pen_miss} {right.pen_score} {right.pen_miss}"
            self._file.write(text + ")\n")
            return
        self._file.write(f'{{"team":{{"time":{time},"l":{json_team(left)},"r":{json_team(right)}}}}}{"" if last else ","}\n')


def _angle(value: float) -> str:
    return quantised(value, ANGLE_STEP)


def _position(values: Sequence[float]) -> list[str]:
    return [quantised(value, POSITION_STEP) for value in values]


class ShownPlayer(NamedTuple):
    """One row of `PLAYER_FRAME` as plain numbers, fields in the same order."""

    side: int
    unum: int
    type: int
    state: int
    pos: Sequence[float]
    vel: Sequence[float]
    body: float
    neck: float
    point: Sequence[float]
    view_quality: int
    view_width: float
    focus: Sequence[float]
    stamina: float
    effort: float
    recovery: float
    capacity: float
    attention: int
    counts: Sequence[int]

    @property
    def letter(self) -> str:
        return "l" if self.side == LEFT else "r"

    @property
    def quality(self) -> str:
        return "l" if self.view_quality == 2 else "h"

    @property
    def target(self) -> tuple[str, int] | None:
        """Side and number of whom the player attends to."""
        side, unum = divmod(self.attention - 1, 11)
        return (_SIDES[side], unum + 1) if self.attention else None


def shown_players(players: npt.NDArray[Any]) -> list[ShownPlayer]:
    """Rows of `PLAYER_FRAME` as plain numbers."""
    return [ShownPlayer(*row) for row in players.tolist()]


def text_show(frame: Frame, version: int) -> str:
    """The line of a frame, also of one that `show.write_show` cannot write."""
    players = " ".join(text_player(row, version) for row in shown_players(frame.players))
    return f"(show {frame.time} ((b) {' '.join(_position(frame.ball.tolist()))}) {players})\n"


def text_player(row: ShownPlayer, version: int) -> str:
    """``((l 1) TYPE STATE x y vx vy body neck [px py] (v h W) (fp D A) (s S E R K) [(f l 2)] (c ...))``.

    Log version 5 knows no focus, version 4 no capacity either.
    """
    state = f"0x{row.state:x}" if row.state else "0"
    motion = [*_position(row.pos), *_position(row.vel), _angle(row.body), _angle(row.neck)]
    if not math.isnan(row.point[0]):
        motion += _position(row.point)
    energy = " ".join(map(number, (row.stamina, row.effort, row.recovery, *((row.capacity,) if version > 4 else ()))))
    attention = "(f {} {}) ".format(*row.target) if row.target else ""
    counts = " ".join(str(max(count, 0)) for count in (row.counts if version > 5 else row.counts[:-1]))
    focus = f"(fp {' '.join(_position(row.focus))}) " if version > 5 else ""
    return (
        f"(({row.letter} {row.unum}) {max(row.type, 0)} {state} {' '.join(motion)} (v {row.quality} {_angle(row.view_width)}) "
        f"{focus}(s {energy}) {attention}(c {counts}))"
    )


def json_show(frame: Frame) -> str:
    """The object of a frame, also of one that `show_json.write_show` cannot write."""
    ball = ",".join(f'"{name}":{quantised(value, POSITION_STEP)}' for name, value in zip(("x", "y", "vx", "vy"), frame.ball))
    players = ",".join(map(json_player, shown_players(frame.players)))
    return f'{{"show":{{{json_time(frame.time, frame.stoppage)},"ball":{{{ball}}},"players":[{players}]}}}}'


def json_player(row: ShownPlayer, monitor: bool = False) -> str:
    """A player of a JSON log: as in the text, without the focus point; monitors are told that and no counts."""
    (x, y), (vx, vy) = _position(row.pos), _position(row.vel)
    items = [
        f'"side":"{row.letter}","unum":{row.unum},"type":{max(row.type, 0)},"state":{row.state}',
        f'"x":{x},"y":{y},"vx":{vx},"vy":{vy},"body":{_angle(row.body)},"neck":{_angle(row.neck)}',
    ]
    if not math.isnan(row.point[0]):
        items.append('"px":{},"py":{}'.format(*_position(row.point)))
    items.append(f'"vq":"{row.quality}","vw":{_angle(row.view_width)}')
    if monitor:
        items.append(f'"fdist":{quantised(row.focus[0], POSITION_STEP)},"fdir":{_angle(row.focus[1])}')
    energy = (row.stamina, row.effort, row.recovery, row.capacity)
    items += [f'"{name}":{number(value)}' for name, value in zip(("stamina", "effort", "recovery", "capacity"), energy)]
    if row.target:
        items.append('"fside":"{}","fnum":{}'.format(*row.target))
    if not monitor:
        items += [f'"{name}":{max(count, 0)}' for name, count in zip(LOG_COUNTS, row.counts)]
    return "{" + ",".join(items) + "}"


def json_time(time: int, stoppage: int) -> str:
    """Clock of a JSON object."""
    return f'"time":{time}' + (f',"stime":{stoppage}' if stoppage > 0 else "")


def json_team(team: Team) -> str:
    """A team of a JSON object."""
    name = json.dumps(team.name) if team.name else "null"
    penalties = f',"pen_score":{team.pen_score},"pen_miss":{team.pen_miss}' if team.pen_score or team.pen_miss else ""
    return f'{{"name":{name},"score":{team.score}{penalties}}}'


def json_parameters(values: ParameterSet, alphabetical: bool = False) -> str:
    """A set of parameters as a JSON object."""
    fields = list(dataclasses.fields(values))  # type: ignore[arg-type]
    if alphabetical:
        fields.sort(key=lambda field: field.name)
    items = []
    for field in fields:
        value = getattr(values, field.name)
        word = json.dumps(value) if field.metadata["kind"] in ("flag", "text") else word_of(field, value)
        items.append(f'"{field.name}":{word}')
    return "{" + ",".join(items) + "}"
