"""Files that are there whole or not at all."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from .errors import CprmError


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
