"""Extended Petri nets."""

from .compiled import UNBOUNDED, Arcs, CompiledNet, Memory, PlaceKind, compile_net
from .modules import Instance, flatten, instances
from .net import PetriNet
from .places import (
    INFINITE,
    AnyPlace,
    Belief,
    Command,
    Continuous,
    Input,
    Math,
    ObjectPlace,
    Place,
    Ports,
    Selection,
    Semantics,
    Transition,
)
from .values import FrozenMap

__all__ = [
    "INFINITE",
    "UNBOUNDED",
    "AnyPlace",
    "Arcs",
    "Belief",
    "Command",
    "CompiledNet",
    "Continuous",
    "FrozenMap",
    "Input",
    "Instance",
    "Math",
    "Memory",
    "ObjectPlace",
    "PetriNet",
    "Place",
    "PlaceKind",
    "Ports",
    "Selection",
    "Semantics",
    "Transition",
    "compile_net",
    "flatten",
    "instances",
]
