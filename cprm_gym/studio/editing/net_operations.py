"""What an editor can do to a net: each operation a small JSON object, applied to a copy of the definitions that it touches.

==================  ======================================================================================================
``add_place``       ``{in, place: {kind, name, ...}, at?}``: a place as in a net's file; ``at`` puts it there
``add_transition``  ``{in, transition: {name, ...}, at?}``
``change``          ``{in, name, fields}``: other fields of a place or transition; null takes the default again
``rename``          ``{in, name, to}``: a place, transition or instance, wherever it is named
``remove``          ``{in, names}``: places, transitions and instances, with their arcs
``connect``         ``{in, place, transition, arc, weight?}``: arc is input, output, test, inhibitor or set
``disconnect``      ``{in, place, transition, arc}``
``port``            ``{in, place, role}``: begin, ongoing, done, errors, interrupts, inputs, outputs, parameters, or empty for none
``ports``           ``{in, fields}``: within, answers, idle_interrupts
``semantics``       ``{in, fields}``
``embed``           ``{in, instance, definition, at?}``: a module
``fuse``            ``{in, port, place}``: an empty place parts them again
``move``            ``{in, at: {name: [x, y]}}``
``arrange``         ``{in}``: forget the positions chosen by hand
``define``          ``{name}``: a new, empty definition
``rename_net``      ``{name, to}``: a definition
``undefine``        ``{name}``: a definition that no other uses
``take``            ``{definitions, layout?}``: definitions of another net, those with a name in use under a new one
``main``            ``{name}``: the definition that the file means
``all``             ``{ops, what?}``: several as one, called so
==================  ======================================================================================================
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from ...architecture.petri.files.positions import positions_from_layout
from ...errors import CprmError, NetError, did_you_mean, unknown_name
from .net_parts import ARCS, PORT_MANY, PORT_ONE, PORT_ROLES, Definition, find, forget, has, port_names, readable, rename_in, tidy

Form = dict[str, Any]
"""A net's JSON form."""


def apply(form: Form, op: Mapping[str, Any]) -> Form:
    """The net's form after an operation; the one before stays as it is.

    Raises
    ------
    NetError
        For an operation that does not fit; whether the net that comes out is valid is seen when it is built.
    """
    made = _Edit(form)
    made.do(op)
    return made.form


class _Edit:
    """One operation under way: definitions are copied when they are first touched."""

    def __init__(self, form: Form) -> None:
        self.form = {**form, "definitions": dict(form["definitions"])}
        self._own: set[str] = set()

    def do(self, op: Mapping[str, Any]) -> None:
        """Apply one operation."""
        given = dict(op)
        name = given.pop("op", None)
        function = OPERATIONS.get(name) if isinstance(name, str) else None
        if function is None:
            raise unknown_name("operation", str(name), OPERATIONS)
        if "in" in given:
            given["where"] = given.pop("in")
        try:
            inspect.signature(function).bind(self, **given)
        except TypeError as error:
            raise NetError(f"operation {name!r}: {error}".replace("'where'", "'in'")) from None
        try:
            function(self, **given)
        except (TypeError, KeyError, AttributeError, ValueError) as error:
            if isinstance(error, CprmError):
                raise
            raise NetError(f"operation {name!r}: its values are not of the right kind: {error}") from None

    def definition(self, key: str) -> Definition:
        """A definition that may be changed."""
        known = self.form["definitions"]
        if key not in known:
            raise NetError(f"there is no definition {key!r}.{did_you_mean(str(key), known)}")
        if key not in self._own:
            known[key] = copy.deepcopy(known[key])
            known[key].setdefault("places", [])
            known[key].setdefault("transitions", [])
            self._own.add(key)
        found: Definition = known[key]
        return found

    def put(self, key: str, at: Mapping[str, Any]) -> None:
        """Keep positions in a definition."""
        checked = positions_from_layout({key: dict(at)})[key]
        layout = dict(self.form.get("layout", {}))
        layout[key] = {**layout.get(key, {}), **{name: list(point) for name, point in checked.items()}}
        self.form["layout"] = layout

    def unput(self, key: str, names: Mapping[str, str] | None = None, gone: set[str] | None = None) -> None:
        """Rename or forget positions in a definition."""
        layout = dict(self.form.get("layout", {}))
        if key not in layout:
            return
        layout[key] = {(names or {}).get(n, n): at for n, at in layout[key].items() if n not in (gone or ())}
        if not layout[key]:
            del layout[key]
        self.form["layout"] = layout
        if not layout:
            del self.form["layout"]

    def users(self, key: str) -> list[tuple[str, str]]:
        """(definition, instance) of every place where a definition is embedded."""
        return [(k, i) for k, d in self.form["definitions"].items() for i, target in d.get("modules", {}).items() if target == key]


def _add_place(edit: _Edit, where: str, place: dict[str, Any], at: list[float] | None = None) -> None:
    _add(edit, where, "places", place, at)


def _add_transition(edit: _Edit, where: str, transition: dict[str, Any], at: list[float] | None = None) -> None:
    _add(edit, where, "transitions", transition, at)


