"""Mixtures of real numbers with a hidden attribute for which part it was, so that what is learned of switches is learned of them.

`em` unfolds a model, learns tables and `Noise` as ever, and folds what it has learned: the hidden attribute's table is the weights.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...model.cpds import Dense, Mixture, Prior, Switch
from ...model.domains import Labels, is_continuous
from ...model.model import Model
from ...model.schema import Add, Attribute, PRMClass, parent_text

LEAST = 1e-12
"""The least weight of a part: one without any would never come back."""


@dataclass(frozen=True)
class Unfolded:
    """Where a mixture stood.

    Attributes
    ----------
    owner, attribute, part : str
        Class, attribute, and ``cpd`` or ``initial``.
    hidden : str
        Attribute that says which of its parts it is.
    begins : bool
        The weights are those of the first slice alone.
    """

    owner: str
    attribute: str
    part: str
    hidden: str
    begins: bool

    @property
    def key(self) -> tuple[str, ...]:
        """Of the CPD."""
        return "class", self.owner, self.attribute, self.part

    @property
    def hidden_key(self) -> tuple[str, ...]:
        """Of the table of the hidden attribute."""
        return "class", self.owner, self.hidden, "initial" if self.begins else "cpd"


def unfold(model: Model) -> tuple[Model, tuple[Unfolded, ...]]:
    """The model with a hidden attribute for each `Mixture` that is the whole CPD of a class's real number, and what they stand for."""
    found: list[Unfolded] = []
    # a change that adds parents counts on the target's own, in their order
    added = {c.target.rpartition(".")[2] for r in model.relations for c in r.changes if isinstance(c, Add)}
    classes = tuple(_class(each, found, added) for each in model.classes)
    return (replace(model, classes=classes) if found else model), tuple(found)


def _class(each: PRMClass, found: list[Unfolded], added: Collection[str]) -> PRMClass:
    attributes: list[Attribute] = []
    names = {a.name for a in each.attributes} | {g.name for g in each.given} | {r.name for r in each.references}
    for attribute in each.attributes:
        for part in ("cpd", "initial"):
            cpd = getattr(attribute, part)
            if not isinstance(cpd, Mixture) or not is_continuous(attribute.domain) or attribute.name in added:
                continue
            hidden = f"{attribute.name}_{part}_is"
            while hidden in names:
                hidden += "_"
            names.add(hidden)
            states = tuple(f"part{k}" for k in range(len(cpd.parts)))
            weights = Prior(tuple(w for w, _ in cpd.parts))
            # of a number that begins otherwise the first slice tells nothing of how it goes on
            back = any(parent_text(p).startswith("prev.") for p in attribute.parents)
            apart = not attribute.static and (part == "initial" or attribute.initial is not None or back)
            attributes.append(Attribute(hidden, Labels(states), weights, initial=weights if apart else None, static=attribute.static))
            found.append(Unfolded(each.name, attribute.name, part, hidden, part == "initial" and apart))
            parents = "parents" if part == "cpd" else "initial_parents"
            turned: Any = {
                part: Switch(hidden, list(zip(states, (c for _, c in cpd.parts)))), parents: (*getattr(attribute, parents), hidden),
            }  # fmt: skip
            attribute = replace(attribute, **turned)
        attributes.append(attribute)
    return replace(each, attributes=tuple(attributes))


def fold(model: Model, unfolded: Sequence[Unfolded]) -> Model:
    """An unfolded model with mixtures again, whose weights are what the hidden attributes' tables say."""
    classes = []
    for each in model.classes:
        own = {a.name: a for a in each.attributes}
        mine = [u for u in unfolded if u.owner == each.name]
        for u in mine:
            hidden, parents = own.pop(u.hidden), "parents" if u.part == "cpd" else "initial_parents"
            table = getattr(hidden, u.hidden_key[3])
            given = table.values if isinstance(table, Dense) else table.p
            weights = np.maximum(np.asarray(given, np.float64), LEAST)
            switch = getattr(own[u.attribute], u.part)
            mixture = Mixture(*((float(w), c) for w, (_, c) in zip(weights / weights.sum(), switch.cases)))
            turned: Any = {u.part: mixture, parents: getattr(own[u.attribute], parents)[:-1]}
            own[u.attribute] = replace(own[u.attribute], **turned)
        classes.append(replace(each, attributes=tuple(own.values())) if mine else each)
    return replace(model, classes=tuple(classes))


def with_hidden(only: Sequence[tuple[str, ...]] | None, unfolded: Sequence[Unfolded]) -> list[tuple[str, ...]] | None:
    """Beginnings of keys, and the hidden attributes of those that they name."""
    if only is None:
        return None
    return [*only, *(each.hidden_key for each in unfolded if any(each.key[: len(start)] == tuple(start) for start in only))]


def renamed(key: Hashable, unfolded: Sequence[Unfolded]) -> Hashable | None:
    """Key of a mixture's weights: the mixture's, and ``parts``; None for what stands for nothing. Others as they are."""
    for each in unfolded:
        if isinstance(key, tuple) and key[:3] == each.hidden_key[:3]:
            return (*each.key, "parts") if key == each.hidden_key else None
    return key
