"""Compiled kernels: one set of compiler flags, a cache that is never stale, one announcement.

Numba's disk cache notices a change in a kernel's own file but not in a file whose function the kernel calls (numba issue 1833).
Therefore a kernel keeps its cache in a folder named by the content of its own file and of *all* files of its package that it imports,
directly or not: an edited kernel and those that use it land in a new folder and are compiled again, the others are loaded, also by
another copy of the package. Where these folders are, and who may write them, is decided in `kernel_cache`.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import config as _config
from numba.core import event, types

from .kernel_cache import KernelCache, cache_root, remove_stale, say

config: Any = _config

IMPORT = re.compile(r"^[ \t]*(?:from[ \t]+(\.*)([\w.]*)[ \t]+)?import[ \t]+(\([^)]*\)|[^\n;]+)", re.MULTILINE)
"""An import as it is written: its leading dots, its module, its names. Read thus, a package takes a hundredth of the time of parsing it;
what looks like an import in a text counts as one, which costs nothing but a key that changes too often."""

_announced = False


def content_key(files: Iterable[Path]) -> str:
    """Hex digest of the contents of `files`, the numba version and the Python version."""
    digest = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]}".encode())
    for file in sorted(files):
        digest.update(file.name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


@cache
def imports(file: Path) -> frozenset[Path]:
    """The files of its own package (outside of packages: of its own folder) that `file` imports."""
    top = file.parent
    while (top / "__init__.py").exists():
        top = top.parent
    home = file.relative_to(top).parts[0] if top != file.parent else ""
    found: set[Path] = set()
    for dots, module, names in IMPORT.findall(file.read_text(encoding="utf-8")):
        named = [words[0] for name in re.sub(r"#.*", "", names).strip("()").split(",") if (words := name.split())]
        if dots or module:
            base = (file.parents[len(dots) - 1] if dots else top).joinpath(*module.split("."))
            found |= {path for name in named for path in _files(base / name) or _files(base)}
        else:
            found |= {path for name in named for path in _files(top.joinpath(*name.split(".")))}
    return frozenset(path for path in found if (path.is_relative_to(top / home) if home else path.parent == top))


def _files(module: Path) -> set[Path]:
    """The file of a module or package, if it is there."""
    return {path for path in (module.with_name(module.name + ".py"), module / "__init__.py") if path.is_file()}


def import_closure(file: Path) -> set[Path]:
    """`file` and the files of its package that it imports, directly or through each other."""
    found, todo = {file}, [file]
    while todo:
        fresh = imports(todo.pop()) - found
        found |= fresh
        todo += fresh
    return found


@cache
def _key(source: str) -> str:
    return content_key(import_closure(Path(source).resolve()))


def kernel_group(*, side_by_side: bool = False, **flags: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator like ``numba.njit(cache=True)`` whose cache depends on every file of the package that the kernel's file imports.

    Parameters
    ----------
    side_by_side : bool
        Let the compiler make one instruction of several equal ones on neighbouring numbers, written out one after the other (numba's
        ``NUMBA_SLP_VECTORIZE``, for these kernels alone). Results are the same to the last bit.
    **flags
        Passed on to ``numba.njit`` (``parallel=True`` for example). ``fastmath`` is refused: results must be reproducible.
    """
    if flags.get("fastmath"):
        raise ValueError("fastmath would make results depend on the machine; kernels are compiled without it")
    # numba's index does not tell the flags apart: a version without a way in from Python must not be loaded for Python to call
    kind = "".join(f"-{name}" for name in sorted(flags) if flags[name]) + "-side_by_side" * side_by_side

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(nogil=True, error_model="numpy", **flags)(function)
        root = cache_root()
        if root is not None and not config.DISABLE_JIT:
            dispatcher._cache = KernelCache(function, root / "kernels" / (_key(function.__code__.co_filename) + kind))
        return _widen_integers(_side_by_side(dispatcher) if side_by_side else dispatcher)

    return decorate


def _side_by_side(dispatcher: Any) -> Any:
    """Compile a kernel with numba's setting for neighbouring instructions, which is read when code is made."""
    if config.DISABLE_JIT:
        return dispatcher
    compile_as_set = dispatcher.compile

    def compile_so(signature: Any) -> Any:
        before, config.SLP_VECTORIZE = config.SLP_VECTORIZE, 1
        try:
            return compile_as_set(signature)
        finally:
            config.SLP_VECTORIZE = before

    dispatcher.compile = compile_so
    return dispatcher


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
            root = cache_root()
            say("compiling kernels, once; later runs load them from the cache ..." if root else "compiling kernels ...")
            if root:
                remove_stale(root)

    def on_end(self, data: event.Event) -> None:
        """Nothing to say when a kernel is done."""


event.register("numba:compile", _Announcement())
