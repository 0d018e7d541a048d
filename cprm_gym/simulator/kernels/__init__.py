"""The compiled half of the simulator: functions over one `WORLD` record ``w`` and one `PARAMETERS` record ``p``.

Kernels compute, objects remember: a kernel changes the record in place or returns scalars. It allocates nothing, checks no
arguments and draws only from the counter-based streams of `random`. All kernels share one decorator, so that editing one
compiles those that depend on it again (see `cprm_gym.compilation`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, wraps
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from ...compilation import kernel_group
from ..packing import NO_REFEREE

_entry = kernel_group()
_callee = kernel_group(no_cpython_wrapper=True, no_cfunc_wrapper=True)


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A kernel, compiled for other kernels when one of them calls it, and with a way in when Python calls it.

    Most of some 250 kernels are never called from Python. Leaving out their wrappers, and looking for their cache files only when
    they have to be compiled, saves a quarter of the time of compilation and more than a second of every import.
    """

    @cached_property
    def entry(self) -> Any:
        """What Python calls."""
        return _entry(self.py_func)

    @cached_property
    def callee(self) -> Any:
        """What kernels call."""
        return _callee(self.py_func)

    def __call__(self, *args: Any) -> Any:
        return self.entry(*args)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return self.callee.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        return self.callee.get_overload(sig)


class Event(Kernel):
    """A kernel that tells the referee something: left out where the parameters are of the type `NO_REFEREE`.

    Such a caller is compiled for that type of its own, without the ten modules of the referee behind this one call: more than a third of
    the work of compiling a step, which drills, that have no rules, need not wait for.
    """

    @cached_property
    def silence(self) -> Any:
        """What kernels call where there is no referee."""
        return _callee(_SILENCE[self.py_func.__code__.co_argcount])

    def _version(self, args: Any) -> Any:
        return self.silence if args[1] == _no_referee() else self.callee

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return self._version(args).get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        return self._version(sig if isinstance(sig, tuple) else sig.args).get_overload(sig)


@cache
def _no_referee() -> Any:
    return numba.from_dtype(NO_REFEREE)


def _silent_2(w, p):  # type: ignore[no-untyped-def]
    """Nobody listens."""


def _silent_3(w, p, i):  # type: ignore[no-untyped-def]
    """Nobody listens."""


def _silent_4(w, p, i, a):  # type: ignore[no-untyped-def]
    """Nobody listens."""


def _silent_5(w, p, i, a, b):  # type: ignore[no-untyped-def]
    """Nobody listens."""


_SILENCE = {2: _silent_2, 3: _silent_3, 4: _silent_4, 5: _silent_5}


def event(function: Callable[..., Any]) -> Any:
    """`kernel` for what the referee is told, ``(w, p, ...)``: nothing at all where the parameters are of the type `NO_REFEREE`."""
    return _dispatcher(function, Event)


def kernel(function: Callable[..., Any]) -> Any:
    """``numba.njit`` with the package's flags and a cache keyed by every file that the kernel depends on."""
    return _dispatcher(function, Kernel)


def _dispatcher(function: Callable[..., Any], kind: type[Kernel]) -> Any:
    dispatcher = numba.njit(nogil=True, error_model="numpy")(function)
    if not isinstance(dispatcher, CPUDispatcher):
        return _interpreted(function)
    dispatcher.__class__ = kind
    return dispatcher


def _interpreted(function: Callable[..., Any]) -> Callable[..., Any]:
    """`function` as plain Python, for ``NUMBA_DISABLE_JIT=1``: records get attributes, and hashes overflow on purpose."""

    @wraps(function)
    def run(*args: Any) -> Any:
        if not any(type(a) is np.ndarray and a.dtype.names for a in args):
            return function(*args)
        with np.errstate(over="ignore"):
            return function(*(a.view(np.recarray) if type(a) is np.ndarray and a.dtype.names else a for a in args))

    return run
