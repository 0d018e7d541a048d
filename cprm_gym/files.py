"""Files that are there whole or not at all."""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import math
import os
import secrets
from pathlib import Path
from typing import Any, NoReturn

from .errors import CprmError, FormatError


def hidden_beside(path: Path, ending: str = "") -> Path:
    """A name for what `path` is written to before it is complete: in the same folder, not taken, with the given ending."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.incomplete{ending}")


def check_place(path: str | os.PathLike[str], name: str) -> None:
    """See whether a file can be written, before work is done for it.

    Parameters
    ----------
    path : path
        Of the file.
    name : str
        What the caller calls it: ``record``.

    Raises
    ------
    CprmError
        When the path is a folder, its folder is not there, or nothing can be written in it.
    """
    target = Path(path)
    if target.is_dir():
        raise CprmError(f"{name} {target}: that is a folder; give the name of a file")
    if not target.parent.is_dir():
        raise CprmError(f"{name} {target}: there is no folder {target.parent}")
    probe = hidden_beside(target)
    try:
        probe.open("xb").close()
        probe.unlink()
    except OSError as error:
        raise CprmError(f"{name} {target}: cannot be written: {error.strerror or error}") from None


def read_bounded(path: str | os.PathLike[str], limit: int) -> bytes:
    """The content of a file of at most `limit` bytes.

    Raises
    ------
    FormatError
        When it cannot be read, or is larger.
    """
    try:
        with Path(path).open("rb") as stream:
            data = stream.read(limit + 1)
    except OSError as error:
        raise FormatError(f"{os.fspath(path)}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise FormatError(f"{os.fspath(path)!r}: cannot be read: {error}") from None
    if len(data) > limit:
        raise FormatError(f"{os.fspath(path)}: larger than the {limit:,} bytes that are read")
    return data


def write_atomically(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a file so that a reader sees all of the old content or all of the new one.

    Parameters
    ----------
    path : path
    content : str or bytes
        Text is written as UTF-8.
    """
    target = Path(path)
    temporary = hidden_beside(target)
    try:
        with temporary.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


class AtomicFile:
    """A file that appears under its name only when it is complete: written beside it, moved there by `close`.

    Parameters
    ----------
    path : path
        Where the file will be. A name ending in ``.gz`` is compressed.

    Raises
    ------
    CprmError
        When nothing can be written there.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._temporary = hidden_beside(self.path)
        try:
            self._raw = self._temporary.open("xb")
        except OSError as error:
            raise CprmError(f"{self.path}: cannot be written: {error.strerror or error}") from error
        packed = self.path.suffix == ".gz"
        # no name and no time in the gzip header: the same content gives the same file
        binary: Any = gzip.GzipFile(filename="", mode="wb", fileobj=self._raw, mtime=0) if packed else self._raw
        self._text = io.TextIOWrapper(binary, encoding="utf-8", errors="surrogateescape", newline="\n")

    def write(self, text: str) -> None:
        """Append `text`."""
        self._text.write(text)

    def write_bytes(self, data: bytes) -> None:
        """Append bytes as they are."""
        self._text.flush()
        self._text.buffer.write(data)

    def close(self) -> None:
        """Finish the file and move it to its place."""
        try:
            self._text.close()
            self._raw.close()
            os.replace(self._temporary, self.path)
        except BaseException:
            self.abort()
            raise

    def abort(self) -> None:
        """Forget the file; nothing appears under its name."""
        with contextlib.suppress(OSError, ValueError):
            self._text.close()
        self._raw.close()
        self._temporary.unlink(missing_ok=True)


MAX_DEPTH = 64
"""Levels to which the JSON documents of this package may be nested; none of ours has half as many."""


def parse_json(text: str, where: str) -> Any:
    """The value of a JSON text from anywhere.

    Parameters
    ----------
    text : str
    where : str
        Named in errors.

    Raises
    ------
    FormatError
        When the text is not JSON, holds a number that is not finite, or is nested more than `MAX_DEPTH` levels deep.
    """

    def refuse(constant: str) -> NoReturn:
        raise FormatError(f"{where}: not JSON: {constant} is not a number")

    try:
        value = json.loads(text, parse_constant=refuse)
    except RecursionError:
        raise FormatError(f"{where}: nested too deeply; at most {MAX_DEPTH} levels") from None
    except ValueError as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"{where}: not JSON: {error}") from None
    level, depth = [value], 0
    while level:
        level = [v.values() if isinstance(v, dict) else v for v in level if isinstance(v, dict | list)]
        if depth > MAX_DEPTH:
            raise FormatError(f"{where}: nested too deeply; at most {MAX_DEPTH} levels")
        if any(math.inf in items or -math.inf in items for items in level):
            raise FormatError(f"{where}: a number is too large")
        level, depth = [item for items in level for item in items if isinstance(item, dict | list)], depth + 1
    return value
