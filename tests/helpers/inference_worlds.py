"""Random dynamic nets with relations that switch, and the slow way to ask them: one big sum over the unrolled net."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable


def table(rng: np.random.Generator, shape: tuple[int, ...], zeros: float = 0.0) -> np.ndarray:
    """A random CPD, child last; a share `zeros` of entries is zero."""
    values = rng.dirichlet(np.ones(shape[-1]), size=shape[:-1]) + 1e-3
    values = np.where(rng.random(shape) < zeros, 0.0, values)
    values[..., 0] += values.sum(axis=-1) == 0
    return values / values.sum(axis=-1, keepdims=True)


class RandomWorld(Grounds):
    """Objects with hidden chains and readings, and relations that link them, each slice drawn once for a set of relations.

    The relation ``k`` (a number) makes some variables depend on variables of other objects, in the same slice or the one
    before. Objects listed in ``("without", name)`` do not exist. There is a static variable and one that is given.
    """

    def __init__(self, seed: int, objects: int = 3, zeros: float = 0.0, static: bool = True, with_given: bool = True) -> None:
        rng = np.random.default_rng(seed)
        self.rng, self.zeros = rng, zeros
        self.cards = {}
        self.objects = [f"x{k}" for k in range(objects)]
        self.like = rng.random() < 0.5
        card = int(rng.integers(2, 4))
        for o in self.objects:
            for a in ("p", "q", "seen", "obs"):
                self.cards[f"{o}.{a}"] = 2 if a == "seen" else card if self.like else int(rng.integers(2, 4))
        self.static = ("bias",) if static else ()
        self.given = ("turn",) if with_given else ()
        self.cards.update(dict.fromkeys((*self.static, *self.given), 2))
        self.tables: dict[Any, np.ndarray] = {}
        self.slices: dict[Any, GroundSlice] = {}

    def cpd(self, child: str, parents: Sequence[tuple[str, int]]) -> GroundCPD:
        """The CPD of a child with these parents; like objects share it."""
        kinds = tuple((p.split(".")[-1], lag) for p, lag in parents)
        shape = (*(self.cards[p] for p, _ in parents), self.cards[child])
        key = (child.split(".")[-1] if self.like else child, kinds, shape)
        if key not in self.tables:
            self.tables[key] = table(self.rng, shape, self.zeros)
        return GroundCPD(child, tuple(parents), self.tables[key], key)

    def ground(self, active: tuple[Any, ...] = (), first: bool = False) -> GroundSlice:
        """The slice for some relations."""
        key = (active, first)
        if key in self.slices:
            return self.slices[key]
        gone = {a[1] for a in active if isinstance(a, tuple) and a[0] == "without"}
        new = {a[1] for a in active if isinstance(a, tuple) and a[0] == "enters"}
        live = [o for o in self.objects if o not in gone]
        parents: dict[str, list[tuple[str, int]]] = {}
        if first:
            for name in self.static:
                parents[name] = []
        for o in live:
            begins = first or o in new
            parents[f"{o}.p"] = [] if begins else [(f"{o}.p", 1), (f"{o}.q", 1)]
            parents[f"{o}.q"] = [] if begins else [(f"{o}.q", 1)]
            if self.given and o == live[0]:
                parents[f"{o}.p"].append((self.given[0], 0))
            if self.static and o == live[-1]:
                parents[f"{o}.q"].append((self.static[0], 0 if first else -1))
            parents[f"{o}.seen"] = [(f"{o}.p", 0)]
            parents[f"{o}.obs"] = [(f"{o}.p", 0), (f"{o}.seen", 0)]
        for a in active:
            if isinstance(a, int) and not first:
                link = np.random.default_rng(a)
                one, other = (str(x) for x in link.choice(live, 2, replace=False))
                kind = int(link.integers(0, 3))
                if kind == 0:
                    parents[f"{one}.q"].append((f"{other}.p", 1))
                elif kind == 1:
                    parents[f"{max(one, other)}.p"] = [(f"{min(one, other)}.p", 0)]
                else:
                    parents[f"{one}.p"] = []
        names = [*parents, *self.given]
        variables = {n: GroundVariable(n, tuple(map(str, range(self.cards[n])))) for n in names}
        clean = {
            c: list(dict.fromkeys((p, lag) for p, lag in ps if lag != 1 or p.split(".")[0] not in new | gone)) for c, ps in parents.items()
        }
        self.slices[key] = GroundSlice(variables, tuple(self.cpd(c, ps) for c, ps in clean.items()), self.given)
        return self.slices[key]


def unrolled_joint(
    slices: Sequence[GroundSlice],
    hard: Sequence[Mapping[str, int]],
    soft: Sequence[Mapping[str, np.ndarray]],
    keep: Sequence[tuple[str, int]],
    static: Sequence[str] = (),
) -> np.ndarray:
    """Sum of the product of everything onto some variables (name, slice): not normalised, axes as in `keep`."""
    numbers: dict[tuple[str, int], int] = {}
    evidence: dict[tuple[str, int], int] = {}
    operands: list[Any] = []

    def at(name: str, t: int) -> tuple[str, int]:
        return (name, 0) if name in static else (name, t)

    def add(array: np.ndarray, scope: Sequence[tuple[str, int]]) -> None:
        index = tuple(evidence.get(v, slice(None)) for v in scope)
        operands.append(array[index])
        operands.append([numbers.setdefault(v, len(numbers)) for v in scope if v not in evidence])

    for t, given in enumerate(hard):
        for name, value in given.items():
            if at(name, t) not in keep:
                evidence[at(name, t)] = value
    for t, ground in enumerate(slices):
        for cpd in ground.cpds:
            add(cpd.table, [at(p, t - lag if lag == 1 else t) for p, lag in cpd.parents] + [at(cpd.child, t)])
        for name, likelihood in soft[t].items():
            add(likelihood, [at(name, t)])
        for name, value in hard[t].items():
            if at(name, t) in keep:
                add(np.eye(ground.variables[name].card)[value], [at(name, t)])
    return np.einsum(*operands, [numbers[at(*v)] for v in keep], optimize="greedy")
