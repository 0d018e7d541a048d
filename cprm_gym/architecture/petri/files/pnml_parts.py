"""PNML (ISO/IEC 15909-2): what a file says of places and transitions, and the net that this makes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from ....errors import NetError
from ...expressions import CONSTANTS, FUNCTIONS, WORDS
from ..net.net import PetriNet
from ..net.places import AnyPlace, Place
from ..net.transitions import Transition
from .pnml_tree import Node
from .pnml_words import Words


@dataclass
class RawPlace:
    """A place as the file has it."""

    node: Node
    name: str
    tokens: int
    capacity: int | None


@dataclass
class RawTransition:
    """A transition as the file has it."""

    node: Node
    name: str
    delay: int
    priority: int
    weight: float
    inputs: dict[str, int] = field(default_factory=dict)
    outputs: dict[str, int] = field(default_factory=dict)
    tests: dict[str, int] = field(default_factory=dict)
    inhibitors: dict[str, int] = field(default_factory=dict)
    sets: dict[str, int] = field(default_factory=dict)


def build_net(
    words: Words, places: dict[str, RawPlace], transitions: dict[str, RawTransition], root: Node, title: str
) -> tuple[PetriNet, dict[str, str]]:
    """The value of what was read.

    Parameters
    ----------
    words : Words
        Makes the errors, and notes names that cannot be used.
    places, transitions : dict from id to what was read
    root : Node
        Of the net, for errors that have no closer place.
    title : str
        What the net is called.

    Returns
    -------
    PetriNet
    dict from id to the name in the net
    """
    names = _names({key: p.name for key, p in places.items()}, "places", words)
    called = _names({key: t.name for key, t in transitions.items()}, "transitions", words)
    node = root
    try:
        made: list[AnyPlace] = []
        for key, p in places.items():
            node = p.node
            made.append(Place(names[key], capacity=p.capacity, tokens=p.tokens))
        moves = []
        for key, t in transitions.items():
            node = t.node
            inputs, outputs, tests, inhibitors, sets = (
                {names[p]: w for p, w in arcs.items()} for arcs in (t.inputs, t.outputs, t.tests, t.inhibitors, t.sets)
            )
            moves.append(
                Transition(
                    called[key],
                    inputs,
                    outputs,
                    tests=tests,
                    inhibitors=inhibitors,
                    sets=sets,
                    delay=t.delay,
                    priority=t.priority,
                    weight=t.weight,
                    set_wins=bool(t.sets),
                )
            )
        node = root
        return PetriNet(_legal([title])[0], tuple(made), tuple(moves)), {**names, **called}
    except NetError as error:
        raise words.refuse(node, str(error)) from None


def _names(labels: dict[str, str], what: str, words: Words) -> dict[str, str]:
    """Id -> name in our nets: the name labels if they are all different, else the ids."""
    distinct = len(set(labels.values())) == len(labels)
    if not distinct:
        words.ignored[f"names of {what}, since some are alike"] += 1
    return dict(zip(labels, _legal(labels.values() if distinct else labels)))


def _legal(texts: Iterable[str]) -> list[str]:
    """Texts as legal names, all different; words of the expression language get a ``_``."""
    used: dict[str, int] = {}
    names = []
    for text in texts:
        name = "".join(c if c.isprintable() else "_" for c in text).strip()[:180].strip() or "_"
        if name in FUNCTIONS or name in CONSTANTS or name in WORDS:
            name += "_"
        base, number = name, used.get(name, 0)
        while name in used:
            number += 1
            name = f"{base}_{number}"
        used[base] = max(number, used.get(base, 0))
        used.setdefault(name, 0)
        names.append(name)
    return names
