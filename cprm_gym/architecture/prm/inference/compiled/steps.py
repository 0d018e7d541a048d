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

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar
from weakref import ref

import numpy as np

from cprm_gym.errors import ModelError

from ...grounding.slices import PREVIOUS, SAME, STATIC, GroundCPD, GroundSlice, GroundVariable
from ..join_tree import connected
from .operations import MessageFactor, PlanSpec, SoftFactor, TableFactor
from .plans import Plan, compile_plan

HIDDEN, HELD, WEIGHTED, ABSORBED, BARREN = range(5)
PRESENT, PAST = SAME, PREVIOUS
"""Second part of a node's name: the slice it belongs to; or `STATIC`."""

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Kind(NamedTuple):
    """What two variables of like objects share, and what tells the objects apart."""

    class_name: str
    object_name: str
    attribute: str


class NeedsVariable(Exception):
    """The next slice needs a variable that was summed out of the belief, or that has to be kept as static."""

    def __init__(self, kind: Kind, name: str, static: bool) -> None:
        super().__init__(name)
        self.kind, self.name, self.static = kind, name, static


class Recent(OrderedDict[Key, Value], Generic[Key, Value]):
    """A dictionary that forgets what was not used for longest."""

    def __init__(self, limit: int) -> None:
        super().__init__()
        self.limit = limit

    def fetch(self, key: Key, make: Callable[[], Value]) -> Value:
        """The value of `key`, made if it is not there."""
        if key in self:
            self.move_to_end(key)
            return self[key]
        value = self[key] = make()
        if len(self) > self.limit:
            self.popitem(last=False)
        return value


def kind_of(variable: GroundVariable) -> Kind:
    """Class, object and attribute of a variable; taken from a dotted name where the variable does not say."""
    if variable.object_name or variable.attribute:
        return Kind(variable.class_name, variable.object_name, variable.attribute)
    owner, _, attribute = variable.name.rpartition(".")
    return Kind(variable.class_name, owner, attribute)


class TableStore:
    """Numbers for tables: equal contents, equal numbers.

    Attributes
    ----------
    infos : Recent
        Slices indexed with these numbers, for all filters of an engine.
    """

    def __init__(self) -> None:
        self.infos: Recent[tuple[GroundSlice, frozenset[str]], SliceInfo] = Recent(256)
        self.tables: dict[int, np.ndarray] = {}
        self._numbers: dict[bytes, int] = {}
        self._seen: dict[int, tuple[Any, int]] = {}

    def number(self, table: np.ndarray) -> int:
        """The number of a table; the same array is hashed once."""
        known = self._seen.get(id(table))
        if known is not None and known[0]() is table:
            return known[1]
        array = np.ascontiguousarray(table, dtype=np.float64)
        digest = hashlib.blake2b(array.tobytes() + repr(array.shape).encode(), digest_size=16).digest()
        number = self._numbers.setdefault(digest, len(self._numbers))
        self.tables.setdefault(number, array)
        self._seen = {k: v for k, v in self._seen.items() if v[0]() is not None} if len(self._seen) > 4096 else self._seen
        self._seen[id(table)] = ref(table), number
        return number


