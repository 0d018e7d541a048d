"""Classes, attributes, references and relations: the parts of a probabilistic relational model, as frozen values.

Words
-----
A *class* has *attributes* (random variables of each of its objects), *references* to objects, and what is *given* (always observed).
A *parent* is written as text: ``"zone"`` of the same object, ``"ball.zone"`` along a slot chain of references, with the prefix
``prev.`` in the previous slice; or it is an aggregate over a chain that leads to many objects. A *relation* is over a tuple of
objects, its roles; while it is active on a tuple it *replaces* the CPD of some attributes of these objects, or *adds* parents.

Every definition is checked when it is written: names, states, rows of tables, and cycles as far as the classes decide them.

References: Getoor, Friedman, Koller, Pfeffer, "Learning probabilistic relational models"; dissertation §2.3.4.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ....errors import CprmError, ModelError
from .aggregates import Aggregate
from .cpds import CPD, Uniform, as_cpd
from .domains import Domain, as_domain, is_continuous, state_index

PREVIOUS_PREFIX = "prev."
RESERVED = ("prev", "static")
CONFLICTS = ("exclusive", "priority", "mean", "noisy-or", "mixture")

Parent = str | Aggregate


def prev(parent: str) -> str:
    """The parent in the previous slice: ``prev("dist")`` is ``"prev.dist"``."""
    return PREVIOUS_PREFIX + parent


def parent_text(parent: Parent) -> str:
    """How a parent is called in tables, formulas and messages."""
    return parent if isinstance(parent, str) else parent.text


def _name(name: object, where: str) -> str:
    if not isinstance(name, str) or not name.replace("_", "a").isalnum() or name[0].isdigit() or not name.isascii():
        raise ModelError(f"{where}: a name is made of letters, digits and _, got {name!r}")
    if name in RESERVED:
        raise ModelError(f"{where}: {name!r} is reserved")
    return name


def as_tuple(value: object, where: str, what: str) -> tuple[Any, ...]:
    """A tuple of what was given; a single text is refused, so that it is never taken for its letters.

    Raises
    ------
    ModelError
    """
    if isinstance(value, str | Aggregate):
        given = f"the string {value!r}" if isinstance(value, str) else repr(value)
        raise ModelError(f"{where}: `{what}` takes a tuple, got {given}; write ({value!r},)")
    if not isinstance(value, Iterable):
        raise ModelError(f"{where}: `{what}` takes a tuple, got {value!r}")
    return tuple(value)


def one_or_many(value: Iterable[Any], what: str = "names") -> tuple[Any, ...]:
    """A tuple of what was given, where a text alone is one item: ``"attended(o1)"`` is ``("attended(o1)",)``.

    Raises
    ------
    ModelError
        For what is neither a text nor several things.
    """
    if isinstance(value, str):
        return (value,)
    try:
        return tuple(value)
    except TypeError:
        raise ModelError(f"{what}: {value!r:.60} given; expected a text or several of them, () for none") from None


def _unique(names: Iterable[str], where: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ModelError(f"{where}: {name!r} is defined twice")
        seen.add(name)


def _has_prev(parents: Iterable[Parent]) -> bool:
    return any((p if isinstance(p, str) else p.path).startswith(PREVIOUS_PREFIX) for p in parents)


def _normalise(item: Any, where: str) -> None:
    """Bring the CPD fields of an `Attribute`, `Replace` or `Add` into their one form."""
    parents = as_tuple(item.parents, where, "parents")
    first = as_tuple(item.initial_parents, where, "initial_parents")
    for p in (*parents, *first):
        if not isinstance(p, str | Aggregate):
            raise ModelError(f"{where}: a parent is text or an aggregate, got {p!r}")
    _unique([parent_text(p) for p in parents], f"{where}, parents")
    if _has_prev(first):
        raise ModelError(f"{where}: `initial_parents` cannot be in the previous slice: {first}")
    object.__setattr__(item, "parents", parents)
    object.__setattr__(item, "initial_parents", first)
    object.__setattr__(item, "cpd", as_cpd(item.cpd, where))
    if item.initial is not None:
        object.__setattr__(item, "initial", as_cpd(item.initial, f"{where}, initial"))
    if first and item.initial is None:
        raise ModelError(f"{where}: `initial_parents` need an `initial` CPD")


@dataclass(frozen=True)
class Attribute:
    """A random variable of every object of a class (or of every active tuple of a relation).

    Attributes
    ----------
    name : str
    domain : Labels, Bins or tuple of str
        Its states.
    cpd : CPD or tuple of float
        P(attribute | parents); default `Uniform`.
    parents : tuple of str or Aggregate
    initial, initial_parents
        CPD and parents in the slice in which the object begins to exist, where it has no previous value; default: `cpd`
        itself, or `Uniform` when some parent is in the previous slice.
    static : bool
        Drawn once when the object begins to exist, never again.
    """

    name: str
    domain: Domain
    cpd: CPD = field(default_factory=Uniform)
    parents: tuple[Parent, ...] = ()
    initial: CPD | None = None
    initial_parents: tuple[Parent, ...] = ()
    static: bool = False

    def __post_init__(self) -> None:
        where = f"attribute {self.name!r}"
        _name(self.name, "attribute")
        object.__setattr__(self, "domain", as_domain(self.domain, where))
        _normalise(self, where)
        if self.static and _has_prev(self.parents):
            raise ModelError(f"{where}: a static attribute has no parents in the previous slice")


@dataclass(frozen=True)
class Given:
    """A quantity that is always observed (the agent's own motion, a place of a net): context of CPDs, without a prior.

    Attributes
    ----------
    name : str
    domain : Labels, Bins or tuple of str
    default : str or float, optional
        Taken when a step does not say; without it a missing value is an error.
    """

    name: str
    domain: Domain
    default: str | float | None = None

    def __post_init__(self) -> None:
        _name(self.name, "given")
        object.__setattr__(self, "domain", as_domain(self.domain, f"given {self.name!r}"))
        if self.default is None:
            return
        if is_continuous(self.domain):
            if isinstance(self.default, bool) or not isinstance(self.default, int | float) or not math.isfinite(self.default):
                raise ModelError(f"given {self.name!r}: the default of a real number is a finite number, got {self.default!r}")
            return
        try:
            state_index(self.domain, self.default, "default")
        except CprmError as error:
            raise ModelError(f"given {self.name!r}: {error}") from None


@dataclass(frozen=True)
class Reference:
    """A slot that holds an object of a class, or with `many` a set of them."""

    name: str
    target: str
    many: bool = False

    def __post_init__(self) -> None:
        _name(self.name, "reference")


@dataclass(frozen=True)
class PRMClass:
    """A kind of objects.

    Attributes
    ----------
    name : str
    attributes : tuple of Attribute
    references : tuple of Reference
    given : tuple of Given
    extends : str
        Name of the class whose attributes, references and givens it inherits; an attribute of the same name overrides
        (with the same states).
    abstract : bool
        Has no objects of its own.
    """

    name: str
    attributes: tuple[Attribute, ...] = ()
    references: tuple[Reference, ...] = ()
    given: tuple[Given, ...] = ()
    extends: str = ""
    abstract: bool = False

    def __post_init__(self) -> None:
        where = f"class {self.name!r}"
        _name(self.name, "class")
        for what, kind in (("attributes", Attribute), ("references", Reference), ("given", Given)):
            items = as_tuple(getattr(self, what), where, what)
            for item in items:
                if not isinstance(item, kind):
                    raise ModelError(f"{where}: `{what}` holds {kind.__name__} values, got {item!r}")
            object.__setattr__(self, what, items)
        _unique([*(a.name for a in self.attributes), *(r.name for r in self.references), *(i.name for i in self.given)], where)


@dataclass(frozen=True)
class _Change:
    target: str
    parents: tuple[Parent, ...] = ()
    cpd: CPD = field(default_factory=Uniform)
    initial: CPD | None = None
    initial_parents: tuple[Parent, ...] = ()

    def __post_init__(self) -> None:
        where = f"{type(self).__name__.lower()} {self.target!r}"
        if not isinstance(self.target, str) or self.target.count(".") != 1:
            raise ModelError(f"{where}: the target is 'role.attribute'")
        _normalise(self, where)


@dataclass(frozen=True)
class Replace(_Change):
    """While the relation is active, the target has these parents and this CPD instead of its own.

    Attributes
    ----------
    target : str
        ``"b.dist"``: role and attribute.
    parents : tuple of str or Aggregate
        ``"o.dist"``, ``"prev.b.dist"``, or an attribute of the relation, ``"shoot"``.
    cpd : CPD
    initial, initial_parents
        For the slice in which a parent has no previous value; default: the target's own CPD there.
    """


@dataclass(frozen=True)
class Add(_Change):
    """While the relation is active, the target has these parents besides its own; `cpd` is over its own and then these."""


@dataclass(frozen=True)
class Relation:
    """What may hold between objects.

    Attributes
    ----------
    name : str
    roles : dict of str to str
        Role name -> class name, in the order of the tuple.
    changes : tuple of Replace or Add
    attributes : tuple of Attribute
        Variables that every active tuple has, ``shoot``.
    conflict : {"exclusive", "priority", "mean", "noisy-or", "mixture"}
        When several active tuples change one variable: an error; the highest `priority` wins; the mean of their CPDs;
        independent causes (two states); or the mean with a hidden variable, one for all changes to an object, that says
        which tuple is behind them.
    priority : int
        Higher wins over other relations that change the same variable.
    keep_joint : tuple of tuple of str
        Groups ``("b.dist", "o.dist")`` that should stay in one factor when a belief is projected.
    """

    name: str
    roles: tuple[tuple[str, str], ...]
    changes: tuple[Replace | Add, ...] = ()
    attributes: tuple[Attribute, ...] = ()
    conflict: str = "exclusive"
    priority: int = 0
    keep_joint: tuple[tuple[str, ...], ...] = ()

    def __post_init__(self) -> None:
        where = f"relation {self.name!r}"
        _name(self.name, "relation")
        pairs = self.roles.items() if isinstance(self.roles, Mapping) else as_tuple(self.roles, where, "roles")
        if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in pairs):
            raise ModelError(f"{where}: `roles` maps names to classes, got {self.roles!r}")
        object.__setattr__(self, "roles", tuple((_name(r, where), str(c)) for r, c in pairs))
        object.__setattr__(self, "changes", as_tuple(self.changes, where, "changes"))
        object.__setattr__(self, "attributes", as_tuple(self.attributes, where, "attributes"))
        object.__setattr__(self, "keep_joint", tuple(as_tuple(g, where, "keep_joint") for g in self.keep_joint))
        for change in self.changes:
            if not isinstance(change, Replace | Add):
                raise ModelError(f"{where}: `changes` holds Replace and Add values, got {change!r}")
        _unique([r for r, _ in self.roles] + [a.name for a in self.attributes], where)
        _unique([c.target for c in self.changes], f"{where}, changes")
        if not self.roles:
            raise ModelError(f"{where}: a relation needs at least one role")
        if self.conflict not in CONFLICTS:
            raise ModelError(f"{where}: conflict must be one of {', '.join(CONFLICTS)}, got {self.conflict!r}")


def canonical_tuple(relation: str, objects: Iterable[str]) -> str:
    """``"possesses(o3,ball)"``."""
    return f"{relation}({','.join(objects)})"


def parse_tuple(value: object) -> tuple[str, tuple[str, ...]]:
    """Relation and objects of ``"possesses(o3, ball)"`` or ``("possesses", "o3", "ball")``.

    Raises
    ------
    ModelError
    """
    if isinstance(value, str):
        head, bracket, rest = value.strip().partition("(")
        if bracket and rest.endswith(")"):
            objects = tuple(o.strip() for o in rest[:-1].split(","))
            if head.strip() and all(objects):
                return head.strip(), objects
    elif isinstance(value, tuple) and len(value) >= 2 and all(isinstance(v, str) for v in value):
        return value[0], tuple(value[1:])
    raise ModelError(f"an active relation is written 'possesses(o3,ball)' or ('possesses', 'o3', 'ball'), got {value!r}")


def table_size(domains: Iterable[Domain]) -> int:
    """Cells of a table over these domains."""
    return math.prod(len(d) for d in domains)
