"""JSON game logs (version -1): one array, one object per line (specification/protocol.md 11.1)."""

from __future__ import annotations

import codecs
import io
import itertools
import json
import math
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ..state import PlayMode
from .frames import LOG_COUNTS, SIDES, Clock, Frame, GameLogHeader, Message, Pending, Team, empty_players, player_row, whole
from .kernels import show_json
from .streams import DAMAGED, LONGEST_ITEM
from .text import MODES

_PIECE = 1 << 16
_SHOW = '{"show":{'
UNTOLD = -(2**31)
"""Stoppage of a frame that does not tell it, below all that a log may hold."""


def _finite(text: str) -> float:
    """A number of JSON; ValueError for one that is not finite, as ``1e999`` and ``NaN``."""
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"a number is not finite: {text[:20]}")
    return number


_DECODER = json.JSONDecoder(strict=False, parse_float=_finite, parse_constant=_finite)
_GAP = ", \t\r\n\0"
_REMARKS = {"version", "timestamp"}


class JsonParser:
    """Reads one JSON log from `stream`; the header at once, the frames on demand."""

    def __init__(self, path: Path, stream: io.BufferedReader) -> None:
        self.path = path
        self.trailing: tuple[Message, ...] = ()
        self.header = GameLogHeader(-1)
        self._line_number, self._ended = 0, True
        self._stream = stream
        self._items = self._read_items()
        self._pending: tuple[str, Any] | None = None
        self._read_header()

    def _error(self, what: str) -> FormatError:
        return FormatError(f"{self.path}, line {self._line_number}: {what}")

    def _pieces(self) -> Iterator[str]:
        """The text in pieces of a line, or less when lines are long."""
        decoder = codecs.getincrementaldecoder("utf-8")("surrogateescape")
        try:
            while raw := self._stream.readline(_PIECE):
                self._line_number += self._ended
                self._ended = raw.endswith(b"\n")
                yield decoder.decode(raw)
        except DAMAGED as error:
            raise self._error(f"cannot be decompressed: {error}") from error

    def _read_items(self) -> Iterator[tuple[str, Any]]:
        """Name and content of every object; objects may span lines or share one.

        An object that is not complete is tried again when twice as much of it is there: each byte is looked at a few times only.
        """
        text, wanted = "", 0
        pieces = self._pieces()
        gap = next(pieces, "").lstrip().removeprefix("[")
        for piece in itertools.chain((gap,), pieces):
            if not text and piece.startswith(_SHOW):
                frame = parse_show(piece)
                if frame is not None:
                    yield "show", frame
                    continue
            text += piece
            if len(text) < wanted:
                continue
            text, wanted = yield from self._decode(text)
        text, _ = yield from self._decode(text)
        if text.strip(_GAP + "]"):
            raise self._error(f"ends inside an object: {text[:40]!r}")

    def _decode(self, text: str) -> Generator[tuple[str, Any], None, tuple[str, int]]:
        """Yields the complete objects at the beginning of `text`; returns what is left, and from which length on to try again."""
        at = 0
        while (at := _after_gap(text, at)) < len(text) and text[at] != "]":
            try:
                item, end = _DECODER.raw_decode(text, at)
            except json.JSONDecodeError as error:
                at_end = error.pos >= len(text.rstrip()) - 1 or error.msg.startswith("Unterminated")
                if not at_end:
                    raise self._error(f"not JSON: {error.msg} at {text[error.pos : error.pos + 20]!r}") from error
                if len(text) - at > LONGEST_ITEM:
                    raise self._error(f"an object of more than {LONGEST_ITEM} bytes, or one without its end") from error
                return text[at:], 2 * (len(text) - at)
            except RecursionError:
                raise self._error("objects nested too deeply") from None
            except ValueError as error:  # a number with too many digits
                raise self._error(f"not JSON: {error}") from error
            if not isinstance(item, dict) or len(item) != 1:
                raise self._error(f"an object with one name was expected, got {text[at : at + 40]!r}")
            at = end
            yield next(iter(item.items()))
        return text[at:], 0

    def _read_header(self) -> None:
        header = self.header
        for name, content in self._items:
            if name in ("server_param", "player_param", "player_type"):
                try:
                    header.add(name, content)
                except ValueError as error:
                    raise self._error(f"{name} cannot be read: {error}") from None
            elif name in _REMARKS:
                if not isinstance(content, (str, int, float)):
                    raise self._error(f"{name} is a text")
                header.remarks[name] = str(content)
            else:
                self._pending = (name, content)
                return

    def frames(self) -> Iterator[Frame]:
        """The frames in order, each with the messages written since the frame before."""
        clock = Clock()
        mode, teams = PlayMode.null, (Team(), Team())
        messages = Pending()
        item = self._pending
        while item is not None:
            name, content = item
            try:
                if name == "show":
                    frame = content if isinstance(content, Frame) else _frame(content)
                    clock.tick(frame.time)
                    if frame.stoppage == UNTOLD:
                        frame.stoppage = clock.stoppage
                    frame.mode, (frame.left, frame.right), frame.messages = mode, teams, messages.take()
                    yield frame
                elif name == "playmode":
                    if content["mode"] not in MODES:
                        raise self._error(f"unknown play mode {str(content['mode'])[:40]!r}")
                    mode = MODES[content["mode"]]
                elif name == "team":
                    teams = _team(content["l"]), _team(content["r"])
                elif name == "msg":
                    stime, text = whole(content.get("stime", 0)), content["message"]
                    if not isinstance(text, str):
                        raise ValueError(f"the message is no text but {str(text)[:40]!r}")
                    messages.add(Message(whole(content["time"]), whole(content["board"]), text, stime))
                elif name != "team_graphic":
                    raise self._error(f"unknown item {name[:40]!r}; expected show, playmode, team, msg or team_graphic")
            except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
                if isinstance(error, FormatError):
                    raise
                raise self._error(f"{name} cannot be read ({type(error).__name__}: {str(error)[:100]})") from error
            item = next(self._items, None)
        self.trailing = messages.take()


