"""The flat Bayes net of one time slice.

A `GroundSlice` is what every inference engine reads: the variables of slice ``t``, one CPD for each hidden or
observed variable, and what is given, which is always observed and has no CPD. A sequence of slices is the unrolled,
non-homogeneous net; switching a relation on or off means that the next slice has other CPDs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ....errors import ModelError, did_you_mean
from ..model.cpds import check_rows
from ..model.densities import Density
from ..model.domains import Angle, Bins, Domain, Labels, Real, state_index
from ..model.resolved import topological_order

SAME, PREVIOUS, STATIC = 0, 1, -1
"""Lags of a parent: in the same slice, in the previous one, or static (defined in the first slice)."""


@dataclass(frozen=True, eq=False)
class GroundVariable:
    """One random variable of one object.

    Attributes
    ----------
    name : str
        ``"ball.dist"``, or ``"possesses(o3,ball).shoot"`` for an attribute of a relation.
    states : tuple of str
        Names of the states, in order.
    edges : (K + 1,) float array or None
        Bin edges in the attribute's unit when the states are the K bins of a number; None for named states.
    circular : bool
        The last bin is followed by the first (an angle).
    class_name, object_name, attribute : str
        Where it comes from; two variables with equal `class_name` and `attribute` are of the same kind.
    clip : bool
        Values outside the bins count as in the end bin.
    unit : str
        Of the bins.
    auxiliary : bool
        Nobody declared it: it holds an aggregate or a part of one, or selects among relations.
    quantity : Real or Angle, optional
        Of a real number, which has no states.
    """

    name: str
    states: tuple[str, ...]
    edges: np.ndarray | None = None
    circular: bool = False
    class_name: str = ""
    object_name: str = ""
    attribute: str = ""
    clip: bool = False
    unit: str = ""
    auxiliary: bool = False
    quantity: Real | Angle | None = None

    def __post_init__(self) -> None:
        if self.quantity is not None:
            return
        if len(set(self.states)) != len(self.states) or not self.states:
            raise ModelError(f"variable {self.name!r}: states must be named once each, got {self.states}")
        if self.edges is not None and len(self.edges) != len(self.states) + 1:
            raise ModelError(f"variable {self.name!r}: {self.card} bins need {self.card + 1} edges, got {len(self.edges)}")

    @property
    def card(self) -> int:
        """Number of states."""
        return len(self.states)

    @cached_property
    def domain(self) -> Domain:
        """The states as a domain."""
        if self.quantity is not None:
            return self.quantity
        if self.edges is None:
            return Labels(self.states)
        return Bins(tuple(self.edges.tolist()), self.unit, self.circular, self.clip)

    def index(self, value: object) -> int:
        """State index of an observed value: a state's name or index, or a number for bins.

        Raises
        ------
        EvidenceError
            For an unknown state, NaN, or a number outside the bins; the message names the variable.
        """
        return state_index(self.domain, value, f"evidence for {self.name!r}")


@dataclass(frozen=True, eq=False)
class GroundCPD:
    """P(child | parents) of one variable in one slice.

    Attributes
    ----------
    child : str
        Name of the variable, in this slice.
    parents : tuple of (str, int)
        Variable name and lag: 0 same slice, 1 previous slice, -1 static (the value it had in the first slice).
    table : float array
        One axis per parent as declared, the child's axis last; rows sum to 1. Read only.
    key : hashable
        Identity of the class-level CPD: equal keys, equal tables and equal kinds of parents.
    checked : bool
        The rows are known to be distributions, as those of a checked model are.
    density : Density, optional
        Instead of the table, which then is empty, where a real number is among child and parents; its parents are these in order.
    """

    child: str
    parents: tuple[tuple[str, int], ...]
    table: np.ndarray
    key: Hashable
    checked: bool = False
    density: Density | None = None

    def __post_init__(self) -> None:
        for parent, lag in self.parents:
            if lag not in (SAME, PREVIOUS, STATIC):
                raise ModelError(f"CPD of {self.child!r}: lag of parent {parent!r} is {lag}; allowed are 0, 1 and -1")
        if len(set(self.parents)) != len(self.parents):
            raise ModelError(f"CPD of {self.child!r}: a parent is named twice in {self.parents}")
        if self.table.ndim != len(self.parents) + 1:
            count = len(self.parents)
            raise ModelError(f"CPD of {self.child!r}: table has {self.table.ndim} axes for {count} parents and the child")


@dataclass(frozen=True, eq=False)
class GroundSlice:
    """One time slice of the flat net.

    Attributes
    ----------
    variables : dict of str to GroundVariable
        Every variable of the slice, those given among them.
    cpds : tuple of GroundCPD
        One for each variable that is not given.
    given : tuple of str
        Variables that are always observed (ego motion, places of a net): context of the CPDs, never in the tree, without
        a prior and so without a part in the likelihood.
    relations : tuple of str
        The active relation tuples the slice was made for, ``"possesses(o3,ball)"``.
    clusters : tuple of tuple of str
        Variables that a relation asks to keep together when a belief must be projected.
    owners : frozenset of str
        Objects and relation tuples that exist in the slice, even if they have no variable in it; those of the variables, if not given.
    """

    variables: dict[str, GroundVariable]
    cpds: tuple[GroundCPD, ...]
    given: tuple[str, ...] = ()
    relations: tuple[str, ...] = ()
    clusters: tuple[tuple[str, ...], ...] = ()
    owners: frozenset[str] = frozenset()
    by_child: dict[str, GroundCPD] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        by_child: dict[str, GroundCPD] = {}
        for cpd in self.cpds:
            if cpd.child in by_child:
                raise ModelError(f"variable {cpd.child!r} has two CPDs in one slice")
            by_child[cpd.child] = cpd
            self._check(cpd)
        for name in self.variables:
            if (name in by_child) == (name in self.given):
                what = "is given and has a CPD" if name in by_child else "has no CPD and is not given"
                raise ModelError(f"variable {name!r} {what}")
        object.__setattr__(self, "by_child", by_child)
        if not self.owners:
            object.__setattr__(self, "owners", frozenset(v.object_name for v in self.variables.values()))
        self.order()

    def _check(self, cpd: GroundCPD) -> None:
        if cpd.child not in self.variables:
            raise ModelError(f"CPD of unknown variable {cpd.child!r}.{did_you_mean(cpd.child, self.variables)}")
        for parent, lag in cpd.parents:
            if lag == SAME and parent not in self.variables:
                raise ModelError(f"CPD of {cpd.child!r}: unknown parent {parent!r}.{did_you_mean(parent, self.variables)}")
        if cpd.density is not None:
            return
        states = self.variables[cpd.child].card
        if cpd.table.shape[-1] != states:
            raise ModelError(f"CPD of {cpd.child!r}: {cpd.table.shape[-1]} probabilities for {states} states")
        for (parent, _), size in zip(cpd.parents, cpd.table.shape):
            known = self.variables.get(parent)
            if known is not None and known.card != size:
                raise ModelError(f"CPD of {cpd.child!r}: axis of {parent!r} has {size} entries for {known.card} states")
        if not cpd.checked:
            check_rows(cpd.table, f"CPD of {cpd.child!r}")

    def order(self) -> tuple[str, ...]:
        """Variables in a topological order of the same-slice parents, what is given first.

        Raises
        ------
        ModelError
            If the slice has a cycle; the message shows it.
        """
        parents = {c.child: [p for p, lag in c.parents if lag == SAME] for c in self.cpds}
        return topological_order(parents, self.variables)


class Grounds(ABC):
    """Whatever makes the slices of a filter: a `Grounding`, or a schedule of slices made by hand, which needs `ground` alone.

    Attributes
    ----------
    static : tuple of str
        Variables that are drawn once and never again, as far as they are known.
    """

    static: tuple[str, ...] = ()

    def binned(self) -> Grounds:
        """The same for engines that know states only: real numbers are cut into their bins."""
        return self

    def quantities(self, ground: GroundSlice) -> Mapping[str, float]:
        """Values of real numbers that are given where a user leaves them out."""
        return {}

    @abstractmethod
    def ground(self, relations: Any = (), first: bool = False) -> GroundSlice:
        """The slice for what `situation` gave; the same object for the same arguments."""

    def situation(self, relations: Any = (), objects: Iterable[str] | None = None, before: Any = None) -> Any:
        """What holds in a slice, made of what a user says and of what held before."""
        return relations

    def next(self, before: Any, relations: Any = None) -> Any:
        """What holds in the slice after: these relations, or still the same ones."""
        if relations is not None:
            return relations
        return () if before is None else before

    def defaults(self, ground: GroundSlice) -> Mapping[str, int]:
        """States of what is given where a user leaves it out."""
        return {}
