"""What a drawing shows: items, links and boxes, before anything has a position."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from ....errors import NetError
from ...expressions import Expression
from ..net.net import PetriNet, resolve_name
from ..net.places import AnyPlace, Belief, Continuous, Input, Math, ObjectPlace, Place
from ..net.transitions import Transition

ALL = -1
"""`unfold` for a drawing with every module unfolded."""
Unfold = int | Collection[str]
"""Levels of modules drawn with their inside, or the paths of those instances that are."""
MAX_DRAWN = 20_000
"""Most places, transitions, ports and arcs of one drawing."""


@dataclass(frozen=True)
class Item:
    """A place or transition to draw.

    Parameters
    ----------
    key : str
        Unique in the drawing: the flat name.
    kind : str
        ``place continuous input belief math object port`` or ``immediate timed output``.
    label, detail : str
        What stands beside it; the detail is smaller.
    tokens : int
        Initial tokens, for a discrete place.
    timed : bool
        Of an output transition.
    """

    key: str
    kind: str
    label: str
    detail: str = ""
    tokens: int = 0
    timed: bool = False

    @property
    def is_transition(self) -> bool:
        """Whether it is a bar."""
        return self.kind in ("immediate", "timed", "output")


@dataclass(frozen=True)
class Link:
    """An arc to draw; `style` is ``arc test inhibitor set parameter operand fuse``."""

    source: str
    target: str
    style: str
    label: str = ""


@dataclass
class Box:
    """One net in a drawing: what it holds, and which of it are ports."""

    key: str
    title: str
    items: list[Item] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)
    entries: set[str] = field(default_factory=set)
    exits: set[str] = field(default_factory=set)
    net: PetriNet | None = None
    folded: bool = False

    def walk(self) -> Iterator[Box]:
        """This box and all inside it."""
        yield self
        for box in self.boxes:
            yield from box.walk()


def picture(net: PetriNet, unfold: Unfold = 0, all_ports: bool = False) -> Box:
    """What a drawing of `net` shows.

    Parameters
    ----------
    net : PetriNet
    unfold : int or collection of str
        Levels of modules drawn with their inside, `ALL` for every level; or the paths of the instances that are.
    all_ports : bool
        Show every port of a folded module, not only those that are used.

    Raises
    ------
    NetError
        When it would show more than `MAX_DRAWN` places, transitions, ports and arcs.
    """
    if (size := _size(net, "", unfold, {})) > MAX_DRAWN:
        hint = "; unfold fewer levels" if net.modules and unfold else ""
        raise NetError(f"net {net.name!r}: its drawing has {size:,} places, transitions, ports and arcs, more than {MAX_DRAWN:,}{hint}")
    return _box(net, "", net.name, unfold, all_ports)


def _inside(unfold: Unfold, path: str) -> Unfold | None:
    """How far the inside of the instance at `path` is unfolded, None when it is folded."""
    if isinstance(unfold, int):
        return None if unfold == 0 else unfold - 1 if unfold > 0 else ALL
    return unfold if path in unfold else None


def _size(net: PetriNet, path: str, unfold: Unfold, known: dict[tuple[int, int | str], int]) -> int:
    """How much a drawing shows."""
    key = id(net), unfold if isinstance(unfold, int) else path
    if key not in known:
        arcs = sum(len(t.inputs) + len(t.outputs) + len(t.tests) + len(t.inhibitors) + len(t.sets) for t in net.transitions)
        modules = 0
        for instance, module in net.modules.items():
            inner = _join(path, instance)
            levels = _inside(unfold, inner)
            modules += len(module.ports.all) + 1 if levels is None else _size(module, inner, levels, known)
        known[key] = len(net.places) + len(net.transitions) + arcs + modules
    return known[key]


def _join(path: str, instance: str) -> str:
    return f"{path}.{instance}" if path else instance


def _box(net: PetriNet, path: str, title: str, unfold: Unfold, all_ports: bool) -> Box:
    prefix = f"{path}." if path else ""
    box = Box(path, title, net=net)
    box.entries = {prefix + port for port in net.ports.entries}
    box.exits = {prefix + port for port in net.ports.exits}
    scope = {p.name: p for p in net.places} | net.port_places()
    box.items += [_place_item(place, prefix) for place in net.places]
    for t in net.transitions:
        box.items.append(_transition_item(t, prefix))
        box.links += _transition_links(t, prefix)
    for place in net.places:
        box.links += _operand_links(place, prefix, scope)
    for instance, module in net.modules.items():
        inner = _join(path, instance)
        heading = f"{instance} : {module.name}" if instance != module.name else instance
        levels = _inside(unfold, inner)
        box.boxes.append(folded(module, inner, heading) if levels is None else _box(module, inner, heading, levels, all_ports))
    box.links += [Link(prefix + target, prefix + port, "fuse") for port, target in net.fuse.items()]
    if not all_ports:
        _drop_unused_ports(box)
    return box


def folded(module: PetriNet, path: str, heading: str) -> Box:
    """A module as a box with all its ports."""
    own = {p.name: p for p in module.places}
    ports = module.ports
    box = Box(path, heading, entries={f"{path}.{p}" for p in (*ports.entries, *ports.parameters)}, net=module, folded=True)
    box.exits = {f"{path}.{p}" for p in ports.exits}
    for port in ports.all:
        kind = "object" if isinstance(own[port], ObjectPlace) else "port"
        box.items.append(Item(f"{path}.{port}", kind, port))
    return box


def _drop_unused_ports(box: Box) -> None:
    """Folded modules show the ports of the behaviour interface that are used, if any are used at all."""
    used = {end for link in box.links for end in (link.source, link.target)}
    for inner in (inner for inner in box.boxes if inner.folded):
        keep = [item for item in inner.items if item.key in used]
        inner.items = keep or inner.items


def _place_item(place: AnyPlace, prefix: str) -> Item:
    kind, detail, tokens = "place", "", 0
    if isinstance(place, Place):
        tokens = place.tokens
        detail = f"≤ {place.capacity}" if place.capacity is not None and place.capacity > 1 else ""
    elif isinstance(place, Input):
        kind, detail = "input", place.observes if place.observes != place.name else ""
    elif isinstance(place, Belief):
        state = f" = {place.state}" if place.state else ""
        kind, detail = "belief", f"{place.view} of {place.variable}{state}"
    elif isinstance(place, Math):
        kind, detail = "math", f"= {place.expression}"
    elif isinstance(place, Continuous):
        kind, detail = "continuous", f"{place.value:g}"
    elif isinstance(place, ObjectPlace):
        kind, detail = "object", place.class_name
        if place.select is not None:
            rank = "" if place.select.k == 1 else f"no. {place.select.k} by "
            order = "least" if place.select.minimize else "most"
            detail = f"{rank}{order} {place.select.best}" + (f" where {place.select.where}" if place.select.where else "")
    return Item(prefix + place.name, kind, place.name, detail, tokens)


def _transition_item(t: Transition, prefix: str) -> Item:
    details = []
    if t.is_timed:
        details.append(f"{t.delay}")
    if t.emits is not None:
        details.append(f"{t.emits.name}({', '.join(f'{value}' for value in t.emits.params.values())})")
    if t.priority:
        details.append(f"priority {t.priority}")
    kind = "output" if t.emits is not None else "timed" if t.is_timed else "immediate"
    return Item(prefix + t.name, kind, t.name, ", ".join(details), timed=t.is_timed)


def _transition_links(t: Transition, prefix: str) -> list[Link]:
    name = prefix + t.name
    links = [Link(prefix + p, name, "arc", f"{w}" if w != 1 else "") for p, w in t.inputs.items()]
    links += [Link(name, prefix + p, "arc", f"{w}" if w != 1 else "") for p, w in t.outputs.items()]
    links += [Link(prefix + p, name, "test", f"≥ {w:g}" if w != 1 else "") for p, w in t.tests.items()]
    links += [Link(prefix + p, name, "inhibitor", f"≥ {w:g}" if w != 1 else "") for p, w in t.inhibitors.items()]
    links += [Link(name, prefix + p, "set", f"= {w}") for p, w in t.sets.items()]
    if t.emits is not None:
        sources = {value for value in t.emits.params.values() if isinstance(value, str)}
        links += [Link(prefix + p, name, "parameter") for p in sorted(sources)]
    return links


def _operand_links(place: AnyPlace, prefix: str, scope: Mapping[str, AnyPlace]) -> list[Link]:
    texts: list[str] = []
    skip = ""
    if isinstance(place, Math):
        texts = [place.expression]
    elif isinstance(place, ObjectPlace) and place.select is not None:
        texts, skip = [text for text in (place.select.best, place.select.where) if text], f"{place.select.candidate}."
    elif isinstance(place, Belief) and resolve_name(place.variable, scope)[1]:
        texts = [place.variable]
    found: dict[str, None] = {}
    for text in texts:
        for name in Expression(text).names:
            if not skip or not name.startswith(skip):
                found[resolve_name(name, scope)[0]] = None
    return [Link(prefix + name, prefix + place.name, "operand") for name in found if name]


def drop_quantities(box: Box) -> None:
    """Leave out inputs, beliefs, math and continuous places, and the arcs at them, in a picture: what stays is what happens.

    Parameters
    ----------
    box : Box
        Changed in place; a transition that only quantities touch stays.
    """
    for part in box.walk():
        hidden = set() if part.net is None or not part.folded else {f"{part.key}.{port}" for port in part.net.ports.parameters}
        part.items = [i for i in part.items if i.kind not in ("input", "belief", "math", "continuous") and i.key not in hidden]
    there = {item.key for part in box.walk() for item in part.items}
    for part in box.walk():
        part.links = [link for link in part.links if link.source in there and link.target in there]
