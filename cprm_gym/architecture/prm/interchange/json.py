"""Models as JSON text: what is read back is equal to what was written, numbers to the last bit.

A value is an object with ``"is"``, the name of its class, and its fields; fields that have their default are left out. Nothing
in a file is executed.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ....errors import CprmError, FormatError, did_you_mean
from ....files import parse_json, read_bounded, write_atomically
from ..grounding.grounding import Grounding
from ..model import aggregates, cpds, domains, schema
from ..model.model import Model

FORMAT = "cprm_gym relational model"
VERSION = 1
MAX_FILE_BYTES = 64 * 1024 * 1024
"""Largest file that is read."""

LINE = 120
"""Length up to which a part of a model is written on one line."""

_TYPES: dict[str, type] = {
    t.__name__: t
    for t in (
        domains.Labels, domains.Bins, domains.Real, domains.Angle,
        cpds.Uniform, cpds.Prior, cpds.Table, cpds.Dense, cpds.Noise, cpds.Chance, cpds.Switch, cpds.Mixture, cpds.NoisyOr,
        aggregates.Exists, aggregates.All, aggregates.Count, aggregates.Min, aggregates.Max, aggregates.Mean,
        aggregates.AnyCause,
        schema.Attribute, schema.Given, schema.Reference, schema.PRMClass, schema.Replace, schema.Add, schema.Relation,
        Model,
    )
}  # fmt: skip

_FORMER = {"Input": "Given", "inputs": "given"}
"""Words of older files and what they are called now."""

_MAKERS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "Mixture": lambda fields: cpds.Mixture(*((weight, part) for weight, part in fields["parts"])),
    "Table": lambda fields: cpds.Table([(tuple(key), tuple(row)) for key, row in fields["rows"]]),
}


def model_to_json(model: Model) -> str:
    """The model as JSON text.

    Parameters
    ----------
    model : Model
    """
    return json_text({"format": FORMAT, "version": VERSION, "model": _encode(model)}) + "\n"


def model_from_json(text: str, where: str = "model") -> Model:
    """The model that a JSON text holds, checked like any other.

    Parameters
    ----------
    text : str
    where : str
        Named in errors.

    Raises
    ------
    FormatError
        If the text is not a model; the message says at which place.
    ModelError
        If the model in it is not well defined.
    """
    value = _decode(_document(text, where, "model"), f"{where}: model")
    if not isinstance(value, Model):
        raise FormatError(f"{where}: holds a {type(value).__name__}, not a Model")
    return value


def world_to_json(grounding: Grounding) -> str:
    """A model with its objects and references as JSON text."""
    references: dict[str, dict[str, list[str]]] = {}
    for (name, slot), targets in grounding.references.items():
        references.setdefault(name, {})[slot] = list(targets)
    body = {"model": _encode(grounding.model), "objects": grounding.objects, "references": references}
    return json_text({"format": FORMAT, "version": VERSION, **body}) + "\n"


def world_from_json(text: str, where: str = "world") -> Grounding:
    """The objects and the model that a JSON text holds.

    Raises
    ------
    FormatError
    ModelError
    """
    model = model_from_json(text, where)
    objects = _document(text, where, "objects")
    references = _document(text, where, "references")
    if not isinstance(objects, dict) or not all(isinstance(c, str) for c in objects.values()):
        raise FormatError(f"{where}: 'objects' must map names to classes")
    lists = isinstance(references, dict) and all(
        isinstance(slots, dict) and all(isinstance(t, list) and all(isinstance(x, str) for x in t) for t in slots.values())
        for slots in references.values()
    )
    if not lists:
        raise FormatError(f"{where}: 'references' must map objects to slots to lists of objects")
    return Grounding(model, objects, references)


def save_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model to a file, all or nothing."""
    write_atomically(path, model_to_json(model))


def load_model(path: str | os.PathLike[str]) -> Model:
    """Read a model from a file.

    Raises
    ------
    FormatError
        If the file cannot be read or is not a model.
    ModelError
    """
    return model_from_json(read_text(path), str(path))


def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a file, or a `FormatError` that names it."""
    try:
        return read_bounded(path, MAX_FILE_BYTES).decode()
    except UnicodeDecodeError as error:
        raise FormatError(f"{path}: cannot be read: {error}") from None


def _document(text: str, where: str, part: str) -> Any:
    document = parse_json(text, where)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FormatError(f"{where}: not a relational model: 'format' must be {FORMAT!r}")
    if document.get("version") != VERSION:
        raise FormatError(f"{where}: version {document.get('version')!r}; this program reads version {VERSION}")
    if part not in document:
        raise FormatError(f"{where}: has no {part!r}")
    return document[part]


def json_text(value: Any, indent: int = 0) -> str:
    """JSON with every row of numbers, and everything else that fits, on one line."""
    short = json.dumps(value, allow_nan=False)
    parted = isinstance(value, dict) or (isinstance(value, list) and any(isinstance(v, dict | list) for v in value))
    if len(short) + indent <= LINE or not parted:
        return short
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        parts = [f"{json.dumps(k)}: {json_text(v, indent + 1)}" for k, v in value.items()]
    else:
        parts = [json_text(v, indent + 1) for v in value]
    left, right = "{}" if isinstance(value, dict) else "[]"
    return f"{left}\n{pad}" + f",\n{pad}".join(parts) + f"\n{' ' * indent}{right}"


def _encode(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [_encode(v) for v in value]
    if isinstance(value, Mapping):
        return {k: _encode(v) for k, v in value.items()}
    if not dataclasses.is_dataclass(value):
        return value
    out: dict[str, Any] = {"is": type(value).__name__}
    for f in dataclasses.fields(value):
        item = getattr(value, f.name)
        if not _is_default(f, item):
            out[f.name] = _encode(item)
    return out


def _is_default(f: dataclasses.Field[Any], item: Any) -> bool:
    if f.default is not dataclasses.MISSING:
        return type(item) is type(f.default) and bool(item == f.default)
    if f.default_factory is not dataclasses.MISSING:
        return bool(item == f.default_factory())
    return False


def _decode(value: Any, where: str) -> Any:
    if isinstance(value, list):
        return tuple(_decode(v, f"{where}[{k}]") for k, v in enumerate(value))
    if not isinstance(value, dict):
        return value
    name = str(value.get("is"))
    name = _FORMER.get(name, name)
    if name not in _TYPES:
        hint = did_you_mean(name, _TYPES)
        raise FormatError(f"{where}: 'is' must name a part of a model, got {name!r}.{hint}")
    made = _TYPES[name]
    allowed = {f.name for f in dataclasses.fields(made)}
    label = value.get("name", value.get("target", ""))
    here = f"{where}.{name}{f' {label!r}' if label else ''}"
    fields = {}
    for key, item in value.items():
        if key == "is":
            continue
        key = key if key in allowed else str(_FORMER.get(key, key))
        if key not in allowed:
            raise FormatError(f"{here}: unknown field {key!r}.{did_you_mean(key, allowed)}")
        fields[key] = _decode(item, f"{here}.{key}")
    try:
        return _MAKERS[name](fields) if name in _MAKERS else made(**fields)
    except CprmError as error:
        raise type(error)(f"{here}: {error}") from None
    except (TypeError, ValueError, LookupError, AttributeError, ArithmeticError) as error:
        raise FormatError(f"{here}: cannot be made from {sorted(fields)}: {error}") from None
