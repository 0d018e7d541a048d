"""Modules in modules: the flat net of a hierarchy, and where each instance's places went."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from ....errors import NetError
from ...expressions import Expression
from .net import MAX_PARTS, PetriNet, check_size, resolve_name
from .places import AnyPlace, Belief, Math, ObjectPlace, Selection
from .transitions import Command, Transition
from .values import FrozenMap

V = TypeVar("V")


@dataclass(frozen=True)
class Instance:
    """One module at one place in a hierarchy.

    Parameters
    ----------
    path : str
        Instance names joined by dots; empty for the outermost net.
    net : PetriNet
        The module.
    places, transitions : mapping
        Name inside the module (own and ``instance.port``) -> name in the flat net.
    """

    path: str
    net: PetriNet
    places: Mapping[str, str]
    transitions: Mapping[str, str]

    def __repr__(self) -> str:
        return f"Instance({self.path!r}, {self.net.name!r})"


def instances(net: PetriNet, max_parts: int = MAX_PARTS) -> dict[str, Instance]:
    """Every instance in the hierarchy of `net` by its path, the outermost net first under ``""``.

    Raises
    ------
    NetError
        When the hierarchy has more than `max_parts` places, transitions and modules.
    """
    check_size(net, max_parts, "its hierarchy has")
    return {instance.path: instance for instance in _walk(net, "", {})}


def _walk(net: PetriNet, path: str, bound: Mapping[str, str]) -> Iterator[Instance]:
    """`bound`: own places of `net` that the net around has fused -> their flat names."""
    prefix = f"{path}." if path else ""
    names = {p.name: bound.get(p.name, prefix + p.name) for p in net.places}

    def flat(name: str) -> str:
        if name in names:
            return names[name]
        return flat(net.fuse[name]) if name in net.fuse else prefix + name

    names.update({port: flat(port) for port in net.port_places()})
    yield Instance(path, net, names, {t.name: prefix + t.name for t in net.transitions})
    for name, module in net.modules.items():
        inner = {port: names[f"{name}.{port}"] for port in module.ports.all if f"{name}.{port}" in net.fuse}
        yield from _walk(module, prefix + name, inner)


def flatten(net: PetriNet, max_parts: int = MAX_PARTS) -> PetriNet:
    """The one flat net that a hierarchy means.

    A place ``begin`` of instance ``orient`` is called ``orient.begin``; fused places have the name and the definition of the
    place they were fused with. The order of declaration is: a net's own parts, then its modules' in order.

    Parameters
    ----------
    net : PetriNet
    max_parts : int
        Most places, transitions and modules that the hierarchy may have in all: a short file can mean an enormous net.

    Returns
    -------
    PetriNet
        Without modules; equal to `net` when that has none.

    Raises
    ------
    NetError
        When it has more parts, which costs no time to find, or does not flatten to a valid net.
    """
    if not net.modules:
        return net
    check_size(net, max_parts, "flattening would make")
    places: list[AnyPlace] = []
    transitions: list[Transition] = []
    for instance in instances(net, max_parts).values():
        scope = {p.name: p for p in instance.net.places} | instance.net.port_places()
        prefix = f"{instance.path}." if instance.path else ""
        rename = _Rename(scope, instance.places)
        for place in instance.net.places:
            if instance.places[place.name] == prefix + place.name:
                places.append(rename.place(place))
        transitions += [rename.transition(t, instance.transitions[t.name]) for t in instance.net.transitions]
    try:
        return replace(net, places=tuple(places), transitions=tuple(transitions), modules={}, fuse={})
    except NetError as error:
        raise NetError(f"flattening: {error}") from None


class _Rename:
    """Rewrites the parts of one instance in flat names."""

    def __init__(self, scope: Mapping[str, AnyPlace], names: Mapping[str, str]) -> None:
        self.scope = scope
        self.names = names

    def dotted(self, name: str) -> str:
        place, attribute = resolve_name(name, self.scope)
        if not place:
            return name
        return f"{self.names[place]}.{attribute}" if attribute else self.names[place]

    def place(self, place: AnyPlace) -> AnyPlace:
        name = self.names[place.name]
        if isinstance(place, Math):
            return replace(place, name=name, expression=Expression(place.expression).rename(self.dotted).text)
        if isinstance(place, Belief):
            owner, attribute = resolve_name(place.variable, self.scope)
            held = isinstance(self.scope.get(owner), ObjectPlace) and bool(attribute)
            return replace(place, name=name, variable=self.dotted(place.variable) if held else place.variable)
        if isinstance(place, ObjectPlace) and place.select is not None:
            return replace(place, name=name, select=self.selection(place.select))
        return replace(place, name=name)

    def selection(self, select: Selection) -> Selection:
        def rename(name: str) -> str:
            return name if name.startswith(select.candidate + ".") else self.dotted(name)

        best = Expression(select.best).rename(rename).text
        return replace(select, best=best, where=Expression(select.where).rename(rename).text if select.where else "")

    def transition(self, t: Transition, name: str) -> Transition:
        def renamed(arcs: Mapping[str, V]) -> FrozenMap[V]:
            return FrozenMap({self.names[place]: weight for place, weight in arcs.items()})

        for kind in ("inputs", "outputs", "tests", "inhibitors", "sets"):
            arcs: Mapping[str, float] = getattr(t, kind)
            if len({self.names[p] for p in arcs}) < len(arcs):
                raise NetError(f"transition {name!r}: `{kind}` names one fused place twice: {', '.join(arcs)}")
        emits = t.emits
        if emits is not None:
            emits = Command(emits.name, **{k: self.names[v] if isinstance(v, str) else v for k, v in emits.params.items()})
        return replace(
            t,
            name=name,
            inputs=renamed(t.inputs),
            outputs=renamed(t.outputs),
            tests=renamed(t.tests),
            inhibitors=renamed(t.inhibitors),
            sets=renamed(t.sets),
            emits=emits,
        )
