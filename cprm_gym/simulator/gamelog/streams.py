"""The bytes of a log: decompressed, in lines, and never more of them at once than a log can need.

Logs come from strangers, and a few kilobytes of gzip can become gigabytes. What is read is therefore bounded by the budgets here; a file
beyond one of them is refused with a `FormatError` that names it.
"""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Iterator
from pathlib import Path

from ...errors import FormatError

LONGEST_ITEM = 1 << 20
"""Bytes of one line, message or object of a log; a cycle has some 4,000 and the parameters some 10,000."""
MOST_PENDING = 1 << 23
"""Bytes of messages between two cycles."""
MOST_TYPES = 1000
"""Player types in a header."""
DAMAGED = (OSError, EOFError, zlib.error)
"""What reading a damaged compressed file raises."""


def open_log(path: Path) -> io.BufferedReader:
    """The bytes of `path`, decompressed if they begin like a gzip file."""
    try:
        stream = open(path, "rb")  # noqa: SIM115 - the caller closes it
        if stream.peek(2)[:2] != b"\x1f\x8b":
            return stream
        stream.close()
        return io.BufferedReader(gzip.open(path, "rb"))  # type: ignore[arg-type]
    except OSError as error:
        raise FormatError(f"{path}: cannot be read: {error.strerror or error}") from error


def undamaged(path: Path, error: Exception) -> FormatError:
    """The error for bytes that cannot be decompressed."""
    return FormatError(f"{path}: cannot be decompressed: {error}")


def beginning(path: Path, stream: io.BufferedReader, size: int) -> bytes:
    """The first bytes of `stream`, which stays where it is.

    Raises
    ------
    FormatError
        When they cannot be decompressed.
    """
    try:
        return stream.peek(size)[:size]
    except DAMAGED as error:
        raise undamaged(path, error) from error


def read_lines(path: Path, stream: io.BufferedReader, longest: int = LONGEST_ITEM) -> Iterator[bytes]:
    """The lines of `stream` with their line breaks.

    Raises
    ------
    FormatError
        When a line is longer than `longest` bytes, or cannot be decompressed.
    """
    number = 0
    try:
        while line := stream.readline(longest + 1):
            number += 1
            if len(line) > longest:
                raise FormatError(f"{path}, line {number}: longer than {longest} bytes, which is the most a line may have")
            yield line
    except DAMAGED as error:
        raise FormatError(f"{path}, line {number + 1}: cannot be decompressed: {error}") from error
