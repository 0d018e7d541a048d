"""One step of the particle filter: what is drawn, in which order, and what is weighed.

`Structure` is made once for a slice, a division of the belief into components and a pattern of evidence; a `Block` takes some
particles through it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cprm_gym.errors import ModelError

from ...grounding.slices import PREVIOUS, GroundCPD
from ..compiled import kernels
from ..compiled.slice_info import ABSORBED, BARREN, HELD, WEIGHTED, NeedsVariable, SliceInfo
from ..evidence import Readings, one_hot
from ..join_tree import connected

NOW, OLD, SEEN, SEEN_BEFORE = range(4)


class Spot(NamedTuple):
    """Where a parent's value is found: among the particles of this or the previous slice, or among their readings."""

    kind: int
    name: str
    row: int
    card: int


class Lone(NamedTuple):
    """A reading that depends on one hidden variable alone: likelihoods of it, one row for each value of all others."""

    table: np.ndarray
    """(values of the observed parents and of the reading, card of the hidden parent); a missing reading is a row of ones."""
    spots: tuple[Spot, ...]
    row: int
    states: int


class Draw(NamedTuple):
    """A variable to be drawn."""

    child: str
    home: int
    table: np.ndarray
    spots: tuple[Spot, ...]
    row: int
    observed: bool
    lone: tuple[Lone, ...]


class Weigh(NamedTuple):
    """A reading that several hidden variables, or none, must fit. `home` is -1 for none."""

    child: str
    home: int
    table: np.ndarray
    spots: tuple[Spot, ...]
    row: int


