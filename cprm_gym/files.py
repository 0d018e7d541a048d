"""Files that are there whole or not at all."""

from __future__ import annotations

import os
import secrets
from pathlib import Path


def hidden_beside(path: Path) -> Path:
    """A name for what `path` is written to before it is complete: in the same folder, not taken."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.incomplete")


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
