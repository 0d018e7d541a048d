"""Which cells of several variables go together, because their values hang on the same observations.

`near = "1 if distance < 2 else 0"` and `distance` are two variables of one observation: of their four combinations of cells only two can
be. Variables that share something they read form a group; each group has a table of the combinations that `regions.combinations` finds
possible or leaves undecided, together with the tokens and the objects that its expressions read. An undecided combination is explored
but marked, so that no verdict rests on it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ....errors import NetError
from ...expressions import Expression, Node
from ...expressions.intervals import bound
from ...petri import Belief, CompiledNet, Continuous, Input, Math, ObjectPlace, Place
from ...petri.net.net import resolve_name
from ..net_arrays import selected_places
from .regions import LARGEST, MOST_COMBINATIONS, Combination, Question, combinations, moderate
from .variables import Variable

MOST_SITUATIONS = 64
"""Combinations of tokens and objects of one group that are looked at one by one."""


@dataclass(frozen=True, eq=False)
class Group:
    """Variables whose values hang together.

    Attributes
    ----------
    columns : tuple of int
        Of a node: tokens of places, then cells of variables.
    rows : (K, len(columns)) int16
        Combinations that can be, or may be for all that is known.
    sure : (K,) bool
        Those that can be.
    points : tuple of mapping from atom to value
        For each sure row what is observed; empty for the others.
    listed : bool
        Whether what is in no row cannot be; False where there are too many combinations: it is undecided then.
    excludes_nothing : bool
        Whether every combination can be.
    """

    columns: tuple[int, ...]
    rows: np.ndarray
    sure: np.ndarray
    points: tuple[Mapping[str, float], ...]
    listed: bool
    excludes_nothing: bool


@dataclass(frozen=True, eq=False)
class Joint:
    """All groups of a net.

    Attributes
    ----------
    groups, whole : tuple of Group
        Those that exclude something or leave it undecided, and those in which every combination can be.
    of_variable : (X,) int64
        The group of each variable, -1 if it moves freely.
    lossy : (X,) bool
        Variables that hang on observations and change within a cycle: what was known of the observation is forgotten then.
    shown_by : mapping from atom to places
        The places that show what is observed.
    """

    groups: tuple[Group, ...]
    whole: tuple[Group, ...]
    of_variable: np.ndarray
    lossy: np.ndarray
    shown_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def joint_cells(
    c: CompiledNet,
    variables: Sequence[Variable],
    places: Sequence[str],
    ranges: Mapping[str, tuple[float, float]],
    bounds: Mapping[str, tuple[float, float]],
    volatile: set[int],
    enough: Callable[[], bool] = lambda: False,
) -> Joint:
    """The groups of a net's variables.

    Parameters
    ----------
    c : CompiledNet
    variables : sequence of Variable
    places : sequence of str
        Columns of a node that hold tokens; the cells of the variables follow.
    ranges, bounds : mapping from place to (least, largest)
        What follows for every place, and what was given.
    volatile : set of int
        Variables that may change within a cycle.
    enough : callable
        Whether the time granted is spent: what is left is undecided.
    """
    return _Builder(c, variables, places, ranges, bounds, volatile, enough).build()


class _Builder:
    """What the expressions of one net read, and the groups that follow."""

    def __init__(
        self,
        c: CompiledNet,
        variables: Sequence[Variable],
        places: Sequence[str],
        ranges: Mapping[str, tuple[float, float]],
        bounds: Mapping[str, tuple[float, float]],
        volatile: set[int],
        enough: Callable[[], bool],
    ) -> None:
        self.c, self.variables, self.ranges, self.bounds, self.volatile, self.enough = c, variables, ranges, bounds, volatile, enough
        self.column = {name: k for k, name in enumerate(places)}
        self.scope = {p.name: p for p in c.net.places}
        self.cell_column = {v.name: len(places) + x for x, v in enumerate(variables)}
        self.selected = {name: x for x, v in enumerate(variables) if v.is_object for name in v.places}
        self.span: dict[str, tuple[float, float]] = {}  # of every atom
        self.shown_by: dict[str, list[str]] = {}
        self.leaf: dict[str, Node] = {}  # of every place: its atom, its number, or its step
        self.step: dict[str, Node] = {}  # of every math place, over leaves
        self.attributes: dict[str, str] = {}  # atom of an attribute -> object place
        self.first_values: dict[str, set[float]] = {}
        self.reads: dict[str, frozenset[str]] = {}
        """Place -> atoms, directly or through other places."""
        for p in c.net.places:
            self.leaf[p.name] = Node("name", name=f"math {p.name}") if isinstance(p, Math) else self._leaf(p)
        for p in c.net.places:
            if not isinstance(p, Math):
                self.reads[p.name] = frozenset({self.leaf[p.name].name} - {""})
        for m in c.math:
            self.step[m.name] = self._over_leaves(m)
            self.reads[m.name] = self._read(self.step[m.name])
        kept = {p.name for p, s in zip(c.net.places, selected_places(c)) if isinstance(p, (Place, ObjectPlace)) and not s}
        self.tokens = {f"tokens {name}" for name in kept}
        """Atoms that a node shows: what hangs on them alone is no secret of the environment."""

    def _read(self, tree: Node) -> frozenset[str]:
        found: set[str] = set()
        for node in tree.walk():
            kind, _, place = node.name.partition(" ")
            found |= self.reads[place] if kind == "math" else {node.name} - {""}
            if node.name in self.attributes:
                found.add(f"tokens {self.attributes[node.name]}")
        return frozenset(found)

    def _observed(self, name: str) -> list[str]:
        """The atoms of a place that the environment sets."""
        return sorted(self.reads[name] - self.tokens)

    def _leaf(self, p: object) -> Node:
        """The atom that a place shows."""
        if isinstance(p, Continuous) and p.name not in self.c.net.ports.parameters:
            return Node("number", value=float(p.value))
        if isinstance(p, (Place, ObjectPlace)):
            atom = f"tokens {p.name}"
            self.span[atom] = (0.0, 1.0) if isinstance(p, ObjectPlace) else self.ranges[p.name]
            return Node("name", name=atom)
        assert isinstance(p, (Continuous, Input, Belief))
        if isinstance(p, Input):
            atom = f"input {p.observes}"
        elif isinstance(p, Belief):
            atom = f"belief {p.variable} {p.view} {p.state}"
        else:
            atom = f"value {p.name}"
        low, high = self.ranges[p.name]
        before = self.span.get(atom, (-LARGEST, LARGEST))
        self.span[atom] = max(before[0], low), min(before[1], high)
        if self.span[atom][0] > self.span[atom][1]:
            raise NetError(f"bounds of place {p.name!r}: nothing is left of what {atom.split(' ', 1)[1]!r} may be")
        self.shown_by.setdefault(atom, []).append(p.name)
        self.first_values.setdefault(atom, set()).add(float(p.value))
        return Node("name", name=atom)

    def _over_leaves(self, m: Math) -> Node:
        """The expression of a math place over atoms and other math places."""

        def replaced(node: Node) -> Node:
            if node.op == "name":
                place, attribute = resolve_name(node.name, self.scope)
                if not attribute:
                    return self.leaf[place]
                atom = f"attribute {place} {attribute}"
                self.attributes[atom] = place
                self.span[atom] = (-LARGEST, LARGEST)
                return Node("name", name=atom)
            return Node(node.op, tuple(replaced(arg) for arg in node.args), node.value, node.name) if node.args else node

        return replaced(Expression(m.expression).tree)

    def _steps(self, places: Iterable[str], missing: set[str]) -> list[tuple[str, Node]]:
        """What computes these places, in order, when these attributes are missing."""
        wanted = set(places)
        for m in reversed(self.c.math):
            if m.name in wanted:
                wanted |= {n.name.partition(" ")[2] for n in self.step[m.name].walk() if n.name.startswith("math ")}
        found = []
        for m in self.c.math:
            if m.name in wanted:
                absent = any(node.name in missing for node in self.step[m.name].walk())
                found.append((f"math {m.name}", Node("number", value=float(m.default)) if absent else self.step[m.name]))
        return found

    # -- groups -----------------------------------------------------------------------------------------------------------------

    def build(self) -> Joint:
        count = len(self.variables)
        of_variable, lossy = np.full(count, -1, np.int64), np.zeros(count, bool)
        groups: list[Group] = []
        whole: list[Group] = []
        for x, v in enumerate(self.variables):
            known = {f"tokens {name}" for name in self.selected}
            lossy[x] = x in self.volatile and bool(set(self._observed(v.name)) - known)
        for members, maths in self._components():
            found = self._group(members, maths)
            if found.excludes_nothing:
                whole.append(found)
            else:
                of_variable[members] = len(groups)
                groups.append(found)
        return Joint(tuple(groups), tuple(whole), of_variable, lossy, {atom: tuple(names) for atom, names in self.shown_by.items()})

    def _components(self) -> list[tuple[list[int], list[str]]]:
        """Variables that share an atom, and the math places whose values must be defined for them."""
        numbers = [node.value for m in self.c.math for node in Expression(m.expression).tree.walk() if node.op == "number"] + [
            edge for v in self.variables for cell in v.cells for edge in cell if abs(edge) < LARGEST
        ]
        far = moderate(numbers)
        near = {
            atom: span if span[0] >= far or span[1] <= -far else (max(span[0], -far), min(span[1], far)) for atom, span in self.span.items()
        }
        owner: dict[str, str] = {}

        def root(atom: str) -> str:
            while owner.get(atom, atom) != atom:
                atom = owner[atom]
            return atom

        demanding = []
        for m in self.c.math:
            atoms = self._observed(m.name)
            span = bound(self.step[m.name], near)
            near[f"math {m.name}"] = (-far, far) if span.empty else (span.low, span.high)
            partial = not span.total or span.empty or m.name in self.bounds
            wanted = any(m.name in v.places for v in self.variables)
            if partial or wanted:
                for a in atoms[1:]:
                    owner[root(a)] = root(atoms[0])
            if partial:
                demanding.append(m.name)
        found: dict[str, tuple[list[int], list[str]]] = {}
        for x, v in enumerate(self.variables):
            atoms = self._observed(v.name)
            if v.fixed and not atoms:
                continue
            key = root(atoms[0]) if atoms else f"alone {x}"
            found.setdefault(key, ([], []))[0].append(x)
        for name in demanding:
            atoms = self._observed(name)
            if atoms:
                found.setdefault(root(atoms[0]), ([], []))[1].append(name)
        return [
            (members, maths)
            for members, maths in found.values()
            if len(members) > 1 or maths or isinstance(self.scope[self.variables[members[0]].name], Math)
        ]

    def _group(self, members: list[int], maths: list[str]) -> Group:
        """The table of a group."""
        names = [self.variables[x].name for x in members]
        read = frozenset().union(*(self.reads[name] for name in (*names, *maths)))
        attributes = sorted(a for a in read if a in self.attributes)
        owners = sorted({self.attributes[a] for a in attributes})
        tokens = sorted({a.split(" ", 1)[1] for a in read if a.startswith("tokens")} | set(owners))
        counted = [p for p in tokens if self._tokens_of(p) is not None]
        spans = [self._tokens_of(p) or () for p in counted]
        while math.prod(map(len, spans)) > MOST_SITUATIONS:
            longest = max(range(len(spans)), key=lambda k: len(spans[k]))
            del counted[longest], spans[longest]
        absences, listed = self._absences(attributes, math.prod(map(len, spans)))
        rows: dict[Combination, Mapping[str, float] | None] = {}
        for held in itertools.product(*spans):
            there = dict(zip(counted, held))
            for missing in absences:
                if any(there.get(self.attributes[a], 1) == 0 and a not in missing for a in attributes):
                    continue
                found, whole = self._situation(names, maths, there, missing)
                listed &= whole
                for cells, point in found.items():
                    key = (*held, *cells)
                    rows[key] = point if point is not None else rows.get(key)
        listed &= len(rows) <= MOST_COMBINATIONS
        columns = [self.column.get(p, self.cell_column.get(p, -1)) for p in counted]
        kept = [k for k, column in enumerate(columns) if column >= 0]
        all_of_them = math.prod(map(len, spans)) * math.prod(len(self.variables[x].cells) for x in members)
        whole = listed and len(rows) == all_of_them and all(point is not None for point in rows.values())
        return self._table(rows, kept, [columns[k] for k in kept], len(counted), members, (listed, whole))

    def _absences(self, attributes: list[str], times: int) -> tuple[list[set[str]], bool]:
        """Which attributes may be missing at once, and whether that is all; else those of whole objects."""
        if times * 2 ** len(attributes) <= MOST_SITUATIONS:
            return [set(some) for k in range(len(attributes) + 1) for some in itertools.combinations(attributes, k)], True
        owners = sorted({self.attributes[a] for a in attributes})
        found = [set(some) for k in range(len(owners) + 1) for some in itertools.islice(itertools.combinations(owners, k), 16)]
        return [{a for a in attributes if self.attributes[a] in some} for some in found], False

    def _table(
        self,
        rows: Mapping[Combination, Mapping[str, float] | None],
        kept: list[int],
        columns: list[int],
        n: int,
        members: list[int],
        facts: tuple[bool, bool],
    ) -> Group:
        """Rows as arrays; places that no node shows are left out, objects that are selected are the cells of their variables."""
        merged: dict[Combination, Mapping[str, float] | None] = {}
        for row, point in rows.items():
            shown = [row[k] + (columns[i] >= len(self.column)) for i, k in enumerate(kept)]
            key = (*shown, *row[n:])
            merged[key] = point if point is not None else merged.get(key)
        width = len(kept) + len(members)
        table = np.array(list(merged), np.int16).reshape(len(merged), width)
        sure = np.array([point is not None for point in merged.values()], bool)
        cells = [len(self.column) + x for x in members]
        return Group((*columns, *cells), table, sure, tuple(point or {} for point in merged.values()), *facts)

    def _tokens_of(self, place: str) -> range | None:
        """The numbers of tokens that are looked at one by one; None where they are too many."""
        p = self.scope[place]
        if isinstance(p, ObjectPlace):
            return range(2)
        most = p.capacity if isinstance(p, Place) else None
        return range(most + 1) if most is not None and most < MOST_SITUATIONS else None

    def _situation(
        self, names: list[str], maths: list[str], there: Mapping[str, int], missing: set[str]
    ) -> tuple[dict[Combination, Mapping[str, float] | None], bool]:
        """Combinations of cells with these tokens and objects, with a point each where one was found; whether that is all."""
        steps = self._steps((*names, *maths), missing)
        wanted = [self.leaf[name] for name in names]
        used = {n.name for tree in (*wanted, *(tree for _, tree in steps)) for n in tree.walk() if n.op == "name"}
        steps += [(f"constant {leaf.value!r}", leaf) for leaf in wanted if leaf.op == "number"]
        ranges = {}
        vague = False
        for atom in sorted(used - {name for name, _ in steps}):
            kind, _, place = atom.partition(" ")
            if kind == "tokens" and place in there:
                ranges[atom] = (float(there[place]), float(there[place]))
            else:
                vague |= kind == "tokens"
                ranges[atom] = self.span[atom]
        cells = [self.variables[self._variable(name)].cells for name in names]
        asked = tuple((leaf.name or f"constant {leaf.value!r}", choices) for leaf, choices in zip(wanted, cells))
        limits = tuple((name, self.ranges[name.partition(" ")[2]]) for name, _ in steps if name.partition(" ")[2] in self.bounds)
        question = Question(tuple(ranges.items()), tuple(steps), asked, limits)
        answer = combinations(question, self.enough)
        found: dict[Combination, Mapping[str, float] | None] = dict.fromkeys(sorted(answer.undecided))
        found |= {cells_: None if vague else point for cells_, point in answer.possible.items()}
        for cells_ in sorted(self._unobserved(question)):
            found.setdefault(cells_, None)
        return found, answer.complete

    def _variable(self, name: str) -> int:
        return next(x for x, v in enumerate(self.variables) if v.name == name)

    def _unobserved(self, question: Question) -> set[Combination]:
        """What may be besides while something is not yet observed of which the places show different first values."""
        box = dict(question.ranges)
        apart = {atom for atom in box if len(self.first_values.get(atom, ())) > 1}
        if not apart:
            return set()
        for atom in apart:
            box[atom] = (min(self.first_values[atom]), max(self.first_values[atom]))
        spans = dict(box)
        for name, tree in question.steps:
            span = bound(tree, spans)
            spans[name] = (-LARGEST, LARGEST) if span.empty else (span.low, span.high)
        able = [
            [k for k, (a, b) in enumerate(cells, 1) if spans[name][0] < b and spans[name][1] >= a] for name, cells in question.quantities
        ]
        return set(itertools.product(*able)) if math.prod(map(len, able)) <= MOST_COMBINATIONS else set()
