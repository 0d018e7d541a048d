"""Faces of packages: the names that a package offers, each loaded when it is first used (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from .errors import did_you_mean

Face = tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]


def lazy_face(package: str, homes: Mapping[str, str]) -> Face:
    """What a package's ``__init__`` needs to offer names that live in its modules.

    It is called in the ``else`` of ``if TYPE_CHECKING: from .module import Name as Name``, which type checkers and editors read; a test
    holds the two together.

    Parameters
    ----------
    package : str
        ``__name__`` of the package.
    homes : mapping of str to str
        Module, relative to the package (``"net.places"``), and the names taken from it, separated by blanks; ``""`` for submodules that are
        offered themselves.

    Returns
    -------
    (list of str, callable, callable)
        For ``__all__``, ``__getattr__`` and ``__dir__``.
    """
    home_of: dict[str, tuple[str, str]] = {}
    for module, names in homes.items():
        for name in names.split():
            home_of[name] = (f"{package}.{module}" if module else f"{package}.{name}", name if module else "")

    def load(name: str) -> Any:
        if name not in home_of:
            hint = "" if name.startswith("_") else did_you_mean(name, home_of)
            raise AttributeError(f"module {package!r} has no attribute {name!r}.{hint}")
        module, attribute = home_of[name]
        loaded = import_module(module)
        value = getattr(loaded, attribute) if attribute else loaded
        setattr(sys.modules[package], name, value)
        return value

    offered = sorted(home_of)
    return offered, load, lambda: sorted({*offered, *vars(sys.modules[package])})


def made_on_use(module: str, makers: Mapping[str, Callable[[], Any]]) -> Callable[[str], Any]:
    """A module's ``__getattr__`` for values that take time to make: each is made when it is first asked for, and then kept.

    Parameters
    ----------
    module : str
        ``__name__`` of the module.
    makers : mapping of str to callable
        Name -> what makes the value.
    """

    def load(name: str) -> Any:
        if name not in makers:
            hint = "" if name.startswith("_") else did_you_mean(name, makers)
            raise AttributeError(f"module {module!r} has no attribute {name!r}.{hint}")
        value = makers[name]()
        setattr(sys.modules[module], name, value)
        return value

    return load
