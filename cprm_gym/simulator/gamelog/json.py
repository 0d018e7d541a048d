"""JSON game logs (version -1): one array, one object per line (specification/protocol.md 11.1)."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ..state import PlayMode
from .frames import LOG_COUNTS, SIDES, Clock, Frame, GameLogHeader, Message, Team, empty_players, player_row
from .text import MODES

_DECODER = json.JSONDecoder(strict=False)
_LONGEST = 1 << 20
_GAP = ", \t\r\n\0"
_REMARKS = {"version", "timestamp"}


class JsonParser:
    """Reads one JSON log from `stream`; the header at once, the frames on demand."""

    def __init__(self, path: Path, stream: io.BufferedReader) -> None:
        self.path = path
        self.trailing: tuple[Message, ...] = ()
        self.header = GameLogHeader(-1)
        self._line_number = 0
        self._stream = stream
        self._items = self._read_items()
        self._pending: tuple[str, Any] | None = None
        self._read_header()

    def _error(self, what: str) -> FormatError:
        return FormatError(f"{self.path}, line {self._line_number}: {what}")

    def _read_items(self) -> Iterator[tuple[str, Any]]:
        """Name and content of every object; objects may span lines or share one."""
        text, opened = "", False
        try:
            for raw in self._stream:
                self._line_number += 1
                text += raw.decode("utf-8", "surrogateescape")
                if not opened:
                    text = text.lstrip().removeprefix("[")
                    opened = True
                at = 0
                while (at := _after_gap(text, at)) < len(text) and text[at] != "]":
                    try:
                        item, end = _DECODER.raw_decode(text, at)
                    except json.JSONDecodeError as error:
                        at_end = error.pos >= len(text.rstrip()) - 1 or error.msg.startswith("Unterminated")
                        if at_end and len(text) - at < _LONGEST:
                            break
                        raise self._error(f"not JSON: {error.msg} at {text[error.pos : error.pos + 20]!r}") from error
                    if not isinstance(item, dict) or len(item) != 1:
                        raise self._error(f"an object with one name was expected, got {str(item)[:40]!r}")
                    at = end
                    yield next(iter(item.items()))
                text = text[at:]
        except (OSError, EOFError) as error:
            raise self._error(f"cannot be decompressed: {error}") from error
        if text.strip(_GAP + "]"):
            raise self._error(f"ends inside an object: {text[:40]!r}")

    def _read_header(self) -> None:
        header = self.header
        for name, content in self._items:
            if name in ("server_param", "player_param", "player_type"):
                try:
                    header.add(name, content)
                except ValueError as error:
                    raise self._error(f"{name} cannot be read: {error}") from None
            elif name in _REMARKS:
                header.remarks[name] = str(content)
            else:
                self._pending = (name, content)
                return

    def frames(self) -> Iterator[Frame]:
        """The frames in order, each with the messages written since the frame before."""
        clock = Clock()
        mode, teams = PlayMode.null, (Team(), Team())
        messages: list[Message] = []
        item = self._pending
        while item is not None:
            name, content = item
            try:
                if name == "show":
                    frame = _frame(content)
                    clock.tick(frame.time)
                    frame.stoppage = int(content.get("stime", clock.stoppage))
                    frame.mode, (frame.left, frame.right), frame.messages = mode, teams, tuple(messages)
                    messages = []
                    yield frame
                elif name == "playmode":
                    if content["mode"] not in MODES:
                        raise self._error(f"unknown play mode {content['mode']!r}")
                    mode = MODES[content["mode"]]
                elif name == "team":
                    teams = _team(content["l"]), _team(content["r"])
                elif name == "msg":
                    stime = int(content.get("stime", 0))
                    messages.append(Message(int(content["time"]), int(content["board"]), str(content["message"]), stime))
                elif name != "team_graphic":
                    raise self._error(f"unknown item {name!r}; expected show, playmode, team, msg or team_graphic")
            except (ValueError, KeyError, TypeError) as error:
                if isinstance(error, FormatError):
                    raise
                raise self._error(f"{name} cannot be read ({type(error).__name__}: {error})") from error
            item = next(self._items, None)
        self.trailing = tuple(messages)


def _after_gap(text: str, at: int) -> int:
    """Where the next item begins, from `at` on."""
    while at < len(text) and text[at] in _GAP:
        at += 1
    return at


def _team(content: dict[str, Any]) -> Team:
    return Team(content.get("name") or "", int(content["score"]), int(content.get("pen_score", 0)), int(content.get("pen_miss", 0)))


def _frame(content: dict[str, Any]) -> Frame:
    frame = Frame(int(content["time"]))
    ball = content["ball"]
    frame.ball = np.array([ball["x"], ball["y"], ball["vx"], ball["vy"]], dtype=np.float64)
    rows = frame.players = empty_players()
    for player in content["players"]:
        row = rows[player_row(SIDES[player["side"]], player["unum"])]
        row["type"], row["state"] = player["type"], player["state"]
        row["pos"], row["vel"] = (player["x"], player["y"]), (player["vx"], player["vy"])
        row["body"], row["neck"] = player["body"], player["neck"]
        if "px" in player:
            row["point"] = player["px"], player["py"]
        row["view_quality"], row["view_width"] = 1 if player["vq"] == "h" else 2, player["vw"]
        if "fdist" in player:
            row["focus"] = player["fdist"], player["fdir"]
        for name in ("stamina", "effort", "recovery", "capacity"):
            if name in player:
                row[name] = player[name]
        if "fside" in player:
            row["attention"] = player_row(SIDES[player["fside"]], player["fnum"]) + 1
        row["counts"] = [player.get(name, -1) for name in LOG_COUNTS]
    return frame
