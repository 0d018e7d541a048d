"""Text game logs, versions 4 to 6: one parenthesised item per line (specification/protocol.md 11.1)."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ..state import PlayMode
from .frames import (
    LOG_COUNTS,
    SIDES,
    Clock,
    Frame,
    GameLogHeader,
    Message,
    Pending,
    Team,
    empty_players,
    player_row,
    whole,
)
from .kernels import show
from .streams import LONGEST_ITEM, read_lines

_PAIR = re.compile(r'\(([A-Za-z_0-9]+) ("[^"]*"|[^()]*)\)')
_MESSAGE = re.compile(r'\(msg (-?\d{1,10}) (-?\d{1,10}) "')
_WORDS = {"true": True, "false": False}
MODES = {mode.name: mode for mode in PlayMode}


def parameter_value(text: str) -> bool | int | float | str:
    """A value of ``(name value)``: int, float, the text between quotes, or one of the words ``true`` and ``false`` of converters."""
    if text.startswith('"'):
        return text.strip('"')
    if text in _WORDS:
        return _WORDS[text]
    if "_" in text or not text.isascii():
        raise ValueError(f"a number was expected, not {text[:20]!r}")
    try:
        return int(text)
    except ValueError:
        return float(text)


def parameter_pairs(text: str) -> dict[str, Any]:
    """The ``(name value)`` pairs of a parameter message."""
    return {name: parameter_value(value) for name, value in _PAIR.findall(text)}


class TextParser:
    """Reads one text log from `stream`; the header at once, the frames on demand."""

    def __init__(self, path: Path, stream: io.BufferedReader, version: int) -> None:
        self.path = path
        self.trailing: tuple[Message, ...] = ()
        self.header = GameLogHeader(version)
        self._line_number = 0
        self._stream = stream
        self._pending: str | None = None
        self._lines = self._read_lines()
        next(self._lines)  # ULG and the version
        self._read_header()

    def _read_lines(self) -> Iterator[str]:
        for raw in read_lines(self.path, self._stream):
            self._line_number += 1
            line = raw.decode("utf-8", "surrogateescape").rstrip("\r\n\0")
            if raw[-1:] != b"\n" and not line.startswith("(msg ") and line.count("(") != line.count(")"):
                raise self._error(f"the log ends inside this item, as one that was cut short does: {line[:40]!r}")
            if line:
                yield line

    def _error(self, what: str) -> FormatError:
        return FormatError(f"{self.path}, line {self._line_number}: {what}")

    def _read_header(self) -> None:
        for line in self._lines:
            kind = line[1 : line.find(" ")]
            if kind not in ("server_param", "player_param", "player_type"):
                self._pending = line
                return
            try:
                self.header.add(kind, parameter_pairs(line[len(kind) + 1 :]))
            except ValueError as error:
                raise self._error(f"{kind} cannot be read: {error}") from None

    def frames(self) -> Iterator[Frame]:
        """The frames in order, each with the messages written since the frame before."""
        clock = Clock()
        mode, teams = PlayMode.null, (Team(), Team())
        messages = Pending()
        line = self._pending
        while line is not None:
            try:
                if line.startswith("(show "):
                    frame = parse_show(line)
                    frame.stoppage = clock.tick(frame.time)
                    frame.mode, (frame.left, frame.right), frame.messages = mode, teams, messages.take()
                    yield frame
                elif line.startswith("(playmode "):
                    name = line[10:].rstrip(")").split()[1]
                    if name not in MODES:
                        raise self._error(f"unknown play mode {name!r}")
                    mode = MODES[name]
                elif line.startswith("(team "):
                    teams = parse_team(line)
                elif line.startswith("(msg "):
                    messages.add(self._message(line))
                else:
                    raise self._error(f"unknown item {line[:40]!r}; expected show, playmode, team or msg")
            except (ValueError, IndexError, KeyError, OverflowError) as error:
                if isinstance(error, FormatError):
                    raise
                raise self._error(f"cannot be read ({error}): {line[:60]!r}") from error
            line = next(self._lines, None)
        self.trailing = messages.take()

    def _message(self, line: str) -> Message:
        head = _MESSAGE.match(line)
        if head is None:
            raise self._error(f"a message has a time, a board and a text in quotes, got {line[:60]!r}")
        # the server writes whatever stands in its buffer, line breaks included
        parts, size = [line[head.end() :]], len(line)
        while not parts[-1].rstrip().endswith('")'):
            more = next(self._lines, None)
            if more is None:
                raise self._error("a message without its closing quote")
            size += len(more) + 1
            if size > LONGEST_ITEM:
                raise self._error(f"a message of more than {LONGEST_ITEM} bytes, or one without its closing quote")
            parts.append(more)
        return Message(whole(head[1]), whole(head[2]), "\n".join(parts).rstrip().removesuffix('")'))


def parse_team(line: str) -> tuple[Team, Team]:
    """``(team T NL NR SL SR [PSL PML PSR PML])`` as two teams."""
    left, right, *scores = line[6:].rstrip(")").split()[1:]
    numbers = [whole(score) for score in scores]
    if len(numbers) not in (2, 6):
        raise ValueError(f"{len(numbers)} scores instead of 2 or 6")
    pen = numbers[2:] or [0, 0, 0, 0]
    return (
        Team("" if left == "null" else left, numbers[0], pen[0], pen[1]),
        Team("" if right == "null" else right, numbers[1], pen[2], pen[3]),
    )


def parse_show(line: str) -> Frame:
    """One ``(show T ((b) …) ((l 1) …) …)`` line; mode and teams are left to the caller."""
    frame = Frame(0, ball=np.empty(4))
    try:
        time = show.read_show(np.frombuffer(line.encode("ascii"), np.uint8), frame.ball, frame.players)
    except UnicodeEncodeError:
        time = -1
    if time < 0:
        return _parse_show(line)
    frame.time = time
    return frame


def _parse_show(line: str) -> Frame:
    """The same for a line that the kernel does not take, or what is wrong with it."""
    if "_" in line or not line.isascii():
        raise ValueError("'_' and digits of other scripts stand in no number")
    head, ball, *players = line.split(" ((")
    frame = Frame(whole(head[6:]))
    if not ball.startswith("b) "):
        raise ValueError(f"no ball but {ball[:20]!r}")
    frame.ball = np.array(ball[3:].rstrip(")").split(), dtype=np.float64)
    if frame.ball.shape != (4,):
        raise ValueError(f"{frame.ball.size} numbers of the ball instead of 4")
    if not np.isfinite(frame.ball).all():
        raise ValueError(f"a number of the ball is not finite: {ball[:40]!r}")
    rows = frame.players = empty_players()
    for text in players:
        _parse_player(rows, text)
    return frame


def _parse_player(rows: Any, text: str) -> None:
    """Fill the row of one player from ``l 1) TYPE STATE x y … (v h 120) … (c …))``."""
    motion, *parts = text.replace(")", "").split(" (")
    side, unum, kind, state, *numbers = motion.split()
    row = rows[player_row(SIDES[side], int(unum))]
    row["type"], row["state"] = int(kind), int(state, 16)
    values = [float(number) for number in numbers]
    if len(values) not in (6, 8):
        raise ValueError(f"player {side} {unum} has {len(values)} numbers instead of 6 or 8")
    if not math.isfinite(sum(values)):
        raise ValueError(f"a number of player {side} {unum} is not finite")
    row["pos"], row["vel"], row["body"], row["neck"] = values[0:2], values[2:4], values[4], values[5]
    if len(values) == 8:
        row["point"] = values[6:8]
    for part in parts:
        kind, *items = part.split()
        if kind == "v":
            row["view_quality"], row["view_width"] = 1 if items[0] == "h" else 2, float(items[1])
        elif kind == "s":
            row["stamina"], row["effort"], row["recovery"] = map(float, items[:3])
            if len(items) > 3:
                row["capacity"] = float(items[3])
        elif kind == "c":
            row["counts"][: len(items)] = items[: len(LOG_COUNTS)]
        elif kind == "fp":
            row["focus"] = float(items[0]), float(items[1])
        elif kind == "f":
            row["attention"] = player_row(SIDES[items[0]], int(items[1])) + 1
        else:
            raise ValueError(f"player {side} {unum} has an unknown part {kind!r}")
