"""Classes and relations, checked together: a probabilistic relational model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ....errors import ModelError
from .cpds import Dense
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
    def acyclic(self) -> bool:
        """No set of objects and active relations can make a cycle."""
        return self.checked.acyclic

    @property
    def checked(self) -> Checked:
        """The resolved model."""
        found: Checked = self._checked  # type: ignore[attr-defined]
        return found

    def with_cpds(self, learned: Mapping[tuple[str, ...], Dense]) -> Model:
        """The same model with other CPDs.

        Parameters
        ----------
        learned : mapping of key to Dense
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
