"""Conditional probability distributions of a class: written as values, turned into tables once.

Every CPD has ``table(child, parents, where)``: the domain of the child, the ordered pairs (name, domain) of its parents, and
the start of an error message. The table has one axis per parent as declared and the child's axis last; its rows sum to 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import ModelError, did_you_mean
from .domains import Bins, Domain, as_domain, listed
from .formulas import Formula
from .integration import average_over_bins, integrate_noise, with_floor

Parents = Sequence[tuple[str, Domain]]

SUM_TOLERANCE = 1e-9
"""How far the sum of a written row may be from 1."""

MAX_CHANCES = 200_000_000
"""Most values that one `Chance` may compute, at some nanoseconds each; see `integration.MAX_VALUES` for those of a `Noise`."""

MAX_CELLS = 20_000_000
"""Largest table that is built; a larger one is a mistake in the model."""


class CPD:
    """Base of everything that gives P(child | parents)."""

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        """The table: parents' axes as declared, the child's last.

        Parameters
        ----------
        child : Labels or Bins
        parents : sequence of (str, Labels or Bins)
        where : str
            Start of the message of an error.

        Raises
        ------
        ModelError
        """
        raise NotImplementedError


def _pairs(value: object, what: str, example: str) -> list[tuple[Any, Any]]:
    found = listed(value, what, example)
    if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in found):
        raise ModelError(f"{what} are a mapping or pairs, such as {example}, got {value!r}")
    return [(first, second) for first, second in found]


def as_cpd(value: object, where: str) -> CPD:
    """A CPD from what a user wrote: a CPD, or a tuple of probabilities (a `Prior`)."""
    if isinstance(value, CPD):
        return value
    if isinstance(value, tuple | list) and value and all(isinstance(v, int | float) for v in value):
        return Prior(tuple(value))
    if isinstance(value, dict):
        return Table(value)
    raise ModelError(f"{where}: a CPD is Prior, Uniform, Table, Dense, Noise, Chance, Switch, Mixture or NoisyOr, got {value!r}")


def check_distribution(values: Sequence[float], states: int, where: str) -> tuple[float, ...]:
    """The probabilities as floats, or an error that says which are wrong.

    Raises
    ------
    ModelError
        If the count is not `states`, a value is negative or not finite, or the sum is not 1.
    """
    try:
        row = tuple(float(v) for v in listed(values, "probabilities", "(0.4, 0.6)"))
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, ModelError):
            raise ModelError(f"{where}: {error}") from None
        raise ModelError(f"{where}: probabilities must be numbers, got {values!r}") from None
    if len(row) != states:
        raise ModelError(f"{where}: {len(row)} probabilities for {states} states")
    for k, p in enumerate(row):
        if not (math.isfinite(p) and p >= 0.0):
            raise ModelError(f"{where}: probability {k} is {p!r}; allowed are 0 to 1")
    if abs(math.fsum(row) - 1.0) > SUM_TOLERANCE:
        raise ModelError(f"{where}: probabilities sum to {math.fsum(row):.12g}, not 1: {row}")
    return row


def check_rows(table: np.ndarray, where: str) -> None:
    """Refuse a table with a negative, non-finite or not-summing row, naming the row.

    Parameters
    ----------
    table : float array
        Child axis last.
    where : str
        Start of the message.

    Raises
    ------
    ModelError
    """
    good = np.isfinite(table).all(axis=-1) & (table >= 0).all(axis=-1)
    with np.errstate(invalid="ignore"):
        good &= np.abs(table.sum(axis=-1) - 1.0) <= SUM_TOLERANCE
    if good.all():
        return
    row = tuple(int(i) for i in np.argwhere(~np.atleast_1d(good))[0]) if table.ndim > 1 else ()
    values = table[row]
    distribution = np.isfinite(values).all() and (values >= 0).all()
    what = f"sums to {float(values.sum())!r}, not 1" if distribution else "has values that are no probabilities"
    raise ModelError(f"{where}: row {row} {what}: {values.tolist()}")


def _shape(child: Domain, parents: Parents, where: str) -> tuple[int, ...]:
    shape = (*(len(d) for _, d in parents), len(child))
    if math.prod(shape) > MAX_CELLS:
        sizes = ", ".join(f"{name} {len(d)}" for name, d in parents)
        raise ModelError(f"{where}: a table of {math.prod(shape)} cells ({sizes}; child {len(child)}); at most {MAX_CELLS}")
    return shape


@dataclass(frozen=True)
class Uniform(CPD):
    """Every state equally likely; bins too, whatever their width."""

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        return np.full(_shape(child, parents, where), 1.0 / len(child))


@dataclass(frozen=True)
class Prior(CPD):
    """The same distribution whatever the parents, ``Prior((0.4, 0.4, 0.2))``."""

    p: tuple[float, ...]

    def __post_init__(self) -> None:
        given = listed(self.p, "probabilities", "(0.4, 0.6)")
        object.__setattr__(self, "p", check_distribution(given, len(given), "prior"))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        row = check_distribution(self.p, len(child), where)
        return np.array(np.broadcast_to(np.array(row), _shape(child, parents, where)))


@dataclass(frozen=True, init=False)
class Table(CPD):
    """Rows by the states of the parents; ``"*"`` stands for any state, the first row that matches wins.

    Parameters
    ----------
    rows : mapping of tuple of str to tuple of float
        ``{("yes", "yes"): (0.2, 0.8), ("*", "*"): (0.9, 0.1)}``. With one parent a key may be the state alone.
    """

    rows: tuple[tuple[tuple[str, ...], tuple[float, ...]], ...]

    def __init__(self, rows: Mapping[Any, Sequence[float]] | Sequence[tuple[Any, Sequence[float]]]) -> None:
        pairs = rows.items() if isinstance(rows, Mapping) else _pairs(rows, "rows of a table", '{("yes", "no"): (0.4, 0.6)}')
        made = []
        for key, values in pairs:
            names = (key,) if isinstance(key, str) else listed(key, "states of a row", '("yes", "no")')
            values = listed(values, f"probabilities of row {names}", "(0.4, 0.6)")
            made.append((names, check_distribution(values, len(values), f"row {names}")))
        object.__setattr__(self, "rows", tuple(made))

    @classmethod
    def from_function(cls, function: Callable[..., Sequence[float]], *domains: Domain | tuple[str, ...]) -> Table:
        """Evaluate `function` once for every combination of parents' states.

        Parameters
        ----------
        function : callable
            Takes a state name per named parent and a mid-point per binned one; returns the probabilities of the child's states.
        *domains : Labels, Bins or tuple of str
            Of the parents, in order.
        """
        spaces = [as_domain(d, "Table.from_function") for d in domains]
        rows = []
        for index in np.ndindex(*(len(s) for s in spaces)):
            key = tuple(s.states[k] for s, k in zip(spaces, index))
            rows.append((key, tuple(function(*(s.values[k] for s, k in zip(spaces, index))))))
        return cls(rows)

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        out = np.zeros(shape)
        free = np.ones(shape[:-1], dtype=bool)
        for names, values in self.rows:
            if len(names) != len(parents):
                raise ModelError(f"{where}, row {names}: {len(names)} states for {len(parents)} parents")
            row = check_distribution(values, len(child), f"{where}, row {names}")
            picks = []
            for name, (parent, domain) in zip(names, parents):
                if name != "*" and name not in domain.states:
                    known = ", ".join(domain.states)
                    hint = did_you_mean(name, domain.states)
                    raise ModelError(f"{where}, row {names}: {parent!r} has no state {name!r}.{hint} Known: {known}")
                picks.append(slice(None) if name == "*" else slice(domain.states.index(name), domain.states.index(name) + 1))
            block = tuple(picks)
            out[block] = np.where(free[block][..., None], np.array(row), out[block])
            free[block] = False
        if free.any():
            first = tuple(int(i) for i in np.argwhere(free)[0]) if parents else ()
            gap = tuple(domain.states[k] for k, (_, domain) in zip(first, parents))
            raise ModelError(f"{where}: no row for {gap} ({int(free.sum())} rows are missing)")
        return out


@dataclass(frozen=True, init=False, eq=False)
class Dense(CPD):
    """A whole table of numbers, as learning and import give it; two are equal when all their numbers are.

    Parameters
    ----------
    values : array_like
        Parents' axes as declared, the child's last.
    domains : tuple of tuple of str, optional
        `stamp` of the domain of every axis; when given, a model whose states or bins have changed since is refused.
    """

    values: np.ndarray
    domains: tuple[tuple[str, ...], ...] | None

    def __init__(self, values: Any, domains: Sequence[Sequence[str]] | None = None) -> None:
        array = np.array(values, dtype=float, order="C")
        array.flags.writeable = False
        object.__setattr__(self, "values", array)
        object.__setattr__(self, "domains", None if domains is None else tuple(tuple(d) for d in domains))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Dense):
            return NotImplemented
        return self.domains == other.domains and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash((self.values.shape, self.values.tobytes()))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        if self.values.shape != shape:
            raise ModelError(f"{where}: table has shape {self.values.shape}, needed is {shape}")
        if self.domains is not None:
            for axis, (known, domain) in enumerate(zip(self.domains, [d for _, d in parents] + [child])):
                if known != domain.stamp:
                    raise ModelError(f"{where}: axis {axis} was made for {known}, the model has {domain.stamp}")
        flat = self.values.reshape(-1, shape[-1])
        for k, row in enumerate(flat):
            if not np.all(row >= 0.0) or abs(row.sum() - 1.0) > SUM_TOLERANCE:
                at = np.unravel_index(k, shape[:-1]) if parents else ()
                names = tuple(d.states[int(i)] for i, (_, d) in zip(at, parents))
                check_distribution(tuple(row.tolist()), shape[-1], f"{where}, row {names}")
        return np.array(self.values)


@dataclass(frozen=True)
class Noise(CPD):
    """A number with noise, integrated over the bins of child and parents (`integration`).

    Attributes
    ----------
    mean : str
        Expression in the parents' names, ``"prev.dist + prev.vdist"``; a named-state parent counts as the index of its state.
    sd : float or str
        Standard deviation: a number (additive noise) or an expression in the parents (multiplicative noise is
        ``"0.05 * prev.dist"``). 0 is a deterministic value.
    shape : {"normal", "uniform"}
        Of the noise; uniform noise of half-width h has ``sd = h / sqrt(3)``.
    floor : float
        Share of a uniform distribution mixed into every row, so that no observation is impossible.
    points : int
        Gauss-Legendre nodes per bin of parents that have no closed form; 0 chooses by bin width and `sd`.

    Notes
    -----
    Parents are taken as uniform inside their bins, end bins of the child hold the tails, a circular child wraps.
    """

    mean: str
    sd: float | str = 0.0
    shape: str = "normal"
    floor: float = 1e-6
    points: int = 0

    def __post_init__(self) -> None:
        if self.shape not in ("normal", "uniform"):
            raise ModelError(f"noise: shape must be 'normal' or 'uniform', got {self.shape!r}")
        if not 0.0 <= self.floor < 1.0:
            raise ModelError(f"noise: floor must be at least 0 and below 1, got {self.floor!r}")
        if isinstance(self.sd, int | float) and not (math.isfinite(self.sd) and self.sd >= 0.0):
            raise ModelError(f"noise: sd must be at least 0, got {self.sd!r}")
        if not 0 <= self.points <= 4096:
            raise ModelError(f"noise: points must be 0 to 4096, got {self.points!r}")
        Formula(self.mean)
        Formula(str(self.sd))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        if not isinstance(child, Bins):
            raise ModelError(f"{where}: noise needs a child with bins; it has the states {child.states}")
        mean, sd = Formula(self.mean), Formula(str(self.sd))
        known = dict(parents)
        _only_parents((*mean.names, *sd.names), known, where)
        used = [(n, d) for n, d in parents if n in mean.names or n in sd.names]
        small = integrate_noise(mean, sd, self.shape, child, used, self.points, where)
        return spread_axes(with_floor(small, self.floor), [n for n, _ in used], [n for n, _ in parents], shape)


@dataclass(frozen=True)
class Chance(CPD):
    """The probability of the second of two states as an expression, averaged over the parents' bins.

    Attributes
    ----------
    p : str
        ``"0.95 if abs(dir) < 1.05 else 0.03"``; values outside 0 to 1 are an error.
    floor : float
        Share of a uniform distribution mixed in.
    points : int
        Gauss-Legendre nodes per bin and parent.
    """

    p: str
    floor: float = 0.0
    points: int = 64

    def __post_init__(self) -> None:
        if not 0.0 <= self.floor < 1.0:
            raise ModelError(f"chance: floor must be at least 0 and below 1, got {self.floor!r}")
        if not 1 <= self.points <= 4096:
            raise ModelError(f"chance: points must be 1 to 4096, got {self.points!r}")
        Formula(self.p)

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        if len(child) != 2:
            raise ModelError(f"{where}: Chance needs a child of two states; it has {child.states}")
        formula, known = Formula(self.p), dict(parents)
        _only_parents(formula.names, known, where)
        used = [(n, d) for n, d in parents if n in formula.names]

        def value(arrays: list[np.ndarray]) -> np.ndarray:
            p = formula({n: a for (n, _), a in zip(used, arrays)}, len(arrays[0]) if arrays else 1)
            if not (np.isfinite(p).all() and (p >= 0.0).all() and (p <= 1.0).all()):
                raise ModelError(f"{where}: {self.p!r} gives {float(p[~((p >= 0) & (p <= 1))][0])!r}; a probability is 0 to 1")
            return np.stack([1.0 - p, p], axis=1)

        try:
            small = average_over_bins(value, [d for _, d in used], [self.points] * len(used), 2, MAX_CHANCES)
        except ModelError as error:
            raise ModelError(f"{where}: {error}" if where not in str(error) else str(error)) from None
        return spread_axes(with_floor(small, self.floor), [n for n, _ in used], [n for n, _ in parents], shape)


@dataclass(frozen=True, init=False)
class Switch(CPD):
    """Another CPD for each state of one parent, ``Switch("seen", {"yes": Noise("dist", 0.5), "no": Uniform()})``.

    Parameters
    ----------
    parent : str
        One of the parents, by the name under which it is declared.
    cases : mapping of str to CPD
        By state; ``"*"`` for the rest, the first match wins. Each gets the other parents.
    """

    parent: str
    cases: tuple[tuple[str, CPD], ...]

    def __init__(self, parent: str, cases: Mapping[str, object] | Sequence[tuple[str, object]]) -> None:
        pairs = cases.items() if isinstance(cases, Mapping) else _pairs(cases, "cases of a switch", '{"yes": Uniform()}')
        object.__setattr__(self, "parent", parent)
        object.__setattr__(self, "cases", tuple((s, as_cpd(c, f"case {s!r} of switch on {parent!r}")) for s, c in pairs))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        names = [n for n, _ in parents]
        if self.parent not in names:
            raise ModelError(f"{where}: switch on {self.parent!r}, which is not a parent.{did_you_mean(self.parent, names)}")
        axis = names.index(self.parent)
        domain = parents[axis][1]
        rest = [p for k, p in enumerate(parents) if k != axis]
        out = np.zeros(shape)
        for state, _ in self.cases:
            if state != "*" and state not in domain.states:
                hint = did_you_mean(state, domain.states)
                raise ModelError(f"{where}: {self.parent!r} has no state {state!r}.{hint} Known: {', '.join(domain.states)}")
        made: dict[int, np.ndarray] = {}
        for k, state in enumerate(domain.states):
            case = next((i for i, (s, _) in enumerate(self.cases) if s in (state, "*")), None)
            if case is None:
                raise ModelError(f"{where}: switch on {self.parent!r} has no case for {state!r}")
            if case not in made:
                made[case] = self.cases[case][1].table(child, rest, f"{where}, case {self.cases[case][0]!r}")
            out[(slice(None),) * axis + (k,)] = made[case]
        return out


@dataclass(frozen=True, init=False)
class Mixture(CPD):
    """A weighted mean of CPDs, ``Mixture((0.7, Noise("prev.dist", 0.3)), (0.3, Uniform()))``.

    Parameters
    ----------
    *parts : (float, CPD)
        Weights sum to 1; each part gets all parents.
    """

    parts: tuple[tuple[float, CPD], ...]

    def __init__(self, *parts: tuple[float, object]) -> None:
        parts = tuple(_pairs(parts, "parts of a mixture", "(0.5, Uniform())"))
        weights = check_distribution([w for w, _ in parts], len(parts), "weights of a mixture")
        object.__setattr__(self, "parts", tuple((w, as_cpd(c, "mixture")) for w, (_, c) in zip(weights, parts)))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        out = np.zeros(_shape(child, parents, where))
        for k, (weight, cpd) in enumerate(self.parts):
            out += weight * cpd.table(child, parents, f"{where}, part {k}")
        return out


@dataclass(frozen=True)
class NoisyOr(CPD):
    """Independent causes of a two-state child: ``P(no) = (1 - leak) * prod(1 - strength of the causes that hold)``.

    Attributes
    ----------
    strengths : tuple of float
        One per parent, each of two states of which the second means that the cause holds.
    leak : float
        Probability of the child without any cause.
    """

    strengths: tuple[float, ...]
    leak: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "strengths", listed(self.strengths, "strengths", "(0.9, 0.5)"))
        for value in (*self.strengths, self.leak):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 1.0:
                raise ModelError(f"noisy-or: {value!r} is not a probability")
        object.__setattr__(self, "strengths", tuple(float(s) for s in self.strengths))

    def table(self, child: Domain, parents: Parents, where: str = "cpd") -> np.ndarray:
        shape = _shape(child, parents, where)
        if shape[-1] != 2 or any(len(d) != 2 for _, d in parents):
            raise ModelError(f"{where}: noisy-or needs two states in child and parents, got {shape}")
        if len(self.strengths) != len(parents):
            raise ModelError(f"{where}: noisy-or has {len(self.strengths)} strengths for {len(parents)} parents")
        none = np.full((), 1.0 - self.leak)
        for strength in self.strengths:
            none = np.multiply.outer(none, np.array([1.0, 1.0 - strength]))
        return np.stack([none, 1.0 - none], axis=-1)


def spread_axes(table: np.ndarray, used: list[str], parents: list[str], shape: tuple[int, ...]) -> np.ndarray:
    """A table over some parents, repeated along the axes of the parents it does not depend on."""
    index = tuple(slice(None) if name in used else None for name in parents) + (slice(None),)
    return np.array(np.broadcast_to(table[index], shape))


def _only_parents(names: Sequence[str], parents: Mapping[str, Domain], where: str) -> None:
    for name in names:
        if name not in parents:
            known = ", ".join(parents) or "none"
            raise ModelError(f"{where}: {name!r} is not a parent.{did_you_mean(name, parents)} Parents: {known}")
