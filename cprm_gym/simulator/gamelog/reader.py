"""Reading game logs of every version there is: binary 1 to 3, text 4 to 6, JSON, records; plain or gzipped, one cycle at a time."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path

from ...errors import FormatError
from .binary import BinaryParser
from .frames import Frame, GameLogHeader, Message
from .json import JsonParser
from .records import MARK, RecordParser
from .streams import beginning, open_log
from .text import TextParser


class GameLogReader:
    """Reads a game log lazily: iterate it for its frames.

    Parameters
    ----------
    path : path
        A ``.rcg`` file of any version, or one compressed by gzip; the content decides, not the name.

    Attributes
    ----------
    header : GameLogHeader
        Version, parameters and player types (empty for versions 1 and 2, which have none).

    Raises
    ------
    FormatError
        When the file is not a game log or a line cannot be read; the message has the file and the line (or byte).

    Examples
    --------
    >>> for frame in GameLogReader("match.rcg.gz"):  # doctest: +SKIP
    ...     print(frame.time, frame.mode.name, frame.ball[:2])
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        with open_log(self.path) as stream:
            self.header: GameLogHeader = _parser(self.path, stream).header

    @property
    def version(self) -> int:
        """1 to 6, -1 for JSON, 0 for records."""
        return self.header.version

    def __iter__(self) -> Iterator[Frame]:
        with open_log(self.path) as stream:
            yield from _parser(self.path, stream).frames()

    def messages(self) -> Iterator[Message]:
        """Every message of the log, those behind the last frame included."""
        with open_log(self.path) as stream:
            parser = _parser(self.path, stream)
            for frame in parser.frames():
                yield from frame.messages
            yield from parser.trailing

    def __repr__(self) -> str:
        return f"GameLogReader({str(self.path)!r}, version={self.version})"


def _parser(path: Path, stream: io.BufferedReader) -> BinaryParser | JsonParser | RecordParser | TextParser:
    """The parser for the version that the first bytes of `stream` announce."""
    start = beginning(path, stream, len(MARK))
    if start == MARK:
        return RecordParser(path, stream)
    if start[:3] == b"ULG":
        mark = start[3:4]
        if mark in (b"\x02", b"\x03"):
            stream.read(4)
            return BinaryParser(path, stream, mark[0])
        if mark in (b"4", b"5", b"6"):
            return TextParser(path, stream, int(mark))
        raise FormatError(f"{path}: game log version {mark!r} is unknown; known are 1 to 6, JSON and records")
    if start[:1] == b"[":
        return JsonParser(path, stream)
    if start[:2] in (b"\x00\x01", b"\x00\x02", b"\x00\x03"):
        return BinaryParser(path, stream, 1)
    raise FormatError(f"{path}: not a game log: it begins with {start[:4]!r}, not with 'ULG', '[' or a version 1 record")
