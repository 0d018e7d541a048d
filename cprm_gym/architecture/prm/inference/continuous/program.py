"""From the families of one part of a slice to the flat arrays that the kernels run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ....expressions import Assembler, Node
from ...grounding.slices import GroundCPD, GroundVariable
from ...model.densities import CHANCE, FLAT, NORMAL, Density, Leaf
from ...model.domains import Bins, is_continuous
from ...model.formulas import Formula
from .kernels import leaves as k
from .kernels import steps

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")


class Place(NamedTuple):
    """Where a parent is found.

    Attributes
    ----------
    kind : {"column", "slot", "given"}
    at : int
        Column, slot, or the number of the reading.
    variable : GroundVariable
    """

    kind: str
    at: int
    variable: GroundVariable


class Task(NamedTuple):
    """A family in a program.

    Attributes
    ----------
    cpd : GroundCPD
    variable : GroundVariable
    parents : tuple of Place
    target : int
        Slot or column of the child.
    used : int
        Columns in use before it.
    leaf : bool
        Only there to be read: left out where it is not.
    reading : int
        Number of its reading.
    drawn : int
        Which of the random numbers decides it; -1 for none.
    """

    cpd: GroundCPD
    variable: GroundVariable
    parents: tuple[Place, ...]
    target: int
    used: int
    leaf: bool
    reading: int
    drawn: int = -1


class Program(NamedTuple):
    """What a part goes through in a slice.

    A row of `ops`: kind, slot or column of the child, whether it is there to be read only, its reading, states, first of its links and
    how many, first case, first number of its table, number of its period, of its edges, columns in use before it, its random number, the
    first column that is still needed, whether a formula of it bends, whether each component stays one. A row of `leaves`: kind, formula of
    the mean or chance, of the deviation, columns among the inputs, first input, how many, how it depends on the columns, first of its
    numbers, how many conditions it has, the first of them. A row of `inputs`: kind, where it is found, first of the middles of bins.
    """

    ops: np.ndarray
    links: np.ndarray
    cases: np.ndarray
    weights: np.ndarray
    leaves: np.ndarray
    inputs: np.ndarray
    numbers: np.ndarray
    start: np.ndarray
    code: np.ndarray
    constants: np.ndarray
    depth: int
    """Of the stack."""
    width: int
    """Most inputs of a formula."""
    growth: int
    """Components that one can become."""
    formulas: tuple[str, ...]
    """Of each leaf, for messages."""

    @property
    def signature(self) -> tuple[bytes, ...]:
        """Equal for parts that do the same."""
        return tuple(a.tobytes() for a in self[:10])


class Writer:
    """Writes one `Program`."""

    def __init__(self) -> None:
        self.ops: list[list[int]] = []
        self.links: list[tuple[int, int, int]] = []
        self.cases: list[tuple[int, int]] = []
        self.weights: list[float] = []
        self.leaves: list[list[int]] = []
        self.inputs: list[tuple[int, int, int]] = []
        self.numbers: list[float] = []
        self.formulas: list[str] = []
        self.growth = 1
        self.width = 1
        self._assembler = Assembler(lambda name: 0)
        self._lists: dict[tuple[float, ...], int] = {}
        self._reads: list[set[int]] = []

    def finish(self, kept: Iterable[int] = ()) -> Program:
        """The program.

        Parameters
        ----------
        kept : iterable of int
            Columns that are needed after it.
        """
        code = self._assembler.finish()
        needed = set(kept)
        for op, read in zip(reversed(self.ops), reversed(self._reads)):
            needed |= read
            op[13] = min((*needed, op[11]))
        return Program(
            np.array(self.ops, np.int64).reshape(-1, 16),
            np.array(self.links, np.int64).reshape(-1, 3),
            np.array(self.cases, np.int64).reshape(-1, 2),
            np.array(self.weights, np.float64),
            np.array(self.leaves, np.int64).reshape(-1, 10),
            np.array(self.inputs, np.int64).reshape(-1, 3),
            np.array(self.numbers, np.float64),
            code.start,
            code.code,
            code.constants,
            code.depth,
            self.width,
            self.growth,
            tuple(self.formulas),
        )

    def add(self, task: Task) -> None:
        """Append the operation of a family."""
        variable, density = task.variable, task.cpd.density
        links, cases, table, kind = len(self.links), -1, -1, steps.TABLE
        first_leaf, read = len(self.leaves), set[int]()
        if density is None:
            shape = task.cpd.table.shape[:-1]
            self._link(task.parents, shape)
            table = self._list(task.cpd.table.ravel())
            alternatives = 1
        else:
            turned = [task.parents[s] for s in density.switches]
            self._link(turned, [p.variable.card for p in turned])
            cases, alternatives = len(self.cases), max(len(row) for row in density.rows)
            kind = steps.NUMBER if is_continuous(density.child) else (steps.BIN if isinstance(density.child, Bins) else steps.STATE)
            for row in density.rows:
                first = len(self.leaves)
                for weight, leaf in row:
                    self.weights.append(float(np.log(weight)))
                    read |= self._leaf(leaf, density, task.parents)
                self.cases.append((first, len(self.leaves)))
        inner = 1 if variable.quantity is not None else variable.card
        self.growth *= alternatives if task.leaf else inner * alternatives
        edges = self._list(variable.edges) if kind == steps.BIN and variable.edges is not None else -1
        period = variable.quantity.period if variable.quantity is not None else 0.0
        if variable.circular and variable.edges is not None:
            period = float(variable.edges[-1] - variable.edges[0])
        leaves = self.leaves[first_leaf:]
        bends = any(leaf[0] == k.NORMAL and leaf[3] > 0 and leaf[6] == k.NONLINEAR for leaf in leaves)
        alone = kind == steps.NUMBER and alternatives == 1
        self._reads.append(read)
        self.ops.append([
            kind, task.target, int(task.leaf), task.reading, variable.card, links, len(self.links) - links, cases, table,
            self._list([period]), edges, task.used, task.drawn, 0, int(bends), int(alone),
        ])  # fmt: skip

    def _list(self, values: Sequence[float] | np.ndarray) -> int:
        """Where some numbers stand."""
        key = tuple(float(v) for v in values)
        known = self._lists.get(key)
        if known is None:
            known = self._lists[key] = len(self.numbers)
            self.numbers += key
        return known

    def _link(self, parents: Sequence[Place], sizes: Sequence[int]) -> None:
        stride = 1
        for place, size in reversed(list(zip(parents, sizes))):
            self.links.append((0 if place.kind == "slot" else 1, place.at, stride))
            stride *= size

    def _leaf(self, leaf: Leaf, density: Density, parents: Sequence[Place]) -> set[int]:
        """Append a leaf with its formulas and inputs; the columns among these."""
        names = sorted(leaf.inputs, key=lambda name: parents[leaf.inputs[name]].kind != "column")
        # a parent that goes by two names is one input
        order: dict[int, int] = {}
        slots: dict[str, int] = {}
        for name in names:
            at = leaf.inputs[name]
            slots[name] = order.setdefault(at, len(order))
        first = len(self.inputs)
        self.inputs += [self._input(parents[at]) for at in order]
        columns = [at for at in order if parents[at].kind == "column"]
        self.width = max(self.width, len(order))
        mean = sd = -1
        mode, values, breaks, condition = k.NONLINEAR, leaf.values, 0, -1
        if leaf.formula is not None:
            mean = self._assembler.add(leaf.formula.node, slots.__getitem__)
        if leaf.kind == NORMAL and leaf.formula is not None and leaf.deviation is not None:
            sd = self._assembler.add(leaf.deviation.node, slots.__getitem__)
            mode, values = _shape(leaf.formula, leaf.deviation, {n for n in names if leaf.inputs[n] in columns}, len(columns), slots)
        if leaf.kind == CHANCE and leaf.formula is not None:
            condition = mean + 1
            for node in leaf.formula.node.walk():
                if node.op in COMPARISONS:
                    self._assembler.add(Node("-", args=node.args, at=node.at), slots.__getitem__)
                    breaks += 1
        kind = {NORMAL: k.NORMAL, FLAT: k.FLAT, CHANCE: k.CHANCE}.get(leaf.kind, k.ROW)
        self.leaves.append([kind, mean, sd, len(columns), first, len(order), mode, self._list(values), breaks, condition])
        self.formulas.append(" with sd ".join(f.text for f in (leaf.formula, leaf.deviation) if f is not None))
        return {parents[at].at for at in columns}

    def _input(self, place: Place) -> tuple[int, int, int]:
        variable = place.variable
        if place.kind == "column":
            return k.COLUMN, place.at, -1
        if place.kind == "given" and variable.quantity is not None:
            return k.GIVEN_NUMBER, place.at, -1
        if variable.edges is not None:
            middles = self._list(0.5 * (variable.edges[1:] + variable.edges[:-1]))
            return (k.SLOT_MIDDLE if place.kind == "slot" else k.GIVEN_MIDDLE), place.at, middles
        return (k.SLOT if place.kind == "slot" else k.GIVEN_STATE), place.at, -1


def _shape(mean: Formula, sd: Formula, columns: set[str], d: int, slots: Mapping[str, int]) -> tuple[int, tuple[float, ...]]:
    """How a normal depends on its columns, and as far as that is constant the numbers themselves: intercept, deviation or -1, slopes."""
    if not mean.is_affine_in(*columns):
        return k.NONLINEAR, (k.SLOPES_UNKNOWN, -1.0, *(0.0,) * d)
    deviation, slopes, intercept = -1.0 if sd.names else float(sd({}, 1)[0]), [0.0] * d, k.SLOPES_UNKNOWN
    if mean.is_affine_in(*mean.names):
        names = list(mean.names)
        points = {n: np.zeros(len(names) + 1) for n in names}
        for i, n in enumerate(names):
            points[n][i + 1] = 1.0
        at = mean(points, len(names) + 1)
        intercept = float(at[0])
        for i, n in enumerate(names):
            if n in columns:
                slopes[slots[n]] += float(at[i + 1] - at[0])
    if columns & set(sd.names):
        return k.SPREAD, (intercept, deviation, *slopes)
    constant = intercept != k.SLOPES_UNKNOWN and not sd.names and set(mean.names) <= columns
    return (k.CONSTANT if constant else k.AFFINE), (intercept, deviation, *slopes)
