"""Must-reach on a grid: from which cells every run comes to the goal, and within how many steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError


class Branch(NamedTuple):
    """What one action may do from each cell."""

    possible: NDArray[np.bool_]
    """(cells) Whether the agent may choose it somewhere in the cell, for some observation."""
    low: NDArray[np.float64]
    """(cells, n) An enclosure of every next state ..."""
    high: NDArray[np.float64]
    """(cells, n) ... of it; outside of the grid counts as lost, unless it is in the goal."""
    arrives: NDArray[np.bool_]
    """(cells) Whether the goal is certain, so that the enclosure does not matter."""


@dataclass(frozen=True, eq=False)
class Attractor:
    """Cells from which the goal is reached for sure.

    Attributes
    ----------
    edges : tuple of (k + 1,) arrays
        The grid.
    layer : (k1, k2, ...) int32
        Steps within which every run from the cell has arrived, -1 where that is not shown. A ranking function: every step leads to cells
        of lower layers, which `recheck` verifies anew.
    """

    edges: tuple[NDArray[np.float64], ...]
    layer: NDArray[np.int32]

    def steps_from(self, low: Sequence[float], high: Sequence[float]) -> int | None:
        """The bound for all states of a box, None where one of its cells is not shown to arrive."""
        cut = tuple(
            slice(max(0, int(np.searchsorted(e, a, "right")) - 1), max(1, int(np.searchsorted(e, b, "left"))))
            for e, a, b in zip(self.edges, low, high)
        )
        part = self.layer[cut]
        return None if not part.size or (part < 0).any() else int(part.max())

    def at(self, states: NDArray[np.float64]) -> NDArray[np.int64]:
        """(W,) Layer of each state (W, n), -1 outside of the grid."""
        index, inside = [], np.ones(len(states), bool)
        for k, e in enumerate(self.edges):
            i = np.searchsorted(e, states[:, k], "right") - 1
            i = np.where(states[:, k] == e[-1], len(e) - 2, i)
            inside &= (i >= 0) & (i < len(e) - 1)
            index.append(np.clip(i, 0, len(e) - 2))
        return np.where(inside, self.layer[tuple(index)], -1)


def must_reach(edges: Sequence[NDArray[np.float64]], branches: Sequence[Branch], goal_below: float, most: int = 500) -> Attractor:
    """The largest set of cells from which every run reaches the goal.

    A cell joins when every branch that is possible in it leads only to cells that have joined, or to the goal: states whose first number is
    below `goal_below`, which is where the grid begins. Whether a box lies within what has joined is read off a summed-area table.

    Parameters
    ----------
    edges : sequence of (k + 1,) increasing arrays
    branches : sequence of Branch
    goal_below : float
    most : int
        Layers.

    Raises
    ------
    ModelError
    """
    sizes = tuple(len(e) - 1 for e in edges)
    cells = int(np.prod(sizes))
    for b in branches:
        if b.possible.shape != (cells,) or b.low.shape != (cells, len(edges)):
            raise ModelError(f"attractor: {cells} cells of {len(edges)} numbers, a branch has {b.possible.shape} and {b.low.shape}")
    boxes = [_index_box(edges, b, goal_below) for b in branches]
    layer = np.full(cells, -1, np.int32)
    for count in range(1, most + 1):
        table = _summed(layer.reshape(sizes) >= 0)
        ready = layer < 0
        for b, (first, last, lost) in zip(branches, boxes):
            inside = _count(table, first, last) == np.prod(np.maximum(last - first, 0), axis=1)
            ready &= ~b.possible | b.arrives | (~lost & inside)
        if not ready.any():
            break
        layer[ready] = count
    return Attractor(tuple(np.asarray(e, float) for e in edges), layer.reshape(sizes))


def recheck(attractor: Attractor, branches: Sequence[Branch], goal_below: float) -> bool:
    """Whether each step from a cell that joined leads to lower layers or the goal: the stored layers checked on their own."""
    sizes = attractor.layer.shape
    layer = attractor.layer.ravel()
    for b in branches:
        first, last, lost = _index_box(attractor.edges, b, goal_below)
        for count in range(1, int(layer.max(initial=0)) + 1):
            own = (layer == count) & b.possible & ~b.arrives
            if not own.any():
                continue
            table = _summed((attractor.layer >= 0) & (attractor.layer < count))
            inside = _count(table, first[own], last[own]) == np.prod(np.maximum(last[own] - first[own], 0), axis=1)
            if (lost[own] | ~inside).any():
                return False
    return bool(sizes)


def _index_box(
    edges: Sequence[NDArray[np.float64]], b: Branch, goal_below: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Cells that an enclosure touches, [first, last) for each number, and whether it leaves the grid elsewhere than to the goal."""
    first, last = np.empty(b.low.shape, np.int64), np.empty(b.low.shape, np.int64)
    lost = np.zeros(len(b.low), bool)
    for k, e in enumerate(edges):
        first[:, k] = np.clip(np.searchsorted(e, b.low[:, k], "left") - 1, 0, len(e) - 1)
        last[:, k] = np.clip(np.searchsorted(e, b.high[:, k], "right"), 0, len(e) - 1)
        lost |= b.high[:, k] > e[-1]
        if k == 0:
            arrived = b.high[:, 0] < goal_below
            last[arrived, 0] = first[arrived, 0] = 0
        else:
            lost |= b.low[:, k] < e[0]
    arrived = b.high[:, 0] < goal_below
    return first, last, lost & ~arrived


def _summed(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    table = np.zeros(tuple(s + 1 for s in mask.shape), np.int64)
    inner = mask.astype(np.int64)
    for axis in range(mask.ndim):
        inner = inner.cumsum(axis)
    table[tuple(slice(1, None) for _ in mask.shape)] = inner
    return table


def _count(table: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many marked cells lie in each box."""
    n = table.ndim
    total = np.zeros(len(first), np.int64)
    for corner in range(1 << n):
        index = tuple(np.where(last[:, k] > first[:, k], last[:, k] if corner >> k & 1 else first[:, k], 0) for k in range(n))
        total += (-1) ** (n - bin(corner).count("1")) * table[index]
    return total
