"""Every net that ships with the package, by name."""

from __future__ import annotations

import pkgutil
from importlib import import_module

from ..architecture.petri import PetriNet
from ..errors import unknown_name
from . import skills
from .registry import AGENTS, OTHER_SIDE


def shipped_nets() -> dict[str, PetriNet]:
    """The skills and the agents' nets: each module of `skills` gives the nets that it defines, each agent its own.

    Returns
    -------
    dict of str to PetriNet
        By the net's name, in alphabetical order.
    """
    modules = [f"{skills.__name__}.{found.name}" for found in pkgutil.iter_modules(skills.__path__)]
    agents = sorted({*AGENTS.values(), *OTHER_SIDE.values()})
    modules += [f"{__package__}.{agent}" for agent in (*agents, "outfielder.agent", "attacker.agent")]
    nets: dict[str, PetriNet] = {}
    for module in modules:
        for value in vars(import_module(module)).values():
            if isinstance(value, PetriNet):
                nets[value.name] = value
    return dict(sorted(nets.items()))


def shipped_net(name: str) -> PetriNet:
    """The net of that name.

    Raises
    ------
    UnknownName
        Listing the nets there are.
    """
    nets = shipped_nets()
    if name not in nets:
        raise unknown_name("net", name, nets)
    return nets[name]
