"""What a CPD means where a real number is its child or among its parents: leaves, chosen by the states of discrete parents.

A table cannot be written down there. A `Density` has a row of weighted leaves for each combination of the states on which a `Switch`
turns, and a leaf is one formula: a normal with mean and deviation, a chance, or something that depends on no parent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

from ....errors import ModelError, did_you_mean
from .cpds import CPD, Chance, Mixture, Noise, Parents, Prior, Switch, Uniform, check_distribution
from .domains import Bins, Domain, is_continuous
from .formulas import Formula

NORMAL, FLAT, CHANCE, ROW = range(4)
MAX_ROWS = 4096
"""Most combinations of states on which one density may turn."""


@dataclass(frozen=True, eq=False)
class Leaf:
    """One formula of a density.

    Attributes
    ----------
    kind : int
        `NORMAL`: a number with noise. `FLAT`: uniform between limits. `CHANCE`: probability of the second of two states. `ROW`: of all.
    formula : Formula or None
        Mean or chance.
    deviation : Formula or None
        Of a normal.
    values : tuple of float
        Limits of what is flat, the floor of a chance, or the probabilities of a row.
    inputs : dict of str to int
        Name in the formulas -> number of the parent.
    """

    kind: int
    formula: Formula | None = None
    deviation: Formula | None = None
    values: tuple[float, ...] = ()
    inputs: Mapping[str, int] = field(default_factory=dict)

    def moved(self, place: Sequence[int]) -> Leaf:
        """The leaf where parent k is called ``place[k]``."""
        return replace(self, inputs={name: place[k] for name, k in self.inputs.items()})


@dataclass(frozen=True, eq=False)
class Density:
    """P(child | parents) with a real number among them.

    Attributes
    ----------
    child : Domain
    parents : tuple of Domain
    switches : tuple of int
        Numbers of the discrete parents whose states choose the row, in order.
    rows : tuple of tuple of (float, Leaf)
        Weighted leaves for each combination of their states, the last switch fastest.
    """

    child: Domain
    parents: tuple[Domain, ...]
    switches: tuple[int, ...]
    rows: tuple[tuple[tuple[float, Leaf], ...], ...]

    def moved(self, place: Sequence[int], parents: Sequence[Domain]) -> Density:
        """The density where parent k is number ``place[k]`` of `parents`."""
        rows = tuple(tuple((w, leaf.moved(place)) for w, leaf in row) for row in self.rows)
        return Density(self.child, tuple(parents), tuple(place[k] for k in self.switches), rows)


def has_density(child: Domain, parents: Parents) -> bool:
    """Whether a real number is among them, so that there is no table."""
    return is_continuous(child) or any(is_continuous(d) for _, d in parents)


def density(cpd: CPD, child: Domain, parents: Parents, where: str = "cpd") -> Density:
    """What a CPD means for this child and these parents.

    Parameters
    ----------
    cpd : CPD
        `Noise`, `Uniform`, `Chance`, `Prior`, and `Switch` and `Mixture` of these.
    child : Domain
    parents : sequence of (str, Domain)
    where : str
        Start of the message of an error.

    Raises
    ------
    ModelError
        For a CPD that has no meaning there, by name.
    """
    names = [n for n, _ in parents]
    turned = tuple(sorted(_switches(cpd, names, where)))
    for k in turned:
        if is_continuous(parents[k][1]):
            raise ModelError(f"{where}: a switch turns on states; {names[k]!r} is a real number: write a condition into the formula")
    sizes = [len(parents[k][1]) for k in turned]
    if math.prod(sizes) > MAX_ROWS:
        raise ModelError(f"{where}: switches turn on {math.prod(sizes)} combinations of states; at most {MAX_ROWS}")
    rows = []
    for states in product(*(range(size) for size in sizes)):
        fixed = dict(zip(turned, states))
        rows.append(tuple(_leaves(cpd, child, list(parents), fixed, names, where)))
    return Density(child, tuple(d for _, d in parents), turned, tuple(rows))


def chosen(densities: Sequence[Density], parents: Sequence[Domain], selector: int) -> Density:
    """The density that is the k-th of several over the same parents in the k-th state of one of these."""
    turned = (selector, *sorted({k for d in densities for k in d.switches}))
    rows = []
    for states in product(*(range(len(parents[k])) for k in turned)):
        at = dict(zip(turned, states))
        picked, index = densities[states[0]], 0
        for k in picked.switches:
            index = index * len(parents[k]) + at[k]
        rows.append(picked.rows[index])
    return Density(densities[0].child, tuple(parents), turned, tuple(rows))


def averaged(densities: Sequence[Density], parents: Sequence[Domain]) -> Density:
    """The mean of several densities over the same parents."""
    turned = tuple(sorted({k for d in densities for k in d.switches}))
    rows = []
    for states in product(*(range(len(parents[k])) for k in turned)):
        at, row = dict(zip(turned, states)), []
        for d in densities:
            index = 0
            for k in d.switches:
                index = index * len(parents[k]) + at[k]
            row += [(w / len(densities), leaf) for w, leaf in d.rows[index]]
        rows.append(tuple(row))
    return Density(densities[0].child, tuple(parents), turned, tuple(rows))


def _switches(cpd: CPD, names: list[str], where: str) -> set[int]:
    if isinstance(cpd, Switch):
        if cpd.parent not in names:
            raise ModelError(f"{where}: switch on {cpd.parent!r}, which is not a parent.{did_you_mean(cpd.parent, names)}")
        found = {names.index(cpd.parent)}
        return found.union(*(_switches(case, names, where) for _, case in cpd.cases))
    if isinstance(cpd, Mixture):
        return set().union(*(_switches(part, names, where) for _, part in cpd.parts))
    return set()


def _leaves(
    cpd: CPD, child: Domain, parents: list[tuple[str, Domain]], fixed: dict[int, int], names: list[str], where: str
) -> list[tuple[float, Leaf]]:
    """Weighted leaves in one combination of states."""
    if isinstance(cpd, Switch):
        at = names.index(cpd.parent)
        domain = dict(parents)[cpd.parent]
        for state, _ in cpd.cases:
            if state != "*" and state not in domain.states:
                known = ", ".join(domain.states)
                raise ModelError(f"{where}: {cpd.parent!r} has no state {state!r}.{did_you_mean(state, domain.states)} Known: {known}")
        state = domain.states[fixed[at]]
        case = next((c for s, c in cpd.cases if s in (state, "*")), None)
        if case is None:
            raise ModelError(f"{where}: switch on {cpd.parent!r} has no case for {state!r}")
        rest = [p for p in parents if p[0] != cpd.parent]
        return _leaves(case, child, rest, fixed, names, f"{where}, case {state!r}")
    if isinstance(cpd, Mixture):
        return [
            (weight * w, leaf)
            for k, (weight, part) in enumerate(cpd.parts)
            if weight > 0.0
            for w, leaf in _leaves(part, child, parents, fixed, names, f"{where}, part {k}")
        ]
    return _plain(cpd, child, parents, names, where)


def _plain(cpd: CPD, child: Domain, parents: list[tuple[str, Domain]], names: list[str], where: str) -> list[tuple[float, Leaf]]:
    """Leaves of a CPD without parts."""
    numbers = is_continuous(child)
    if isinstance(cpd, Noise) and (numbers or isinstance(child, Bins)):
        mean, sd = Formula(cpd.mean), Formula(str(cpd.sd))
        if not sd.names and float(sd({}, 1)[0]) < 0.0:
            raise ModelError(f"{where}: sd must be at least 0, got {cpd.sd!r}")
        leaf = Leaf(NORMAL, mean, sd, (), _inputs((*mean.names, *sd.names), parents, names, where))
        if numbers or not cpd.floor:
            return [(1.0, leaf)]
        return [(1.0 - cpd.floor, leaf), (cpd.floor, _flat(child, where))]
    if isinstance(cpd, Uniform):
        return [(1.0, _flat(child, where))]
    if numbers:
        raise ModelError(f"{where}: a real number takes Noise, Uniform, and Switch and Mixture of these, got {type(cpd).__name__}")
    if isinstance(cpd, Prior):
        return [(1.0, Leaf(ROW, values=check_distribution(cpd.p, len(child), where)))]
    if isinstance(cpd, Chance):
        if len(child) != 2:
            raise ModelError(f"{where}: Chance needs a child of two states; it has {child.states}")
        formula = Formula(cpd.p)
        return [(1.0, Leaf(CHANCE, formula, None, (cpd.floor,), _inputs(formula.names, parents, names, where)))]
    raise ModelError(
        f"{where}: with a real number among its parents a variable takes Chance, Noise into bins, Prior, Uniform, and Switch and Mixture"
        f" of these, got {type(cpd).__name__}"
    )


def _flat(child: Domain, where: str) -> Leaf:
    if not is_continuous(child):
        return Leaf(ROW, values=(1.0 / len(child),) * len(child))
    limits = child.limits  # type: ignore[union-attr]
    if limits is None:
        raise ModelError(f"{where}: Uniform needs limits: Real(unit, low=..., high=...), or bins; or give a Noise")
    return Leaf(FLAT, values=limits)


def _inputs(used: Sequence[str], parents: list[tuple[str, Domain]], names: list[str], where: str) -> dict[str, int]:
    known = [n for n, _ in parents]
    for name in used:
        if name not in known:
            raise ModelError(f"{where}: {name!r} is not a parent.{did_you_mean(name, known)} Parents: {', '.join(known) or 'none'}")
    return {name: names.index(name) for name in dict.fromkeys(used)}
