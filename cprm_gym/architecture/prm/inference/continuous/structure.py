"""What a step does: which parts of a slice hang together, and the program of each; made once for a slice and a form of belief."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .....errors import ModelError
from ...grounding.slices import PREVIOUS, SAME, GroundCPD
from ..compiled.slice_info import NeedsVariable, SliceInfo
from ..join_tree import connected
from .belief import MixtureBelief, Part
from .program import Place, Program, Task, Writer


class Work(NamedTuple):
    """One group of the slice.

    Attributes
    ----------
    parts : tuple of Part
        Of the belief after it.
    sources : tuple of (int, int array)
        Group of the belief before and its parts, one for each part of this group.
    program : Program
    load_slots, load_columns : int arrays
        Which of the sources' slots and columns the program begins with.
    keep_slots, keep_columns : int arrays
        Which of its own stay.
    periods : float array
        Of the columns that stay.
    turns : float array
        Periods of all columns that it uses.
    slots, columns : int
        How many it uses.
    rows : (M, R) int array
        Rows of the readings.
    draws : int
        Random numbers for each component.
    """

    parts: tuple[Part, ...]
    sources: tuple[tuple[int, np.ndarray], ...]
    program: Program
    load_slots: np.ndarray
    load_columns: np.ndarray
    keep_slots: np.ndarray
    keep_columns: np.ndarray
    periods: np.ndarray
    turns: np.ndarray
    slots: int
    columns: int
    rows: np.ndarray
    draws: int


class Structure:
    """The groups of a slice.

    Parameters
    ----------
    belief : MixtureBelief
        Its form matters, not its numbers.
    info : SliceInfo
    inner : frozenset of str
        Variables that are kept; see `inner_variables`.
    unread : frozenset of str
        Leaves that nobody read and that would only link what is independent.
    drawn : frozenset of str
        Numbers that are drawn instead of kept as normals.
    label : str
        When not empty, all that was believed of the slice before is kept, under its name and this.

    Raises
    ------
    NeedsVariable
        A variable of the previous slice is needed that was not kept.
    """

    def __init__(
        self,
        belief: MixtureBelief,
        info: SliceInfo,
        inner: frozenset[str],
        unread: frozenset[str] = frozenset(),
        drawn: frozenset[str] = frozenset(),
        label: str = "",
    ) -> None:
        self.belief, self.info, self.inner, self.drawn, self.label = belief, info, inner, drawn, label
        self.old = {n: (g, m) for g, group in enumerate(belief.groups) for m, part in enumerate(group.parts) for n in part.names}
        self.given = {n for n, row in info.row.items() if info.given[row]}
        order = {n: k for k, n in enumerate(info.slice.order())}
        families = sorted((c for c in info.slice.cpds if c.child not in unread), key=lambda c: order[c.child])
        made: dict[object, list[tuple[tuple[tuple[int, int], ...], Part, np.ndarray, Work]]] = {}
        for some, sources in self._divided(families):
            work, signature = self._part(some, sources)
            made.setdefault((signature, tuple(g for g, _ in sources)), []).append((sources, work.parts[0], work.rows[0], work))
        self.works = tuple(
            alike[0][3]._replace(
                parts=tuple(part for _, part, _, _ in alike),
                rows=np.array([rows for _, _, rows, _ in alike], np.int64).reshape(len(alike), -1),
                sources=tuple(
                    (alike[0][0][s][0], np.array([sources[s][1] for sources, _, _, _ in alike], np.int64)) for s in range(len(alike[0][0]))
                ),
            )
            for alike in made.values()
        )

    def _divided(self, families: Sequence[GroundCPD]) -> list[tuple[list[GroundCPD], tuple[tuple[int, int], ...]]]:
        """Families that hang together, and the old parts that they go on from."""
        scopes: list[tuple[object, ...]] = []
        for cpd in families:
            tokens: list[object] = [cpd.child]
            for parent, lag in cpd.parents:
                if lag != PREVIOUS and parent in self.info.slice.variables:
                    tokens += [] if parent in self.given else [parent]
                elif parent in self.old:
                    tokens.append(self.old[parent])
                else:
                    raise self._missing(cpd.child, parent, lag)
            scopes.append(tuple(tokens))
        stays = {self.old[n] for n in self.old if self.label or self._static(n)}
        scopes += [(place,) for place in sorted(stays)]
        found = []
        for indices in connected(scopes):
            some = [families[i] for i in sorted(indices) if i < len(families)]
            places = {t for i in indices for t in scopes[i] if isinstance(t, tuple)}
            found.append((some, tuple(sorted(places))))  # type: ignore[type-var]
        return found  # type: ignore[return-value]

    def _static(self, name: str) -> bool:
        row = self.info.row.get(name, -1)
        return row >= 0 and bool(self.info.static[row]) and name not in self.info.slice.variables

    def _missing(self, child: str, parent: str, lag: int) -> Exception:
        before = self.belief.info
        if before is None or parent not in before.row:
            return ModelError(f"CPD of {child!r} has parent {parent!r} in the previous slice, where there is no such variable")
        return NeedsVariable(before.kinds[before.row[parent]], parent, static=lag != PREVIOUS)

    def _part(self, families: Sequence[GroundCPD], sources: tuple[tuple[int, int], ...]) -> tuple[Work, object]:
        """The program of one part, as a group of its own, and what it shares with like parts."""
        info, variables = self.info, self.info.variables
        parts = [self.belief.groups[g].parts[m] for g, m in sources]
        all_slots, all_columns = (sum((p[k] for p in parts), ()) for k in (0, 1))
        asked = {p for c in families for p, lag in c.parents if lag == PREVIOUS or p not in info.slice.variables}
        stays = [n for n in (*all_slots, *all_columns) if self.label or self._static(n)]
        asked.update(stays)
        load_slots = [k for k, n in enumerate(all_slots) if n in asked]
        load_columns = [k for k, n in enumerate(all_columns) if n in asked]
        old = {all_slots[k]: ("slot", i) for i, k in enumerate(load_slots)}
        old |= {all_columns[k]: ("column", i) for i, k in enumerate(load_columns)}
        new: dict[str, tuple[str, int]] = {}
        slots, used, draws = len(load_slots), len(load_columns), 0
        writer = Writer()
        rows: list[int] = []
        number: dict[str, int] = {}

        def reading(name: str) -> int:
            if name not in number:
                number[name] = len(rows)
                rows.append(info.row[name])
            return number[name]

        def place(name: str, lag: int) -> Place:
            if lag != PREVIOUS and name in self.given:
                return Place("given", reading(name), variables[name])
            kind, index = (new if lag != PREVIOUS and name in info.slice.variables else old)[name]
            before = self.belief.info
            variable = variables[name] if lag == SAME or before is None or name not in before.variables else before.variables[name]
            return Place(kind, index, variable)

        for cpd in families:
            v, leaf = variables[cpd.child], cpd.child not in self.inner
            where = tuple(place(p, lag) for p, lag in cpd.parents)
            target = (-1 if leaf else slots) if v.quantity is None else used
            drawn = -1
            if cpd.child in self.drawn and v.quantity is not None and not leaf:
                drawn, draws = draws, draws + 1
            writer.add(Task(cpd, v, where, target, used, leaf, reading(cpd.child), drawn))
            if not leaf:
                new[cpd.child] = ("slot", slots) if v.quantity is None else ("column", used)
                slots, used = slots + (v.quantity is None), used + (v.quantity is not None)
        kept = [(n if "#" in n or not self.label or n not in self.old else f"{n}{self.label}", old[n]) for n in stays] + list(new.items())
        keep_slots = [i for _, (kind, i) in kept if kind == "slot"]
        keep_columns = [i for _, (kind, i) in kept if kind == "column"]
        program = writer.finish(keep_columns)
        program.ops[program.ops[:, 1] < 0, 1] = slots  # leaves share the last slot
        part = Part(tuple(n for n, (kind, _) in kept if kind == "slot"), tuple(n for n, (kind, _) in kept if kind == "column"))
        periods = [self._period(n) for n in part.columns]
        turns = [0.0] * (used + 1)
        for name, (kind, i) in (*old.items(), *new.items()):
            if kind == "column":
                turns[i] = self._period(name)
        arrays = tuple(np.array(a, np.int64) for a in (load_slots, load_columns, keep_slots, keep_columns))
        at_slots, at_columns, stay_slots, stay_columns = arrays
        work = Work(
            (part,), (), program, at_slots, at_columns, stay_slots, stay_columns, np.array(periods), np.array(turns), slots + 2, used + 1,
            np.array([rows], np.int64), draws,
        )  # fmt: skip
        return work, (program.signature, *(a.tobytes() for a in arrays), tuple(periods), tuple(turns), len(rows))

    def _period(self, name: str) -> float:
        plain = name.partition("#")[0] if name not in self.info.variables else name
        for info in (self.info, self.belief.info):
            if info is not None and plain in info.variables:
                quantity = info.variables[plain].quantity
                return 0.0 if quantity is None else quantity.period
        return 0.0


def inner_variables(info: SliceInfo, temporal: frozenset[tuple[str, str]], wanted: frozenset[str] = frozenset()) -> frozenset[str]:
    """Variables of a slice that are kept in the belief: those with children, in it or in the next one, static ones, and those wanted."""
    parents = {p for c in info.slice.cpds for p, lag in c.parents if lag != PREVIOUS}
    found = set()
    for name in info.slice.variables:
        row = info.row[name]
        kind = info.kinds[row]
        if info.given[row]:
            continue
        if name in parents or name in wanted or info.static[row] or (kind.class_name, kind.attribute) in temporal:
            found.add(name)
    return frozenset(found)


def linking_leaves(info: SliceInfo, inner: frozenset[str]) -> tuple[str, ...]:
    """Variables that are there to be read and depend on several others that are not given."""
    out = []
    for cpd in info.slice.cpds:
        hidden = [p for p, lag in cpd.parents if lag == PREVIOUS or p not in info.row or not info.given[info.row[p]]]
        if cpd.child not in inner and len(hidden) > 1:
            out.append(cpd.child)
    return tuple(out)
