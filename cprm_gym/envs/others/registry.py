"""Players by name: scripted ones, and controllers, which are in the entry-point group ``cprm_gym.controllers``.

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
from typing import Any, TypeAlias

from ...errors import ControllerError, ParameterError, UnknownName, unknown_name
from ..controller import ControllerFactory
from ..players.scripted import POLICIES

GROUP = "cprm_gym.controllers"
OtherPlayer: TypeAlias = "str | ControllerFactory"
"""Who plays beside the agents: a scripted policy, a controller by name, or what makes controllers."""


def controller_entries() -> dict[str, EntryPoint]:
    """All registered controllers, unloaded, by name in alphabetical order."""
    found = {entry.name: entry for entry in entry_points(group=GROUP)}
    return dict(sorted(found.items()))


def other_player(given: OtherPlayer) -> str | tuple[str, ControllerFactory]:
    """A scripted policy's name, or the name and factory of a controller.

    A name that is both, ``random``, is the scripted policy.

    Raises
    ------
    UnknownName
        For a name that is neither, or what is no name and makes nothing; the message lists what there is.
    ControllerError, ParameterError
        As for `load_controller`.
    """
    if isinstance(given, str):
        if given in POLICIES:
            return given
        if split_options(given)[0] not in controller_entries():
            raise unknown_name("scripted policy or controller", given, {**dict.fromkeys(POLICIES), **controller_entries()})
        return given, load_controller(given)
    if not callable(given):
        raise UnknownName(f"others: expected the name of a player or a factory of controllers, got {type(given).__name__} {given!r:.60}")
    return getattr(given, "__name__", type(given).__name__), given


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
