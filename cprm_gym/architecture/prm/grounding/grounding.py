"""From a relational model and its objects to flat Bayes nets: one `GroundSlice` for every set of active relations."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ....errors import ModelError, did_you_mean
from ..model.model import Model
from ..model.schema import canonical_tuple, one_or_many, parse_tuple
from .skeleton import Skeleton
from .slice_building import SliceBuilder
from .slices import (
    PREVIOUS,
    SAME,
    STATIC,
    GroundCPD,
    Grounds,
    GroundSlice,
    GroundVariable,
)

__all__ = [
    "PREVIOUS",
    "SAME",
    "STATIC",
    "GroundCPD",
    "GroundSlice",
    "GroundVariable",
    "Grounding",
    "Situation",
    "unroll",
]

CACHED_SLICES = 4096
"""Ground slices that a `Grounding` remembers; the least recently used one is forgotten first."""


@dataclass(frozen=True)
class Situation:
    """What holds in a slice: relations, objects, and which of them are new.

    Attributes
    ----------
    relations : tuple of str
        Active tuples.
    objects : tuple of str or None
        Objects that exist; None for all.
    entering : tuple of str
        Objects and relation tuples that exist in this slice but not in the one before.
    """

    relations: tuple[str, ...] = ()
    objects: tuple[str, ...] | None = None
    entering: tuple[str, ...] = ()


class Grounding(Skeleton, Grounds):
    """A model and the objects of a world, ready to be filtered.

    Parameters
    ----------
    model : Model
    objects : mapping of str to str
        Object name -> class name. All that may ever exist; which are there in a slice is said to `ground`.
    references : mapping of str to mapping, optional
        ``{"red_1": {"ball": "ball", "opponents": ("blue_1", "blue_2")}}``. What is left out defaults to the only object of
        the reference's class, or with `many` to all of them (but not the object itself).

    Raises
    ------
    ModelError
        For an unknown class, object or reference, with the nearest known name.
    """

    def __init__(self, model: Model, objects: Mapping[str, str], references: Mapping[str, Mapping[str, Any]] | None = None) -> None:
        super().__init__(model, objects, references)
        self._slices: OrderedDict[Any, GroundSlice] = OrderedDict()
        self._answers: dict[Any, GroundSlice] = {}
        self._written: dict[str | tuple[str, ...], str] = {}
        self._actives: dict[tuple[Any, ...], tuple[str, ...]] = {}
        self._binned: Grounding | None = None

    def binned(self) -> Grounding:
        """The same objects of `Model.binned`; itself where no real number is.

        Raises
        ------
        ModelError
            For a real number without bins.
        """
        if not self.model.continuous:
            return self
        if self._binned is None:
            references: dict[str, dict[str, tuple[str, ...]]] = {}
            for (name, slot), targets in self.references.items():
                references.setdefault(name, {})[slot] = targets
            self._binned = Grounding(self.model.binned(), self.objects, references)
        return self._binned

    def ground(
        self,
        relations: Iterable[str | tuple[str, ...]] | Situation = (),
        first: bool = False,
        *,
        objects: Iterable[str] | None = None,
        entering: Iterable[str] = (),
    ) -> GroundSlice:
        """The flat net of one slice.

        Parameters
        ----------
        relations : iterable of str or tuple of str, or Situation
            Active tuples, ``"possesses(o3,ball)"`` or ``("possesses", "o3", "ball")``; a set: the order does not matter, and a text
            alone is one tuple. A `Situation` says objects and entering as well.
        first : bool
            The slice has no predecessor.
        objects : iterable of str, optional
            The objects that exist in it; default all.
        entering : iterable of str
            Objects and relation tuples that exist in this slice but not in the one before: they have no previous values.

        Returns
        -------
        GroundSlice
            The same object for the same arguments, as long as it is remembered.

        Raises
        ------
        ModelError
            For an unknown tuple, a conflict of tuples that no rule decides, or a cycle.
        """
        if isinstance(relations, Situation):
            raw: tuple[Any, ...] = (relations.relations, first, relations.objects, relations.entering)
        else:
            raw = (one_or_many(relations), first, None if objects is None else one_or_many(objects), one_or_many(entering))
        known = self._answers.get(raw)
        if known is not None:
            return known
        active = sorted({self.canonical(r) for r in raw[0]})
        live = tuple(self.objects) if raw[2] is None else self._live(raw[2])
        fresh = (
            frozenset((*live, *active)) if first else frozenset(self._entering(e, live, active) for e in raw[3]) - self._forgetful(active)
        )
        key = (tuple(active), live, fresh)
        made = self._slices.get(key)
        if made is None:
            made = SliceBuilder(self, tuple(active), live, fresh).build()
            self._remember(key, made)
        else:
            self._slices.move_to_end(key)
        if len(self._answers) >= CACHED_SLICES:
            self._answers.clear()
        self._answers[raw] = made
        return made

    def _forgetful(self, active: Sequence[str]) -> set[str]:
        """Tuples of relations without attributes: there is nothing of theirs in the slice before, whether they are new or not."""
        relations = self.model.checked.relations
        return {atom for atom in active if not relations[parse_tuple(atom)[0]].attributes}

    def _remember(self, key: Any, made: GroundSlice) -> None:
        self._slices[key] = made
        if len(self._slices) > CACHED_SLICES:
            self._slices.popitem(last=False)

    def canonical(self, relation: str | tuple[str, ...]) -> str:
        """The one way to write an active tuple, after checking relation, number and classes of its objects.

        Raises
        ------
        ModelError
        """
        written = self._written.get(relation)
        if written is None:
            if len(self._written) >= CACHED_SLICES:
                self._written.clear()
            written = self._written[relation] = self._canonical(relation)
        return written

    def _canonical(self, relation: str | tuple[str, ...]) -> str:
        name, args = parse_tuple(relation)
        known = self.model.checked.relations
        if name not in known:
            hint = f"{did_you_mean(name, known)} Known: {', '.join(known) or 'none'}"
            raise ModelError(f"{self.where}: unknown relation {name!r}.{hint}")
        roles = known[name].relation.roles
        text = canonical_tuple(name, args)
        if len(args) != len(roles):
            raise ModelError(f"{self.where}: {text} has {len(args)} objects for the roles {', '.join(r for r, _ in roles)}")
        for arg, (role, class_name) in zip(args, roles):
            if arg not in self.members[class_name]:
                options = self.members[class_name]
                hint = did_you_mean(arg, options)
                shown = ", ".join(options) or "none"
                raise ModelError(f"{self.where}: {text}: role {role!r} takes a {class_name}, got {arg!r}.{hint} Known: {shown}")
        return text

    def _live(self, objects: Sequence[str]) -> tuple[str, ...]:
        for name in objects:
            if name not in self.objects:
                raise ModelError(f"{self.where}: unknown object {name!r}.{did_you_mean(name, self.objects)}")
        wanted = set(objects)
        return tuple(o for o in self.objects if o in wanted)

    def _entering(self, name: str | tuple[str, ...], live: Sequence[str], active: Sequence[str]) -> str:
        text = name if isinstance(name, str) and "(" not in name else self.canonical(name)
        if text not in live and text not in active:
            raise ModelError(f"{self.where}: {text!r} enters but is neither an object nor an active relation of this slice")
        return text

    def situation(
        self,
        relations: Iterable[str | tuple[str, ...]] | Situation = (),
        objects: Iterable[str] | None = None,
        before: Situation | None = None,
    ) -> Situation:
        """What holds in the next slice, with what is new in it.

        Parameters
        ----------
        relations : iterable of str or tuple of str
        objects : iterable of str, optional
            That exist; default all.
        before : Situation, optional
            Of the slice before; without it nothing counts as new (a first slice needs no telling).
        """
        if isinstance(relations, Situation):
            return relations
        raw = one_or_many(relations, "relations")
        active = self._actives.get(raw)
        if active is None:
            active = tuple(sorted({self.canonical(r) for r in raw}))
            if len(self._actives) >= CACHED_SLICES:
                self._actives.clear()
            self._actives[raw] = active
        if before is not None and before.relations is active and objects is None and before.objects is None:
            return before if not before.entering else Situation(active)
        live = None if objects is None else self._live(one_or_many(objects, "objects"))
        if before is None:
            return Situation(active, live)
        old = {*before.relations, *(self.objects if before.objects is None else before.objects)}
        new = tuple(x for x in (*(self.objects if live is None else live), *active) if x not in old)
        return Situation(active, live, new)

    def next(self, before: Situation | None, relations: Iterable[str | tuple[str, ...]] | None = None) -> Situation:
        """What holds in the slice after: these relations, or still the same ones, and the same objects."""
        if before is None:
            return self.situation(() if relations is None else relations)
        return self.situation(before.relations if relations is None else relations, before.objects, before)

    def defaults(self, ground: GroundSlice) -> dict[str, int]:
        """States of what is given and has a default."""
        classes = self.model.checked.classes
        out: dict[str, int] = {}
        for name in ground.given:
            variable = ground.variables[name]
            default = classes[self.objects[variable.object_name]].given[variable.attribute].default
            if default is not None and variable.quantity is None:
                out[name] = variable.index(default)
        return out

    def quantities(self, ground: GroundSlice) -> dict[str, float]:
        """Values of real numbers that are given and have a default."""
        classes, out = self.model.checked.classes, {}
        for name in ground.given:
            variable = ground.variables[name]
            default = classes[self.objects[variable.object_name]].given[variable.attribute].default
            if default is not None and variable.quantity is not None:
                out[name] = float(default)
        return out


def unroll(slices: Sequence[GroundSlice]) -> GroundSlice:
    """One static net of several slices; variable x of slice t is called ``"x#t"``.

    A static variable is the one of the last slice that defines it. What is given stays given.

    Parameters
    ----------
    slices : sequence of GroundSlice

    Returns
    -------
    GroundSlice
        Without lags.

    Raises
    ------
    ModelError
        If a parent does not exist in the slice it should be in.
    """
    variables: dict[str, GroundVariable] = {}
    cpds: list[GroundCPD] = []
    given: list[str] = []
    latest: dict[str, int] = {}
    for t, ground in enumerate(slices):
        for name, v in ground.variables.items():
            latest[name] = t
            full = f"{name}#{t}"
            variables[full] = replace(v, name=full)
        given += [f"{name}#{t}" for name in ground.given]
        for cpd in ground.cpds:
            parents = []
            for parent, lag in cpd.parents:
                at = latest.get(parent, -1) if lag == STATIC else t - lag
                if f"{parent}#{at}" not in variables:
                    raise ModelError(f"slice {t}: {cpd.child!r} needs {parent!r} of slice {at}, which does not have it")
                parents.append((f"{parent}#{at}", SAME))
            cpds.append(GroundCPD(f"{cpd.child}#{t}", tuple(parents), cpd.table, cpd.key, cpd.checked, cpd.density))
    return GroundSlice(variables, tuple(cpds), tuple(given))
