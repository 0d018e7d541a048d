"""Controllers by name: the entry-point group ``cprm_gym.controllers``.

`cprm_baselines` and a user's own package register theirs the same way::

    [project.entry-points."cprm_gym.controllers"]
    mine = "my_package.my_module:make_controller"

where ``make_controller(task, agent)`` returns a `cprm_gym.envs.controller.Controller`.
"""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points

from ..envs.controller import ControllerFactory
from ..errors import ControllerError, unknown_name

GROUP = "cprm_gym.controllers"


def controller_entries() -> dict[str, EntryPoint]:
    """All registered controllers, unloaded, by name in alphabetical order."""
    found = {entry.name: entry for entry in entry_points(group=GROUP)}
    return dict(sorted(found.items()))


def load_controller(name: str) -> ControllerFactory:
    """The factory registered under `name`.

    Raises
    ------
    UnknownName
        Listing the names there are.
    ControllerError
        When the registered code cannot be imported; the message says where it is registered and why it failed.
    """
    entries = controller_entries()
    if name not in entries:
        raise unknown_name("controller", name, entries)
    entry = entries[name]
    try:
        factory: ControllerFactory = entry.load()
    except Exception as error:
        raise ControllerError(f"controller {name!r}: {entry.value} cannot be loaded: {type(error).__name__}: {error}") from error
    return factory