class SliceInfo:
    """A ground slice, indexed for the compiler.

    Attributes
    ----------
    slice : GroundSlice
    names : tuple of str
        Order of the rows of the evidence: variables of the slice, then static ones defined earlier.
    row : dict of str to int
    cards : (V,) int array
    kinds : tuple of Kind
    """

    def __init__(self, ground: GroundSlice, static: dict[str, GroundVariable], store: TableStore) -> None:
        self.slice = ground
        self.variables = dict(ground.variables)
        self.variables.update((n, v) for n, v in static.items() if n not in ground.variables)
        self.names = tuple(self.variables)
        self.row = {name: i for i, name in enumerate(self.names)}
        self.cards = np.array([self.variables[n].card for n in self.names], np.int64)
        self.kinds = tuple(kind_of(self.variables[n]) for n in self.names)
        given = set(ground.given)
        self.given = np.array([n in given for n in self.names], bool)
        self.cpds: tuple[tuple[GroundCPD, int], ...] = tuple((c, store.number(c.table)) for c in ground.cpds if c.child not in given)
        count = len(self.names)
        self.parents = np.zeros((count, count), bool)
        self.has_past = np.zeros(count, bool)
        for cpd, _ in self.cpds:
            child = self.row[cpd.child]
            for parent, lag in cpd.parents:
                if lag == PREVIOUS:
                    self.has_past[child] = True
                elif parent in self.row:
                    self.parents[child, self.row[parent]] = True
        self.leaf = ~self.parents.any(axis=0)
        self.static = np.array([n in static for n in self.names], bool)
        self.static_variables = {n: self.variables[n] for n in self.names if n in static}
        self.owners = frozenset(v.object_name for v in ground.variables.values())
        self._statuses: Recent[tuple[Any, ...], np.ndarray] = Recent(1024)
        self._matters: Recent[frozenset[tuple[str, str]], np.ndarray] = Recent(16)

    def status(self, evidence: np.ndarray, soft: Iterable[str], temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Status of each variable under a pattern of evidence.

        Parameters
        ----------
        evidence : (V, W) int array
            -1 where not observed.
        soft : names
            Variables with a likelihood vector.
        temporal : frozenset of (class, attribute)
            Kinds of variables that some slice has as parents in the previous slice.
        """
        count = (evidence >= 0).sum(axis=1)
        pattern = (count > 0).astype(np.int8) + (count == evidence.shape[1])
        matters = self._matters.fetch(temporal, lambda: ~self._readings(temporal) | (self.parents.sum(axis=1) > 1))
        key = pattern[matters].tobytes(), tuple(soft), temporal
        return self._statuses.fetch(key, lambda: self._status(count, evidence.shape[1], soft, temporal))

    def _kept(self, temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Variables that stay in the belief."""
        return np.array([(k.class_name, k.attribute) in temporal for k in self.kinds], bool) | self.static

    def _readings(self, temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Variables that are there to be observed. Whether they are matters only if they have several parents to couple."""
        return np.asarray(self.leaf & ~self._kept(temporal) & ~self.has_past & ~self.given)

    def _status(self, count: np.ndarray, batch: int, soft: Iterable[str], temporal: frozenset[tuple[str, str]]) -> np.ndarray:
        """Status from the number of agents that observe each variable."""
        kept, reading = self._kept(temporal), self._readings(temporal)
        status = np.where(count == batch, HELD, np.where(count > 0, WEIGHTED, HIDDEN)).astype(np.int8)
        status[self.static & (count > 0)] = WEIGHTED
        status[reading] = ABSORBED
        for name in soft:
            if not self.given[self.row[name]]:
                status[self.row[name]] = WEIGHTED
        status[self.given] = HELD
        self._drop_barren(status, count, kept)
        return status

    def _drop_barren(self, status: np.ndarray, count: np.ndarray, kept: np.ndarray) -> None:
        """Mark the unobserved, childless variables that would couple two or more hidden parents."""
        while True:
            hidden = (status == HIDDEN) | (status == WEIGHTED)
            alive = status != BARREN
            childless = ~(self.parents & alive[:, None]).any(axis=0)
            free = ((status == HIDDEN) | (status == ABSORBED)) & (count == 0) & childless & ~kept & ~self.has_past
            free &= (self.parents & hidden[None, :]).sum(axis=1) > 1
            if not free.any():
                return
            status[free] = BARREN


Node = tuple[str, int]


class PieceFactor(NamedTuple):
    """Variables of a factor in the order of its axes, first column in the array, number of entries."""

    scope: tuple[Node, ...]
    column: int
    size: int


class Piece(NamedTuple):
    """A connected part of the belief: which array, which object in it, which factors."""

    group: int
    instance: int
    factors: tuple[PieceFactor, ...]

    @property
    def columns(self) -> slice:
        """The columns of the array that belong to the piece."""
        last = self.factors[-1]
        return slice(self.factors[0].column, last.column + last.size)


@dataclass(frozen=True, eq=False)
class Layout:
    """What stands where in a belief.

    Attributes
    ----------
    pieces : tuple of Piece
    widths : tuple of int
        Columns of each array.
    counts : tuple of int
        Objects in each array.
    held : dict of str to int
        Variables of the slice that were observed for every agent, and their row in its evidence.
    info : SliceInfo or None
        The slice; None before the first.
    """

    pieces: tuple[Piece, ...]
    widths: tuple[int, ...]
    counts: tuple[int, ...]
    held: dict[str, int]
    info: SliceInfo | None

    def variables(self) -> dict[Node, int]:
        """Piece of each variable in the belief."""
        return {node: i for i, piece in enumerate(self.pieces) for factor in piece.factors for node in factor.scope}


EMPTY = Layout((), (), (), {}, None)


class Move(NamedTuple):
    """Copy columns of some objects' messages into the message of a group."""

    source: int
    instances: np.ndarray
    columns: slice
    to_instances: np.ndarray
    to_columns: slice


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


Choose = Callable[[Sequence[Node], Sequence[tuple[Node, ...]]], tuple[tuple[Node, ...], ...]]
"""From the present variables of a component and the scopes of its factors to the clusters to project on; () keeps all."""


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
        self.layouts: Recent[tuple[Any, ...], Layout] = Recent(limit)
        self.compiled = 0

    def plan(self, spec: PlanSpec) -> Plan:
        """The plan of a signature."""

        def make() -> Plan:
            self.compiled += 1
            return compile_plan(spec, self.store.tables)

        return self.plans.fetch(spec, make)

    def slice_step(
        self, layout: Layout, info: SliceInfo, status: np.ndarray, choose: Choose | None = None, mark: Hashable = None
    ) -> SliceStep:
        """How to go from a belief with `layout` to slice `info` under a pattern of evidence.

        Parameters
        ----------
        layout : Layout
        info : SliceInfo
        status : (V,) int array
        choose : callable, optional
            Chooses the clusters of a component that is to be projected.
        mark : hashable
            Tells choices of clusters apart.

        Raises
        ------
        NeedsVariable
            A variable of the previous slice is needed that is not in the belief.
        """
        key = (layout, info, status.tobytes(), mark)
        return self.slice_steps.fetch(key, lambda: _Assembler(self, layout, info, status, choose).build())

    def layout(
        self, pieces: tuple[Piece, ...], widths: tuple[int, ...], counts: tuple[int, ...], held: dict[str, int], info: SliceInfo
    ) -> Layout:
        """One object for equal layouts."""
        key = (pieces, widths, counts, tuple(held.items()), info)
        return self.layouts.fetch(key, lambda: Layout(pieces, widths, counts, held, info))


class _Assembler:
    """Builds one slice_step."""

    def __init__(self, compiler: Compiler, layout: Layout, info: SliceInfo, status: np.ndarray, choose: Choose | None) -> None:
        self.compiler, self.layout, self.info, self.status, self.choose = compiler, layout, info, status, choose
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
        batches: dict[tuple[Any, ...], list[_Component]] = {}
        for indices in connected([d.scope for d in drafts]):
            inside = [drafts[i] for i in indices]
            if all(d.kind == "piece" for d in inside) and not any(v[1] == STATIC for d in inside for v in d.scope):
                continue
            component = _Component(self, inside)
            batches.setdefault((component.spec, component.source_signature), []).append(component)
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
        layout = self.compiler.layout(tuple(pieces), widths, counts, held, self.info)
        return SliceStep(tuple(groups), layout, self.status.copy(), soft_columns, at, where)

    def group(self, components: Sequence[_Component], soft_columns: dict[str, slice]) -> Group:
        """Like components as one batch."""
        plan = self.compiler.plan(components[0].spec)
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
        values = np.array([c.columns for c in components], np.int64).reshape(len(components), -1, 3)
        soft_at = np.array(
            [
                [(soft_columns[name].start, plan.soft_places[q][1], plan.soft_places[q][0]) for q, name in enumerate(c.soft)]
                for c in components
            ],
            np.int64,
        ).reshape(len(components), -1, 3)
        readings = tuple(c.readings for c in components)
        return Group(plan, tuple(c.nodes for c in components), tuple(moves), direct, values, soft_at, readings)


def _first(component: _Component) -> Node:
    return min(component.nodes, default=("", PRESENT))


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

        pieces = [d for d in drafts if d.kind == "piece"]
        pieces.sort(key=lambda d: tuple(number[v] for v in d.scope))
        self.pieces = [d.number for d in pieces]
        factors: list[MessageFactor | TableFactor | SoftFactor] = []
        at = 0
        for d in pieces:
            piece = assembler.layout.pieces[d.number]
            start = piece.columns.start
            for f in piece.factors:
                factors.append(MessageFactor(tuple(number[assembler.shifted(v)] for v in f.scope), at + f.column - start))
            at += piece.columns.stop - start
        self.source_signature = tuple((p.columns.stop - p.columns.start) for p in (assembler.layout.pieces[i] for i in self.pieces))

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
        present = [v for v in self.nodes if v[1] != PAST]
        clusters: tuple[tuple[Node, ...], ...] = ()
        if assembler.choose is not None and len(present) > 1:
            clusters = assembler.choose(self.nodes, [d.scope for d in drafts])
        self.spec = PlanSpec(
            tuple(assembler.cards[v] for v in self.nodes),
            tuple(v[1] == PAST for v in self.nodes),
            tuple(factors),
            len(self.columns),
            tuple(tuple(number[v] for v in c) for c in clusters),
        )

    def label(self, node: Node) -> tuple[int, str, int]:
        """A name that like components share."""
        kind = self.kinds[node[0]]
        return self.rank[kind[:2]], kind.attribute, node[1]

    def child_label(self, name: str) -> tuple[int, str, str]:
        """A name for the child of a CPD, which may be observed and so not be a node."""
        kind = self.kinds[name]
        return self.rank.get(kind[:2], -1), kind.class_name, kind.attribute
