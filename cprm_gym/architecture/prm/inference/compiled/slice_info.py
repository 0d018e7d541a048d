"""A ground slice as the compiler sees it: rows, kinds, and the status of each variable under a pattern of evidence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ...grounding.slices import PREVIOUS, SAME, GroundCPD, GroundSlice, GroundVariable
from .cache import Recent, TableStore

HIDDEN, HELD, WEIGHTED, ABSORBED, BARREN = range(5)
PRESENT, PAST = SAME, PREVIOUS
"""Second part of a node's name: the slice it belongs to; or `STATIC`."""


class Kind(NamedTuple):
    """What two variables of like objects share, and what tells the objects apart."""

    class_name: str
    object_name: str
    attribute: str


class NeedsVariable(Exception):
    """The next slice needs a variable that was summed out of the belief, or that has to be kept as static."""

    def __init__(self, kind: Kind, name: str, static: bool) -> None:
        super().__init__(name)
        self.kind, self.name, self.static = kind, name, static


def kind_of(variable: GroundVariable) -> Kind:
    """Class, object and attribute of a variable; taken from a dotted name where the variable does not say."""
    if variable.object_name or variable.attribute:
        return Kind(variable.class_name, variable.object_name, variable.attribute)
    owner, _, attribute = variable.name.rpartition(".")
    return Kind(variable.class_name, owner, attribute)


class SliceInfo:
    """A ground slice, indexed for the compiler.

    Attributes
    ----------
    slice : GroundSlice
    names : tuple of str
        Order of the rows of the evidence: variables of the slice, then static ones defined earlier.
    row : dict of str to int
    cards : (V,) int array
    kinds : tuple of Kind
    given, static : (V,) bool arrays
    given_rows : int array
        Rows of what is given.
    defaults : int array
        States of these where nothing is told; -1 for none.
    continuous : bool
        Some variable is a real number.
    quantities : dict of str to float
        Values of real numbers that are given, where nothing is told.
    """

    def __init__(
        self,
        ground: GroundSlice,
        static: dict[str, GroundVariable],
        store: TableStore,
        defaults: Mapping[str, int] = MappingProxyType({}),
        quantities: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        self.slice = ground
        self.variables = dict(ground.variables)
        self.variables.update((n, v) for n, v in static.items() if n not in ground.variables)
        self.names = tuple(self.variables)
        self.row = {name: i for i, name in enumerate(self.names)}
        self.cards = np.array([self.variables[n].card for n in self.names], np.int64)
        self.continuous = any(v.quantity is not None for v in self.variables.values())
        self.quantities = quantities
        self.kinds = tuple(kind_of(self.variables[n]) for n in self.names)
        given = set(ground.given)
        self.given = np.array([n in given for n in self.names], bool)
        self.given_rows = np.flatnonzero(self.given)
        self.defaults = np.array([defaults.get(self.names[r], -1) for r in self.given_rows], np.int64)
        self.cpds: tuple[tuple[GroundCPD, int], ...] = tuple((c, store.number(c.table)) for c in ground.cpds if c.child not in given)
        count = len(self.names)
        self.parents = np.zeros((count, count), bool)
        self.has_past = np.zeros(count, bool)
        for cpd, _ in self.cpds:
            child = self.row[cpd.child]
            for parent, lag in cpd.parents:
                if lag == PREVIOUS:
                    self.has_past[child] = True
                elif parent in self.row:
                    self.parents[child, self.row[parent]] = True
        self.leaf = ~self.parents.any(axis=0)
        self.static = np.array([n in static for n in self.names], bool)
        self.static_variables = {n: self.variables[n] for n in self.names if n in static}
        self._statuses: Recent[tuple[Any, ...], np.ndarray] = Recent(1024)
        self._matters: Recent[frozenset[tuple[str, str]], np.ndarray] = Recent(16)

    def status(self, evidence: np.ndarray, soft: Iterable[str], temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Status of each variable under a pattern of evidence.

        Parameters
        ----------
        evidence : (V, W) int array
            -1 where not observed.
        soft : names
            Variables with a likelihood vector.
        temporal : frozenset of (class, attribute)
            Kinds of variables that some slice has as parents in the previous slice.
        """
        count = (evidence >= 0).sum(axis=1)
        pattern = (count > 0).astype(np.int8) + (count == evidence.shape[1])
        matters = self._matters.fetch(temporal, lambda: ~self._readings(temporal) | (self.parents.sum(axis=1) > 1))
        key = pattern[matters].tobytes(), tuple(soft), temporal
        return self._statuses.fetch(key, lambda: self._status(count, evidence.shape[1], soft, temporal))

    def _kept(self, temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Variables that stay in the belief."""
        return np.array([(k.class_name, k.attribute) in temporal for k in self.kinds], bool) | self.static

    def _readings(self, temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Variables that are there to be observed. Whether they are matters only if they have several parents to couple."""
        return np.asarray(self.leaf & ~self._kept(temporal) & ~self.has_past & ~self.given)

    def _status(self, count: np.ndarray, batch: int, soft: Iterable[str], temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Status from the number of agents that observe each variable."""
        kept, reading = self._kept(temporal), self._readings(temporal)
        status = np.where(count == batch, HELD, np.where(count > 0, WEIGHTED, HIDDEN)).astype(np.int8)
        status[self.static & (count > 0)] = WEIGHTED
        status[reading] = ABSORBED
        for name in soft:
            if not self.given[self.row[name]]:
                status[self.row[name]] = WEIGHTED
        status[self.given] = HELD
        self._drop_barren(status, count, kept)
        return status

    def _drop_barren(self, status: np.ndarray, count: np.ndarray, kept: np.ndarray) -> None:
        """Mark the unobserved, childless variables that would couple two or more hidden parents."""
        while True:
            hidden = (status == HIDDEN) | (status == WEIGHTED)
            alive = status != BARREN
            childless = ~(self.parents & alive[:, None]).any(axis=0)
            free = ((status == HIDDEN) | (status == ABSORBED)) & (count == 0) & childless & ~kept & ~self.has_past
            free &= (self.parents & hidden[None, :]).sum(axis=1) > 1
            if not free.any():
                return
            status[free] = BARREN
