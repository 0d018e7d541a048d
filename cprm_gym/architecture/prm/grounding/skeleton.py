"""The objects of a world: their classes, and whom their references mean."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

from ....errors import ModelError, did_you_mean
from ..model.model import Model
from .slices import GroundCPD, GroundVariable


class Skeleton:
    """A model and the objects of a world.

    Parameters
    ----------
    model, objects, references
        As for `Grounding`.

    Attributes
    ----------
    members : dict of str to tuple of str
        Class -> its objects, those of its subclasses among them.
    variables, cpds : dict
        Parts of slices, shared by those that have them.
    static : tuple of str
        Names of the variables that are drawn once and never again.
    references : dict of (object, slot) to tuple of str
        Those that were given.
    """

    def __init__(self, model: Model, objects: Mapping[str, str], references: Mapping[str, Mapping[str, Any]] | None = None) -> None:
        self.model = model
        self.where = f"model {model.name!r}"
        for what, given in (("objects", objects), ("references", references or {})):
            if not isinstance(given, Mapping):
                raise ModelError(f"{self.where}: `{what}` is a mapping, got {given!r}")
        self.objects = dict(objects)
        checked = model.checked
        self.members: dict[str, tuple[str, ...]] = {}
        for name, class_name in self.objects.items():
            if not isinstance(name, str) or not name or set(name) & set(".(),#* "):
                raise ModelError(f"{self.where}: an object name must not be empty or hold any of '.(),#* ', got {name!r}")
            if class_name not in checked.classes:
                hint = did_you_mean(class_name, checked.classes)
                raise ModelError(f"{self.where}, object {name!r}: unknown class {class_name!r}.{hint}")
            if checked.classes[class_name].abstract:
                raise ModelError(f"{self.where}, object {name!r}: class {class_name!r} is abstract")
        for class_name in checked.classes:
            self.members[class_name] = tuple(o for o, c in self.objects.items() if checked.is_a(c, class_name))
        self.variables: dict[str, GroundVariable] = {}
        self.cpds: dict[str, dict[Hashable, GroundCPD]] = {}
        self.static = tuple(f"{o}.{a.name}" for o, c in self.objects.items() for a in checked.classes[c].attributes.values() if a.static)
        self.references: dict[tuple[str, str], tuple[str, ...]] = {}
        for name, slots in (references or {}).items():
            self._set_references(name, slots)

    def _set_references(self, name: str, slots: Mapping[str, Any]) -> None:
        checked = self.model.checked
        if name not in self.objects:
            raise ModelError(f"{self.where}, references: unknown object {name!r}.{did_you_mean(name, self.objects)}")
        known = checked.classes[self.objects[name]].references
        for slot, value in slots.items():
            where = f"{self.where}, object {name!r}, reference {slot!r}"
            if slot not in known:
                raise ModelError(f"{where}: class {self.objects[name]!r} has no such reference.{did_you_mean(slot, known)}")
            targets = (value,) if isinstance(value, str) else tuple(value)
            if not known[slot].many and len(targets) != 1:
                raise ModelError(f"{where}: holds one object, got {targets}")
            for target in targets:
                if target not in self.members[known[slot].target]:
                    options = self.members[known[slot].target]
                    hint = did_you_mean(target, options)
                    raise ModelError(f"{where}: {target!r} is not a {known[slot].target}.{hint} Known: {', '.join(options)}")
            self.references[name, slot] = targets
