"""Where compiled kernels are kept on disk, by whom they may be read, and what happens when they cannot be.

What numba keeps are pickles, so whoever can write them can run code as their reader. They are therefore read from nowhere but a folder
that belongs to this user (or to the administrator) and that nobody else can write:

* the folder that ``CPRM_GYM_CACHE`` names (an empty text names none); one that cannot be used is an error;
* else ``$XDG_CACHE_HOME/cprm_gym``, ``~/.cache/cprm_gym``, or a folder of this user under the temporary directory, whichever is safe first;
* else none: kernels are compiled anew in every process, which is said once.

A folder that can only be read is used as it is. Kernels of versions that nobody has used for a month are removed when others are
compiled. A full disk or a damaged file costs a compilation, never the run: what is kept is
written whole, with a checksum.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching

from .errors import CacheError

VARIABLE = "CPRM_GYM_CACHE"
STALE = 30.0
"""Days after which kernels that nobody has used are removed."""
DIGEST = hashlib.sha256().digest_size


def say(message: str) -> None:
    """Tell on the error stream, unless ``CPRM_GYM_QUIET`` is 1."""
    if os.environ.get("CPRM_GYM_QUIET") != "1":
        print(f"cprm_gym: {message}", file=sys.stderr, flush=True)


@cache
def _say_once(message: str) -> None:
    say(message)


# -------------------------------------------------------------------------------------------------- the folder


def cache_root() -> Path | None:
    """Folder under which compiled kernels are kept, or None where there is no safe one.

    Raises
    ------
    CacheError
        When ``CPRM_GYM_CACHE`` names a folder that cannot be used; the message says why.
    """
    given = os.environ.get(VARIABLE)
    return _root(given or None, os.environ.get("XDG_CACHE_HOME"), os.environ.get("HOME"))


@cache
def _root(given: str | None, xdg: str | None, home: str | None) -> Path | None:
    if given is not None:
        try:
            return _private(Path(given).expanduser())
        except (OSError, RuntimeError, ValueError) as error:
            raise CacheError(f"{VARIABLE}={given!r}: {_reason(error)}; name a folder of your own that only you can write") from None
    reasons = []
    for candidate in _candidates(xdg):
        try:
            return _private(candidate)
        except (OSError, RuntimeError, ValueError) as error:
            reasons.append(f"{candidate}: {_reason(error)}")
    _say_once("compiled kernels are not kept, every process compiles them anew: " + "; ".join(reasons))
    return None


def _candidates(xdg: str | None) -> Iterator[Path]:
    if xdg and os.path.isabs(xdg):
        yield Path(xdg) / "cprm_gym"
    else:
        yield Path(os.path.expanduser("~")) / ".cache" / "cprm_gym"
    yield Path(tempfile.gettempdir()) / f"cprm_gym-{os.getuid() if hasattr(os, 'getuid') else os.environ.get('USERNAME', 'user')}"


def _private(root: Path) -> Path:
    """`root`, made if it is not there, once it and the folder of kernels in it are known to be safe."""
    if not root.is_absolute():
        root = Path.cwd() / root
    for folder in (root, root / "kernels"):
        try:
            folder.mkdir(mode=0o700, parents=folder is root, exist_ok=True)
        except OSError:
            if not folder.exists():  # a filled folder that can only be read has both
                raise
        _check(folder)
    return root


def _check(folder: Path) -> None:
    """Refuse a folder that somebody else could have filled."""
    link, found = os.lstat(folder), os.stat(folder)
    if not stat.S_ISDIR(found.st_mode):
        raise NotADirectoryError(f"{folder} is not a folder")
    if hasattr(os, "getuid"):
        for owner in (link.st_uid, found.st_uid):
            if owner not in (os.getuid(), 0):
                raise PermissionError(f"{folder} belongs to another user (number {owner})")
        if found.st_mode & 0o022:
            raise PermissionError(f"{folder} can be written by others (mode {stat.S_IMODE(found.st_mode):o})")
    if not os.access(folder, os.R_OK | os.X_OK):
        raise PermissionError(f"{folder} cannot be read")


def _reason(error: Exception) -> str:
    return error.strerror if isinstance(error, OSError) and error.strerror else str(error)


def remove_stale(root: Path, days: float = STALE) -> int:
    """Remove kernels that nobody has used for so many days: those of earlier versions. How many folders they were.

    Using a folder renews its time (`KernelCache`). What cannot be removed stays.
    """
    oldest, removed = time.time() - 86400.0 * days, 0
    try:
        folders = [entry for entry in os.scandir(root / "kernels") if entry.is_dir(follow_symlinks=False)]
        for entry in folders:
            if entry.stat(follow_symlinks=False).st_mtime < oldest:
                shutil.rmtree(entry.path, ignore_errors=True)
                removed += 1
    except OSError as error:
        _say_once(f"old kernels stay: {_reason(error)}")
    return removed


@cache
def _used(folder: Path) -> None:
    """Note, once per process, that a folder of kernels is in use."""
    with suppress(OSError):
        os.utime(folder)


# --------------------------------------------------------------------------------------------------- the files


class _Locator(caching._CacheLocator):  # type: ignore[misc]
    """The folder named by the contents of all files that a kernel depends on."""

    folder: Path

    def __init__(self, py_func: Any) -> None:
        self._line = py_func.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func)

    def get_cache_path(self) -> str:
        return str(self.folder)

    def ensure_cache_path(self) -> None:
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        return self.folder.name  # the contents

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Files(caching.IndexDataCacheFile):  # type: ignore[misc]
    """Index and data of one kernel; a damaged file counts as absent."""

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except Exception:  # whatever a damaged pickle raises
            return {}

    def _load_data(self, name: str) -> Any:
        content = Path(self._data_path(name)).read_bytes()
        digest, data = content[:DIGEST], content[DIGEST:]
        if hashlib.sha256(data).digest() != digest:
            raise OSError(f"{name} is damaged")
        return pickle.loads(data)

    def _save_data(self, name: str, data: Any) -> None:
        dumped = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(dumped).digest() + dumped)


@cache
def _kept_in(folder: Path) -> Any:
    """What numba calls the implementation of a cache, for one folder."""
    place = type("_Place", (_Locator,), {"folder": folder})
    return type("_Kept", (caching.CompileResultCacheImpl,), {"_locator_classes": [place]})


class KernelCache(caching.FunctionCache):  # type: ignore[misc]
    """Numba's cache of one function, in a folder of ours.

    Parameters
    ----------
    py_func : function
    folder : Path
        Named by what the kernel depends on.
    """

    def __init__(self, py_func: Any, folder: Path) -> None:
        self._impl_class = _kept_in(folder)
        super().__init__(py_func)
        _used(folder)
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, self._impl.locator.get_source_stamp())

    @contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        """Loading that fails is a miss, saving that fails is left out: a cache must never end a run."""
        try:
            yield
        except OSError as error:
            if not isinstance(error, PermissionError) and error.errno != 30:  # a folder that can only be read is no news
                _say_once(f"compiled kernels cannot be kept: {_reason(error)}")
        except (pickle.PickleError, EOFError, AttributeError, ImportError, TypeError, ValueError, KeyError, IndexError) as error:
            _say_once(f"a compiled kernel could not be taken from {self._cache_path}: {type(error).__name__}: {error}")