def _add(edit: _Edit, where: str, kind: str, part: dict[str, Any], at: list[float] | None) -> None:
    definition = edit.definition(where)
    if not isinstance(part, dict) or not isinstance(part.get("name"), str):
        raise NetError("a place or transition is an object with a name")
    _free(definition, part["name"])
    definition[kind].append(copy.deepcopy(part))
    if at is not None:
        edit.put(where, {part["name"]: at})


def _free(definition: Definition, name: str) -> None:
    """Refuse a name that is in use: positions and selections go by it."""
    for kind, what in (("places", "place"), ("transitions", "transition")):
        if has(definition[kind], name):
            raise NetError(f"{name!r} is the name of a {what} here already")
    if name in definition.get("modules", {}):
        raise NetError(f"{name!r} is the name of an instance here already")


def _change(edit: _Edit, where: str, name: str, fields: dict[str, Any]) -> None:
    definition = edit.definition(where)
    kind = "places" if has(definition["places"], name) else "transitions"
    part = find(definition[kind], name, "place or transition")
    if "name" in fields:
        raise NetError("a name is changed by the operation 'rename'")
    if kind == "places" and fields.get("kind", part["kind"]) != part["kind"]:
        index = definition[kind].index(part)
        part = definition[kind][index] = {"kind": fields["kind"], "name": name}
    for key, value in fields.items():
        if value is None or (key in ("select", "emits") and not value):
            part.pop(key, None)
        else:
            part[key] = copy.deepcopy(value)
    tidy(definition)


def _rename(edit: _Edit, where: str, name: str, to: str) -> None:
    definition = edit.definition(where)
    if name == to:
        return
    _free(definition, to)
    scope = readable(definition, edit.form["definitions"])
    if has(definition["places"], name):
        users = edit.users(where) if name in port_names(definition) else []
        outside = [(key, instance, readable(edit.form["definitions"][key], edit.form["definitions"])) for key, instance in users]
        place = find(definition["places"], name, "place")
        if place.get("kind") == "input":
            place.setdefault("observes", name)
            if place["observes"] == to:
                del place["observes"]
        place["name"] = to
        rename_in(definition, {name: to}, scope, ports=True)
        for key, instance, seen in outside:
            rename_in(edit.definition(key), {f"{instance}.{name}": f"{instance}.{to}"}, seen, ports=False)
    elif name in definition.get("modules", {}):
        modules = definition["modules"]
        ports = {f"{name}.{port}": f"{to}.{port}" for port in port_names(edit.form["definitions"].get(modules[name], {}))}
        definition["modules"] = {to if i == name else i: target for i, target in modules.items()}
        rename_in(definition, ports, scope, ports=False)
    else:
        find(definition["transitions"], name, "place, transition or instance")["name"] = to
    edit.unput(where, {name: to})


def _remove(edit: _Edit, where: str, names: list[str]) -> None:
    definition = edit.definition(where)
    gone = set(names)
    modules = definition.get("modules", {})
    for name in gone:
        if name not in modules and not has(definition["transitions"], name):
            find(definition["places"], name, "place, transition or instance")
    lost = {name for name in gone if has(definition["places"], name)}
    for instance in gone & set(modules):
        lost |= {f"{instance}.{port}" for port in port_names(edit.form["definitions"].get(modules[instance], {}))}
    definition["transitions"] = [t for t in definition["transitions"] if t["name"] not in gone]
    if modules:
        definition["modules"] = {i: target for i, target in modules.items() if i not in gone}
    ports = set(port_names(definition)) & lost
    forget(definition, lost)
    for key, instance in edit.users(where) if ports else ():
        forget(edit.definition(key), {f"{instance}.{port}" for port in ports})
    edit.unput(where, gone=gone)


def _connect(edit: _Edit, where: str, place: str, transition: str, arc: str, weight: float | None = None) -> None:
    field, part = _arc(edit, where, transition, arc)
    if weight is None:
        weight = part.get(field, {}).get(place, 0 if arc == "set" else 1)
    part[field] = {**part.get(field, {}), place: weight}


def _disconnect(edit: _Edit, where: str, place: str, transition: str, arc: str) -> None:
    field, part = _arc(edit, where, transition, arc)
    if place not in part.get(field, {}):
        raise NetError(f"transition {transition!r} has no {arc} arc with {place!r}")
    del part[field][place]
    tidy(edit.definition(where))


def _arc(edit: _Edit, where: str, transition: str, arc: str) -> tuple[str, dict[str, Any]]:
    if arc not in ARCS:
        raise unknown_name("kind of arc", str(arc), ARCS)
    return ARCS[arc][1], find(edit.definition(where)["transitions"], transition, "transition")


