"""From one slice to the next: which components there are, which of them are alike, and what moves where.

A belief is a set of *pieces*. A piece is a connected product of factors over hidden variables of the latest slice, for every
agent; pieces of objects that are alike lie in one array. `Layout` says which variables stand where. `Compiler.slice_step`
takes a layout, the next slice and the part of the evidence pattern that changes which hidden variables are coupled, and says
how to run the step: the groups of like components, their plan, and the next layout.

The evidence pattern enters through a status for each variable:

* `HELD`: observed for every agent: no node of the tree, its value selects a slice of each table (context).
* `HIDDEN`: a node.
* `WEIGHTED`: a node with a likelihood vector, observed for some agents only or softly.
* `ABSORBED`: a childless reading: its table, at the reading, is a likelihood of its parents; a missing reading is a row of ones.
* `BARREN`: nobody observed it and it has no children that anybody observed: left out. Only where leaving it out keeps
  variables apart that it would couple.

So whether a reading is missing never changes the plan, except where it decides what is coupled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cprm_gym.errors import ModelError

from ...grounding.slices import PREVIOUS, SAME, STATIC
from ..join_tree import connected
from .belief import Layout, Layouts, Move, Node, Piece, PieceFactor
from .cache import Recent, TableStore
from .operations import MessageFactor, PlanSpec, SoftFactor, TableFactor
from .plans import Plan, compile_plan
from .slice_info import ABSORBED, BARREN, HELD, PAST, PRESENT, WEIGHTED, Kind, NeedsVariable, SliceInfo


@dataclass(frozen=True, eq=False)
class Group:
    """Like components of one step.

    Attributes
    ----------
    plan : Plan
    members : tuple of tuple of Node
        Node names of each component, in the plan's numbering.
    moves : tuple of Move
        How the incoming message is put together; ignored if `direct` is not -1.
    direct : int
        Array of the old belief that is the incoming message as it stands.
    columns, soft_at : int arrays
        As `kernels.run_plan` takes them.
    readings : tuple of frozenset of str
        Observed variables of each component.
    """

    plan: Plan
    members: tuple[tuple[Node, ...], ...]
    moves: tuple[Move, ...]
    direct: int
    columns: np.ndarray
    soft_at: np.ndarray
    readings: tuple[frozenset[str], ...]


@dataclass(frozen=True, eq=False)
class SliceStep:
    """How to run one step.

    Attributes
    ----------
    groups : tuple of Group
    layout : Layout
        Of the new belief.
    status : (V,) int array
    soft_columns : dict of str to slice
        Where the likelihood vector of a `WEIGHTED` variable stands.
    soft_width : int
    where : dict of str to (group, instance, column, card)
        The marginal of each hidden variable.
    """

    groups: tuple[Group, ...]
    layout: Layout
    status: np.ndarray
    soft_columns: dict[str, slice]
    soft_width: int
    where: dict[str, tuple[int, int, int, int]]

    def assemble(self, group: Group, messages: Sequence[np.ndarray], batch: int) -> np.ndarray:
        """The incoming message of a group, (objects * agents, columns)."""
        if group.direct >= 0:
            return messages[group.direct]
        size = max((m.to_columns.stop for m in group.moves), default=0)
        out = np.empty((len(group.members), batch, size))
        for move in group.moves:
            source = messages[move.source]
            block = source.reshape(len(source) // batch, batch, source.shape[1])[move.instances, :, move.columns]
            out[move.to_instances, :, move.to_columns] = block
        return out.reshape(len(group.members) * batch, size)


@dataclass
class _Draft:
    """A factor before its component is known."""

    scope: tuple[Node, ...]
    kind: str
    number: int
    axes: tuple[Any, ...] = ()
    missing: int = -1
    child: str = ""


class Compiler:
    """Makes and remembers plans and slice_steps.

    Parameters
    ----------
    store : TableStore
    limit : int
        How many plans, slice_steps and layouts are remembered each.
    """

    def __init__(self, store: TableStore, limit: int = 512) -> None:
        self.store = store
        self.plans: Recent[PlanSpec, Plan] = Recent(limit)
        self.slice_steps: Recent[tuple[Any, ...], SliceStep] = Recent(limit)
        self.layouts = Layouts(limit)
        self.components: Recent[tuple[Any, ...], Recent[tuple[Any, ...], _Component]] = Recent(16)
        self.compiled = 0

    def plan(self, spec: PlanSpec) -> Plan:
        """The plan of a signature."""

        def make() -> Plan:
            self.compiled += 1
            return compile_plan(spec, self.store.tables)

        return self.plans.fetch(spec, make)

    def slice_step(self, layout: Layout, info: SliceInfo, status: np.ndarray) -> SliceStep:
        """How to go from a belief with `layout` to slice `info` under a pattern of evidence.

        Parameters
        ----------
        layout : Layout
        info : SliceInfo
        status : (V,) int array

        Raises
        ------
        NeedsVariable
            A variable of the previous slice is needed that is not in the belief.
        """
        key = (layout, info, status.tobytes())
        return self.slice_steps.fetch(key, lambda: _Assembler(self, layout, info, status).build())


class _Assembler:
    """Builds one slice_step."""

    def __init__(self, compiler: Compiler, layout: Layout, info: SliceInfo, status: np.ndarray) -> None:
        self.compiler, self.layout, self.info, self.status = compiler, layout, info, status
        self.old = layout.variables()
        self.kinds: dict[str, Kind] = {}
        self.cards: dict[Node, int] = {}
        before = layout.info
        if before is not None:
            self.kinds.update(zip(before.names, before.kinds))
        self.kinds.update(zip(info.names, info.kinds))
        for node in self.old:
            assert before is not None
            self.cards[self.shifted(node)] = int(before.cards[before.row[node[0]]])
        for name, row in info.row.items():
            self.cards[name, STATIC if info.static[row] else PRESENT] = int(info.cards[row])

    def shifted(self, node: Node) -> Node:
        """A variable of the belief as the next slice sees it: a static one stays, unless its object left or began anew."""
        name, time = node
        return node if time == STATIC and name in self.info.row and name not in self.info.slice.variables else (name, PAST)

    def resolve(self, parent: str, lag: int, child: str) -> Node | tuple[str, str, int]:
        """The node of a parent, or where its observed value is found: ("value", source, row)."""
        if lag == SAME or (lag != PREVIOUS and parent in self.info.slice.variables):
            row = self.info.row[parent]
            if self.status[row] == HELD:
                return "value", "now", row
            return parent, STATIC if self.info.static[row] else PRESENT
        if lag == PREVIOUS:
            if (parent, PRESENT) in self.old:
                return parent, PAST
            if (parent, STATIC) in self.old:
                return self.shifted((parent, STATIC))
            if parent in self.layout.held:
                return "value", "before", self.layout.held[parent]
            before = self.layout.info
            if before is None or parent not in before.row:
                raise ModelError(f"CPD of {child!r} has parent {parent!r} in the previous slice, where there is no such variable")
            raise NeedsVariable(before.kinds[before.row[parent]], parent, static=False)
        if (parent, STATIC) in self.old and parent in self.info.row:
            return parent, STATIC
        before = self.layout.info
        if before is None or parent not in before.row:
            raise ModelError(f"CPD of {child!r} has the static parent {parent!r}, which was not defined in the first slice")
        raise NeedsVariable(before.kinds[before.row[parent]], parent, static=True)

    def drafts(self) -> list[_Draft]:
        """All factors of the step: message, CPDs at the evidence, likelihoods."""
        out = [
            _Draft(tuple(self.shifted(v) for f in piece.factors for v in f.scope), "piece", i) for i, piece in enumerate(self.layout.pieces)
        ]
        for cpd, number in self.info.cpds:
            row = self.info.row[cpd.child]
            status = self.status[row]
            if status == BARREN:
                continue
            axes: list[Any] = [self.resolve(parent, lag, cpd.child) for parent, lag in cpd.parents]
            missing = -1
            if status in (HELD, ABSORBED):
                axes.append(("value", "now", row))
                missing = len(axes) - 1 if status == ABSORBED else -1
            else:
                axes.append((cpd.child, STATIC if self.info.static[row] else PRESENT))
            scope = tuple(dict.fromkeys(a for a in axes if a[0] != "value" or len(a) == 2))
            out.append(_Draft(scope, "table", number, tuple(axes), missing, cpd.child))
        for row in map(int, np.flatnonzero(self.status == WEIGHTED)):
            node = self.info.names[row], STATIC if self.info.static[row] else PRESENT
            out.append(_Draft((node,), "soft", row, child=node[0]))
        return out

    def build(self) -> SliceStep:
        """The slice_step."""
        drafts = self.drafts()
        batches: dict[tuple[Any, ...], list[_Placed]] = {}
        before = self.layout.info
        known = self.compiler.components.fetch((self.info.names, None if before is None else before.names), lambda: Recent(4096))
        for indices in connected([d.scope for d in drafts]):
            inside = [drafts[i] for i in indices]
            if all(d.kind == "piece" for d in inside) and not any(v[1] == STATIC for d in inside for v in d.scope):
                continue
            key = tuple(map(self.signature, inside))
            component = known.fetch(key, partial(_Component, self, inside))
            placed = _Placed(component, tuple(inside[i].number for i in component.piece_order))
            batches.setdefault((component.spec, component.source_signature), []).append(placed)
        soft_columns, at = {}, 0
        for row in np.flatnonzero(self.status == WEIGHTED):
            soft_columns[self.info.names[row]] = slice(at, at + int(self.info.cards[row]))
            at += int(self.info.cards[row])
        groups, pieces, where = [], [], {}
        # the same order whatever order the belief had, so that beliefs of agents who came other ways have one layout
        for g, components in enumerate(sorted((sorted(b, key=_first) for b in batches.values()), key=lambda b: _first(b[0]))):
            group = self.group(components, soft_columns)
            groups.append(group)
            for b, nodes in enumerate(group.members):
                for factors in group.plan.pieces:
                    named = tuple(PieceFactor(tuple(nodes[v] for v in f.scope), f.column, f.size) for f in factors)
                    pieces.append(Piece(g, b, named))
                for v, (column, card) in group.plan.marginals.items():
                    where[nodes[v][0]] = g, b, column, card
        widths = tuple(group.plan.message_size for group in groups)
        counts = tuple(len(group.members) for group in groups)
        held = {self.info.names[row]: int(row) for row in np.flatnonzero(self.status == HELD)}
        layout = self.compiler.layouts.one(tuple(pieces), widths, counts, held, self.info)
        return SliceStep(tuple(groups), layout, self.status.copy(), soft_columns, at, where)

    def signature(self, draft: _Draft) -> tuple[Any, ...]:
        """What a component is made of, wherever its pieces stand in the belief."""
        if draft.kind != "piece":
            return draft.kind, draft.scope, draft.number, draft.axes, draft.missing, draft.child
        factors = self.layout.pieces[draft.number].factors
        return draft.scope, tuple(f.size for f in factors), tuple(len(f.scope) for f in factors)

    def group(self, components: Sequence[_Placed], soft_columns: dict[str, slice]) -> Group:
        """Like components as one batch."""
        plan = self.compiler.plan(components[0].part.spec)
        moves, at = [], 0
        for k in range(len(components[0].pieces)):
            columns = [self.layout.pieces[c.pieces[k]].columns for c in components]
            size = columns[0].stop - columns[0].start
            by_source: dict[tuple[int, int], list[tuple[int, int]]] = {}
            for b, c in enumerate(components):
                piece = self.layout.pieces[c.pieces[k]]
                by_source.setdefault((piece.group, columns[b].start), []).append((b, piece.instance))
            for (source, start), pairs in by_source.items():
                to, instances = (np.array(x, np.int64) for x in zip(*pairs))
                moves.append(Move(source, instances, slice(start, start + size), to, slice(at, at + size)))
            at += size
        direct = -1
        if len(moves) == 1:
            move = moves[0]
            whole = move.columns == slice(0, self.layout.widths[move.source]) and len(components) == self.layout.counts[move.source]
            if whole and np.array_equal(move.instances, np.arange(len(components))):
                direct = move.source
        values = np.array([c.part.columns for c in components], np.int64).reshape(len(components), -1, 3)
        soft_at = np.array(
            [
                [(soft_columns[name].start, plan.soft_places[q][1], plan.soft_places[q][0]) for q, name in enumerate(c.part.soft)]
                for c in components
            ],
            np.int64,
        ).reshape(len(components), -1, 3)
        readings = tuple(c.part.readings for c in components)
        return Group(plan, tuple(c.part.nodes for c in components), tuple(moves), direct, values, soft_at, readings)


class _Placed(NamedTuple):
    """A component, and which pieces of the belief go into it, in its order."""

    part: _Component
    pieces: tuple[int, ...]


def _first(component: _Placed) -> Node:
    return component.part.first


class _Component:
    """A connected component of a step, its variables numbered so that like components get the same numbers."""

    def __init__(self, assembler: _Assembler, drafts: Sequence[_Draft]) -> None:
        self.kinds = assembler.kinds
        info = assembler.info
        nodes = {v for d in drafts for v in d.scope}
        owners = sorted({self.kinds[name][:2] for name, _ in nodes})
        self.rank = {owner: i for i, owner in enumerate(owners)}
        self.nodes: tuple[Node, ...] = tuple(sorted(nodes, key=self.label))
        number = {v: i for i, v in enumerate(self.nodes)}

        self.first = min(self.nodes, default=("", PRESENT))
        self.piece_order = [i for i, d in enumerate(drafts) if d.kind == "piece"]
        self.piece_order.sort(key=lambda i: tuple(number[v] for v in drafts[i].scope))
        pieces = [drafts[i] for i in self.piece_order]
        factors: list[MessageFactor | TableFactor | SoftFactor] = []
        at = 0
        for d in pieces:
            piece = assembler.layout.pieces[d.number]
            start = piece.columns.start
            for f in piece.factors:
                factors.append(MessageFactor(tuple(number[assembler.shifted(v)] for v in f.scope), at + f.column - start))
            at += piece.columns.stop - start
        self.source_signature = tuple((p.columns.stop - p.columns.start) for p in (assembler.layout.pieces[d.number] for d in pieces))

        self.columns: list[tuple[int, int, int]] = []
        places: dict[tuple[Any, ...], int] = {}
        tables = [d for d in drafts if d.kind == "table"]
        tables.sort(key=lambda d: (self.child_label(d.child), tuple(number[v] for v in d.scope), d.number))
        readings = set()
        for d in tables:
            axes = []
            for k, axis in enumerate(d.axes):
                if len(axis) == 2:
                    axes.append(number[axis])
                    continue
                missing = assembler.compiler.store.tables[d.number].shape[k] if k == d.missing else 0
                place = places.setdefault((axis, missing), len(places))
                if place == len(self.columns):
                    self.columns.append((axis[2], int(axis[1] == "before"), missing))
                if axis[1] == "now":
                    readings.add(info.names[axis[2]])
                axes.append(-1 - place)
            factors.append(TableFactor(d.number, tuple(axes), d.missing))
        soft = sorted((d for d in drafts if d.kind == "soft"), key=lambda d: number[d.scope[0]])
        self.soft = [d.child for d in soft]
        factors += [SoftFactor(number[d.scope[0]], q) for q, d in enumerate(soft)]
        self.readings = frozenset(readings | set(self.soft))
        self.spec = PlanSpec(
            tuple(assembler.cards[v] for v in self.nodes),
            tuple(v[1] == PAST for v in self.nodes),
            tuple(factors),
            len(self.columns),
            (),
        )

    def label(self, node: Node) -> tuple[int, str, int]:
        """A name that like components share."""
        kind = self.kinds[node[0]]
        return self.rank[kind[:2]], kind.attribute, node[1]

    def child_label(self, name: str) -> tuple[int, str, str]:
        """A name for the child of a CPD, which may be observed and so not be a node."""
        kind = self.kinds[name]
        return self.rank.get(kind[:2], -1), kind.class_name, kind.attribute
