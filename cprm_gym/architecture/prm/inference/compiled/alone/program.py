"""All plans of a step as one program, for an agent who is alone.

A step runs the plan of each group of components. For many agents each is worth a call of its own; for one agent what surrounds the calls
would take longer than they do. So the plans of an engine lie one behind the other in a `Shelf`, and a `Program` says for each component
of a step which operations are its, what comes from where, and where its answers go.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import kernels
from ..lanes.kernels import LARGEST
from ..plans import MAX_LOOPS, Plan
from . import kernels as alone

if TYPE_CHECKING:
    from ..belief import Layout
    from ..steps import Group, SliceStep

Table = np.ndarray
MOST_PLANS = 512
"""On one shelf; then another is begun, which programs made later use."""


def fits(step: SliceStep) -> bool:
    """Whether a step can be a program: all of its plans run in lanes, so that many agents' sums are taken in the same order."""
    return all(group.plan.in_lanes for group in step.groups)


class Place(NamedTuple):
    """Where a plan stands: its operations, and its constants on the heap."""

    first: int
    last: int
    constants: int


class Shelf:
    """Plans one behind the other, with a heap whose first `LARGEST` entries are room for the row at work."""

    def __init__(self) -> None:
        self.ops: Table = np.zeros((0, 12), np.int64)
        self.band_constants: Table = np.zeros(0)
        self.rows: Table = np.zeros((0, 3), np.int64)
        self.banded: Table = np.zeros(0)
        self.loops: Table = np.zeros((0, 4), np.int64)
        self.shifts: Table = np.zeros((0, 2), np.int64)
        self.heap: Table = np.zeros(LARGEST)
        self.counter: Table = np.zeros(MAX_LOOPS, np.int64)
        self.values: Table = np.zeros(1, np.int64)
        self.places: dict[int, tuple[Plan, Place]] = {}

    def place(self, plan: Plan) -> Place:
        """Where a plan stands; it is put there if it is new."""
        known = self.places.get(id(plan))
        if known is None:
            known = self.places[id(plan)] = plan, self._put(plan)
        return known[1]

    def address(self, plan: Plan, place: Place, at: Table) -> Table:
        """Addresses of a plan's own heap on the heap of all."""
        constants = len(plan.constants)
        return np.where(at < constants, at + place.constants, at - constants)

    def _put(self, plan: Plan) -> Place:
        place = Place(len(self.ops), len(self.ops) + len(plan.ops), len(self.heap))
        ops = plan.ops.copy()
        kind = ops[:, kernels.KIND]
        for column, bands in ((kernels.A, kernels.BAND_ROWS), (kernels.B, kernels.BAND_SUM), (kernels.C, -1)):
            own = ops[:, column]
            ops[:, column] = np.where(kind == bands, own + len(self.rows), self.address(plan, place, own))
        kind[kind == kernels.CONTRACT] = kernels.IN_ORDER
        ops[:, [kernels.LOOP, kernels.LOOP_END]] += len(self.loops)
        ops[:, kernels.A_SHIFT : kernels.B_SHIFT_END + 1] += len(self.shifts)
        rows = plan.band_rows.copy()
        rows[:, 2] += len(self.banded)
        self.ops = np.concatenate([self.ops, ops])
        self.band_constants = np.concatenate([self.band_constants, plan.band_constants])
        self.rows = np.concatenate([self.rows, rows])
        self.banded = np.concatenate([self.banded, plan.band_values])
        self.loops = np.concatenate([self.loops, plan.loops])
        self.shifts = np.concatenate([self.shifts, plan.shifts])
        self.heap = np.concatenate([self.heap, plan.constants])
        if plan.spec.values > len(self.values):
            self.values = np.zeros(plan.spec.values, np.int64)
        return place


class Answers(NamedTuple):
    """What a program gave, by group as `Plan.run` gives it, and all marginals as one array."""

    messages: tuple[Table, ...]
    marginals: list[Table]
    sums: list[Table]
    increment: Table
    flat: Table


