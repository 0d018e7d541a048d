"""The compiled half of the simulator: functions over one `WORLD` record ``w`` and one `PARAMETERS` record ``p``.

Kernels compute, objects remember: a kernel changes the record in place or returns scalars. It allocates nothing, checks no
arguments and draws only from the counter-based streams of `random`. All kernels share one decorator, so that editing one
compiles those that depend on it again (see `cprm_gym.compilation`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, wraps
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from ...compilation import kernel_group

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


def kernel(function: Callable[..., Any]) -> Any:
    """``numba.njit`` with the package's flags and a cache keyed by every file that the kernel depends on."""
    dispatcher = numba.njit(nogil=True, error_model="numpy")(function)
    if not isinstance(dispatcher, CPUDispatcher):
        return _interpreted(function)
    dispatcher.__class__ = Kernel
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
