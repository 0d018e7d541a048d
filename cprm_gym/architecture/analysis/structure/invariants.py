"""P- and T-invariants: weighted sums of tokens that never change, and bags of firings that change nothing.

`flow_basis` is a basis of all invariants, by exact elimination: whole numbers, fast, complete, signs mixed. `semiflows` are the minimal
ones without negative weights, by Farkas' algorithm (Colom, Silva 1991): readable, but there can be exponentially many.

Set arcs are not linear: a P-invariant here uses no place that a set arc writes, a T-invariant no transition that has one. Test and
inhibitor arcs and capacities only forbid firings; invariants stay true.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import gcd
from typing import Literal

import numpy as np

from ..net_arrays import KEEP, System

Vector = dict[int, int]


def never() -> bool:
    """The time never ends."""
    return False


@dataclass(frozen=True)
class Invariant:
    """One invariant.

    Attributes
    ----------
    weights : dict from name to int
        Of places (P) or transitions (T); the others have weight 0.
    value : int
        For a P-invariant the weighted sum in the initial marking, and so in every marking.
    """

    weights: dict[str, int]
    value: int = 0

    @property
    def support(self) -> frozenset[str]:
        """The names with a weight."""
        return frozenset(self.weights)

    def __str__(self) -> str:
        parts = []
        for name, w in self.weights.items():
            sign = "-" if w < 0 else "+"
            parts.append(f"{sign} {'' if abs(w) == 1 else f'{abs(w)} '}{name}")
        return " ".join(parts).removeprefix("+ ")


@dataclass(frozen=True)
class Invariants:
    """Invariants of one kind.

    Attributes
    ----------
    kind : {"P", "T"}
    vectors : tuple of Invariant
    complete : bool
        False if Farkas' algorithm was cut short.
    """

    kind: Literal["P", "T"]
    vectors: tuple[Invariant, ...]
    complete: bool = True

    @property
    def covered(self) -> frozenset[str]:
        """Names that occur in an invariant without negative weights."""
        return frozenset(n for v in self.vectors if min(v.weights.values()) > 0 for n in v.weights)


def flow_basis(system: System, kind: Literal["P", "T"] = "P", enough: Callable[[], bool] = never) -> Invariants:
    """A basis of the P- or T-invariants, in whole numbers.

    Parameters
    ----------
    system : System
    kind : {"P", "T"}
    enough : callable
        Whether to stop early, with those found so far.
    """
    columns, names = _columns(system, kind)
    found, complete = integer_kernel(columns, enough)
    return _named(system, kind, names, found, complete)


def semiflows(system: System, kind: Literal["P", "T"] = "P", max_rows: int = 2000, enough: Callable[[], bool] = never) -> Invariants:
    """The minimal invariants without negative weights (minimal support), by Farkas' algorithm.

    Parameters
    ----------
    system : System
    kind : {"P", "T"}
    max_rows : int
        Rows of the working table beyond which the search is cut short (`Invariants.complete` is then False and those found so
        far that are invariants are returned).
    enough : callable
        Whether to cut it short now.
    """
    columns, names = _columns(system, kind)
    found, complete = farkas(columns, max_rows, enough)
    return _named(system, kind, names, found, complete)


def _columns(system: System, kind: str) -> tuple[list[Vector], list[str]]:
    """For each place (P) or transition (T) its row of the incidence matrix as a sparse vector, and the names."""
    matrix = system.incidence
    writes = system.sets != KEEP
    if kind == "P":
        kept = np.flatnonzero(~writes.any(axis=0))
        rows = [{int(t): int(matrix[t, p]) for t in np.flatnonzero(matrix[:, p])} for p in kept]
        return rows, [system.places[p] for p in kept]
    kept = np.flatnonzero(~writes.any(axis=1))
    rows = [{int(p): int(matrix[t, p]) for p in np.flatnonzero(matrix[t])} for t in kept]
    return rows, [system.transitions[t] for t in kept]


def _named(system: System, kind: Literal["P", "T"], names: list[str], found: Iterable[Vector], complete: bool) -> Invariants:
    column = {name: p for p, name in enumerate(system.places)}
    vectors = []
    for vector in found:
        weights = {names[i]: w for i, w in sorted(vector.items())}
        value = sum(w * int(system.marking[column[n]]) for n, w in weights.items()) if kind == "P" else 0
        vectors.append(Invariant(weights, value))
    return Invariants(kind, tuple(vectors), complete)


def _combine(a: int, x: Vector, b: int, y: Vector) -> Vector:
    """``a x + b y`` without zeros."""
    result = {i: a * v for i, v in x.items()}
    for i, v in y.items():
        total = result.get(i, 0) + b * v
        if total:
            result[i] = total
        else:
            result.pop(i, None)
    return result


def _reduced(rest: Vector, part: Vector) -> tuple[Vector, Vector]:
    """Both divided by the greatest common divisor of all entries."""
    divisor = gcd(*rest.values(), *part.values())
    if divisor > 1:
        return {i: v // divisor for i, v in rest.items()}, {i: v // divisor for i, v in part.items()}
    return rest, part


def integer_kernel(columns: list[Vector], enough: Callable[[], bool] = never) -> tuple[list[Vector], bool]:
    """A basis, with whole numbers, of all rational y with ``sum y[i] * columns[i] = 0``, by exact elimination.

    Parameters
    ----------
    columns : list of sparse vectors (dict from equation to coefficient)

    Returns
    -------
    list of sparse vectors, bool
        Entries without common divisor and with a sum that is not negative; whether they are all, or `enough` said to stop.
    """
    rows = {i: (dict(c), {i: 1}) for i, c in enumerate(columns)}
    where: dict[int, set[int]] = {}
    for i, c in enumerate(columns):
        for e in c:
            where.setdefault(e, set()).add(i)
    while where and not enough():
        equation = min(where, key=lambda e: (len(where[e]), e))
        holders = where.pop(equation)
        if not holders:
            continue
        pivot = min(holders, key=lambda i: (abs(rows[i][0][equation]), len(rows[i][0]) + len(rows[i][1]), i))
        rest, part = rows.pop(pivot)
        for e in rest:
            if e != equation:
                where[e].discard(pivot)
        p = rest[equation]
        for i in holders - {pivot}:
            old = rows[i][0]
            v = old[equation]
            g = gcd(p, v)
            new = _combine(p // g, old, -v // g, rest)
            rows[i] = _reduced(new, _combine(p // g, rows[i][1], -v // g, part))
            for e in old.keys() - new.keys() - {equation}:
                where[e].discard(i)
            for e in new.keys() - old.keys():
                where[e].add(i)
    basis = []
    for _, part in sorted((r for r in rows.values() if not r[0]), key=lambda r: sorted(r[1])):
        sign = 1 if part[min(part)] > 0 else -1
        positive = all(v * sign > 0 for v in part.values())
        sign = sign if positive or sum(part.values()) * sign >= 0 else -sign
        basis.append({i: sign * v for i, v in part.items()})
    return basis, not where


def farkas(columns: list[Vector], max_rows: int, enough: Callable[[], bool] = never) -> tuple[list[Vector], bool]:
    """The minimal-support solutions y >= 0 of ``sum y[i] * columns[i] = 0``.

    Returns
    -------
    list of sparse vectors, bool
        The solutions, and whether the search was completed.
    """
    rows: list[tuple[Vector, Vector, int]] = [(dict(c), {i: 1}, 1 << i) for i, c in enumerate(columns)]
    open_ = {e for c in columns for e in c}
    while open_:
        plus: dict[int, int] = dict.fromkeys(open_, 0)
        minus: dict[int, int] = dict.fromkeys(open_, 0)
        for rest, _, _ in rows:
            for e, v in rest.items():
                if v > 0:
                    plus[e] += 1
                else:
                    minus[e] += 1
        equation = min(open_, key=lambda e: (plus[e] * minus[e] - plus[e] - minus[e], e))
        open_.discard(equation)
        above = [r for r in rows if r[0].get(equation, 0) > 0]
        below = [r for r in rows if r[0].get(equation, 0) < 0]
        kept = [r for r in rows if equation not in r[0]]
        if len(kept) + len(above) * len(below) > 4 * max_rows:
            return [part for rest, part, _ in kept if not rest], False
        fresh = []
        for a in above:
            if enough():
                return [part for rest, part, _ in kept if not rest], False
            for b in below:
                p, n = a[0][equation], -b[0][equation]
                g = gcd(p, n)
                rest, part = _reduced(_combine(n // g, a[0], p // g, b[0]), _combine(n // g, a[1], p // g, b[1]))
                fresh.append((rest, part, a[2] | b[2]))
        rows = kept + _minimal(kept, fresh)
        if len(rows) > max_rows:
            return [part for rest, part, _ in rows if not rest], False
    return [part for _, part, _ in rows], True


def _minimal(kept: list[tuple[Vector, Vector, int]], fresh: list[tuple[Vector, Vector, int]]) -> list[tuple[Vector, Vector, int]]:
    """Those of `fresh` whose support holds no other support."""
    chosen: list[tuple[Vector, Vector, int]] = []
    supports = [r[2] for r in kept]
    for row in sorted(fresh, key=lambda r: r[2].bit_count()):
        if not any(s & row[2] == s for s in supports):
            chosen.append(row)
            supports.append(row[2])
    return chosen


def structural_bounds(system: System, invariants: Invariants) -> dict[str, int]:
    """Most tokens per place that P-invariants without negative weights allow."""
    bounds: dict[str, int] = {}
    for v in invariants.vectors:
        if min(v.weights.values()) > 0:
            for name, w in v.weights.items():
                bounds[name] = min(bounds.get(name, v.value // w), v.value // w)
    return bounds


def finite_transitions(system: System, bounded: bool) -> dict[int, str]:
    """Transitions that no infinite run fires again and again, and why; from the arcs alone.

    A transition that takes what is put back finitely often fires finitely often. In a bounded net what fires for ever is part of a
    T-invariant without negative weights: what all of it only adds to, or only takes from, a place is in none. Places that set arcs
    write say nothing.

    Parameters
    ----------
    system : System
    bounded : bool
        Whether the net is known to be bounded.
    """
    change = system.incidence
    change[:, (system.sets != KEEP).any(axis=0)] = 0
    found: dict[int, str] = {}
    alive = np.ones(len(system.transitions), bool)
    while True:
        gains, losses = (change[alive] > 0).any(axis=0), (change[alive] < 0).any(axis=0)
        drained, filled = losses & ~gains, gains & ~losses
        fresh = [(t, p, "is never put back into") for t, p in np.argwhere((change < 0) & drained) if alive[t]]
        if not fresh and bounded:
            fresh = [(t, p, "is never taken again from") for t, p in np.argwhere((change > 0) & filled) if alive[t]]
        if not fresh:
            return found
        for t, p, how in fresh:
            verb = "takes" if how.endswith("into") else "puts"
            found.setdefault(int(t), f"{system.transitions[t]!r} {verb} what {how} {system.places[p]!r}")
            alive[t] = False
