"""From any version of game logs to any other."""

from __future__ import annotations

import datetime
import os
import re
from pathlib import Path

from ...errors import FormatError
from .binary_writer import BinaryLogWriter
from .reader import GameLogReader
from .records import RecordLogWriter
from .streams import DAMAGED, open_log, undamaged
from .writer import JSON, GameLogWriter

VERSIONS = ("1", "2", "3", "4", "5", "6", "json", "record")
"""Names of the versions that can be written."""
_RESULT = re.compile(rb"\(result (\d{12}) ")
_PIECE = 1 << 20


def convert(source: str | os.PathLike[str], target: str | os.PathLike[str], version: str | None = None) -> int:
    """Write the game of one log into another; how many frames it has.

    Parameters
    ----------
    source : path
        Of any version, plain or gzipped.
    target : path
        A name that ends in ``.gz`` is compressed.
    version : str, optional
        One of `VERSIONS`. If it is not given, ``json`` or ``record`` for a name that ends so
        (before ``.gz``), else 6.

    Raises
    ------
    FormatError
        When the source cannot be read, or there is no such version.
    CprmError
        When nothing can be written.
    """
    name = Path(target).name.removesuffix(".gz")
    version = version or next((kind for kind in ("json", "record") if name.endswith(f".{kind}")), "6")
    if version not in VERSIONS:
        raise FormatError(f"version {version!r}: allowed are {', '.join(VERSIONS)}")
    reader = GameLogReader(source)
    header = reader.header
    settings = header.parameters(), header.player_parameters(), header.types()
    count = 0
    if version in ("1", "2", "3"):
        with BinaryLogWriter(target, int(version), *settings) as old:
            for frame in reader:
                old.write(frame)
                count += 1
        return count
    date = _played(reader.path)
    writer: GameLogWriter | RecordLogWriter
    if version == "record":
        writer = RecordLogWriter(target, *settings, teams=("", ""), date=date)
    else:
        writer = GameLogWriter(target, *settings, teams=("", ""), version=JSON if version == "json" else int(version), date=date)
    with writer:
        for frame in reader:
            frame.messages = tuple(message for message in frame.messages if not message.text.startswith("(result "))
            writer.teams = frame.left.name, frame.right.name
            writer.write(frame)
            count += 1
    return count


def _played(path: Path) -> datetime.datetime | None:
    """When the game was played, by the result at the end of its log; None where it has none."""
    said, before = None, b""
    with open_log(path) as stream:
        try:
            while piece := stream.read(_PIECE):
                for found in _RESULT.finditer(before + piece):
                    said = found[1]
                before = piece[-64:]
        except DAMAGED as error:
            raise undamaged(path, error) from error
    try:
        return datetime.datetime.strptime(said.decode() + "+0000", "%Y%m%d%H%M%z") if said else None
    except ValueError:
        return None
