"""Compiled kernels: one set of compiler flags, a cache that is never stale, one announcement.

Numba's disk cache notices a change in a kernel's own file but not in a file whose function the kernel calls (numba issue 1833).
Therefore a kernel keeps its cache in a directory named by the content of its own file and of *all* files of its group that it
imports, directly or not: an edited kernel and those that use it land in a new directory and are compiled again, the others are loaded.
"""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numba
from numba.core import config as _config
from numba.core import event, types

config: Any = _config

_announced = False


def cache_root() -> Path:
    """Directory under which the compiled kernels are kept.

    ``$CPRM_GYM_CACHE`` if set, else ``$XDG_CACHE_HOME/cprm_gym`` or ``~/.cache/cprm_gym``; the temporary directory if that
    cannot be written.
    """
    given = os.environ.get("CPRM_GYM_CACHE")
    root = Path(given) if given else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "cprm_gym"
    try:
        root.mkdir(parents=True, exist_ok=True)
        if os.access(root, os.W_OK):
            return root
    except OSError:
        pass
    return Path(tempfile.gettempdir()) / "cprm_gym_cache"


def content_key(files: Iterable[Path]) -> str:
    """Hex digest of the contents of `files`, the numba version and the Python version."""
    digest = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]}".encode())
    for file in sorted(files):
        digest.update(file.name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def import_closure(file: Path, group: Iterable[Path]) -> list[Path]:
    """`file` and the files of `group` that it imports, directly or through each other.

    Modules are recognised by their last name, so two files of one group must not share one.
    """
    by_stem = {path.stem: path for path in group}
    found, todo = {file}, [file]
    while todo:
        for node in ast.walk(ast.parse(todo.pop().read_text(encoding="utf-8"))):
            names: list[str] = []
            if isinstance(node, ast.ImportFrom):
                names = [(node.module or "").rpartition(".")[2], *(alias.name for alias in node.names)]
            elif isinstance(node, ast.Import):
                names = [alias.name.rpartition(".")[2] for alias in node.names]
            for path in (by_stem[name] for name in names if name in by_stem):
                if path not in found:
                    found.add(path)
                    todo.append(path)
    return sorted(found)


def kernel_group(*paths: str | Path, **flags: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator like ``numba.njit(cache=True)`` whose cache depends on every file in `paths` that the kernel's file imports.

    Parameters
    ----------
    *paths : path
        The files, or directories of ``*.py`` files, whose functions call each other.
    **flags
        Passed on to ``numba.njit`` (``parallel=True`` for example). ``fastmath`` is refused: results must be reproducible.
    """
    if flags.get("fastmath"):
        raise ValueError("fastmath would make results depend on the machine; kernels are compiled without it")
    files: list[Path] = []
    for path in map(Path, paths):
        files += path.glob("*.py") if path.is_dir() else [path]
    group = [file.resolve() for file in files]
    keys: dict[str, str] = {}
    # numba's index does not tell the flags apart: a version without a way in from Python must not be loaded for Python to call
    kind = "".join(f"-{name}" for name in sorted(flags) if flags[name])

    def decorate(function: Callable[..., Any]) -> Any:
        source = function.__code__.co_filename
        if source not in keys:
            keys[source] = content_key(import_closure(Path(source).resolve(), group)) + kind
        previous = config.CACHE_DIR
        config.CACHE_DIR = str(cache_root() / "kernels" / keys[source])
        try:
            return _widen_integers(numba.njit(cache=True, nogil=True, error_model="numpy", **flags)(function))
        finally:
            config.CACHE_DIR = previous

    return decorate


def _plain(kind: types.Type) -> types.Type:
    """`kind` as a type of arguments: constants lose their value, whole numbers become int64 (uint64 stays)."""
    kind = types.unliteral(kind)
    return types.int64 if isinstance(kind, types.Integer) and kind != types.uint64 else kind


def _widen_integers(dispatcher: Any) -> Any:
    """Let compiled callers share one version of a kernel: numba would compile one for each constant and width of integer."""
    if config.DISABLE_JIT:  # then it is the plain function
        return dispatcher
    template = dispatcher.get_call_template

    def get_call_template(args: Iterable[types.Type], kws: dict[str, types.Type]) -> Any:
        return template(tuple(map(_plain, args)), {name: _plain(kind) for name, kind in kws.items()})

    dispatcher.get_call_template = get_call_template
    return dispatcher


class _Announcement(event.Listener):  # type: ignore[misc]
    """Says once per process, on the error stream, that one of our kernels is being compiled."""

    def on_start(self, data: event.Event) -> None:
        global _announced
        module = getattr(data.data["dispatcher"].py_func, "__module__", "")
        if not _announced and module.startswith("cprm_gym"):
            _announced = True
            if os.environ.get("CPRM_GYM_QUIET") != "1":
                print("cprm_gym: compiling kernels, once; later runs load them from the cache ...", file=sys.stderr, flush=True)

    def on_end(self, data: event.Event) -> None:
        """Nothing to say when a kernel is done."""


event.register("numba:compile", _Announcement())
