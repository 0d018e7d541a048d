"""Controllers by name: the entry-point group ``cprm_gym.controllers``.

`cprm_baselines` and a user's own package register theirs the same way::

    [project.entry-points."cprm_gym.controllers"]
    mine = "my_package.my_module:make_controller"

where ``make_controller(task, agent)`` returns a `cprm_gym.envs.controller.Controller`. Options of a factory stand behind its name,
``cprm:t_b=5:latency=5``, wherever a controller is named.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Sequence
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ..envs.controller import ControllerFactory
from ..errors import ControllerError, ParameterError, unknown_name

GROUP = "cprm_gym.controllers"


def controller_entries() -> dict[str, EntryPoint]:
    """All registered controllers, unloaded, by name in alphabetical order."""
    found = {entry.name: entry for entry in entry_points(group=GROUP)}
    return dict(sorted(found.items()))


def load_controller(name: str) -> ControllerFactory:
    """The factory registered under `name`, with the options that stand behind it.

    Raises
    ------
    UnknownName
        Listing the names there are.
    ControllerError
        When the registered code cannot be imported; the message says where it is registered and why it failed.
    ParameterError
        For options that are none, or that the factory does not take.
    """
    name, options = split_options(name)
    entries = controller_entries()
    if name not in entries:
        raise unknown_name("controller", name, entries)
    entry = entries[name]
    try:
        factory: ControllerFactory = entry.load()
    except Exception as error:
        raise ControllerError(f"controller {name!r}: {entry.value} cannot be loaded: {type(error).__name__}: {error}") from error
    if not options:
        return factory
    taken = inspect.signature(factory).parameters.values()
    if not any(p.kind is p.VAR_KEYWORD for p in taken):
        for option in options:
            if option not in [p.name for p in taken][2:]:
                known = ", ".join([p.name for p in taken][2:]) or "none"
                raise ParameterError(f"controller {name!r} has no option {option!r}; it has {known}")
    return functools.partial(factory, **options)


def split_options(name: str) -> tuple[str, dict[str, Any]]:
    """A controller's name, and the options that stand behind it: whole numbers, ``true`` and ``false``, or text.

    Raises
    ------
    ParameterError
        For what is no option.
    """
    name, *given = name.split(":")
    options: dict[str, Any] = {}
    for text in given:
        option, sign, value = text.partition("=")
        if not option.isidentifier() or not sign or not value or option in options:
            raise ParameterError(f"controller {name!r}: {text!r} is no option; they are written {name}:option=value, each once")
        plain = value.lstrip("-")
        options[option] = int(value) if plain.isdecimal() and plain.isascii() else {"true": True, "false": False}.get(value, value)
    return name, options


def with_options(names: Sequence[str], **options: Any) -> tuple[str, ...]:
    """Names of controllers in which those of the architecture, ``cprm``, have these options; None is no option.

    Raises
    ------
    ParameterError
        When none of them is.
    """
    given = {option: value for option, value in options.items() if value is not None}
    text = "".join(f":{option}={value}" for option, value in given.items())
    if text and not any(split_options(name)[0] == "cprm" for name in names):
        raise ParameterError(f"{', '.join(given)}: of the controller 'cprm'; named are {', '.join(names) or 'none'}")
    return tuple(name + text if split_options(name)[0] == "cprm" else name for name in names)
