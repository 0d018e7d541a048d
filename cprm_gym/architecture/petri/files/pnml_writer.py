"""PNML (ISO/IEC 15909-2): writing.

The plain part of a file is the skeleton that every place/transition tool understands: one flat page with the discrete and object
places, their initial tokens, and the ordinary arcs; a test arc is a pair of opposite arcs. Inhibitor and set arcs are never ``<arc>``
elements, because other tools silently take those for ordinary arcs; they are entries of one ``toolspecific`` block at the net, like
everything else that a place/transition net cannot say (`pnml_block.py`).

`expanded_net` is the other way out: a place/transition net with the same behaviour, with complement places for bounded places.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from ....errors import NetError
from ....files import write_atomically
from ..net.modules import flatten
from ..net.net import PetriNet
from ..net.places import ObjectPlace, Place
from ..net.transitions import Transition
from .json import definition_keys, net_to_dict
from .pnml_block import moved_places, skeleton
from .pnml_tree import PTNET, TOOL, VERSION
from .positions import Positions, with_positions

_KINDS = {
    "Place": "discrete",
    "ObjectPlace": "object",
    "Continuous": "continuous",
    "Input": "input",
    "Belief": "belief",
    "Math": "math",
}
MAX_VARIANTS = 10_000
"""Most transitions that `expanded_net` writes for one transition with set arcs."""


def write_pnml(net: PetriNet, path: str | Path, *, expanded: bool = False, bounds: Mapping[str, int] | None = None) -> None:
    """Write a net to a PNML file, all of it or nothing.

    Parameters
    ----------
    net : PetriNet
    path : path
    expanded : bool
        Write `expanded_net` instead, exact for every place/transition tool; it does not read back to the same net.
    bounds : mapping from place to tokens, optional
        For `expanded_net`.
    """
    write_atomically(path, to_pnml(expanded_net(net, bounds) if expanded else net))


def to_pnml(net: PetriNet, positions: Positions | None = None) -> str:
    """The PNML text of a net.

    Parameters
    ----------
    net : PetriNet
    positions : mapping, optional
        Where parts of a drawing stand, by the keys of the definitions (`positions.py`). Those of the net's own places and transitions are
        ``<graphics>``, which every tool reads; those of its modules stand in our block.
    """
    flat = flatten(net)
    own = (positions or {}).get(definition_keys(net)[net], {})
    ids = _identifiers([net.name, "page", *(p.name for p in flat.places), *(t.name for t in flat.transitions)])
    name_id, page_id = ids[:2]
    place_id = dict(zip((p.name for p in flat.places), ids[2:]))
    transition_id = dict(zip((t.name for t in flat.transitions), ids[2 + len(flat.places) :]))
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">',
        f' <net id="{name_id}" type="{PTNET}">',
        f"  <name><text>{escape(net.name)}</text></name>",
        f'  <page id="{page_id}">',
    ]
    for place in flat.places:
        lines += _place(place, place_id[place.name], _graphics(own.get(place.name)))
    arcs: list[str] = []
    entries: list[str] = []
    for t in flat.transitions:
        lines += _transition(t, transition_id[t.name], _graphics(own.get(t.name)))
        _arcs(t, flat, place_id, transition_id[t.name], arcs, entries)
    lines += [line.format(id=f"arc{k}") for k, line in enumerate(arcs, 1)]
    lines.append("  </page>")
    if _is_extended(net):
        lines += _block(net, entries, positions)
    return "\n".join([*lines, " </net>", "</pnml>", ""])


def _identifiers(names: list[str]) -> list[str]:
    """XML ids that look like the names and are all different."""
    used: set[str] = set()
    found = []
    for name in names:
        base = re.sub(r"[^A-Za-z0-9_.-]", "_", name)
        base = base if re.match(r"[A-Za-z_]", base) and not re.fullmatch(r"arc\d+", base) else f"_{base}"
        candidate, number = base, 1
        while candidate in used:
            number += 1
            candidate = f"{base}-{number}"
        used.add(candidate)
        found.append(candidate)
    return found


def _hint(indent: str, parts: Mapping[str, object]) -> list[str]:
    """A ``toolspecific`` element with the given children."""
    if not parts:
        return []
    inner = "".join(f"<{tag}>{escape(str(value))}</{tag}>" for tag, value in parts.items())
    return [f'{indent}<toolspecific tool="{TOOL}" version="{VERSION}">{inner}</toolspecific>']


def _graphics(at: tuple[float, float] | None) -> list[str]:
    return [] if at is None else [f'    <graphics><position x="{at[0]:g}" y="{at[1]:g}"/></graphics>']


def _place(place: Any, identifier: str, graphics: list[str]) -> list[str]:
    hints: dict[str, object] = {}
    if not isinstance(place, Place):
        hints["kind"] = _KINDS[type(place).__name__]
    elif place.capacity is not None:
        hints["capacity"] = place.capacity
    tokens = place.tokens if isinstance(place, Place) else 0
    lines = [f'   <place id="{identifier}">', f"    <name><text>{escape(place.name)}</text></name>", *graphics]
    if tokens:
        lines.append(f"    <initialMarking><text>{tokens}</text></initialMarking>")
    return [*lines, *_hint("    ", hints), "   </place>"]


def _transition(t: Transition, identifier: str, graphics: list[str]) -> list[str]:
    hints: dict[str, object] = {}
    if t.delay:
        hints["delay"] = t.delay
    if t.priority:
        hints["priority"] = t.priority
    if t.emits is not None:
        hints["command"] = t.emits.name
    return [
        f'   <transition id="{identifier}">',
        f"    <name><text>{escape(t.name)}</text></name>",
        *graphics,
        *_hint("    ", hints),
        "   </transition>",
    ]


def _arcs(t: Transition, flat: PetriNet, place_id: Mapping[str, str], identifier: str, arcs: list[str], entries: list[str]) -> None:
    """Add the plain arcs of `t` to `arcs` and its other arcs to `entries`."""
    inputs, outputs, read = skeleton(t, moved_places(flat))
    for name, weight in inputs.items():
        arcs.append(_arc(place_id[name], identifier, weight))
    for name, weight in outputs.items():
        arcs.append(_arc(identifier, place_id[name], weight))

    def entry(kind: str, name: str, **values: object) -> None:
        attributes = "".join(f" {key}={quoteattr(f'{value}')}" for key, value in values.items())
        entries.append(f'   <arc type="{kind}" place="{place_id[name]}" transition="{identifier}"{attributes}/>')

    for name, threshold in t.tests.items():
        entry("test", name, threshold=threshold, weight=read[name])
    for name, threshold in t.inhibitors.items():
        entry("inhibitor", name, threshold=threshold)
    for name, value in t.sets.items():
        entry("set", name, value=value)


def _arc(source: str, target: str, weight: int) -> str:
    line = f'   <arc id="{{id}}" source="{source}" target="{target}"'
    return f"{line}/>" if weight == 1 else f"{line}><inscription><text>{weight}</text></inscription></arc>"


def _is_extended(net: PetriNet) -> bool:
    """Whether a plain file would not read back to an equal net."""
    plain = PetriNet(
        net.name,
        tuple(Place(p.name, tokens=p.tokens) for p in net.places if isinstance(p, Place)),
        tuple(Transition(t.name, t.inputs, t.outputs) for t in net.transitions) if not net.modules and _ordinary(net) else (),
    )
    return plain != net


def _ordinary(net: PetriNet) -> bool:
    """Whether every place is a discrete one."""
    return all(isinstance(p, Place) for p in net.places)


def _losses(net: PetriNet) -> list[str]:
    """What a reader of plain place/transition nets loses."""
    flat = flatten(net)
    lost = []
    checks = (
        ("inhibitor arcs", any(t.inhibitors for t in flat.transitions)),
        ("set arcs", any(t.sets for t in flat.transitions)),
        ("capacities", any(isinstance(p, Place) and p.capacity is not None for p in flat.places)),
        ("delays and priorities", any(t.delay or t.priority for t in flat.transitions)),
        ("conditions on inputs, beliefs and continuous places", not _ordinary(flat)),
        ("commands", any(t.emits for t in flat.transitions)),
        ("modules and ports", bool(net.modules or net.ports.all)),
    )
    lost += [what for what, there in checks if there]
    return lost


def _block(net: PetriNet, entries: list[str], positions: Positions | None) -> list[str]:
    """Our block: what is lost without it, the arcs that are not ordinary, the net itself."""
    lost = _losses(net)
    note = f"A reader of plain place/transition nets loses: {', '.join(lost)}. " if lost else ""
    if any("set arcs" in what for what in lost):
        note += "What it finds says nothing about the net."
    elif lost:
        note += "It finds every behaviour of the net and more: what it excludes is excluded; deadlocks and liveness do not carry over."
    return [
        f'  <toolspecific tool="{TOOL}" version="{VERSION}">',
        *([f"   <note>{escape(note.strip())}</note>"] if note else []),
        *entries,
        f"   <definition>{escape(json.dumps(with_positions(net_to_dict(net), positions), separators=(',', ':')))}</definition>",
        "  </toolspecific>",
    ]


def expanded_net(net: PetriNet, bounds: Mapping[str, int] | None = None) -> PetriNet:
    """A place/transition net, ordinary arcs only, with the same untimed behaviour.

    Places with a capacity, an inhibitor arc or a set arc get a complement place, so that both together always hold the capacity; a
    transition with set arcs becomes one for every combination of values that its places may have. Conditions on continuous,
    input and belief places are dropped (they may be anything), delays and priorities too: analysis of the untimed view.

    Parameters
    ----------
    net : PetriNet
    bounds : mapping from place to tokens, optional
        Proven bounds of places without a capacity that need a complement place.

    Raises
    ------
    NetError
        When such a place has no bound, or the variants of a transition are too many.
    """
    flat = flatten(net)
    limits: dict[str, int] = {}
    needed = {name for t in flat.transitions for name in (*t.inhibitors, *t.sets)}
    places: list[Place] = []
    for p in flat.places:
        if isinstance(p, ObjectPlace) and p.select is None:
            places.append(Place(p.name))
            limits[p.name] = 1
        elif isinstance(p, Place):
            places.append(Place(p.name, tokens=p.tokens))
            limit = p.capacity if p.capacity is not None else (bounds or {}).get(p.name)
            if limit is not None and (p.capacity is not None or p.name in needed):
                limits[p.name] = limit
            elif p.name in needed:
                raise NetError(f"net {net.name!r}, place {p.name!r}: has no capacity; the expanded net needs a bound for it")
    free = {p.name for p in flat.places} - {p.name for p in places}
    complements = {name: f"not {name}" for name in limits}
    tokens = {p.name: p.tokens for p in places}
    places += [Place(c, tokens=limits[name] - tokens[name]) for name, c in complements.items()]
    weak = flat.semantics.capacity == "weak"
    transitions = []
    for t in flat.transitions:
        if any(t.tests.get(name, -float("inf")) >= w for name, w in t.inhibitors.items() if name in free):
            continue
        transitions += _variants(t, limits, complements, free, weak)
    return PetriNet(f"{net.name} expanded", tuple(places), tuple(transitions))


def _variants(t: Transition, limits: Mapping[str, int], complements: Mapping[str, str], free: set[str], weak: bool) -> list[Transition]:
    """The ordinary transitions that do together what `t` does."""
    touched = [n for n in dict.fromkeys((*t.inputs, *t.outputs, *t.tests, *t.inhibitors)) if n not in free and n not in t.sets]
    take: dict[str, int] = {}
    give: dict[str, int] = {}
    for name in touched:
        consumed, produced = t.inputs.get(name, 0), t.outputs.get(name, 0)
        least = max(consumed, int(t.tests.get(name, 0)))
        take[name], give[name] = least, produced + least - consumed
        if name in limits:
            out, back = (produced, consumed) if weak else (max(0, produced - consumed), max(0, consumed - produced))
            room = max(out, limits[name] - int(t.inhibitors[name]) + 1) if name in t.inhibitors else out
            take[complements[name]], give[complements[name]] = room, back + room - out
    written = [n for n in t.sets if n not in free]
    count = 1
    for name in written:
        count *= limits[name] + 1
    if count > MAX_VARIANTS:
        raise NetError(f"transition {t.name!r}: its set arcs would need {count} transitions in the expanded net")
    found = []
    for values in itertools.product(*(range(limits[n] + 1) for n in written)):
        if not all(_allows(t, n, v, limits[n], weak) for n, v in zip(written, values)):
            continue
        inputs, outputs = dict(take), dict(give)
        for name, value in zip(written, values):
            inputs[name], inputs[complements[name]] = value, limits[name] - value
            outputs[name], outputs[complements[name]] = t.sets[name], limits[name] - t.sets[name]
        label = f"{t.name} [{', '.join(f'{n}={v}' for n, v in zip(written, values))}]" if written else t.name
        found.append(Transition(label, {k: w for k, w in inputs.items() if w}, {k: w for k, w in outputs.items() if w}))
    return found


def _allows(t: Transition, name: str, value: int, limit: int, weak: bool) -> bool:
    """Whether `t` may fire while the place that it sets holds `value`."""
    consumed, produced = t.inputs.get(name, 0), t.outputs.get(name, 0)
    after = value + produced - (0 if weak else consumed)
    return value >= max(consumed, t.tests.get(name, 0)) and value < t.inhibitors.get(name, limit + 1) and (produced == 0 or after <= limit)
