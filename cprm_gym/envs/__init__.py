"""The soccer world as Gymnasium and PettingZoo environments.

``soccer_v0`` is the PettingZoo module (`parallel_env`, `env`, `raw_env`); Gymnasium ids are ``cprm/<Task>-v0``.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

__all__ = ["soccer_v0"]


def __getattr__(name: str) -> ModuleType:
    """``soccer_v0`` is loaded when it is first used: registering environments must not load the simulator."""
    if name == "soccer_v0":
        return import_module(".soccer", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