def _after_gap(text: str, at: int) -> int:
    """Where the next item begins, from `at` on."""
    while at < len(text) and text[at] in _GAP:
        at += 1
    return at


def _team(content: dict[str, Any]) -> Team:
    name = content.get("name") or ""
    if not isinstance(name, str):
        raise ValueError(f"a team's name is a text, got {str(name)[:40]!r}")
    return Team(name, whole(content["score"]), whole(content.get("pen_score", 0)), whole(content.get("pen_miss", 0)))


def _real(value: Any) -> float:
    """A number, not a text or a truth value."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"a number was expected, got {str(value)[:40]!r}")
    return float(value)


def _reals(content: dict[str, Any], *names: str) -> list[float]:
    return [_real(content[name]) for name in names]


def parse_show(line: str) -> Frame | None:
    """The frame of a line that holds its object whole and as servers write it; None for others."""
    try:
        text = np.frombuffer(bytearray(line, "ascii"), np.uint8)
    except UnicodeEncodeError:
        return None
    frame = Frame(0, UNTOLD, ball=np.empty(4))
    frame.time, stoppage, end = show_json.read_show(text, frame.ball, frame.players, np.empty(8))
    if end < 0 or line[end:].strip(_GAP):
        return None
    frame.stoppage = stoppage if stoppage >= 0 else UNTOLD
    return frame


def _frame(content: dict[str, Any]) -> Frame:
    frame = Frame(whole(content["time"]), whole(content["stime"]) if "stime" in content else UNTOLD)
    frame.ball = np.array(_reals(content["ball"], "x", "y", "vx", "vy"))
    rows = frame.players = empty_players()
    for player in content["players"]:
        row = rows[player_row(SIDES[player["side"]], whole(player["unum"]))]
        row["type"], row["state"] = whole(player["type"]), whole(player["state"])
        row["pos"], row["vel"] = _reals(player, "x", "y"), _reals(player, "vx", "vy")
        row["body"], row["neck"] = _reals(player, "body", "neck")
        if "px" in player:
            row["point"] = _reals(player, "px", "py")
        row["view_quality"], row["view_width"] = 1 if player["vq"] == "h" else 2, _real(player["vw"])
        if "fdist" in player:
            row["focus"] = _reals(player, "fdist", "fdir")
        for name in ("stamina", "effort", "recovery", "capacity"):
            if name in player:
                row[name] = _real(player[name])
        if "fside" in player:
            row["attention"] = player_row(SIDES[player["fside"]], whole(player["fnum"])) + 1
        row["counts"] = [whole(player.get(name, -1)) for name in LOG_COUNTS]
    return frame
