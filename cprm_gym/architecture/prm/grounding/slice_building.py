"""The making of one ground slice: rules of classes and active relations, chains of aggregates, conflicts."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....errors import ModelError
from ..model.aggregates import chain
from ..model.cpds import MAX_CELLS
from ..model.densities import Density, averaged, chosen
from ..model.domains import Angle, Bins, Domain, Real
from ..model.resolved import ClassInfo, RelationInfo, Rule, Rules, Slot
from ..model.schema import parse_tuple
from .skeleton import Skeleton
from .slices import PREVIOUS, SAME, STATIC, GroundCPD, GroundSlice, GroundVariable

SHARED_CPDS = 256
"""CPDs of one variable that slices share; beyond that many they are made anew."""

Parents = tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class Context:
    """Where a rule is applied: to an object, or to the objects in the roles of an active tuple."""

    name: str
    roles: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Bound:
    """A rule with its parents found."""

    parents: Parents
    table: np.ndarray
    key: Hashable
    density: Density | None = None


@dataclass(frozen=True, eq=False)
class Claim:
    """An active tuple that changes a variable."""

    atom: str
    relation: RelationInfo
    rules: Rules
    context: Context


class SliceBuilder:
    """Builds one `GroundSlice`; used once.

    Parameters
    ----------
    skeleton : Skeleton
    active : sequence of str
        Canonical active tuples.
    live : sequence of str
        Objects that exist.
    entering : frozenset of str
        Objects and tuples without a previous slice.
    """

    def __init__(self, skeleton: Skeleton, active: Sequence[str], live: Sequence[str], entering: frozenset[str]) -> None:
        self.skeleton = skeleton
        self.checked = skeleton.model.checked
        self.where = skeleton.where
        self.active = active
        self.live = live
        self.alive = set(live)
        self.entering = entering
        self.variables: dict[str, GroundVariable] = {}
        self.cpds: list[GroundCPD] = []
        self.given: list[str] = []
        self.selectors: dict[tuple[str, tuple[str, ...]], str] = {}

    def build(self) -> GroundSlice:
        """The slice."""
        claims = self._claims()
        for name in self.live:
            info = self.checked.classes[self.skeleton.objects[name]]
            self._add_object(name, info, claims)
        clusters = []
        for atom in self.active:
            relation, context = self._atom(atom)
            self._add_tuple(atom, relation, context)
            for group in relation.relation.keep_joint:
                clusters.append(tuple(self._role_attribute(text, context) for text in group))
        try:
            owners = frozenset((*self.live, *self.active))
            return GroundSlice(self.variables, tuple(self.cpds), tuple(self.given), tuple(self.active), tuple(clusters), owners)
        except ModelError as error:
            raise ModelError(f"{self.where} with {', '.join(self.active) or 'no active relation'}: {error}") from None

    def _role_attribute(self, text: str, context: Context) -> str:
        role, _, attribute = text.partition(".")
        return f"{context.roles[role]}.{attribute}"

    def _atom(self, atom: str) -> tuple[RelationInfo, Context]:
        name, objects = parse_tuple(atom)
        info = self.checked.relations[name]
        for o in objects:
            if o not in self.alive:
                raise ModelError(f"{self.where}: {atom} is active, but {o!r} does not exist in this slice")
        return info, Context(atom, {role: o for (role, _), o in zip(info.relation.roles, objects)})

    def _claims(self) -> dict[str, list[Claim]]:
        out: dict[str, list[Claim]] = {}
        for atom in self.active:
            info, context = self._atom(atom)
            for target, rules in info.changes.items():
                out.setdefault(self._role_attribute(target, context), []).append(Claim(atom, info, rules, context))
        return out

    def _variable(self, name: str, domain: Domain, class_name: str, object_name: str, attribute: str) -> None:
        if name in self.variables:
            raise ModelError(f"{self.where}: two variables are called {name!r}")
        known = self.skeleton.variables.get(name)
        if known is None or known.domain != domain or (known.class_name, known.attribute) != (class_name, attribute):
            known = _variable(name, domain, class_name, object_name, attribute)
            self.skeleton.variables[name] = known
        self.variables[name] = known

    def _cpd(self, child: str, bound: Bound) -> None:
        bound = _merge_repeated(bound)
        parents, key = bound.parents, bound.key
        shared = self.skeleton.cpds.setdefault(child, {})
        known = shared.get((parents, key))
        if known is None:
            if len(shared) >= SHARED_CPDS:
                shared.clear()
            known = shared[parents, key] = GroundCPD(child, parents, bound.table, key, True, bound.density)
        self.cpds.append(known)

    def _add_object(self, name: str, info: ClassInfo, claims: Mapping[str, list[Claim]]) -> None:
        context = Context(name, {"": name})
        for label, given in info.given.items():
            self._variable(f"{name}.{label}", given.domain, info.name, name, label)
            self.given.append(f"{name}.{label}")
        for label, attribute in info.attributes.items():
            full = f"{name}.{label}"
            if attribute.static and name not in self.entering:
                continue
            self._variable(full, attribute.domain, info.name, name, label)
            self._cpd(full, self._decide(full, attribute.domain, info.rules[label], context, claims.get(full, [])))

    def _add_tuple(self, atom: str, info: RelationInfo, context: Context) -> None:
        for label, attribute in info.attributes.items():
            full = f"{atom}.{label}"
            if attribute.static and atom not in self.entering:
                continue
            self._variable(full, attribute.domain, info.relation.name, atom, label)
            self._cpd(full, self._own(full, info.rules[label], context))

    def _own(self, full: str, rules: Rules, context: Context) -> Bound:
        """The rule of the class: the initial one where there is no previous value."""
        if rules.initial is not None and (context.name in self.entering or not self._usable(rules.main, context)):
            return self._bind(rules.initial, context)
        if not self._usable(rules.main, context):
            raise ModelError(f"{self.where}: {full!r} needs a previous value that does not exist; give it an `initial` CPD")
        return self._bind(rules.main, context)

    def _decide(self, full: str, domain: Domain, rules: Rules, context: Context, claims: Sequence[Claim]) -> Bound:
        """The class's rule, or what the active tuples that claim the variable make of it."""
        valid: list[tuple[Claim, Rule]] = []
        for claim in claims:
            if self._usable(claim.rules.main, claim.context):
                valid.append((claim, claim.rules.main))
            elif claim.rules.initial is not None:
                valid.append((claim, claim.rules.initial))
        if not valid:
            return self._own(full, rules, context)
        highest = max(c.relation.relation.priority for c, _ in valid)
        valid = [(c, r) for c, r in valid if c.relation.relation.priority == highest]
        bound = [self._bind(r, c.context) for c, r in valid]
        if len(bound) == 1:
            return bound[0]
        modes = {c.relation.relation.conflict for c, _ in valid}
        atoms = tuple(c.atom for c, _ in valid)
        mode = modes.pop()
        if modes or mode in ("exclusive", "priority"):
            raise ModelError(
                f"{self.where}: {' and '.join(atoms)} all change {full!r}; deactivate all but one, give their relations different"
                " priorities, or one conflict rule: mean, noisy-or or mixture"
            )
        return self._combine(mode, full, domain, context, atoms, bound)

    def _combine(self, mode: str, full: str, domain: Domain, context: Context, atoms: tuple[str, ...], bound: list[Bound]) -> Bound:
        union = tuple(dict.fromkeys(p for b in bound for p in b.parents))
        if bound[0].density is not None:
            return self._combine_densities(mode, full, context, atoms, bound, union)
        if any(b.density is not None for b in bound):
            raise ModelError(f"{self.where}: {' and '.join(atoms)} change {full!r}, only some of them with a real number as parent")
        sizes = {p: size for b in bound for p, size in zip(b.parents, b.table.shape)}
        shape = (*(sizes[p] for p in union), len(domain))
        if math.prod(shape) * len(bound) > MAX_CELLS:
            raise ModelError(f"{self.where}: {' and '.join(atoms)} give {full!r} a table of {math.prod(shape)} cells")
        merged = [_merge_repeated(b) for b in bound]
        tables = [np.broadcast_to(_onto(b.table, b.parents, union), shape) for b in merged]
        key = (mode, tuple(b.key for b in merged), tuple(tuple(union.index(q) for q in b.parents) for b in merged))
        if mode == "mean":
            return _bound(union, np.mean(tables, axis=0), key)
        if mode == "noisy-or":
            none = np.prod([t[..., 0] for t in tables], axis=0)
            return _bound(union, np.stack([none, 1.0 - none], axis=-1), key)
        selector = self._selector(context, atoms)
        return _bound(((selector, SAME), *union), np.stack(tables), key)

    def _combine_densities(
        self, mode: str, full: str, context: Context, atoms: tuple[str, ...], bound: list[Bound], union: Parents
    ) -> Bound:
        """As `_combine`, where a real number is among child and parents."""
        if any(b.density is None for b in bound) or mode == "noisy-or":
            raise ModelError(
                f"{self.where}: {' and '.join(atoms)} all change {full!r}; with real numbers by exclusive, priority, mean or mixture"
            )
        domains = {p: d for b in bound if b.density is not None for p, d in zip(b.parents, b.density.parents)}
        key = (mode, tuple(b.key for b in bound), tuple(tuple(union.index(q) for q in b.parents) for b in bound))
        if mode == "mixture":
            selector = self._selector(context, atoms)
            union, domains = ((selector, SAME), *union), {**domains, (selector, SAME): self.variables[selector].domain}
        spaces = [domains[p] for p in union]
        moved = [b.density.moved([union.index(p) for p in b.parents], spaces) for b in bound if b.density is not None]
        made = chosen(moved, spaces, 0) if mode == "mixture" else averaged(moved, spaces)
        return Bound(union, np.zeros((0,) * (len(union) + 1)), key, made)

    def _selector(self, context: Context, atoms: tuple[str, ...]) -> str:
        known = self.selectors.get((context.name, atoms))
        if known is None:
            count = sum(1 for name, _ in self.selectors if name == context.name)
            known = f"{context.name}.selector" + (f"#{count + 1}" if count else "")
            self.selectors[context.name, atoms] = known
            uniform = np.full(len(atoms), 1.0 / len(atoms))
            uniform.flags.writeable = False
            self.variables[known] = GroundVariable(known, atoms, object_name=context.name, attribute="selector", auxiliary=True)
            self.cpds.append(GroundCPD(known, (), uniform, ("selector", len(atoms)), checked=True))
        return known

    def _usable(self, rule: Rule, context: Context) -> bool:
        """Every previous value that the rule needs exists."""
        for slot in rule.parents:
            if not slot.lag or slot.aggregate is not None:
                continue
            owner = context.name if not slot.owner else self._follow(slot, context)[0]
            if owner in self.entering:
                return False
        return True

    def _bind(self, rule: Rule, context: Context) -> Bound:
        return Bound(tuple(self._parent(s, context) for s in rule.parents), rule.table, rule.key, rule.density)

    def _parent(self, slot: Slot, context: Context) -> tuple[str, int]:
        if slot.aggregate is not None:
            return self._aggregate(slot, context), SAME
        owner = context.name if not slot.owner else self._follow(slot, context)[0]
        full = f"{owner}.{slot.attribute}"
        if slot.is_static:
            return full, SAME if owner in self.entering else STATIC
        return full, PREVIOUS if slot.lag else SAME

    def _follow(self, slot: Slot, context: Context) -> tuple[str, ...]:
        """Objects at the end of a slot chain."""
        reached: tuple[str, ...] = (context.roles[slot.role],)
        for name in slot.references:
            found: dict[str, None] = {}
            for o in reached:
                found.update(dict.fromkeys(self._slot_value(o, name)))
            reached = tuple(found)
        return reached

    def _slot_value(self, name: str, slot: str) -> tuple[str, ...]:
        info = self.checked.classes[self.skeleton.objects[name]]
        reference = info.references[slot]
        given = self.skeleton.references.get((name, slot))
        options = given if given is not None else tuple(o for o in self.skeleton.members[reference.target] if o != name)
        present = tuple(o for o in options if o in self.alive)
        if reference.many:
            return present
        if len(present) != 1:
            what = "no object exists" if not present else f"several could be meant: {', '.join(present)}"
            raise ModelError(f"{self.where}, object {name!r}, reference {slot!r}: {what}; say which in `references`")
        return present

    def _aggregate(self, slot: Slot, context: Context) -> str:
        """Name of the variable that holds an aggregate, made with its chain when first needed."""
        assert slot.aggregate is not None
        full = f"{context.name}.{slot.aggregate.text}"
        if full in self.variables:
            return full
        objects = self._follow(slot, context)
        if slot.lag:
            objects = tuple(o for o in objects if o not in self.entering)
        links = chain(slot.aggregate, slot.source, len(objects), f"{self.where}, {full!r}")
        before: tuple[tuple[str, int], ...] = ()
        for k, link in enumerate(links):
            last = k == len(links) - 1
            name = full if last else f"{full}#{k}"
            domain = slot.domain
            if last:
                self._variable(name, domain, "", context.name, slot.aggregate.text)
            else:
                owner, text = context.name, slot.aggregate.text
                self.variables[name] = GroundVariable(name, link.states, object_name=owner, attribute=text, auxiliary=True)
            parents = before
            if objects:
                lag = PREVIOUS if slot.lag else SAME
                if slot.is_static and objects[k] not in self.entering:
                    lag = STATIC
                parents = (*before, (f"{objects[k]}.{slot.attribute}", lag))
            key = ("aggregate", slot.aggregate, slot.source, len(objects), k)
            self.cpds.append(GroundCPD(name, parents, link.table, key, checked=True))
            before = ((name, SAME),)
        return full