def _port(edit: _Edit, where: str, place: str, role: str) -> None:
    definition = edit.definition(where)
    find(definition["places"], place, "place")
    if role and role not in PORT_ROLES:
        raise unknown_name("kind of port", role, PORT_ROLES)
    ports = definition.setdefault("ports", {})
    for one in PORT_ONE:
        if ports.get(one) == place:
            del ports[one]
    for many in PORT_MANY:
        ports[many] = [name for name in ports.get(many, ()) if name != place]
    if role in PORT_ONE:
        ports[role] = place
    elif role:
        ports[role] = [*ports[role], place]
    if "answers" in ports:
        outcomes = {ports.get("done"), *ports.get("errors", ())}
        kept = {i: [o for o in outs if o in outcomes] for i, outs in ports["answers"].items() if i in ports["interrupts"]}
        ports["answers"] = {i: outs for i, outs in kept.items() if outs}
    tidy(definition)


def _fields(edit: _Edit, where: str, part: str, fields: Mapping[str, Any], allowed: tuple[str, ...]) -> None:
    definition = edit.definition(where)
    for key, value in fields.items():
        if key not in allowed:
            raise unknown_name("field", str(key), allowed)
        definition.setdefault(part, {})[key] = value
    tidy(definition)


def _ports(edit: _Edit, where: str, fields: dict[str, Any]) -> None:
    _fields(edit, where, "ports", fields, ("within", "answers", "idle_interrupts"))


def _semantics(edit: _Edit, where: str, fields: dict[str, Any]) -> None:
    _fields(edit, where, "semantics", fields, ("capacity", "persistence", "choice", "max_firings"))


def _embed(edit: _Edit, where: str, instance: str, definition: str, at: list[float] | None = None) -> None:
    own = edit.definition(where)
    _free(own, instance)
    if definition not in edit.form["definitions"]:
        raise NetError(f"there is no definition {definition!r}.{did_you_mean(definition, edit.form['definitions'])}")
    own.setdefault("modules", {})[instance] = definition
    if at is not None:
        edit.put(where, {instance: at})


def _fuse(edit: _Edit, where: str, port: str, place: str) -> None:
    definition = edit.definition(where)
    fuse = {p: t for p, t in definition.get("fuse", {}).items() if p != port}
    definition["fuse"] = {**fuse, port: place} if place else fuse
    tidy(definition)


def _move(edit: _Edit, where: str, at: dict[str, Any]) -> None:
    edit.definition(where)
    edit.put(where, at)


def _arrange(edit: _Edit, where: str) -> None:
    edit.unput(where, gone=set(edit.form.get("layout", {}).get(where, ())))


def _define(edit: _Edit, name: str) -> None:
    if name in edit.form["definitions"]:
        raise NetError(f"there is a definition {name!r} already")
    edit.form["definitions"][name] = {"places": [], "transitions": []}


def _rename_net(edit: _Edit, name: str, to: str) -> None:
    edit.definition(name)
    _define(edit, to)
    for key, instance in edit.users(name):
        edit.definition(key)["modules"][instance] = to
    known = edit.form["definitions"]
    moved = known[name]
    moved.pop("name", None)
    edit.form["definitions"] = {to if key == name else key: moved if key == name else d for key, d in known.items() if key != to}
    if edit.form["net"] == name:
        edit.form["net"] = to
    if name in edit.form.get("layout", {}):
        edit.form["layout"] = {to if key == name else key: at for key, at in edit.form["layout"].items()}


def _undefine(edit: _Edit, name: str) -> None:
    edit.definition(name)
    users = edit.users(name)
    if users or edit.form["net"] == name:
        raise NetError(f"definition {name!r} is used by {', '.join(repr(k) for k, _ in users) or 'the file, which means it'}")
    edit.unput(name, gone=set(edit.form.get("layout", {}).get(name, ())))
    del edit.form["definitions"][name]


def _take(edit: _Edit, definitions: dict[str, Any], layout: dict[str, Any] | None = None) -> None:
    if not isinstance(definitions, dict) or not all(isinstance(d, dict) for d in definitions.values()):
        raise NetError("definitions are an object of objects")
    known = edit.form["definitions"]
    names = {}
    for key, given in definitions.items():
        name, number = key, 1
        while name in known and known[name] != given:
            number += 1
            name = f"{key}_{number}"
        names[key] = name
    for key, given in definitions.items():
        made = copy.deepcopy(given)
        if "modules" in made:
            made["modules"] = {i: names.get(target, target) for i, target in made["modules"].items()}
        known.setdefault(names[key], made)
    for key, at in positions_from_layout(layout or {}).items():
        if key in names and names[key] not in edit.form.get("layout", {}):
            edit.put(names[key], at)


def _main(edit: _Edit, name: str) -> None:
    edit.definition(name)
    edit.form["net"] = name


def _all(edit: _Edit, ops: list[dict[str, Any]], what: str = "") -> None:
    for op in ops:
        edit.do(op)


OPERATIONS: Mapping[str, Callable[..., None]] = {
    "add_place": _add_place, "add_transition": _add_transition, "change": _change, "rename": _rename, "remove": _remove,
    "connect": _connect, "disconnect": _disconnect, "port": _port, "ports": _ports, "semantics": _semantics, "embed": _embed,
    "fuse": _fuse, "move": _move, "arrange": _arrange, "define": _define, "rename_net": _rename_net, "undefine": _undefine,
    "take": _take, "main": _main, "all": _all,
}  # fmt: skip
