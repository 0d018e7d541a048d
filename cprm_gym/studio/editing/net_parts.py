"""The JSON form of a net, taken apart: what the operations of an editor look up and change in it.

Everything here works on plain dictionaries, one definition of a net's JSON form (`cprm_gym.architecture.petri.files.json`); what comes out
is checked by building the net from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ...architecture.expressions import Expression
from ...architecture.petri import AnyPlace, ObjectPlace, Place
from ...architecture.petri.net.net import resolve_name
from ...errors import ExpressionError, NetError, did_you_mean

Definition = dict[str, Any]
ARCS: Mapping[str, tuple[bool, str]] = {
    "input": (True, "inputs"),
    "output": (False, "outputs"),
    "test": (True, "tests"),
    "inhibitor": (True, "inhibitors"),
    "set": (False, "sets"),
}
"""Kind of an arc -> whether it goes from the place to the transition, and the field of the transition that holds it."""
PORT_ONE = ("begin", "ongoing", "done")
PORT_MANY = ("errors", "interrupts", "inputs", "outputs", "parameters")
PORT_ROLES = PORT_ONE + PORT_MANY


def find(parts: list[dict[str, Any]], name: str, what: str) -> dict[str, Any]:
    """The place or transition of that name.

    Raises
    ------
    NetError
    """
    for part in parts:
        if part["name"] == name:
            return part
    known = [part["name"] for part in parts]
    raise NetError(f"there is no {what} {name!r}.{did_you_mean(name, known)}")


def has(parts: list[dict[str, Any]], name: str) -> bool:
    """Whether a place or transition of that name is there."""
    return any(part["name"] == name for part in parts)


def free_name(definition: Definition, wanted: str) -> str:
    """`wanted`, or with the lowest number behind it that makes it new among places, transitions and instances."""
    taken = {p["name"] for p in definition.get("places", [])} | {t["name"] for t in definition.get("transitions", [])}
    taken |= set(definition.get("modules", {}))
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted}_{number}"
    return name


Scope = Mapping[str, AnyPlace]
_OBJECT, _OTHER = ObjectPlace("object", "Object"), Place("other")
"""What stands for places where names are resolved: only whether they hold objects matters."""


def readable(definition: Definition, definitions: Mapping[str, Definition]) -> Scope:
    """Names that expressions may read, own places and ports of instances, mapped to a place that holds objects or one that does not."""
    scope: dict[str, AnyPlace] = {p["name"]: _stands_for(p) for p in definition.get("places", [])}
    for instance, target in definition.get("modules", {}).items():
        inner = definitions.get(target, {})
        kinds = {p["name"]: _stands_for(p) for p in inner.get("places", [])}
        scope |= {f"{instance}.{port}": kinds.get(port, _OTHER) for port in port_names(inner)}
    return scope


def _stands_for(place: Mapping[str, Any]) -> AnyPlace:
    return _OBJECT if place.get("kind") == "object" else _OTHER


def port_names(definition: Definition) -> tuple[str, ...]:
    """Every port of a definition."""
    ports = definition.get("ports", {})
    return tuple(ports[r] for r in PORT_ONE if ports.get(r)) + tuple(name for r in PORT_MANY for name in ports.get(r, ()))


def port_role(definition: Definition, place: str) -> str:
    """Which port a place is, empty for none."""
    ports = definition.get("ports", {})
    for role in PORT_ONE:
        if ports.get(role) == place:
            return role
    return next((role for role in PORT_MANY if place in ports.get(role, ())), "")


def renamed_text(text: str, rename: Callable[[str], str]) -> str:
    """An expression with its names replaced, everything else as it was written."""
    try:
        expression = Expression(text)
    except ExpressionError:
        return text
    nodes = sorted({(node.at, node.name) for node in expression.tree.walk() if node.op == "name"}, reverse=True)
    if not all(text.startswith(name, at) for at, name in nodes):  # blanks around a dot
        return expression.rename(rename).text
    for at, name in nodes:
        text = text[:at] + rename(name) + text[at + len(name) :]
    return text


def rename_in(definition: Definition, names: Mapping[str, str], scope: Scope, *, ports: bool) -> None:
    """Replace names of places wherever a definition uses them.

    Parameters
    ----------
    definition : dict
        Changed.
    names : mapping
        Old name -> new name.
    scope : mapping
        Names that expressions may read, as `readable` gives them, before.
    ports : bool
        Whether the names are own places, which may be ports.
    """

    def dotted(name: str) -> str:
        place, attribute = resolve_name(name, scope)
        new = names.get(place, place)
        return name if not place else f"{new}.{attribute}" if attribute else new

    for place in definition.get("places", []):
        if "expression" in place:
            place["expression"] = renamed_text(place["expression"], dotted)
        if place.get("kind") == "belief" and resolve_name(place["variable"], scope)[1]:
            place["variable"] = dotted(place["variable"])
        select = place.get("select")
        if select:
            candidate = select["class_name"].lower() + "."
            for key in ("best", "where"):
                if select.get(key):
                    select[key] = renamed_text(select[key], lambda n, c=candidate: n if n.startswith(c) else dotted(n))  # type: ignore[misc]
    for transition in definition.get("transitions", []):
        for _, field in ARCS.values():
            if field in transition:
                transition[field] = {names.get(place, place): weight for place, weight in transition[field].items()}
        emits = transition.get("emits")
        if emits:
            emits["params"] = {k: names.get(v, v) if isinstance(v, str) else v for k, v in emits.get("params", {}).items()}
    if "fuse" in definition:
        definition["fuse"] = {names.get(port, port): names.get(target, target) for port, target in definition["fuse"].items()}
    if ports and "ports" in definition:
        given = definition["ports"]
        for role in PORT_ONE:
            if given.get(role):
                given[role] = names.get(given[role], given[role])
        for role in PORT_MANY:
            if role in given:
                given[role] = [names.get(name, name) for name in given[role]]
        if "answers" in given:
            given["answers"] = {names.get(i, i): [names.get(o, o) for o in outcomes] for i, outcomes in given["answers"].items()}


def forget(definition: Definition, names: set[str]) -> None:
    """Take places out of a definition with every arc, port, fusion and command parameter that names them.

    Expressions that read them are left: the net is then refused, and the message names the expression.
    """
    definition["places"] = [p for p in definition.get("places", []) if p["name"] not in names]
    for transition in definition.get("transitions", []):
        for _, field in ARCS.values():
            if field in transition:
                transition[field] = {p: w for p, w in transition[field].items() if p not in names}
    if "fuse" in definition:
        definition["fuse"] = {p: t for p, t in definition["fuse"].items() if p not in names and t not in names}
    ports = definition.get("ports", {})
    for role in PORT_ONE:
        if ports.get(role) in names:
            del ports[role]
    for role in PORT_MANY:
        if role in ports:
            ports[role] = [name for name in ports[role] if name not in names]
    if "answers" in ports:
        kept = {i: [o for o in outs if o not in names] for i, outs in ports["answers"].items() if i not in names}
        ports["answers"] = {i: outs for i, outs in kept.items() if outs}
    tidy(definition)


def tidy(definition: Definition) -> None:
    """Leave out what is empty, as the writer of nets does."""
    for transition in definition.get("transitions", []):
        for _, field in ARCS.values():
            if not transition.get(field, True):
                del transition[field]
    for key in ("modules", "fuse", "ports", "semantics"):
        held = definition.get(key)
        if isinstance(held, dict):
            definition[key] = {k: v for k, v in held.items() if v not in (None, [], {})}
            if not definition[key]:
                del definition[key]
