"""Mixtures of real numbers with a hidden attribute for which part it was, so that what is learned of switches is learned of them.

`em` unfolds a model, learns tables and `Noise` as ever, and folds what it has learned: the hidden attribute's table is the weights.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...model.cpds import Dense, Mixture, Prior, Switch, Table
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
    cases : tuple of (str, int)
        Of mixtures that are cases of a `Switch`, their states and how many parts each has; none where the mixture is the whole CPD.
    """

    owner: str
    attribute: str
    part: str
    hidden: str
    begins: bool
    cases: tuple[tuple[str, int], ...] = ()

    @property
    def key(self) -> tuple[str, ...]:
        """Of the CPD."""
        return "class", self.owner, self.attribute, self.part

    @property
    def hidden_key(self) -> tuple[str, ...]:
        """Of the table of the hidden attribute."""
        return "class", self.owner, self.hidden, "initial" if self.begins else "cpd"


def unfold(model: Model) -> tuple[Model, tuple[Unfolded, ...]]:
    """The model with a hidden attribute for mixtures of real numbers, and what they stand for.

    For each `Mixture` that is the whole CPD of a class's number, and for those that are cases of a `Switch` that is, one for all of them.
    """
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
            if not is_continuous(attribute.domain) or attribute.name in added:
                continue
            if isinstance(cpd, Switch) and part == "cpd" and _mixed(cpd):
                extra, attribute, stands = _switched(each.name, attribute, cpd, names)
                attributes.append(extra)
                found.append(stands)
            if not isinstance(cpd, Mixture):
                continue
            hidden = _named(f"{attribute.name}_{part}_is", names)
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


def _named(name: str, names: set[str]) -> str:
    """A name that there is not yet, and is from now on."""
    while name in names:
        name += "_"
    names.add(name)
    return name


def _mixed(switch: Switch) -> list[tuple[str, Mixture]]:
    """The cases of single states that are mixtures; one of all other states would have weights for each."""
    return [(state, case) for state, case in switch.cases if isinstance(case, Mixture) and state != "*"]


def _switched(owner: str, attribute: Attribute, cpd: Switch, names: set[str]) -> tuple[Attribute, Attribute, Unfolded]:
    """A hidden attribute whose table has a row for each state that leads to a mixture, the one that turns on it, what they stand for."""
    mixed = _mixed(cpd)
    hidden, most = _named(f"{attribute.name}_cpd_is", names), max(len(case.parts) for _, case in mixed)
    states = tuple(f"part{k}" for k in range(most))
    parent = next(p for p in attribute.parents if parent_text(p) == cpd.parent)
    rows = [((state,), (*(w for w, _ in case.parts), *(0.0,) * (most - len(case.parts)))) for state, case in mixed]
    table = Table([*rows, (("*",), (1.0, *(0.0,) * (most - 1)))])
    back = any(parent_text(p).startswith("prev.") for p in attribute.parents)
    apart = not attribute.static and (attribute.initial is not None or back)
    begins = Prior((1.0 / most,) * most) if apart else None
    extra = Attribute(hidden, Labels(states), table, (parent,), initial=begins, static=attribute.static)
    turns = {state: Switch(hidden, [*zip(states, (c for _, c in m.parts)), ("*", m.parts[-1][1])]) for state, m in mixed}
    cases = [(state, turns.get(state, case)) for state, case in cpd.cases]
    turned = replace(attribute, cpd=Switch(cpd.parent, cases), parents=(*attribute.parents, hidden))
    return extra, turned, Unfolded(owner, attribute.name, "cpd", hidden, False, tuple((state, len(case.parts)) for state, case in mixed))


def _folded(switch: Switch, table: Any, cases: Sequence[tuple[str, int]]) -> Switch:
    """A switch of `_switched` with its mixtures again."""
    counts = dict(cases)
    made = []
    for state, case in switch.cases:
        if state in counts and isinstance(case, Switch):
            if isinstance(table, Dense):
                assert table.domains is not None
                given = table.values[table.domains[0].index(state)]
            else:
                given = dict(table.rows)[state,]
            weights = np.maximum(np.asarray(given, np.float64)[: counts[state]], LEAST)
            case = Mixture(*((float(w), c) for w, (_, c) in zip(weights / weights.sum(), case.cases)))
        made.append((state, case))
    return Switch(switch.parent, made)


def fold(model: Model, unfolded: Sequence[Unfolded]) -> Model:
    """An unfolded model with mixtures again, whose weights are what the hidden attributes' tables say."""
    classes = []
    for each in model.classes:
        own = {a.name: a for a in each.attributes}
        mine = [u for u in unfolded if u.owner == each.name]
        for u in mine:
            hidden, parents = own.pop(u.hidden), "parents" if u.part == "cpd" else "initial_parents"
            table = getattr(hidden, u.hidden_key[3])
            if u.cases:
                turned_on = own[u.attribute].cpd
                assert isinstance(turned_on, Switch)
                again = _folded(turned_on, table, u.cases)
                own[u.attribute] = replace(own[u.attribute], cpd=again, parents=own[u.attribute].parents[:-1])
                continue
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
