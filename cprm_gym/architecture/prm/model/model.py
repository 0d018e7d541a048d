"""Classes and relations, checked together: a probabilistic relational model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ....errors import ModelError
from .cpds import CPD
from .domains import Angle, Domain, Real, is_continuous
from .resolved import Checked
from .schema import PRMClass, Relation, as_tuple


@dataclass(frozen=True)
class Model:
    """Classes and relations, checked together.

    Attributes
    ----------
    name : str
    classes : tuple of PRMClass
    relations : tuple of Relation

    Raises
    ------
    ModelError
        Names the class, attribute and row that are wrong.

    Notes
    -----
    `acyclic` says that the classes alone exclude a cycle of same-slice parents, whatever the objects and active relations
    are; otherwise each ground slice is checked when it is made. A cycle within one object, or made by one relation, is
    refused here.
    """

    name: str
    classes: tuple[PRMClass, ...] = ()
    relations: tuple[Relation, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "classes", as_tuple(self.classes, f"model {self.name!r}", "classes"))
        object.__setattr__(self, "relations", as_tuple(self.relations, f"model {self.name!r}", "relations"))
        object.__setattr__(self, "_checked", Checked(self.name, self.classes, self.relations))

    @property
    def continuous(self) -> bool:
        """Some attribute or given is a real number or an angle."""
        domains = [a.domain for c in self.classes for a in c.attributes] + [g.domain for c in self.classes for g in c.given]
        domains += [a.domain for r in self.relations for a in r.attributes]
        return any(map(is_continuous, domains))

    def binned(self) -> Model:
        """The same model with every `Real` and `Angle` cut into its bins, for engines that know states only.

        Raises
        ------
        ModelError
            For one that has no bins.
        """

        def cut(item: Any, owner: str) -> Any:
            return replace(item, domain=_bins_of(item.domain, f"model {self.name!r}, {owner}, {item.name!r}"))

        return Model(
            self.name,
            tuple(
                replace(c, attributes=tuple(cut(a, f"class {c.name!r}") for a in c.attributes),
                        given=tuple(cut(g, f"class {c.name!r}") for g in c.given))
                for c in self.classes
            ),
            tuple(replace(r, attributes=tuple(cut(a, f"relation {r.name!r}") for a in r.attributes)) for r in self.relations),
        )  # fmt: skip

    @property
    def acyclic(self) -> bool:
        """No set of objects and active relations can make a cycle."""
        return self.checked.acyclic

    @property
    def checked(self) -> Checked:
        """The resolved model."""
        found: Checked = self._checked  # type: ignore[attr-defined]
        return found

    def with_cpds(self, learned: Mapping[tuple[str, ...], CPD]) -> Model:
        """The same model with other CPDs.

        Parameters
        ----------
        learned : mapping of key to CPD
            Keys as in `GroundCPD.key`: ``("class", class, attribute, "cpd" or "initial")`` or ``("relation", relation,
            target or attribute, "cpd" or "initial")``.

        Raises
        ------
        ModelError
            For a key that the model does not have.
        """
        left = dict(learned)

        def changed(item: Any, kind: str, owner: str, label: str) -> Any:
            new = {}
            for part in ("cpd", "initial"):
                cpd = left.pop((kind, owner, label, part), None)
                if cpd is not None:
                    new[part] = cpd
            return replace(item, **new) if new else item

        classes = tuple(replace(c, attributes=tuple(changed(a, "class", c.name, a.name) for a in c.attributes)) for c in self.classes)
        relations = tuple(
            replace(
                r,
                attributes=tuple(changed(a, "relation", r.name, a.name) for a in r.attributes),
                changes=tuple(changed(c, "relation", r.name, c.target) for c in r.changes),
            )
            for r in self.relations
        )
        if left:
            raise ModelError(f"model {self.name!r} has no CPD {next(iter(left))!r}")
        return replace(self, classes=classes, relations=relations)


def _bins_of(domain: Domain, where: str) -> Domain:
    """The bins of a real number; other domains as they are."""
    if not isinstance(domain, Real | Angle):
        return domain
    if domain.bins is None:
        kind = type(domain).__name__
        raise ModelError(f"{where}: a {kind} without bins; give {kind}({domain.unit!r}, bins=...), or take the engine 'mixture'")
    return domain.bins
