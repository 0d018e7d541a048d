"""PNML (ISO/IEC 15909-2): what a place/transition net cannot say, in one ``toolspecific`` block of ours, read back.

The plain part of a file is a *skeleton* of the net (`skeleton`). The block holds the arcs that are not ordinary and, at its end, the whole
net as JSON (`json.py`), so that reading gives an equal value; a file whose plain part was changed by another tool afterwards is refused
rather than half believed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ....errors import FormatError, NetError
from ..net.modules import flatten
from ..net.net import PetriNet
from ..net.places import ObjectPlace, Place
from ..net.transitions import Transition
from ..net.values import FrozenMap
from .json import net_from_json
from .pnml_tree import VERSION, Node


def skeleton(t: Transition, moved: frozenset[str]) -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
    """The plain arcs of a transition.

    Parameters
    ----------
    t : Transition
    moved : frozenset of str
        The discrete and object places.

    Returns
    -------
    inputs, outputs : dict from place to weight
        Test arcs included as pairs of opposite arcs.
    read : dict from place to weight
        How much of both arcs is the test arc.
    """
    inputs, outputs, read = dict(t.inputs), dict(t.outputs), {}
    for name, threshold in t.tests.items():
        more = max(0, int(threshold) - inputs.get(name, 0)) if name in moved else 0
        read[name] = more
        if more:
            inputs[name] = inputs.get(name, 0) + more
            outputs[name] = outputs.get(name, 0) + more
    return inputs, outputs, read


def moved_places(flat: PetriNet) -> frozenset[str]:
    """The discrete and object places, those whose tokens transitions move."""
    return frozenset(p.name for p in flat.places if isinstance(p, (Place, ObjectPlace)))


def net_from_block(
    block: Node,
    plain: PetriNet,
    names: Mapping[str, str],
    capacities: Mapping[str, int],
    refuse: Callable[[Node, str], FormatError],
) -> PetriNet:
    """The net that our block and the plain part mean together.

    Parameters
    ----------
    block : Node
        The ``toolspecific`` element.
    plain : PetriNet
        The plain part as read.
    names : mapping from XML id to name
    capacities : mapping from place to tokens
        Those that our hints on the places give.
    refuse : callable
        Makes the error for a node.
    """
    if block.attributes.get("version") != VERSION:
        raise refuse(block, f"version {block.attributes.get('version')!r} of our extensions; this package reads {VERSION}")
    definition = block.first("definition")
    if definition is None:
        return _with_entries(block, plain, names, capacities, refuse)
    try:
        net = net_from_json(definition.text)
        flat = flatten(net)
    except NetError as error:
        raise refuse(definition, str(error)) from None
    difference = _difference(flat, plain)
    if difference:
        raise refuse(
            definition, f"the plain part was changed after this was written: {difference}; read with block=False to take the plain part"
        )
    _check_entries(block, flat, names, refuse)
    return net


def _check_entries(block: Node, flat: PetriNet, names: Mapping[str, str], refuse: Callable[[Node, str], FormatError]) -> None:
    """Refuse entries that say something else than the definition beside them."""
    arcs: dict[tuple[str, str, str], float] = {}
    for t in flat.transitions:
        for kind, found in (("test", t.tests), ("inhibitor", t.inhibitors), ("set", t.sets)):
            arcs |= {(kind, t.name, place): float(value) for place, value in found.items()}
    for node in block.children:
        if node.tag in ("note", "definition") and node is block.first(node.tag):
            continue
        kind = node.attributes.get("type", "")
        key = (kind, *(names.get(node.attributes.get(end, ""), "") for end in ("transition", "place")))
        text = node.attributes.get("value" if kind == "set" else "threshold", "")
        if node.tag != "arc" or key not in arcs or text not in (f"{arcs[key]}", f"{arcs[key]:.0f}"):
            raise refuse(node, "differs from the definition of our block; read with block=False to take the plain part")
        del arcs[key]
    if arcs:
        raise refuse(
            block, f"its entry of the {' arc of '.join(next(iter(arcs))[:2])} is gone; read with block=False to take the plain part"
        )


def _difference(flat: PetriNet, plain: PetriNet) -> str:
    """The first difference between the skeleton of `flat` and a plain net, or ``""``."""
    moved = moved_places(flat)
    wanted = {p.name: p.tokens if isinstance(p, Place) else 0 for p in flat.places}
    found = {p.name: p.tokens for p in plain.places if isinstance(p, Place)}
    if wanted != found:
        name = next(n for n in (*wanted, *found) if wanted.get(n) != found.get(n))
        return f"place {name!r} has {found.get(name, 'gone')} instead of {wanted.get(name, 'not being there')}"
    arcs = {t.name: skeleton(t, moved)[:2] for t in flat.transitions}
    read = {t.name: (dict(t.inputs), dict(t.outputs)) for t in plain.transitions}
    name = next((n for n in (*arcs, *read) if arcs.get(n) != read.get(n)), "")
    return f"the arcs of transition {name!r} differ" if name else ""


def _with_entries(
    block: Node,
    plain: PetriNet,
    names: Mapping[str, str],
    capacities: Mapping[str, int],
    refuse: Callable[[Node, str], FormatError],
) -> PetriNet:
    """The plain net with the arcs that the entries of a block without definition add."""
    kinds = ("inputs", "outputs", "tests", "inhibitors", "sets")
    changed: dict[str, dict[str, dict[str, float]]] = {t.name: {kind: dict(getattr(t, kind)) for kind in kinds} for t in plain.transitions}
    known = {p.name for p in plain.places}
    for node in block.children:
        if node.tag == "note":
            continue
        if node.tag != "arc" or node.namespace:
            raise refuse(node, "is not understood in our block; known: arc, definition, note")
        for key in node.attributes:
            if key not in ("type", "place", "transition", "threshold", "weight", "value"):
                raise refuse(node, f"the attribute {key!r} is not understood; known: place, threshold, transition, type, value, weight")
        place, name = (names.get(node.attributes.get(end, ""), "") for end in ("place", "transition"))
        if place not in known or name not in changed:
            raise refuse(
                node, f"joins {node.attributes.get('place')!r} and {node.attributes.get('transition')!r}, which the net does not have"
            )
        _add_entry(node, place, changed[name], refuse)
    try:
        places = (replace(p, capacity=capacities.get(p.name, p.capacity)) if isinstance(p, Place) else p for p in plain.places)
        moves = []
        for t in plain.transitions:
            arcs: Any = {kind: FrozenMap(found) for kind, found in changed[t.name].items()}
            moves.append(replace(t, **arcs, set_wins=t.set_wins or bool(changed[t.name]["sets"])))
        return replace(plain, places=tuple(places), transitions=tuple(moves))
    except NetError as error:
        raise refuse(block, str(error)) from None


def _add_entry(node: Node, place: str, arcs: dict[str, dict[str, float]], refuse: Callable[[Node, str], FormatError]) -> None:
    """Add one arc of our block to those of its transition."""

    def number(key: str, default: str) -> int:
        text = node.attributes.get(key, default).strip()
        if not re.fullmatch(r"[0-9]{1,10}", text):
            raise refuse(node, f"{key} is a whole number from 0, got {text[:40]!r}")
        return int(text)

    kind = node.attributes.get("type", "")
    if kind == "inhibitor":
        arcs["inhibitors"][place] = number("threshold", "1")
    elif kind == "set":
        arcs["sets"][place] = number("value", "1")
    elif kind == "test":
        weight = number("weight", "0")
        for way in ("inputs", "outputs"):
            if weight > arcs[way].get(place, 0):
                raise refuse(node, f"weight {weight} of the test arc is more than the {way} of the plain part")
            if weight:
                arcs[way][place] -= weight
                if not arcs[way][place]:
                    del arcs[way][place]
        arcs["tests"][place] = number("threshold", "1")
    else:
        raise refuse(node, f"arcs of type {kind!r} are not read here; known: inhibitor, set, test")