class Structure:
    """What a step does.

    Parameters
    ----------
    before : SliceInfo or None
        The previous slice.
    old_parts : tuple of tuple of str
        Components of the belief.
    held_before : frozenset of str
        Variables of the previous slice that every agent observed.
    info : SliceInfo
    status : (V,) int array

    Raises
    ------
    NeedsVariable
        A variable of the previous slice is needed that was not drawn.
    """

    def __init__(
        self,
        before: SliceInfo | None,
        old_parts: tuple[tuple[str, ...], ...],
        held_before: frozenset[str],
        info: SliceInfo,
        status: np.ndarray,
    ) -> None:
        self.before, self.held_before, self.info, self.status = before, held_before, info, status
        self.old_parts = old_parts
        self.owner = {n: k for k, part in enumerate(old_parts) for n in part}
        self.drawn = {n for n in info.slice.variables if status[info.row[n]] not in (HELD, ABSORBED, BARREN)}
        self.kept = tuple(n for n in info.names if n not in info.slice.variables and n in self.owner)
        self.held = frozenset(n for n, row in info.row.items() if status[row] == HELD)
        families = [c for c in info.slice.cpds if status[info.row[c.child]] != BARREN]
        spots = [tuple(self._spot(p, lag, c.child, n) for (p, lag), n in zip(c.parents, c.table.shape)) for c in families]
        homes = self._divide(families, spots)
        self._order(families, spots, homes)

    def _spot(self, name: str, lag: int, child: str, card: int) -> Spot:
        """Where the value of a parent is found."""
        if lag != PREVIOUS and name in self.info.slice.variables:
            return Spot(NOW if name in self.drawn else SEEN, name, self.info.row[name], card)
        if name in self.owner:
            return Spot(NOW if name in self.kept else OLD, name, -1, card)
        if self.before is None or name not in self.before.row:
            raise ModelError(f"CPD of {child!r} has parent {name!r} in the previous slice, where there is no such variable")
        row = self.before.row[name]
        if name in self.held_before:
            return Spot(SEEN_BEFORE, name, row, card)
        raise NeedsVariable(self.before.kinds[row], name, static=lag != PREVIOUS)

    def _token(self, spot: Spot) -> Any:
        """What a hidden parent belongs to: a variable of this slice, or a component of the belief."""
        return ("old", self.owner[spot.name]) if spot.kind == OLD or spot.name in self.kept else spot.name

    def _divide(self, families: Sequence[GroundCPD], spots: Sequence[tuple[Spot, ...]]) -> list[int]:
        """Independent components; the one of each family, -1 if all of it was observed."""
        scopes: list[tuple[Any, ...]] = []
        for cpd, found in zip(families, spots):
            hidden = tuple(self._token(s) for s in found if s.kind in (NOW, OLD))
            scopes.append(hidden + ((cpd.child,) if cpd.child in self.drawn else ()))
        scopes += [(("old", self.owner[n]),) for n in self.kept]
        homes = [-1] * len(families)
        parts: list[tuple[str, ...]] = []
        self.sources: list[tuple[int, ...]] = []
        self.readers: list[tuple[str, ...]] = []
        for indices in connected(scopes):
            tokens = dict.fromkeys(v for i in indices for v in scopes[i])
            if not tokens:
                continue
            for i in indices:
                if i < len(families):
                    homes[i] = len(parts)
            sources = tuple(t[1] for t in tokens if not isinstance(t, str))
            self.readers.append(tuple(families[i].child for i in indices if i < len(families)))
            parts.append((*(t for t in tokens if isinstance(t, str)), *(n for n in self.kept if self.owner[n] in sources)))
            self.sources.append(sources)
        self.parts = tuple(parts)
        return homes

    def _order(self, families: Sequence[GroundCPD], spots: Sequence[tuple[Spot, ...]], homes: Sequence[int]) -> None:
        """Draws in topological order, and what is weighed afterwards."""
        info = self.info
        lone: dict[str, list[Lone]] = {}
        self.weighs: list[Weigh] = []
        for cpd, found, home in zip(families, spots, homes):
            if cpd.child in self.drawn:
                continue
            hidden = [k for k, s in enumerate(found) if s.kind in (NOW, OLD)]
            row = info.row[cpd.child]
            if len(hidden) == 1 and found[hidden[0]].kind == NOW and found[hidden[0]].name in self.drawn:
                lone.setdefault(found[hidden[0]].name, []).append(_lone(cpd.table, hidden[0], found, row))
            else:
                self.weighs.append(Weigh(cpd.child, home, _rows(cpd.table), found, row))
        place = {n: i for i, n in enumerate(info.slice.order())}
        self.draws = [
            Draw(
                c.child,
                home,
                _rows(c.table),
                found,
                info.row[c.child],
                bool(self.status[info.row[c.child]] == WEIGHTED),
                tuple(lone.get(c.child, ())),
            )
            for c, found, home in sorted(zip(families, spots, homes), key=lambda item: place[item[0].child])
            if c.child in self.drawn
        ]
        part_of = {n: k for k, part in enumerate(self.parts) for n in part}
        self.kept_readings = [(n, info.row[n], part_of[n]) for n in self.kept if self.status[info.row[n]] == WEIGHTED]


def _rows(table: np.ndarray) -> np.ndarray:
    """A CPD as one row for each value of its parents."""
    return np.ascontiguousarray(table, dtype=np.float64).reshape(-1, table.shape[-1])


def _lone(table: np.ndarray, axis: int, spots: tuple[Spot, ...], row: int) -> Lone:
    """A reading's CPD as likelihoods of its only hidden parent."""
    extended = np.concatenate([table, np.ones((*table.shape[:-1], 1))], axis=-1)
    moved = np.moveaxis(extended, axis, -1)
    others = tuple(s for k, s in enumerate(spots) if k != axis)
    return Lone(np.ascontiguousarray(moved).reshape(-1, table.shape[axis]), others, row, table.shape[-1])