def _variable(name: str, domain: Domain, class_name: str, object_name: str, attribute: str) -> GroundVariable:
    if isinstance(domain, Real | Angle):
        return GroundVariable(
            name,
            (),
            None,
            domain.period > 0.0,
            class_name,
            object_name,
            attribute,
            unit=domain.unit,
            auxiliary=not class_name,
            quantity=domain,
        )
    if not isinstance(domain, Bins):
        return GroundVariable(name, domain.states, None, False, class_name, object_name, attribute, auxiliary=not class_name)
    edges = np.array(domain.edges)
    edges.flags.writeable = False
    return GroundVariable(
        name, domain.states, edges, domain.circular, class_name, object_name, attribute, domain.clip, domain.unit, auxiliary=not class_name
    )


def _bound(parents: Parents, table: np.ndarray, key: Hashable) -> Bound:
    table = np.ascontiguousarray(table)
    table.flags.writeable = False
    return Bound(parents, table, key)


def _merge_repeated(bound: Bound) -> Bound:
    """One axis for a variable that is a parent twice: the diagonal of the table."""
    unique = tuple(dict.fromkeys(bound.parents))
    if len(unique) == len(bound.parents):
        return bound
    axes = [unique.index(p) for p in bound.parents]
    if bound.density is not None:
        spaces = [bound.density.parents[bound.parents.index(p)] for p in unique]
        return Bound(unique, np.zeros((0,) * (len(unique) + 1)), (bound.key, tuple(axes)), bound.density.moved(axes, spaces))
    table = np.einsum(bound.table, [*axes, len(unique)], [*range(len(unique)), len(unique)]).copy()
    table.flags.writeable = False
    return Bound(unique, table, (bound.key, tuple(axes)))


def _onto(table: np.ndarray, parents: Parents, union: Parents) -> np.ndarray:
    """The table with its axes in the order of `union`, length 1 for parents it does not have."""
    order = sorted(range(len(parents)), key=lambda k: union.index(parents[k]))
    turned = np.transpose(table, [*order, len(parents)])
    index = tuple(slice(None) if p in parents else None for p in union) + (slice(None),)
    return np.asarray(turned[index])