class Program:
    """A step for one agent.

    Parameters
    ----------
    shelf : Shelf
    step : SliceStep
        All of whose plans run in lanes.
    before : Layout
        Of the belief before.
    """

    def __init__(self, shelf: Shelf, step: SliceStep, before: Layout) -> None:
        self.shelf = shelf
        self._columns = before.widths
        self._starts = [0, *itertools.accumulate(n * w for n, w in zip(before.counts, before.widths))]
        tables: dict[str, list[tuple[int, ...]]] = {"copies": [], "columns": [], "soft": [], "outputs": []}
        self._components: list[list[int]] = []
        self.ends = np.zeros(3, np.int64)
        self._parts: list[tuple[tuple[slice, int, int], ...]] = []
        for group in step.groups:
            self._add(group, tables)
        self.components = np.array(self._components, np.int64).reshape(-1, 12)
        self.copies, self.columns, self.soft_at = (np.array(tables[k], np.int64).reshape(-1, 3) for k in ("copies", "columns", "soft"))
        self.outputs = np.array(tables["outputs"], np.int64).reshape(-1, 5)
        self.no_soft = np.ones((1, step.soft_width))

    def _add(self, group: Group, tables: dict[str, list[tuple[int, ...]]]) -> None:
        """The components of a group."""
        plan, members = group.plan, len(group.members)
        place = self.shelf.place(plan)
        widths = np.array([plan.message_size, plan.marginal_size, plan.sums], np.int64)
        starts, self.ends = self.ends, self.ends + members * widths
        cuts = zip(starts.tolist(), self.ends.tolist(), widths.tolist())
        self._parts.append(tuple((slice(first, last), members, width) for first, last, width in cuts))

        def at(address: int) -> int:
            return int(self.shelf.address(plan, place, np.int64(address)))

        for b in range(members):
            before = [len(tables[k]) for k in ("copies", "columns", "soft", "outputs")]
            tables["copies"] += [(source, at(plan.message_at + to), size) for source, to, size in self._moves(group, b)]
            tables["columns"] += [tuple(c) for c in group.columns[b].tolist()]
            tables["soft"] += [(column, size, at(to)) for column, size, to in group.soft_at[b].tolist()]
            first = starts + b * widths
            for kind, address, size, column, slot in plan.outputs.tolist():
                own = slot if slot < 0 else int(first[2]) + slot
                tables["outputs"].append((kind, at(address), size, int(first[kind]) + column, own))
            after = [len(tables[k]) for k in ("copies", "columns", "soft", "outputs")]
            parts = [n for pair in zip(before, after) for n in pair]
            self._components.append([place.first, place.last, *parts, int(first[2]), int(first[2]) + plan.sums])

    def _moves(self, group: Group, member: int) -> list[tuple[int, int, int]]:
        """What is copied from the belief before: (first of its entries, place in the component's message, how many)."""
        if group.direct >= 0:
            width = self._columns[group.direct]
            return [(self._starts[group.direct] + member * width, 0, width)]
        moves = []
        for move in group.moves:
            for to, source in zip(move.to_instances.tolist(), move.instances.tolist()):
                if to == member:
                    at = self._starts[move.source] + source * self._columns[move.source] + move.columns.start
                    moves.append((at, move.to_columns.start, move.columns.stop - move.columns.start))
        return moves

    def entries(self, where: tuple[int, int, int, int]) -> range:
        """Where a variable's marginal stands among all marginals, from ``SliceStep.where``."""
        group, instance, column, card = where
        cut, _, width = self._parts[group][1]
        first = cut.start + instance * width + column
        return range(first, first + card)

    def run(self, before: Table, evidence: Table, previous: Table, soft: Table) -> Answers:
        """Run it; `before` is all arrays of the belief, one behind the other."""
        shelf = self.shelf
        message, marginals, sums = (np.empty(n) for n in self.ends.tolist())
        increment = alone.run_step(
            shelf.ops,
            shelf.band_constants,
            shelf.rows,
            shelf.banded,
            shelf.loops,
            shelf.shifts,
            shelf.heap,
            shelf.counter,
            shelf.values,
            self.components,
            self.copies,
            self.columns,
            self.soft_at,
            self.outputs,
            before,
            evidence,
            previous,
            soft,
            message,
            marginals,
            sums,
        )
        parts = [[flat[cut].reshape(n, w) for cut, n, w in of] for flat, of in zip((message, marginals, sums), zip(*self._parts))]
        found, answers, totals = parts or ([], [], [])
        return Answers(tuple(found), answers, totals, np.array([increment]), marginals)
