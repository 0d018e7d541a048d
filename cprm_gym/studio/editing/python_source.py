"""Nets, models and CPRMs as Python text that makes the same value again."""

from __future__ import annotations

import dataclasses
import keyword
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Command, Input, PetriNet, Transition
from ...architecture.petri.files.json import definition_keys
from ...architecture.prm import Grounding, Model
from ...architecture.prm.model.cpds import Dense, Mixture

WIDTH = 120
_HOMES = ("cprm_gym.architecture.cprm", "cprm_gym.architecture.petri", "cprm_gym.architecture.prm")


def python_source(value: PetriNet | Model | Grounding | CPRM) -> str:
    """Python text that defines an equal value, one constant for each module.

    Parameters
    ----------
    value : PetriNet, Model, Grounding or CPRM
    """
    writer = _Writer()
    net = value if isinstance(value, PetriNet) else value.net if isinstance(value, CPRM) else None
    lines: list[str] = []
    if net is not None:
        for module, key in definition_keys(net).items():
            writer.names[module] = writer.constant(key)
            lines.append(f"{writer.names[module]} = {writer.net(module)}\n")
    if isinstance(value, CPRM):
        if value.model is not None:
            writer.model = value.model, "MODEL"
            lines.append(f"MODEL = {writer.fields(value.model, 0)}\n")
        lines.append(f"CPRM_VALUE = {writer.fields(value, 0)}\n")
    elif isinstance(value, Model):
        lines.append(f"MODEL = {writer.fields(value, 0)}\n")
    elif isinstance(value, Grounding):
        references: dict[str, dict[str, tuple[str, ...]]] = {}
        for (name, slot), targets in value.references.items():
            references.setdefault(name, {})[slot] = targets
        writer.used.add("Grounding")
        lines.append(f"MODEL = {writer.fields(value.model, 0)}\n")
        lines.append(f"WORLD = Grounding(MODEL, {writer.text(value.objects, 0)}, {writer.text(references, 0)})\n")
    return "\n".join([*writer.imports(), "", *lines])


class _Writer:
    """Writes values, and remembers which names they need."""

    def __init__(self) -> None:
        self.names: dict[PetriNet, str] = {}
        self.model: tuple[Model, str] | None = None
        self.used: set[str] = set()

    def imports(self) -> list[str]:
        """The lines that import what was used, from the faces of the packages."""
        from importlib import import_module

        found: dict[str, list[str]] = {}
        left = set(self.used)
        for home in _HOMES:
            face = import_module(home)
            mine = sorted(name for name in left if name in face.__all__)
            left -= set(mine)
            if mine:
                found[home] = mine
        lines = []
        for home, names in found.items():
            line = f"from {home} import {', '.join(names)}"
            lines.append(line if len(line) <= WIDTH else f"from {home} import (\n    " + ",\n    ".join(names) + ",\n)")
        return lines

    def constant(self, key: str) -> str:
        """A new name of a constant for a definition."""
        name = re.sub(r"\W", "_", key, flags=re.ASCII).upper()
        name = name if name[:1].isalpha() and not keyword.iskeyword(name) else f"NET_{name}"
        taken, number, made = {*self.names.values(), "MODEL", "WORLD", "CPRM", "CPRM_VALUE"}, 1, name
        while made in taken:
            number += 1
            made = f"{name}_{number}"
        return made

    def net(self, net: PetriNet) -> str:
        """The call that makes a net."""
        self.used.add("PetriNet")
        parts = [repr(net.name)]
        if net.ports != type(net.ports)():
            parts.append(f"ports={self.fields(net.ports, 4)}")
        parts += [f"{kind}={self.text(value, 4)}" for kind, value in (("places", net.places), ("transitions", net.transitions)) if value]
        if net.modules:
            parts.append("modules={" + ", ".join(f"{i!r}: {self.names[m]}" for i, m in net.modules.items()) + "}")
        if net.fuse:
            parts.append(f"fuse={self.text(dict(net.fuse), 4)}")
        if net.semantics != type(net.semantics)():
            parts.append(f"semantics={self.fields(net.semantics, 4)}")
        return "PetriNet(\n    " + ",\n    ".join(parts) + ",\n)"

    def text(self, value: Any, indent: int) -> str:
        """Any part of a net or model."""
        if isinstance(value, PetriNet):
            return self.names[value]
        if self.model is not None and value is self.model[0]:
            return self.model[1]
        if isinstance(value, np.ndarray):
            return self.group("[", [self.text(v, indent + 4) for v in value.tolist()], "]", indent)
        if isinstance(value, Mapping):
            return self.group("{", [f"{self.text(k, 0)}: {self.text(v, indent + 4)}" for k, v in value.items()], "}", indent)
        if isinstance(value, (tuple, list)):
            items = [self.text(v, indent + 4) for v in value]
            return f"({items[0]},)" if len(items) == 1 and "\n" not in items[0] else self.group("(", items, ")", indent)
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            return self.fields(value, indent)
        return repr(value)

    def group(self, left: str, items: list[str], right: str, indent: int) -> str:
        """Items on one line, or one below the other where they do not fit."""
        line = left + ", ".join(items) + right
        if len(line) + indent <= WIDTH and "\n" not in line:
            return line
        pad = " " * (indent + 4)
        return left + "\n" + "".join(f"{pad}{item},\n" for item in items) + " " * indent + right

    def fields(self, value: Any, indent: int) -> str:
        """The call that makes a dataclass, fields with their default left out."""
        name = type(value).__name__
        self.used.add(name)
        if isinstance(value, Mixture):
            return self.group("Mixture(", [self.text(part, indent + 4) for part in value.parts], ")", indent)
        if isinstance(value, Dense):
            domains = [] if value.domains is None else [f"domains={self.text(value.domains, indent + 4)}"]
            return self.group("Dense(", [self.text(value.values, indent + 4), *domains], ")", indent)
        if isinstance(value, Command):
            given = [repr(value.name)]
            plain = all(key.isidentifier() and not keyword.iskeyword(key) for key in value.params)
            given += [f"{k}={v!r}" for k, v in value.params.items()] if plain else [f"**{dict(value.params)!r}"] if value.params else []
            return self.group("Command(", given, ")", indent)
        made: list[str] = []
        for field in dataclasses.fields(value):
            held = getattr(value, field.name)
            if not field.init or self.is_default(value, field, held):
                continue
            written = self.text(held, indent + 4)
            made.append(written if not made and field.name == "name" else f"{field.name}={written}")
        return self.group(f"{name}(", made, ")", indent)

    @staticmethod
    def is_default(value: Any, field: dataclasses.Field[Any], held: Any) -> bool:
        """Whether a field need not be written."""
        if isinstance(value, Transition):  # its fields have no defaults of their own
            usual = {"delay": 0, "priority": 0, "emits": None, "weight": 1.0, "memory": "enabling", "servers": 1, "set_wins": False}
            return bool(held == usual[field.name]) if field.name in usual else field.name != "name" and not held
        if isinstance(value, Input) and field.name == "observes":
            return bool(held == value.name)
        if field.default is not dataclasses.MISSING:
            return type(held) is type(field.default) and bool(held == field.default)
        return field.default_factory is not dataclasses.MISSING and bool(held == field.default_factory())
