"""Nets as JSON: lossless, versioned, with the hierarchy.

A file holds each module once, under ``definitions``; instances refer to it by name::

    {"format": "cprm_gym net", "version": 1, "net": "approach",
     "definitions": {"orient": {"places": [...], "transitions": [...]},
                     "approach": {"modules": {"orient": "orient"}, ...}},
     "layout": {"approach": {"begin": [40, 12], ...}}}

``layout`` is where somebody put parts of a drawing by hand (`positions.py`); it may be left out and means nothing to the net.
Fields that have their default are left out. Reading checks everything that writing a net in Python checks.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from ....errors import NetError, did_you_mean
from ....files import write_atomically
from ..net.checks import shown
from ..net.net import PetriNet, depth_first_order
from ..net.places import PLACE_KINDS, AnyPlace, Belief, Continuous, Input, Math, ObjectPlace, Place, Selection
from ..net.ports import Ports
from ..net.semantics import Semantics
from ..net.transitions import Command, Transition

FORMAT, VERSION = "cprm_gym net", 1
MAX_BYTES = 2**24
"""Longest text that is read."""

_KINDS: Mapping[str, type[Any]] = {
    "place": Place,
    "continuous": Continuous,
    "input": Input,
    "belief": Belief,
    "math": Math,
    "object": ObjectPlace,
}
_KIND_OF = {cls: kind for kind, cls in _KINDS.items()}
assert set(_KIND_OF) == set(PLACE_KINDS)

_TRANSITION_DEFAULTS: Mapping[str, Any] = {
    "inputs": {}, "outputs": {}, "tests": {}, "inhibitors": {}, "sets": {}, "delay": 0, "priority": 0, "emits": None,
    "weight": 1.0, "memory": "enabling", "servers": 1, "set_wins": False,
}  # fmt: skip


def definition_keys(net: PetriNet) -> dict[PetriNet, str]:
    """The key under which each module of a net, and the net itself, stands among the definitions, inner ones first."""
    keys: dict[PetriNet, str] = {}
    taken: set[str] = set()

    def define(module: PetriNet) -> None:
        if module in keys:
            return
        for inner in module.modules.values():
            define(inner)
        key, number = module.name, 1
        while key in taken:
            number += 1
            key = f"{module.name}#{number}"
        keys[module] = key
        taken.add(key)

    define(net)
    return keys


def net_to_dict(net: PetriNet) -> dict[str, Any]:
    """The JSON form of a net, as plain dictionaries and lists."""
    keys = definition_keys(net)
    definitions: dict[str, dict[str, Any]] = {}
    for module, key in keys.items():
        modules = {instance: keys[inner] for instance, inner in module.modules.items()}
        written: dict[str, Any] = {} if key == module.name else {"name": module.name}
        written["places"] = [_place_to_dict(place) for place in module.places]
        written["transitions"] = [_transition_to_dict(t) for t in module.transitions]
        for name, value in (("modules", modules), ("fuse", dict(module.fuse))):
            if value:
                written[name] = value
        for name, part in (("ports", module.ports), ("semantics", module.semantics)):
            if part_fields := _changed_fields(part):
                written[name] = part_fields
        definitions[key] = written
    return {"format": FORMAT, "version": VERSION, "net": keys[net], "definitions": definitions}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return [_plain(inner) for inner in value] if isinstance(value, tuple) else value


def _changed_fields(part: Any) -> dict[str, Any]:
    """The fields of a dataclass that do not have their default."""
    found = {}
    for field in fields(part):
        value = getattr(part, field.name)
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        if value != default:
            found[field.name] = _plain(value)
    return found


def _place_to_dict(place: AnyPlace) -> dict[str, Any]:
    written = {"kind": _KIND_OF[type(place)], **_changed_fields(place)}
    if isinstance(place, ObjectPlace) and place.select is not None:
        written["select"] = _changed_fields(place.select)
    if isinstance(place, Input) and place.observes == place.name:
        del written["observes"]
    return written


def _transition_to_dict(t: Transition) -> dict[str, Any]:
    written: dict[str, Any] = {"name": t.name}
    for key, default in _TRANSITION_DEFAULTS.items():
        value = getattr(t, key)
        if key == "emits" and value is not None:
            written[key] = {"command": t.emits.name if t.emits else "", "params": dict(value.params)}
        elif value != default:
            written[key] = _plain(value)
    return written


def net_from_dict(data: object, net: str | None = None) -> PetriNet:
    """The net that a JSON form describes.

    Parameters
    ----------
    data : object
        What a JSON parser made of a file.
    net : str, optional
        The key of the definition that is wanted; default the one that ``net`` names there.

    Raises
    ------
    NetError
        Where it is not of that form, or describes a net that is not valid; the message says where.
    """
    nets = nets_from_dict(data)
    assert isinstance(data, dict)
    wanted = data.get("net") if net is None else net
    if not isinstance(wanted, str) or wanted not in nets:
        where = "'net' names" if net is None else "no net"
        raise NetError(
            f"{where} {shown(wanted)}, which is not defined.{did_you_mean(str(wanted)[:80], nets)} Defined: {', '.join(nets) or 'none'}"
        )
    return nets[wanted]


def nets_from_dict(data: object) -> dict[str, PetriNet]:
    """Every net that a JSON form defines, by the keys of the definitions, inner ones first.

    Raises
    ------
    NetError
        As `net_from_dict`.
    """
    top = _mapping(data, "the file", _TOP_KEYS)
    if top.get("format") != FORMAT:
        raise NetError(f"not a net: 'format' is {shown(top.get('format'))}, expected {FORMAT!r}")
    if top.get("version") != VERSION:
        raise NetError(f"version {shown(top.get('version'))} of the net format; this package reads version {VERSION}")
    definitions = _mapping(top.get("definitions"), "'definitions'")
    written = {key: _mapping(value, f"definition {key!r}", _NET_KEYS) for key, value in definitions.items()}
    edges = {}
    for key, value in written.items():
        edges[key] = list(_mapping(value.get("modules", {}), f"definition {key!r}: 'modules'").values())
        for target in edges[key]:
            if not isinstance(target, str) or target not in written:
                raise NetError(f"definition {key!r}: unknown module {shown(target)}.{did_you_mean(shown(target), written)}")
    order = depth_first_order(edges, lambda circle: f"modules contain each other in a circle: {circle}")
    nets: dict[str, PetriNet] = {}
    for key in order:
        nets[key] = _net(key, written[key], nets)
    return nets


_TOP_KEYS = ("format", "version", "net", "definitions", "layout")
_NET_KEYS = ("name", "places", "transitions", "modules", "fuse", "ports", "semantics")


def _mapping(value: object, where: str, allowed: tuple[str, ...] | None = None) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise NetError(f"{where}: expected an object, got {type(value).__name__}")
    for key in value:
        if allowed is not None and key not in allowed:
            raise NetError(f"{where}: unknown entry {shown(key)}.{did_you_mean(key[:80], allowed)} Known: {', '.join(allowed)}")
    return value


def _list(value: object, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise NetError(f"{where}: expected a list, got {type(value).__name__}")
    return value


def _call(make: Callable[..., Any], where: str, arguments: Mapping[str, Any]) -> Any:
    try:
        return make(**arguments)
    except TypeError as error:
        raise NetError(f"{where}: {error}") from None
    except NetError as error:
        raise NetError(f"{where}: {error}") from None


def _dataclass(cls: type[Any], value: object, where: str) -> Any:
    allowed = tuple(field.name for field in fields(cls))
    given = {key: tuple(v) if isinstance(v, list) else v for key, v in _mapping(value, where, allowed).items()}
    if cls is Ports and "answers" in given:
        answers = _mapping(given["answers"], f"{where}: 'answers'")
        given["answers"] = {key: tuple(_list(v, f"{where}: 'answers'")) for key, v in answers.items()}
    for field in fields(cls):
        if field.default is MISSING and field.default_factory is MISSING and field.name not in given:
            raise NetError(f"{where}: has no {field.name!r}")
    return _call(cls, where, given)


def _net(key: str, data: Mapping[str, Any], nets: Mapping[str, PetriNet]) -> PetriNet:
    where = f"definition {key!r}"
    places = [_place(p, f"{where}: place {i}") for i, p in enumerate(_list(data.get("places", []), f"{where}: 'places'"))]
    listed = _list(data.get("transitions", []), f"{where}: 'transitions'")
    transitions = [_transition(t, f"{where}: transition {i}") for i, t in enumerate(listed)]
    arguments = {
        "name": data.get("name", key),
        "places": tuple(places),
        "transitions": tuple(transitions),
        "modules": {instance: nets[target] for instance, target in data.get("modules", {}).items()},
        "fuse": _mapping(data.get("fuse", {}), f"{where}: 'fuse'"),
        "ports": _dataclass(Ports, data.get("ports", {}), f"{where}: 'ports'"),
        "semantics": _dataclass(Semantics, data.get("semantics", {}), f"{where}: 'semantics'"),
    }
    net: PetriNet = _call(PetriNet, where, arguments)
    return net


def _place(data: object, where: str) -> AnyPlace:
    given = dict(_mapping(data, where))
    kind = given.pop("kind", None)
    if not isinstance(kind, str) or kind not in _KINDS:
        raise NetError(f"{where}: unknown kind {shown(kind)}.{did_you_mean(shown(kind), _KINDS)} Known: {', '.join(_KINDS)}")
    if kind == "object" and "select" in given:
        given["select"] = _dataclass(Selection, given["select"], f"{where}: 'select'")
    place: AnyPlace = _dataclass(_KINDS[kind], given, where)
    return place


def _transition(data: object, where: str) -> Transition:
    given = dict(_mapping(data, where, ("name", *_TRANSITION_DEFAULTS)))
    if given.get("emits") is not None:
        emits = _mapping(given["emits"], f"{where}: 'emits'", ("command", "params"))
        params = _mapping(emits.get("params", {}), f"{where}: 'params'")
        name = emits.get("command")
        given["emits"] = _call(lambda **values: Command(name, **values), f"{where}: 'emits'", params)  # type: ignore[arg-type]
    for key in ("inputs", "outputs", "tests", "inhibitors", "sets"):
        if key in given:
            given[key] = _mapping(given[key], f"{where}: {key!r}")
    if "name" not in given:
        raise NetError(f"{where}: has no 'name'")
    transition: Transition = _call(Transition, where, given)
    return transition


def net_to_json(net: PetriNet) -> str:
    """The net as JSON text."""
    return json.dumps(net_to_dict(net), indent=1, ensure_ascii=False) + "\n"


def net_from_json(text: str, net: str | None = None) -> PetriNet:
    """The net that a JSON text describes, equal to the one that was written.

    Raises
    ------
    NetError
        Where it is no JSON, longer than `MAX_BYTES`, or `net_from_dict` refuses it.
    """
    return net_from_dict(_parsed(text), net)


def json_names(text: str) -> tuple[str, ...]:
    """The keys of the nets that a JSON text defines."""
    top = _mapping(_parsed(text), "the file", _TOP_KEYS)
    return tuple(_mapping(top.get("definitions"), "'definitions'"))


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """A JSON object; an entry that stands twice has no meaning."""
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        double = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise NetError(f"the entry {shown(double)} stands twice in one object")
    return found


def _parsed(text: str) -> object:
    if len(text) > MAX_BYTES:
        raise NetError(f"{len(text):,} characters; nets of up to {MAX_BYTES:,} are read")
    try:
        return json.loads(text, object_pairs_hook=_object)
    except NetError:
        raise
    except (ValueError, RecursionError) as error:
        raise NetError(f"not JSON: {error}") from None


def save_net(net: PetriNet, path: str | os.PathLike[str]) -> None:
    """Write a net to a JSON file, all of it or nothing."""
    write_atomically(path, net_to_json(net))
