"""The operations of a plan while it is being made: tables, products and sums, and where they lie on the heap."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple

import numpy as np

from . import kernels
from .bands import bands_of

LONG_RUN = 8
"""Entries in a row of memory from which on it pays to make them the innermost loop."""


Loop = tuple[int, int, int, int]
"""How often, and the stride of each operand."""


class MessageFactor(NamedTuple):
    """A factor of the incoming message: its nodes in the order of its axes, and its first column."""

    scope: tuple[int, ...]
    column: int


class TableFactor(NamedTuple):
    """A CPD.

    Attributes
    ----------
    table : int
        Number of the table.
    axes : tuple of int
        A node, or ``-1 - k`` for the observed variable in column k, for each axis of the table.
    missing : int
        Axis that gets one more state, of ones, for a reading that is missing; -1 for none.
    """

    table: int
    axes: tuple[int, ...]
    missing: int = -1


class SoftFactor(NamedTuple):
    """The likelihood vector in a slot, on one node."""

    node: int
    slot: int


@dataclass(frozen=True)
class PlanSpec:
    """The signature of a component: equal signatures run as one batch.

    Attributes
    ----------
    cards : tuple of int
        Number of states of each node. A node is a hidden variable of the past or of the present slice.
    past : tuple of bool
        Which nodes are of the past slice, and have to be eliminated.
    factors : tuple of MessageFactor, TableFactor and SoftFactor
    values : int
        Number of columns of observed variables.
    clusters : tuple of tuple of int
        Present nodes whose joint the message keeps, disjoint; nodes in none are summed out. Empty keeps everything.
    """

    cards: tuple[int, ...]
    past: tuple[bool, ...]
    factors: tuple[MessageFactor | TableFactor | SoftFactor, ...]
    values: int
    clusters: tuple[tuple[int, ...], ...] = ()


class Cost(NamedTuple):
    """What one row of a plan takes."""

    bytes: int
    """Memory of the heap."""
    flops: float
    """Multiplications and additions."""
    largest: int
    """Entries of the largest table."""


class OutputFactor(NamedTuple):
    """A factor of the new message: nodes in the order of its axes, first column, number of entries."""

    scope: tuple[int, ...]
    column: int
    size: int


class Tensor(NamedTuple):
    """A table on the heap while a plan is being made; axes in C order."""

    scope: tuple[int, ...]
    buffer: int
    """Virtual buffer; -1 for a constant that has no place yet, -2 for a fixed place."""
    base: int = 0
    shifts: tuple[tuple[int, int], ...] = ()
    constant: Any = None
    """The `TableFactor` of a constant without a place."""


def materialise(table: np.ndarray, order: Sequence[int], missing: int) -> tuple[np.ndarray, list[int]]:
    """A CPD's table with its axes in another order.

    Parameters
    ----------
    table : float array
    order : sequence of int
        Positions of the axes.
    missing : int
        Position of the axis that gets one more state, of ones; -1 for none.

    Returns
    -------
    flat : float array
    strides : list of int
        Of each axis, in the new order.
    """
    if missing >= 0:
        shape = list(table.shape)
        shape[missing] = 1
        table = np.concatenate([table, np.ones(shape)], axis=missing)
    moved = np.ascontiguousarray(np.transpose(table, order), dtype=np.float64)
    return moved.ravel(), [s // moved.itemsize for s in moved.strides]


class Builder:
    """Collects operations in single-assignment form and lowers them."""

    def __init__(self, spec: PlanSpec, tables: Mapping[int, np.ndarray]) -> None:
        self.spec = spec
        self.tables = tables
        self.cards = dict(enumerate(spec.cards))
        self.ops: list[list[Any]] = []
        self.loops: list[tuple[int, int, int, int]] = []
        self.shifts: list[tuple[int, int]] = []
        self.sizes: list[int] = []
        self.constants: list[np.ndarray] = [np.ones(1)]
        self.constant_size = 1
        self.bands: dict[tuple[Any, ...], tuple[float, int] | None] = {}
        self.band_constants: dict[int, float] = {}  # of an operation
        self.band_rows: list[np.ndarray] = [np.zeros((0, 3), np.int64)]
        self.band_values: list[np.ndarray] = [np.zeros(0)]
        self.placed: dict[tuple[Any, ...], tuple[int, tuple[int, ...]]] = {}
        self.flops = 0.0
        self.sums = 0
        self.one = Tensor((), -2, 0)
        self.message_size = sum(self.size(f.scope) for f in spec.factors if isinstance(f, MessageFactor))
        self.soft_sizes = {f.slot: self.cards[f.node] for f in spec.factors if isinstance(f, SoftFactor)}

    def size(self, scope: Iterable[int]) -> int:
        """Entries of a table over `scope`."""
        return prod(self.cards[v] for v in scope)

    def source(self, factor: MessageFactor | TableFactor | SoftFactor) -> Tensor:
        """Where a factor of the specification is found. Places of message and likelihoods are resolved when all is known."""
        if isinstance(factor, MessageFactor):
            return Tensor(factor.scope, -3, factor.column)
        if isinstance(factor, SoftFactor):
            return Tensor((factor.node,), -4, factor.slot)
        return Tensor(tuple(a for a in factor.axes if a >= 0), -1, constant=factor)

    def place(self, tensor: Tensor, order: Sequence[int]) -> Tensor:
        """Give a constant a place, its axes in the given order; anything else is returned as it is."""
        if tensor.buffer != -1:
            return tensor
        factor: TableFactor = tensor.constant
        observed = [k for k, axis in enumerate(factor.axes) if axis < 0]
        key, flat, strides = self.materialised(factor, order)
        if key not in self.placed:
            self.placed[key] = self.constant_size, tuple(strides)
            self.constants.append(flat)
            self.constant_size += len(flat)
        base, strides_ = self.placed[key]
        shifts = tuple((strides_[i], -1 - factor.axes[k]) for i, k in enumerate(observed))
        return Tensor(tuple(order), -2, base, shifts)

    def materialised(self, factor: TableFactor, order: Sequence[int]) -> tuple[tuple[Any, ...], np.ndarray, list[int]]:
        """The table of a constant with observed axes first and the others in this order: its key, the table, the strides."""
        observed = [k for k, axis in enumerate(factor.axes) if axis < 0]
        positions = (*observed, *(factor.axes.index(v) for v in order))
        key = factor.table, factor.missing, positions
        return key, *materialise(self.tables[factor.table], positions, factor.missing)

    def ones(self, size: int) -> Tensor:
        """A constant table of ones, flat."""
        key = ("ones", size)
        if key not in self.placed:
            self.placed[key] = self.constant_size, ()
            self.constants.append(np.ones(size))
            self.constant_size += size
        return Tensor((), -2, self.placed[key][0])

    def new(self, scope: tuple[int, ...]) -> Tensor:
        """A new virtual buffer."""
        self.sizes.append(self.size(scope))
        return Tensor(scope, len(self.sizes) - 1)

    def strides(self, tensor: Tensor) -> dict[int, int]:
        """Stride of each axis of a tensor."""
        result, stride = {}, 1
        for v in reversed(tensor.scope):
            result[v] = stride
            stride *= self.cards[v]
        return result

    def contract(self, x: Tensor, y: Tensor, drop: Iterable[int] = (), order: Sequence[int] | None = None) -> Tensor:
        """Product of two tensors, summed over the variables in `drop`.

        Parameters
        ----------
        x, y : Tensor
        drop : variables
        order : sequence of variables, optional
            Axes of the result; chosen for speed if not given.
        """
        if self.size(y.scope) > self.size(x.scope) or (x.buffer == -1 and y.buffer != -1 and self.size(y.scope) * 4 >= self.size(x.scope)):
            x, y = y, x
        drop = set(drop)
        scope = list(dict.fromkeys(x.scope + y.scope))
        kept = [v for v in scope if v not in drop]
        if order is None:
            order = self.result_order(x, y, kept)
        inner = self.inner(x, y, order)
        sequence = [v for v in order if v not in inner] + [v for v in scope if v in drop and v not in inner] + inner
        x, y = self.ordered(x, sequence), self.ordered(y, sequence)
        result = self.new(tuple(order))
        sx, sy, sc = self.strides(x), self.strides(y), self.strides(result)
        loops = [(self.cards[v], sx.get(v, 0), sy.get(v, 0), sc.get(v, 0)) for v in sequence if self.cards[v] > 1]
        if loops and loops[-1][1] == 0 and loops[-1][2] == 1:
            x, y = y, x
            loops = [(n, b, a, c) for n, a, b, c in loops]
        loops = merge_loops(loops)
        if not self.by_bands(x, y, result, loops):
            self.emit(kernels.CONTRACT, self.place(x, x.scope), self.place(y, y.scope), result, loops)
        self.flops += 2.0 * self.size(scope)
        return result

    def ordered(self, tensor: Tensor, sequence: Sequence[int]) -> Tensor:
        """A constant without a place with its axes in the order of the loops; anything else as it is."""
        return tensor._replace(scope=tuple(sequence_of(tensor, sequence))) if tensor.buffer == -1 else tensor

    def by_bands(self, x: Tensor, y: Tensor, result: Tensor, loops: list[Loop]) -> bool:
        """Emit a product with a table of bands, summed over its rows or along them; False where it is none."""
        if len(loops) < 2 or loops[-1][1:] != (1, 0, 1) or loops[-2][3] != 0:
            return False
        *outer, (count, sa, sb, _), (n, _, _, _) = loops
        if x.buffer == -1 and sa % n == 0:  # a vector, times rows that stand side by side
            if (found := self.banded(x, n, [loop[1] for loop in outer])) is None:
                return False
            rows, constant, strides = found
            inner: list[Loop] = [(count, sa // n, sb, 0), (n, 1, 0, 1)]
            self.band_constants[len(self.ops)] = constant
            self.emit(kernels.BAND_ROWS, rows, self.place(y, y.scope), result, [*replaced(outer, 1, strides), *inner])
            return True
        if y.buffer != -1 or x.buffer == -1 or sb != 1 or any(loop[1] for loop in outer):
            return False
        if (found := self.banded(y, count, [loop[2] for loop in outer])) is None:
            return False
        rows, constant, strides = found  # several vectors, weighed by what stands in a row: their sum times the constant, and the band
        total = self.flat(n)
        self.emit(kernels.CONTRACT, x, self.one, total, [(count, sa, 0, 0), (n, 1, 0, 1)])
        self.emit(kernels.CONTRACT, total, self.scalar(constant), result, [*((m, 0, 0, c) for m, _, _, c in outer), (n, 1, 0, 1)])
        self.emit(kernels.BAND_SUM, x, rows, result, [*replaced(outer, 2, strides), (count, sa, 1, 0), (n, 1, 0, 1)])
        return True

    def flat(self, size: int) -> Tensor:
        """A new virtual buffer of so many entries, over no variables."""
        self.sizes.append(size)
        return Tensor((), len(self.sizes) - 1)

    def scalar(self, value: float) -> Tensor:
        """A constant."""
        key = ("scalar", value)
        if key not in self.placed:
            self.placed[key] = self.constant_size, ()
            self.constants.append(np.array([value]))
            self.constant_size += 1
        return Tensor((), -2, self.placed[key][0])

    def banded(self, tensor: Tensor, n: int, strides: Sequence[int]) -> tuple[Tensor, float, list[int]] | None:
        """A constant as bands of rows of `n` entries: where they are, the constant, the strides in rows; None where that does not suit."""
        factor: TableFactor = tensor.constant
        key, flat, all_strides = self.materialised(factor, tensor.scope)
        observed = [k for k, axis in enumerate(factor.axes) if axis < 0]
        shifts = tuple((all_strides[i], -1 - factor.axes[k]) for i, k in enumerate(observed))
        if flat.size % n or any(stride % n for stride in (*strides, *(stride for stride, _ in shifts))):
            return None
        name = (*key, n)
        if name not in self.bands:
            found = bands_of(flat.reshape(-1, n))
            self.bands[name] = None if found is None else (found.constant, sum(map(len, self.band_rows)))
            if found is not None:
                self.band_rows.append(found.rows + np.array([0, 0, sum(map(len, self.band_values))]))
                self.band_values.append(found.values)
        known = self.bands[name]
        if known is None:
            return None
        constant, first = known
        return Tensor((), -2, first, tuple((stride // n, column) for stride, column in shifts)), constant, [s // n for s in strides]

    def result_order(self, x: Tensor, y: Tensor, kept: Sequence[int]) -> list[int]:
        """Axes of a product such that the innermost loop runs over consecutive memory."""
        run: list[int] = []
        for v in reversed(x.scope):
            if v in y.scope or v not in kept:
                break
            run.insert(0, v)
        fresh = [v for v in kept if v not in x.scope]
        rest = [v for v in x.scope if v in kept and v not in run]
        if fresh and self.size(run) < max(LONG_RUN, self.size(fresh[-1:])) and y.buffer == -1:
            return rest + run + fresh
        return rest + fresh + run

    def inner(self, x: Tensor, y: Tensor, order: Sequence[int]) -> list[int]:
        """Variables of the innermost loop."""
        if not order:
            return [x.scope[-1]] if x.scope else []
        last = order[-1]
        dropped_last = x.scope and x.scope[-1] not in order
        if dropped_last and last not in y.scope and x.buffer != -1:
            return [x.scope[-1]]
        run: list[int] = []
        for v in reversed(order):
            if (v in x.scope) != (last in x.scope) or (v in y.scope) != (last in y.scope):
                break
            run.insert(0, v)
        return run

    def emit(self, kind: int, a: Tensor, b: Tensor, c: Tensor, loops: Sequence[tuple[int, int, int, int]] = (), extra: int = 0) -> None:
        """Append one operation."""
        first = len(self.loops)
        self.loops += loops
        spans = []
        for operand in (a, b):
            start = len(self.shifts)
            self.shifts += operand.shifts
            spans += [start, len(self.shifts)]
        size = self.sizes[c.buffer] if c.buffer >= 0 else self.size(c.scope)
        self.ops.append([kind, a, b, c, size, first, len(self.loops), *spans, extra])

    def owned(self, tensor: Tensor) -> Tensor:
        """The tensor itself if it is a buffer of its own, else a copy."""
        return tensor if tensor.buffer >= 0 else self.contract(tensor, self.one, order=tensor.scope)

    def marginal(self, tensor: Tensor, keep: Sequence[int]) -> Tensor:
        """Sum of a tensor onto `keep`, axes in that order."""
        if tuple(keep) == tensor.scope and tensor.buffer >= 0:
            return tensor
        return self.contract(tensor, self.one, [v for v in tensor.scope if v not in keep], order=list(keep))

    def product(self, tensors: Sequence[Tensor]) -> Tensor | None:
        """Product of tensors, smallest first; None for an empty product."""
        pool = sorted(tensors, key=lambda t: self.size(t.scope))
        while len(pool) > 1:
            first = pool.pop(0)
            best = min(range(len(pool)), key=lambda i: (self.size(set(first.scope) | set(pool[i].scope)), i))
            joined = self.contract(first, pool.pop(best))
            pool.append(joined)
            pool.sort(key=lambda t: self.size(t.scope))
        return pool[0] if pool else None

    def eliminate(self, factors: list[Tensor], past: set[int]) -> list[Tensor]:
        """Sum out the variables in `past`, cheapest first; a variable is summed as soon as no other factor has it."""
        left = set(past)
        while left:
            price = {}
            for v in left:
                union = {u for f in factors if v in f.scope for u in f.scope}
                price[v] = self.size(union), v
            best = min(left, key=lambda v: price[v])
            inside = [f for f in factors if best in f.scope]
            factors = [f for f in factors if best not in f.scope]
            while len(inside) > 1:
                a, b = self.cheapest_pair(inside, factors, left)
                others = factors + [f for f in inside if f is not a and f is not b]
                joined = self.contract(a, b, self.dead(a, b, others, left))
                inside = [f for f in inside if f is not a and f is not b] + [joined]
            if inside and best in inside[0].scope:
                inside = [self.contract(inside[0], self.one, self.dead(inside[0], self.one, factors, left))]
            factors += inside
            left = {v for v in left if any(v in f.scope for f in factors)}
        return factors

    @staticmethod
    def dead(a: Tensor, b: Tensor, others: Sequence[Tensor], past: set[int]) -> set[int]:
        """Past variables of two factors that no other factor has."""
        union = set(a.scope) | set(b.scope)
        return {v for v in union & past if not any(v in f.scope for f in others)}

    def cheapest_pair(self, inside: Sequence[Tensor], outside: Sequence[Tensor], past: set[int]) -> tuple[Tensor, Tensor]:
        """The two factors whose product, summed where possible, is cheapest to make and smallest."""
        best: tuple[tuple[int, int], Tensor, Tensor] | None = None
        for i, a in enumerate(inside):
            for j in range(i):
                b = inside[j]
                union = set(a.scope) | set(b.scope)
                others = [f for k, f in enumerate(inside) if k not in (i, j)] + list(outside)
                price = self.size(union), self.size(union - self.dead(a, b, others, past))
                if best is None or price < best[0]:
                    best = price, a, b
        assert best is not None
        return best[1], best[2]


def replaced(loops: Sequence[Loop], column: int, strides: Sequence[int]) -> list[Loop]:
    """Loops with other strides of one operand."""
    return [(*loop[:column], stride, *loop[column + 1 :]) for loop, stride in zip(loops, strides)]  # type: ignore[misc]


def sequence_of(tensor: Tensor, sequence: Sequence[int]) -> list[int]:
    """The variables of a tensor in the order of the loops."""
    return [v for v in sequence if v in tensor.scope]


def merge_loops(loops: Sequence[tuple[int, int, int, int]]) -> list[tuple[int, int, int, int]]:
    """Join neighbouring loops that together walk evenly through all three tables."""
    merged: list[tuple[int, int, int, int]] = []
    for loop in loops:
        if merged and all(merged[-1][k] == loop[k] * loop[0] for k in (1, 2, 3)):
            merged[-1] = (merged[-1][0] * loop[0], *loop[1:])
        else:
            merged.append(loop)
    return merged


def allocate(ops: Sequence[Sequence[Any]], sizes: Sequence[int], kept: set[int], start: int) -> tuple[dict[int, int], int]:
    """Places on the heap: a buffer is freed after its last use, and its room taken by the first that fits.

    Parameters
    ----------
    ops : list of operations
        Operands are `Tensor`; a buffer is written first where it stands as third operand.
    sizes : sequence of int
        Entries of each buffer.
    kept : set of int
        Buffers that must survive to the end.
    start : int
        First free place.

    Returns
    -------
    places : dict of buffer to int
    end : int
        Size of the heap.
    """
    last: dict[int, int] = {}
    for k, op in enumerate(ops):
        for tensor in op[1:4]:
            if tensor.buffer >= 0:
                last[tensor.buffer] = k
    places: dict[int, int] = {}
    free: list[tuple[int, int]] = []
    end = start
    for k, op in enumerate(ops):
        new = op[3].buffer
        if new >= 0 and new not in places:
            for i, (at, room) in enumerate(free):
                if room >= sizes[new]:
                    places[new] = at
                    free[i : i + 1] = [(at + sizes[new], room - sizes[new])] if room > sizes[new] else []
                    break
            else:
                places[new] = end
                end += sizes[new]
        for tensor in op[1:4]:
            b = tensor.buffer
            if b >= 0 and last[b] == k and b not in kept and b in places:
                free.append((places[b], sizes[b]))
                last[b] = -1
        free = _joined(free)
    return places, end


def _joined(free: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Neighbouring free stretches as one."""
    result: list[tuple[int, int]] = []
    for at, room in sorted(free):
        if result and sum(result[-1]) == at:
            result[-1] = result[-1][0], result[-1][1] + room
        else:
            result.append((at, room))
    return result