class Block:
    """Some particles through one step.

    Attributes
    ----------
    values : dict of str to (W, P) int array
    weights, prior : list of (W, P) float arrays
        Of each component, with and without the readings; not normalised, comparable between blocks.
    constant : (W,) float array
        ln P of readings that no hidden variable influences.
    """

    def __init__(
        self,
        structure: Structure,
        rng: np.random.Generator,
        old: dict[str, np.ndarray],
        old_weights: Sequence[np.ndarray],
        previous: np.ndarray,
        readings: Readings,
        number: int,
    ) -> None:
        self.structure, self.rng, self.previous, self.readings, self.number = structure, rng, previous, readings, number
        self.parts, self.readers, self.held = structure.parts, structure.readers, structure.held
        self.batch = readings.hard.shape[1]
        self.old: dict[str, np.ndarray] = {}
        self.prior: list[np.ndarray] = []
        self._bring_in(old, old_weights)
        self.weights = [w.copy() for w in self.prior]
        self.values = {n: self.old[n] for n in structure.kept}
        self.constant = np.zeros(self.batch)
        self.constant_names: list[str] = []
        for draw in structure.draws:
            self._draw(draw)
        for weigh in structure.weighs:
            self._weigh(weigh)
        for name, row, home in structure.kept_readings:
            self.weights[home] *= np.take_along_axis(self._evidence(name, row), self.values[name], axis=1)

    def _bring_in(self, old: dict[str, np.ndarray], old_weights: Sequence[np.ndarray]) -> None:
        """Old particles of each new component; old components that meet are paired at random."""
        for sources in self.structure.sources:
            weight = np.full((self.batch, self.number), 1.0 / self.number)
            for k in sources:
                if len(sources) == 1 and old_weights[k].shape[1] == self.number:
                    self.old.update((n, old[n]) for n in self.structure.old_parts[k])
                    weight = old_weights[k]
                    continue
                ancestors = np.empty((self.batch, self.number), np.int64)
                kernels.systematic(old_weights[k], self.rng.random(self.batch), ancestors)
                ancestors = self.rng.permuted(ancestors, axis=1)
                self.old.update((n, np.take_along_axis(old[n], ancestors, axis=1)) for n in self.structure.old_parts[k])
            self.prior.append(weight)

    def _value(self, spot: Spot) -> np.ndarray:
        """Values of a parent, (W, P) of particles or (W, 1) of readings."""
        if spot.kind == NOW:
            return self.values[spot.name]
        if spot.kind == OLD:
            return self.old[spot.name]
        source = self.readings.hard if spot.kind == SEEN else self.previous
        return np.asarray(source[spot.row][:, None])

    def _row(self, spots: Sequence[Spot]) -> np.ndarray:
        """Row of a table that the parents select, (W, P) or (W, 1)."""
        rows = np.zeros((self.batch, 1), np.int64)
        for spot in spots:
            rows = rows * spot.card + self._value(spot)
        return rows

    def _evidence(self, name: str, row: int) -> np.ndarray:
        """Hard and soft evidence on a drawn variable, (W, card)."""
        likelihood = one_hot(self.readings.hard[row], int(self.structure.info.cards[row]))
        return likelihood * self.readings.soft[name] if name in self.readings.soft else likelihood

    def _draw(self, draw: Draw) -> None:
        """Draw one variable for all particles."""
        likelihood = self._evidence(draw.child, draw.row) if draw.observed else np.ones((self.batch, draw.table.shape[1]))
        for lone in draw.lone:
            reading = self.readings.hard[lone.row]
            index = self._row(lone.spots)[:, 0] * (lone.states + 1) + np.where(reading < 0, lone.states, reading)
            likelihood = likelihood * lone.table[index]
        rows = np.ascontiguousarray(np.broadcast_to(self._row(draw.spots), (self.batch, self.number)))
        out = np.empty((self.batch, self.number), np.int64)
        kernels.draw(draw.table, rows, likelihood, self.rng.random((self.batch, self.number)), self.weights[draw.home], out)
        self.values[draw.child] = out

    def _weigh(self, weigh: Weigh) -> None:
        """Multiply weights by the probability of a reading."""
        reading = self.readings.hard[weigh.row]
        seen = reading >= 0
        if not seen.any():
            return
        chance = np.where(seen[:, None], weigh.table[self._row(weigh.spots), np.maximum(reading, 0)[:, None]], 1.0)
        if weigh.home >= 0:
            self.weights[weigh.home] *= chance
            return
        with np.errstate(divide="ignore"):
            self.constant += np.log(chance[:, 0])
        self.constant_names.append(weigh.child)
