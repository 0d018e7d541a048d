"""Command logs (``.rcl``): every datagram the server received, in order, and what it announced (specification/protocol.md 11.2)."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from ...errors import FormatError
from ...files import AtomicFile
from .streams import LONGEST_ITEM, beginning, open_log, read_lines

_LINE = re.compile(r"(-?\d{1,10}),(\d{1,10})\t(.*)\Z", re.DOTALL)
_RECEIVED = re.compile(r"Recv (.+?): (.*)\Z", re.DOTALL)
_PLAYER = re.compile(r"(.+)_(\d{1,2})\Z")


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line: the server's clock when it was written, and its text."""

    time: int
    stoppage: int
    text: str

    @property
    def sender(self) -> str | None:
        """``Left_1``, ``Coach`` (the trainer) or ``Left_Coach`` for a received datagram, else None."""
        found = _RECEIVED.match(self.text)
        return found[1] if found else None

    @property
    def command(self) -> str | None:
        """The text of a received datagram, else None."""
        found = _RECEIVED.match(self.text)
        return found[2] if found else None

    @property
    def player(self) -> tuple[str, int] | None:
        """Team name and uniform number, for a player's datagram."""
        sender = self.sender
        found = _PLAYER.match(sender) if sender else None
        return (found[1], int(found[2])) if found else None

    @property
    def referee(self) -> str | None:
        """What the referee announced, for such a line."""
        return self.text[9:-1] if self.text.startswith("(referee ") and self.text.endswith(")") else None

    def __str__(self) -> str:
        return f"{self.time},{self.stoppage}\t{self.text}"


def _line(found: re.Match[str], parts: list[str]) -> LogLine:
    return LogLine(int(found[1]), int(found[2]), "\n".join(parts))


class CommandLogReader:
    """Reads a command log lazily: iterate it for its lines, or `cycles` for the lines of one think phase at a time.

    Parameters
    ----------
    path : path
        A ``.rcl`` file, plain or gzipped.

    Raises
    ------
    FormatError
        While iterating, for a line that is none; the message has the file and the line's number.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        with open_log(self.path) as stream:
            start = beginning(self.path, stream, 1)
        if start and not (start.isdigit() or start == b"-"):
            raise FormatError(f"{self.path}: not a command log: it begins with {start!r}, not with 'TIME,STOPPAGE'")

    def __iter__(self) -> Iterator[LogLine]:
        """The lines in order. A datagram that contains line breaks is one line here."""
        found: re.Match[str] | None = None
        parts: list[str] = []
        size = 0
        with open_log(self.path) as stream:
            for number, raw in enumerate(read_lines(self.path, stream), 1):
                text = raw.decode("utf-8", "surrogateescape").removesuffix("\n").removesuffix("\r")
                begins = _LINE.match(text)
                if begins is None and found is None:
                    raise FormatError(f"{self.path}, line {number}: expected TIME,STOPPAGE and a tabulator, got {text[:60]!r}")
                if begins is not None:
                    if found is not None:
                        yield _line(found, parts)
                    found, parts, size = begins, [begins[3].rstrip("\0")], 0
                    continue
                size += len(text) + 1
                if size > LONGEST_ITEM:
                    raise FormatError(f"{self.path}, line {number}: a datagram of more than {LONGEST_ITEM} bytes")
                parts.append(text)
        if found is not None:
            yield _line(found, parts)

    def cycles(self) -> Iterator[tuple[tuple[int, int], list[LogLine]]]:
        """``(time, stoppage)`` and the lines written at that clock, in order."""
        for clock, lines in itertools.groupby(self, key=lambda line: (line.time, line.stoppage)):
            yield clock, list(lines)


class CommandLogWriter:
    """Writes a command log. Use it in a ``with`` block: the file appears when the block ends, and not at all if it fails.

    Parameters
    ----------
    path : path
        Name of the file, usually ending in ``.rcl``, or ``.rcl.gz`` to compress.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file = AtomicFile(path)

    def received(self, time: int, stoppage: int, sender: str, command: str) -> None:
        """A datagram from `sender` (``Left_1``, ``Coach``, ``Left_Coach``)."""
        self.line(LogLine(time, stoppage, f"Recv {sender}: {command}"))

    def referee(self, time: int, stoppage: int, announcements: Iterable[str]) -> None:
        """What the referee said."""
        for name in announcements:
            self.line(LogLine(time, stoppage, f"(referee {name})"))

    def line(self, line: LogLine) -> None:
        """Any line."""
        self._file.write(f"{line}\n")

    def close(self) -> None:
        """Finish the file."""
        self._file.close()

    def __enter__(self) -> CommandLogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if kind is None:
            self._file.close()
        else:
            with contextlib.suppress(OSError):
                self._file.abort()
