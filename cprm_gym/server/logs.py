"""Game log and text log of a match, written while it is played (specification/protocol.md 11)."""

from __future__ import annotations

import csv
import datetime
import os
from pathlib import Path

from ..errors import CprmError
from ..files import check_place
from ..simulator.gamelog.binary_writer import BinaryLogWriter
from ..simulator.gamelog.commands import CommandLogWriter, LogLine
from ..simulator.gamelog.frames import Frame
from ..simulator.gamelog.writer import JSON, GameLogWriter
from ..simulator.state import PlayMode
from .core import Server
from .stadium import Stadium


class MatchLogs:
    """Writes ``.rcg`` and ``.rcl`` of a server's match into a folder; the names are those of the server.

    Parameters
    ----------
    server : Server
    folder : path
        Must be there.
    date : datetime, optional
        When the match is played; now if not given.

    Raises
    ------
    CprmError
        When nothing can be written there.
    """

    def __init__(self, server: Server, folder: str | os.PathLike[str], date: datetime.datetime | None = None) -> None:
        self._stadium = server.stadium
        self._parameters = server.settings.server
        self._folder = Path(folder)
        check_folder(self._folder)
        self._date = date or datetime.datetime.now()
        self._mode: PlayMode | None = None
        self._game: GameLogWriter | BinaryLogWriter | None = None
        self._text: CommandLogWriter | None = None
        parameters, sim = self._parameters, server.stadium.sim
        if parameters.game_logging:
            self._game_place = self._unfinished(".rcg", parameters.game_log_compression)
            version, told = parameters.game_log_version, (sim.parameters, sim.player_parameters, sim.types)
            if version in (1, 2, 3):
                self._game = BinaryLogWriter(self._game_place, version, *told)
            else:
                known = version if version in (JSON, 4, 5) else 6
                self._game = GameLogWriter(self._game_place, *told, teams=("", ""), version=known, date=self._date)
            self._stadium.viewers.append(self._frame)
            self._stadium.messages.append(self._message)
        if parameters.text_logging:
            self._text_place = self._unfinished(".rcl", parameters.text_log_compression)
            self._text = CommandLogWriter(self._text_place)
            self._stadium.listeners.append(self._line)

    def _unfinished(self, ending: str, compression: int) -> Path:
        return self._folder / f"incomplete{os.getpid()}{ending}{'.gz' if compression else ''}"

    def _frame(self, frame: Frame) -> None:
        """What the server logs of a step: everything but the waits before kick-offs, and the end once."""
        assert self._game is not None
        over = frame.mode == PlayMode.time_over
        if frame.mode == PlayMode.before_kick_off or (over and self._mode in (PlayMode.time_over, None)):
            return
        self._mode = frame.mode
        self._game.write(frame)

    def _message(self, time: int, stoppage: int, text: str) -> None:
        assert self._game is not None
        if self._parameters.record_messages or text.startswith("(team_graphic"):
            if isinstance(self._game, BinaryLogWriter):
                self._game.message(text)
            else:
                self._game.message(text, 1, time, stoppage)

    def _line(self, time: int, stoppage: int, text: str) -> None:
        assert self._text is not None
        self._text.line(LogLine(time, stoppage, text))

    def close(self) -> list[Path]:
        """Finish the logs; their names."""
        written = []
        p = self._parameters
        stem = result_name(self._stadium)
        if self._game is not None:
            self._stadium.viewers.remove(self._frame)
            self._stadium.messages.remove(self._message)
            if isinstance(self._game, GameLogWriter):
                self._game.teams = self._stadium.sim.team_names
            self._game.__exit__(None, None, None)
            dated = f"{self._date.strftime(p.log_date_format)}" if p.game_log_dated else ""
            written.append(_rename(self._game_place, p.game_log_fixed_name if p.game_log_fixed else f"{dated}{stem}"))
        if self._text is not None:
            self._stadium.listeners.remove(self._line)
            self._text.close()
            dated = f"{self._date.strftime(p.log_date_format)}" if p.text_log_dated else ""
            written.append(_rename(self._text_place, p.text_log_fixed_name if p.text_log_fixed else f"{dated}{stem}"))
        return written


def check_folder(folder: Path) -> None:
    """See whether logs can be written into a folder, before a match is opened for them.

    Raises
    ------
    CprmError
        When it is not there or nothing can be written there.
    """
    if not folder.is_dir():
        raise CprmError(f"--log {folder}: there is no such folder")
    check_place(folder / "incomplete.rcg", "--log")


def _rename(place: Path, stem: str) -> Path:
    """Give a finished log its name; one that is there is not overwritten."""
    ending = "".join(place.suffixes)
    stem = "".join(character if character.isalnum() or character in "_-+." else "_" for character in stem)
    target, number = place.with_name(stem + ending), 1
    while target.exists():
        number += 1
        target = place.with_name(f"{stem}-{number}{ending}")
    os.replace(place, target)
    return target


def result_name(stadium: Stadium) -> str:
    """``LEFT_2-vs-RIGHT_1``: names, coaches' names and goals, as logs are named; ``null`` for a team that never came."""
    world, parts = stadium.world, []
    shots = bool((world["pen_score"] + world["pen_miss"]).any())
    for side, team in enumerate(stadium.teams):
        if not team.name:
            parts.append("null")
            continue
        coach = f"_{team.coach_name}" if team.coach_name else ""
        penalties = f"_{world['pen_score'][side]}" if shots else ""
        parts.append(f"{team.name}{coach}_{world['score'][side]}{penalties}")
    return "-vs-".join(parts)


def result_line(stadium: Stadium) -> str:
    """The result in words: ``Left 2 : 1 Right, penalties 3 : 2``."""
    world = stadium.world
    left, right = (team.name or "nobody" for team in stadium.teams)
    line = f"{left} {world['score'][0]} : {world['score'][1]} {right}"
    if (world["pen_score"] + world["pen_miss"]).any():
        line += f", penalties {world['pen_score'][0]} : {world['pen_score'][1]}"
    return f"{line}, {stadium.time} cycles"


def append_result(stadium: Stadium, path: str | os.PathLike[str], date: datetime.datetime | None = None) -> None:
    """Add a row to a table of results in CSV: date, teams, goals, penalties, cycles; with a head if the file is new.

    Raises
    ------
    CprmError
        When it cannot be written.
    """
    world = stadium.world
    head = ["date", "left", "right", "left_goals", "right_goals", "left_penalties", "right_penalties", "cycles"]
    numbers = [*world["score"], *world["pen_score"]]
    row = [f"{date or datetime.datetime.now():%Y-%m-%dT%H:%M:%S}", *(team.name for team in stadium.teams), *numbers, stadium.time]
    target = Path(path)
    try:
        new = not target.exists() or target.stat().st_size == 0
        with target.open("a", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            if new:
                writer.writerow(head)
            writer.writerow(row)
    except OSError as error:
        raise CprmError(f"{target}: cannot be written: {error.strerror or error}") from None
