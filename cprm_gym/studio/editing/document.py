"""A document that is being edited: a net, a model, objects with their model, or a CPRM with all of them; with undo and redo.

Its content is the JSON form of its file, so that what is saved is what was seen. A net is valid after every operation, or the operation is
refused; a model may be unfinished for a while, and what is wrong with it is said (`problems`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...architecture.cprm import CPRM
from ...architecture.cprm.files import FORMAT as CPRM_FORMAT
from ...architecture.cprm.files import cprm_from_json, cprm_to_json
from ...architecture.petri import PetriNet
from ...architecture.petri.files.json import FORMAT as NET_FORMAT
from ...architecture.petri.files.json import net_from_dict, net_to_dict, nets_from_dict
from ...architecture.petri.files.positions import Positions, positions_from_layout, with_positions
from ...architecture.prm import Grounding, Model, model_from_json, model_to_json, world_from_json, world_to_json
from ...architecture.prm.interchange.json import FORMAT as MODEL_FORMAT
from ...architecture.prm.interchange.json import json_text
from ...errors import CprmError, FormatError
from . import model_operations, net_operations

Value = PetriNet | Model | Grounding | CPRM
STEPS = 500
"""Operations that can be undone."""


@dataclass(frozen=True)
class State:
    """What a document holds at one moment.

    Attributes
    ----------
    data : dict
        The JSON form; never changed in place.
    what : str
        The operation that led here, in words.
    """

    data: dict[str, Any]
    what: str = ""


@dataclass
class Document:
    """A document and its history.

    Parameters
    ----------
    name : str
        As it is shown.
    data : dict
        A JSON form: of a net, a relational model (with objects or without) or a CPRM.

    Attributes
    ----------
    revision : int
        Grows with every change, undone or done again.
    """

    name: str
    data: dict[str, Any]
    revision: int = 0
    _past: list[State] = field(default_factory=list)
    _future: list[State] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.kind == "":
            raise FormatError(f"{self.name}: neither a net nor a model nor a CPRM: 'format' is {self.data.get('format')!r}")
        self._now = State(self.data)

    @property
    def kind(self) -> str:
        """``net``, ``model``, ``world`` (a model with objects) or ``cprm``."""
        known = {NET_FORMAT: "net", CPRM_FORMAT: "cprm", MODEL_FORMAT: "world" if "objects" in self.data else "model"}
        found = self.data.get("format")
        return known.get(found, "") if isinstance(found, str) else ""

    @property
    def net(self) -> dict[str, Any] | None:
        """The JSON form of its net."""
        return self.data if self.kind == "net" else self.data.get("net") if self.kind == "cprm" else None

    @property
    def model(self) -> dict[str, Any] | None:
        """The JSON form of its model, with format and version."""
        return self.data if self.kind in ("model", "world") else self.data.get("model") if self.kind == "cprm" else None

    @property
    def positions(self) -> Positions:
        """Where parts of its net were put by hand."""
        return positions_from_layout((self.net or {}).get("layout", {}))

    # -- changes --------------------------------------------------------------------------------------------------------------------

    def apply(self, op: Mapping[str, Any], part: str = "net") -> None:
        """Do an operation of `net_operations` or `model_operations`.

        Raises
        ------
        CprmError
            When it does not fit, or its net would not be valid; the document is then as before.
        """
        form = self.net if part == "net" else self.model
        if form is None:
            raise FormatError(f"{self.name} has no {part}")
        try:
            self._apply(form, op, part)
        except CprmError:
            self.data = self._now.data
            raise

    def _apply(self, form: dict[str, Any], op: Mapping[str, Any], part: str) -> None:
        if part == "net":
            made = net_operations.apply(form, op)
            net_from_dict(made)  # builds every definition
        else:
            made = self._model_part(model_operations.apply(self._model_form(form), op))
        self.put(self._with(part, made), describe(op))

    def _model_form(self, form: dict[str, Any]) -> dict[str, Any]:
        """A model's form with the objects, which stand beside it in a CPRM."""
        return form if self.kind != "cprm" else {**form, "objects": self.data["objects"], "references": self.data.get("references", {})}

    def _model_part(self, made: dict[str, Any]) -> dict[str, Any]:
        if self.kind != "cprm":
            return made
        self.data = {**self.data, "objects": made["objects"], "references": made["references"]}
        return {key: value for key, value in made.items() if key not in ("objects", "references")}

    def _with(self, part: str, form: dict[str, Any]) -> dict[str, Any]:
        return {**self.data, part: form} if self.kind == "cprm" else form

    def put(self, data: dict[str, Any], what: str) -> None:
        """Take other content; the former can be had back by `undo`."""
        self._past.append(self._now)
        del self._past[:-STEPS]
        self._future.clear()
        self._become(State(data, what))

    def freeze(self, definition: str, at: Mapping[str, Any]) -> None:
        """Fix the positions of a definition's parts as they are shown, a part of the operation that comes next."""
        assert self.net is not None
        self.data = self._with("net", net_operations.apply(self.net, {"op": "move", "in": definition, "at": dict(at)}))

    def undo(self) -> bool:
        """Take back the last operation; False when there is none."""
        if not self._past:
            return False
        self._future.append(self._now)
        self._become(self._past.pop())
        return True

    def redo(self) -> bool:
        """Do again what was taken back last; False when there is none."""
        if not self._future:
            return False
        self._past.append(self._now)
        self._become(self._future.pop())
        return True

    def _become(self, state: State) -> None:
        self._now, self.data = state, state.data
        self.revision += 1

    @property
    def history(self) -> dict[str, str]:
        """What would be undone and done again, in words; empty for nothing."""
        return {"undo": self._now.what if self._past else "", "redo": self._future[-1].what if self._future else ""}

    # -- values ---------------------------------------------------------------------------------------------------------------------

    def value(self) -> Value:
        """What the document means.

        Raises
        ------
        CprmError
            When it is not valid.
        """
        if self.kind == "net":
            return net_from_dict(self.data)
        text = json.dumps(self.data)
        if self.kind == "cprm":
            return cprm_from_json(text, self.name)
        return world_from_json(text, self.name) if self.kind == "world" else model_from_json(text, self.name)

    def definition(self, key: str | None = None) -> PetriNet:
        """One of its nets, by default the one that the file means."""
        if self.net is None:
            raise FormatError(f"{self.name} has no net")
        return net_from_dict(self.net, key)

    def definitions(self) -> dict[str, PetriNet]:
        """All its nets, by the keys of their definitions."""
        return {} if self.net is None else nets_from_dict(self.net)

    def model_value(self) -> Model:
        """Its model."""
        if self.model is None:
            raise FormatError(f"{self.name} has no model")
        return model_from_json(json.dumps(self.model), self.name)

    def grounding(self) -> Grounding:
        """Its model with its objects; without any, one object of each class that can have objects."""
        model = self.model_value()
        objects = self.data.get("objects") or {c.name.lower(): c.name for c in model.classes if not c.abstract}
        return Grounding(model, objects, self.data.get("references") or {})

    def problem(self) -> str:
        """Why it is not valid; empty when it is."""
        try:
            self.value()
        except CprmError as error:
            return str(error)
        return ""

    def text(self) -> str:
        """The content of its file in JSON."""
        if self.kind in ("net", "cprm"):
            return json.dumps(self.data, indent=1, ensure_ascii=False) + "\n"
        return json_text(self.data) + "\n"


def describe(op: Mapping[str, Any]) -> str:
    """An operation in words, for a button that undoes it."""
    name = str(op.get("op", "")).replace("_", " ")
    if name == "all":
        ops = op.get("ops") or [{}]
        return str(op.get("what") or describe(ops[0]))
    part = op.get("place") or op.get("transition") or op.get("name") or op.get("instance") or op.get("names") or ""
    part = part.get("name", "") if isinstance(part, dict) else ", ".join(map(str, part[:3])) if isinstance(part, list) else part
    path = op.get("path")
    if path:
        part = str(next((p for p in reversed(path) if isinstance(p, str)), ""))
    return f"{name} {part}".strip()


def form_of(value: Value, positions: Positions | None = None) -> dict[str, Any]:
    """The JSON form of a value, as a document holds it."""
    if isinstance(value, PetriNet):
        return with_positions(net_to_dict(value), positions)
    writer = {CPRM: cprm_to_json, Grounding: world_to_json, Model: model_to_json}
    text = next(write for kind, write in writer.items() if isinstance(value, kind))(value)  # type: ignore[arg-type, operator]
    made: dict[str, Any] = json.loads(text)
    return made
