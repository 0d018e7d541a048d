"""What a model means once every name in it is looked up: the resolved form that grounding, learning and drawing read."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....errors import ModelError, did_you_mean
from .aggregates import Aggregate
from .cpds import CPD, Dense, Uniform, check_rows
from .densities import Density, density, has_density
from .domains import Domain, is_continuous
from .schema import Add, Attribute, Given, Parent, PRMClass, Reference, Relation, Replace, table_size

Key = tuple[str, str, str, str]

MAX_MODEL_CELLS = 50_000_000
"""Most cells that all tables of a model may have together, 400 MB."""

MAX_REMEMBERED = 200_000
"""Larger tables are not kept for the next model that has the same CPD."""


@dataclass(frozen=True, eq=False)
class Slot:
    """A parent, looked up.

    Attributes
    ----------
    text : str
        As written.
    lag : int
        1 with the prefix ``prev.``, else 0.
    role : str
        Of a relation, where the chain starts; empty for the object itself and for attributes of the relation.
    references : tuple of str
        Chain of references to follow from there.
    attribute : str
        At the end of the chain.
    owner : str
        Name of the class at the end of the chain; empty for an attribute of the relation itself.
    domain : Labels or Bins
        What the child sees (of the result, for an aggregate).
    source : Labels or Bins
        Domain of the attribute at the end of the chain.
    is_given, is_static : bool
    aggregate : Aggregate or None
    """

    text: str
    lag: int
    role: str
    references: tuple[str, ...]
    attribute: str
    owner: str
    domain: Domain
    source: Domain
    is_given: bool
    is_static: bool
    aggregate: Aggregate | None


@dataclass(frozen=True, eq=False)
class Rule:
    """Parents, CPD and table of one variable in one situation.

    Attributes
    ----------
    parents : tuple of Slot
    domain : Domain
        Of the child.
    cpd : CPD
    table : float array
        Parents' axes, the child's last; read only; empty where there is a density.
    key : (kind, owner, label, "cpd" or "initial")
        Where it is written in the model.
    """

    parents: tuple[Slot, ...]
    domain: Domain
    cpd: CPD
    table: np.ndarray
    key: Key
    density: Density | None = None
    """Instead of a table, where a real number is among child and parents."""


@dataclass(frozen=True, eq=False)
class Rules:
    """The rule of an attribute or change, and the one for the slice in which something has no previous value."""

    main: Rule
    initial: Rule | None


@dataclass(frozen=True, eq=False)
class ClassInfo:
    """A class with everything it inherits."""

    name: str
    lineage: tuple[str, ...]
    attributes: dict[str, Attribute]
    declared_in: dict[str, str]
    references: dict[str, Reference]
    given: dict[str, Given]
    rules: dict[str, Rules]
    abstract: bool


@dataclass(frozen=True, eq=False)
class RelationInfo:
    """A relation with its rules: of its own attributes by name, of its changes by ``role.attribute``."""

    relation: Relation
    attributes: dict[str, Attribute]
    rules: dict[str, Rules]
    changes: dict[str, Rules]


def build_table(cpd: CPD, child: Domain, parents: tuple[tuple[str, Domain], ...], where: str) -> np.ndarray:
    """The checked, read-only table of a CPD; those that take work to make are remembered."""
    size = table_size([child, *(d for _, d in parents)])
    once = isinstance(cpd, Dense) or size > MAX_REMEMBERED
    return _build(cpd, child, parents, where) if once else _remembered(cpd, child, parents, where)


def _build(cpd: CPD, child: Domain, parents: tuple[tuple[str, Domain], ...], where: str) -> np.ndarray:
    table = np.ascontiguousarray(cpd.table(child, parents, where))
    check_rows(table, where)
    table.flags.writeable = False
    return table


_remembered = lru_cache(maxsize=512)(_build)


class Checked:
    """The resolved model.

    Parameters
    ----------
    name : str
    classes : sequence of PRMClass
    relations : sequence of Relation

    Attributes
    ----------
    classes : dict of str to ClassInfo
    relations : dict of str to RelationInfo
    acyclic : bool
        The classes alone exclude a cycle of same-slice parents.

    Raises
    ------
    ModelError
    """

    def __init__(self, name: str, classes: Sequence[PRMClass], relations: Sequence[Relation]) -> None:
        self.where = f"model {name!r}"
        self._cells = 0
        self.classes: dict[str, ClassInfo] = {}
        self.relations: dict[str, RelationInfo] = {}
        self._by_name: dict[str, PRMClass] = {}
        for c in classes:
            if c.name in self._by_name:
                raise ModelError(f"{self.where}: class {c.name!r} is defined twice")
            self._by_name[c.name] = c
        for c in classes:
            self._inherit(c.name)
        for info in self.classes.values():
            for reference in info.references.values():
                self._class(reference.target, f"class {info.name!r}, reference {reference.name!r}")
        for c in classes:
            self._class_rules(c)
        for relation in relations:
            if relation.name in self.relations:
                raise ModelError(f"{self.where}: relation {relation.name!r} is defined twice")
            self.relations[relation.name] = self._relation(relation)
        for info in self.classes.values():
            self._no_own_cycle(info)
        for related in self.relations.values():
            self._no_relation_cycle(related)
        self.acyclic = self._class_level_acyclic()

    def is_a(self, name: str, ancestor: str) -> bool:
        """Class `name` is `ancestor` or inherits from it."""
        return ancestor in self.classes[name].lineage

    def _class(self, name: str, where: str) -> ClassInfo:
        if name not in self.classes:
            known = ", ".join(self._by_name)
            raise ModelError(f"{self.where}, {where}: unknown class {name!r}.{did_you_mean(name, self._by_name)} Known: {known}")
        return self.classes[name]

    def _inherit(self, name: str, below: tuple[str, ...] = ()) -> ClassInfo:
        if name in self.classes:
            return self.classes[name]
        if name in below:
            raise ModelError(f"{self.where}: classes inherit in a circle: {' -> '.join((*below, name))}")
        c = self._by_name[name]
        if not c.extends:
            empty = ClassInfo(name, (name,), {}, {}, {}, {}, {}, c.abstract)
            parent = empty
        else:
            if c.extends not in self._by_name:
                hint = did_you_mean(c.extends, self._by_name)
                raise ModelError(f"{self.where}, class {name!r}: extends unknown class {c.extends!r}.{hint}")
            parent = self._inherit(c.extends, (*below, name))
        where = f"{self.where}, class {name!r}"
        for a in c.attributes:
            old = parent.attributes.get(a.name)
            if old is not None and (old.domain != a.domain or old.static != a.static):
                above = parent.declared_in[a.name]
                raise ModelError(f"{where}: {a.name!r} overrides an attribute of {above!r} with other states")
        taken = {"attribute": set(parent.attributes), "reference": set(parent.references), "given": set(parent.given)}
        mine = [("attribute", a.name) for a in c.attributes]
        mine += [("reference", r.name) for r in c.references] + [("given", i.name) for i in c.given]
        for kind, label in mine:
            for other, inherited in taken.items():
                if label in inherited and not (kind == other == "attribute"):
                    raise ModelError(f"{where}: {kind} {label!r} is already an inherited {other}")
        info = ClassInfo(
            name,
            (name, *(parent.lineage if c.extends else ())),
            {**parent.attributes, **{a.name: a for a in c.attributes}},
            {**parent.declared_in, **{a.name: name for a in c.attributes}},
            {**parent.references, **{r.name: r for r in c.references}},
            {**parent.given, **{i.name: i for i in c.given}},
            {},
            c.abstract,
        )
        self.classes[name] = info
        return info

    def _class_rules(self, c: PRMClass) -> None:
        """Rules of the attributes that the class itself declares; inherited ones are shared with the ancestor."""
        info = self.classes[c.name]
        if c.extends and not self.classes[c.extends].rules and self.classes[c.extends].attributes:
            self._class_rules(self._by_name[c.extends])
        if c.extends:
            info.rules.update({n: r for n, r in self.classes[c.extends].rules.items() if n not in info.rules})
        for a in c.attributes:
            where = f"{self.where}, class {c.name!r}, attribute {a.name!r}"
            info.rules[a.name] = self._rules(a, a.domain, a.parents, where, ("class", c.name, a.name), {"": c.name}, {})

    def _rules(
        self, item: Attribute | Replace | Add, domain: Domain, parents: Sequence[Parent], where: str,
        place: tuple[str, str, str], heads: dict[str, str], own: dict[str, Attribute],
    ) -> Rules:  # fmt: skip
        slots = tuple(self.resolve(p, where, heads, own) for p in parents)
        main = self._rule(slots, item.cpd, domain, where, (*place, "cpd"))
        wants_initial = item.initial is not None or (place[0] == "class" or "." not in place[2])
        if item.initial is None and not any(s.lag for s in slots):
            return Rules(main, None)
        if not wants_initial:
            return Rules(main, None)
        first = tuple(self.resolve(p, f"{where}, initial", heads, own) for p in item.initial_parents)
        cpd = Uniform() if item.initial is None else item.initial
        return Rules(main, self._rule(first, cpd, domain, f"{where}, initial", (*place, "initial")))

    def _rule(self, slots: tuple[Slot, ...], cpd: CPD, domain: Domain, where: str, key: Key) -> Rule:
        parents = tuple((s.text, s.domain) for s in slots)
        if has_density(domain, parents):
            return Rule(slots, domain, cpd, np.zeros((0,) * (len(slots) + 1)), key, density(cpd, domain, parents, where))
        self._cells += table_size([domain, *(s.domain for s in slots)])
        if self._cells > MAX_MODEL_CELLS:
            raise ModelError(f"{where}: with this table the model has {self._cells} cells; at most {MAX_MODEL_CELLS}")
        table = build_table(cpd, domain, parents, where)
        return Rule(slots, domain, cpd, table, key)

    def resolve(self, parent: Parent, where: str, heads: dict[str, str], own: dict[str, Attribute]) -> Slot:
        """Look a parent up.

        Parameters
        ----------
        parent : str or Aggregate
        where : str
            Start of the message of an error.
        heads : dict of str to str
            Role -> class; a class's own attributes are under the role ``""``.
        own : dict of str to Attribute
            Attributes of the relation.

        Raises
        ------
        ModelError
        """
        aggregate = parent if isinstance(parent, Aggregate) else None
        path = parent.path if isinstance(parent, Aggregate) else parent
        text = parent.text if isinstance(parent, Aggregate) else parent
        lag = int(path.startswith("prev."))
        parts = path[5:].split(".") if lag else path.split(".")
        role, owner = "", heads.get("", "")
        if not owner:
            if len(parts) == 1:
                return self._own_slot(parts[0], text, lag, where, heads, own)
            role, *parts = parts
            if role not in heads:
                hint = did_you_mean(role, [*heads, *own])
                raise ModelError(f"{where}: parent {text!r} starts with unknown role {role!r}.{hint} Known: {', '.join(heads)}")
            owner = heads[role]
        many = False
        for name in parts[:-1]:
            references = self._class(owner, where).references
            if name not in references:
                hint = did_you_mean(name, references)
                raise ModelError(f"{where}: parent {text!r}: class {owner!r} has no reference {name!r}.{hint}")
            many = many or references[name].many
            owner = references[name].target
        if many and aggregate is None:
            raise ModelError(f"{where}: parent {text!r} leads to many objects; use an aggregate such as Exists({text!r}, state)")
        if aggregate is not None and not many:
            raise ModelError(f"{where}: parent {text!r} leads to one object; write {path!r} without the aggregate")
        return self._end_slot(parts, owner, text, lag, role, where, aggregate)

    def _end_slot(self, parts: list[str], owner: str, text: str, lag: int, role: str, where: str, aggregate: Aggregate | None) -> Slot:
        info, name = self._class(owner, where), parts[-1]
        found = info.attributes.get(name) or info.given.get(name)
        if found is None:
            known = [*info.attributes, *info.given]
            hint = f"{did_you_mean(name, known)} Known: {', '.join(known)}"
            raise ModelError(f"{where}: parent {text!r}: class {owner!r} has no attribute {name!r}.{hint}")
        is_given = name in info.given
        is_static = name in info.attributes and info.attributes[name].static
        if lag and is_given:
            raise ModelError(f"{where}: parent {text!r}: what is given has no previous value; declare a second `Given` for it")
        if lag and is_static:
            raise ModelError(f"{where}: parent {text!r}: a static attribute is the same in every slice; leave out 'prev.'")
        if aggregate is not None and is_continuous(found.domain):
            raise ModelError(f"{where}: parent {text!r}: {name!r} is a real number; aggregates are of states: make it a `Chance` first")
        domain = found.domain if aggregate is None else aggregate.domain(found.domain, where)
        return Slot(text, lag, role, tuple(parts[:-1]), name, owner, domain, found.domain, is_given, is_static, aggregate)

    def _own_slot(self, name: str, text: str, lag: int, where: str, heads: dict[str, str], own: dict[str, Attribute]) -> Slot:
        if name not in own:
            hint = did_you_mean(name, [*own, *heads])
            known = ", ".join([*own, *(f"{r}.attribute" for r in heads)])
            raise ModelError(f"{where}: unknown parent {text!r}.{hint} Known: {known}")
        a = own[name]
        return Slot(text, lag, "", (), name, "", a.domain, a.domain, False, a.static, None)

    def _relation(self, relation: Relation) -> RelationInfo:
        where = f"{self.where}, relation {relation.name!r}"
        heads = {}
        for role, name in relation.roles:
            self._class(name, f"relation {relation.name!r}, role {role!r}")
            heads[role] = name
        own = {a.name: a for a in relation.attributes}
        rules = {}
        for a in relation.attributes:
            place = ("relation", relation.name, a.name)
            rules[a.name] = self._rules(a, a.domain, a.parents, f"{where}, attribute {a.name!r}", place, heads, own)
        changes = {}
        for change in relation.changes:
            here = f"{where}, {change.target!r}"
            target = self._target(change.target, here, heads)
            if relation.conflict == "noisy-or" and len(target.domain) != 2:
                raise ModelError(f"{here}: conflict 'noisy-or' needs a target of two states, it has {target.domain.states}")
            parents = change.parents
            if isinstance(change, Add):
                role = change.target.partition(".")[0]
                parents = (*(_moved(p, role) for p in target.parents), *parents)
            place = ("relation", relation.name, change.target)
            changes[change.target] = self._rules(change, target.domain, parents, here, place, heads, own)
        for group in relation.keep_joint:
            for text in group:
                self._target(text, f"{where}, keep_joint", heads)
        return RelationInfo(relation, own, rules, changes)

    def _target(self, text: str, where: str, heads: dict[str, str]) -> Attribute:
        role, _, name = text.partition(".")
        if role not in heads:
            raise ModelError(f"{where}: unknown role {role!r}.{did_you_mean(role, heads)} Known: {', '.join(heads)}")
        attributes = self.classes[heads[role]].attributes
        if name not in attributes:
            hint = did_you_mean(name, attributes)
            raise ModelError(f"{where}: class {heads[role]!r} has no attribute {name!r}.{hint} Known: {', '.join(attributes)}")
        if attributes[name].static:
            raise ModelError(f"{where}: a static attribute cannot be changed by a relation")
        return attributes[name]

    def _no_own_cycle(self, info: ClassInfo) -> None:
        for part in ("main", "initial"):
            edges = {}
            for name, rules in info.rules.items():
                rule = rules.main if part == "main" or rules.initial is None else rules.initial
                edges[name] = [s.attribute for s in rule.parents if not s.lag and not s.references and not s.is_given]
            _ordered(edges, f"{self.where}, class {info.name!r}")

    def _no_relation_cycle(self, info: RelationInfo) -> None:
        edges: dict[str, list[str]] = {}
        for role, name in info.relation.roles:
            for attribute, rules in self.classes[name].rules.items():
                same = [s for s in rules.main.parents if not s.lag and not s.references and not s.is_given]
                edges[f"{role}.{attribute}"] = [f"{role}.{s.attribute}" for s in same]
        for label, rules in [*info.rules.items(), *info.changes.items()]:
            same = [s for s in rules.main.parents if not s.lag and not s.references and not s.is_given]
            edges[label] = [f"{s.role}.{s.attribute}" if s.role else s.attribute for s in same]
        _ordered(edges, f"{self.where}, relation {info.relation.name!r}")

    def _class_level_acyclic(self) -> bool:
        """No cycle among concrete classes and attributes, each class standing for all its objects."""
        concrete = [c for c in self.classes.values() if not c.abstract]
        edges: dict[str, list[str]] = {}

        def add(child: str, rules: Rules, own: str) -> None:
            into = edges.setdefault(child, [])
            for rule in (rules.main, *([rules.initial] if rules.initial else [])):
                for s in rule.parents:
                    if s.lag or s.is_given:
                        continue
                    if not s.references and not s.role:
                        into.append(f"{own}.{s.attribute}")
                    else:
                        into += [f"{c.name}.{s.attribute}" for c in concrete if s.owner in c.lineage]

        for info in concrete:
            for name, rules in info.rules.items():
                add(f"{info.name}.{name}", rules, info.name)
        for related in self.relations.values():
            heads, own = dict(related.relation.roles), f"{related.relation.name}()"
            for name, rules in related.rules.items():
                add(f"{own}.{name}", rules, own)
            for target, rules in related.changes.items():
                role, _, name = target.partition(".")
                for info in concrete:
                    if heads[role] in info.lineage:
                        add(f"{info.name}.{name}", rules, own)
        try:
            topological_order(edges, edges)
        except ModelError:
            return False
        return True


def all_rules(checked: Checked) -> dict[tuple[str, ...], Rule]:
    """Every CPD of a model by its key."""
    out: dict[tuple[str, ...], Rule] = {}
    every = [r for info in checked.classes.values() for r in info.rules.values()]
    every += [r for info in checked.relations.values() for r in (*info.rules.values(), *info.changes.values())]
    for rules in every:
        for rule in (rules.main, rules.initial):
            if rule is not None:
                out[rule.key] = rule
    return out


def topological_order(parents: dict[str, list[str]], names: Iterable[str]) -> tuple[str, ...]:
    """Names such that parents come before children; among the free ones the given order is kept.

    Raises
    ------
    ModelError
        If there is a cycle; the message shows it as ``a -> b -> a``.
    """
    done: dict[str, None] = {}
    path: dict[str, None] = {}

    for root in names:
        stack = [(root, iter(parents.get(root, ())))]
        if root in done:
            continue
        path[root] = None
        while stack:
            node, rest = stack[-1]
            parent = next(rest, None)
            if parent is None:
                stack.pop()
                path.pop(node, None)
                done[node] = None
            elif parent in path:
                loop = list(path)[list(path).index(parent) :]
                shown = " -> ".join([parent, *reversed(loop)])
                raise ModelError(f"variables of one slice depend on each other in a cycle: {shown}")
            elif parent not in done:
                path[parent] = None
                stack.append((parent, iter(parents.get(parent, ()))))
    return tuple(done)


def _ordered(edges: dict[str, list[str]], where: str) -> None:
    try:
        topological_order(edges, edges)
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from None


def _moved(parent: Parent, role: str) -> Parent:
    """A parent of the class, written in a relation where the object has a role."""
    path = parent.path if isinstance(parent, Aggregate) else parent
    moved = f"prev.{role}.{path[5:]}" if path.startswith("prev.") else f"{role}.{path}"
    return parent.moved(moved) if isinstance(parent, Aggregate) else moved
