"""What the execution kernel reads: the net's rules as flat records, worked out once per net.

The conditions of all arcs and capacities of a transition become one list of ranges: it is enabled iff ``low <= m < high``
holds for each. What a firing can change (other transitions, math places) is worked out beforehand, so that a firing looks at
those only. A field ``x`` with a field ``x_end`` is a range of rows of another array.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba.core import config
from numpy.typing import NDArray

from ....errors import NetError, did_you_mean
from ...expressions import Expression
from ...expressions.compiler import Assembler
from ..net.net import resolve_name
from ..net.places import Input, ObjectPlace
from ..net.transitions import Transition
from .compiled_net import UNBOUNDED, CompiledNet, Memory, PlaceKind
from .kernels.bit_sets import tops_of


def _record(ints: str, reals: str = "") -> np.dtype[Any]:
    return np.dtype([(name, "i4") for name in ints.split()] + [(name, "f8") for name in reals.split()], align=True)


def _records(rows: Sequence[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Rows as records, whose fields are attributes: compiled always, in plain Python in a recarray only."""
    records = np.array(rows, dtype)
    return records.view(np.recarray) if config.DISABLE_JIT else records  # type: ignore[attr-defined]


CONDITION = _record("place moved", "low high")  # moved: 1 for discrete and object places
ARC = _record("place object", "value")  # object: number of the object place, -1 for others
MATH = _record("slot code code_end attr attr_end", "default")  # attr: slots of object attributes it reads
OBJECT = _record("place attr attr_end")  # attr: attribute slots to refresh when its object changes
ATTRIBUTE = _record("slot column")  # slot of the row; first column of the attribute in the object data
SELECTION = _record("object best best_end where where_end rank count present cand cand_end", "sign")
PARAMETER = _record("target source", "value")  # source: slot; -1 the value; -2 - o index of the object in object place o
TRANSITION = _record(
    "cond cond_end pre pre_end post post_end set set_end "
    "affected affected_end "  # transitions whose enabledness its firing may change, itself among them
    "touched touched_end "  # timed transitions that need tokens which it consumes
    "remath remath_end "  # math places that its firing may change, in order of evaluation
    "clock clock_end param param_end "
    "carrier "  # number of the object input whose object goes on, -1 for none
    "command group "  # -1 for none
    "delay memory servers priority "
    "rank",  # its place in the order of firing of the immediate transitions, or of the timed ones
    "weight",
)
SLOT = _record("math math_end cond cond_end own")  # math places and transitions that read it; own: the math place that it is, -1
OPTIONS = _record(
    "intermediate random most early immediate immediate_end timed timed_end resampler resampler_end math math_end "
    "ready_tops due_tops"  # of the sets of immediate and of timed transitions
)


class Program(NamedTuple):
    """The rules of a net, as arrays of the records above."""

    transitions: NDArray[Any]
    conditions: NDArray[Any]
    arcs: NDArray[Any]
    maths: NDArray[Any]
    objects: NDArray[Any]
    attributes: NDArray[Any]
    selections: NDArray[Any]
    parameters: NDArray[Any]
    slots: NDArray[Any]
    lists: NDArray[np.int32]  # numbers of transitions and math places, and slots
    code: NDArray[np.int32]
    constants: NDArray[np.float64]
    options: NDArray[Any]  # one row


class Layout(NamedTuple):
    """Names of what the arrays of an execution hold."""

    inputs: tuple[str, ...]  # observed quantities, the columns of the input array
    input_slots: NDArray[np.int32]  # place that ...
    input_columns: NDArray[np.int32]  # ... observes that column
    beliefs: tuple[str, ...]  # belief places, the columns of the belief array
    belief_slots: NDArray[np.int32]
    objects: tuple[str, ...]  # object places
    attributes: Mapping[str, tuple[str, ...]]  # class -> attributes that the net reads
    columns: Mapping[tuple[str, str], int]  # (class, attribute) -> first column of the object data; attribute "" is presence
    sizes: Mapping[str, int]  # class -> objects
    n_columns: int
    commands: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    parameters: Mapping[str, Mapping[str, int]]  # command -> parameter -> column
    n_parameters: int
    n_slots: int
    n_clocks: int
    depth: int  # of the expression stack
    math: tuple[str, ...]  # math places, in order of evaluation


def build(net: CompiledNet, sizes: Mapping[str, int], exclusive: Sequence[Sequence[str]] = ()) -> tuple[Program, Layout]:
    """The program of a net.

    Parameters
    ----------
    net : CompiledNet
    sizes : mapping
        Class name -> number of objects, for every class whose attributes the net reads.
    exclusive : sequence of sequences of command names
        Of each, at most one goes out per cycle.
    """
    return _Builder(net, sizes, exclusive).build()


class _Rows:
    """Rows of one array, appended in pieces."""

    def __init__(self) -> None:
        self.rows: list[Any] = []

    def add(self, rows: Iterable[Any]) -> tuple[int, int]:
        """Append rows; returns their range."""
        start = len(self.rows)
        self.rows += rows
        return start, len(self.rows)


class _Builder:
    def __init__(self, net: CompiledNet, sizes: Mapping[str, int], exclusive: Sequence[Sequence[str]]) -> None:
        self.net = net
        self.exclusive = exclusive
        self.sizes = dict(sizes)
        self.scope = {p.name: p for p in net.net.places}
        self.object_places = [p for p in net.net.places if isinstance(p, ObjectPlace)]
        self.object_number = {p.name: i for i, p in enumerate(self.object_places)}
        self.slots = net.n_places
        self.held_slots: dict[tuple[str, str], int] = {}  # (object place, attribute) -> slot
        self.candidate_slots: dict[tuple[str, str], int] = {}  # (class, attribute) -> slot
        self.attributes: dict[str, dict[str, None]] = {p.class_name: {} for p in self.object_places}
        self.assembler = Assembler(self.slot)
        self.maths = [self.assembler.add(Expression(p.expression).tree) for p in net.math]
        self.selections = [self.add_selection(p) for p in self.object_places if p.select is not None]
        self.code = self.assembler.finish()
        self.columns, self.n_columns = self.object_columns()
        self.conditions = [self.ranges(t) for t in range(net.n_transitions)]
        self.parameters = self.command_parameters()
        self.commands = tuple(self.parameters)
        self.groups = self.exclusive_groups()
        self.lists = _Rows()

    # -- names ------------------------------------------------------------------------------------------------------------

    def slot(self, name: str) -> int:
        """Slot of a name in an expression: a place, or an attribute of a held object."""
        place, attribute = resolve_name(name, self.scope)
        if not attribute:
            return self.net.place_index[place]
        owner = self.scope[place]
        assert isinstance(owner, ObjectPlace)
        return self.new_slot(self.held_slots, (place, attribute), owner.class_name, attribute)

    def new_slot(self, table: dict[tuple[str, str], int], key: tuple[str, str], class_name: str, attribute: str) -> int:
        if key not in table:
            table[key] = self.slots
            self.slots += 1
            self.attributes[class_name][attribute] = None
        return table[key]

    def add_selection(self, place: ObjectPlace) -> tuple[ObjectPlace, int, int]:
        """Compile the expressions of a selection; returns their numbers, -1 for no condition."""
        select = place.select
        assert select is not None

        def slot(name: str) -> int:
            head, _, attribute = name.partition(".")
            if head != select.candidate or not attribute:
                return self.slot(name)
            return self.new_slot(self.candidate_slots, (select.class_name, attribute), select.class_name, attribute)

        best = self.assembler.add(Expression(select.best).tree, slot)
        return place, best, self.assembler.add(Expression(select.where).tree, slot) if select.where else -1

    def object_columns(self) -> tuple[dict[tuple[str, str], int], int]:
        """Where each attribute's block of columns starts in the object data."""
        columns: dict[tuple[str, str], int] = {}
        total = 0
        title = f"net {self.net.net.name!r}"
        for name, read in self.attributes.items():
            if name not in self.sizes:
                if read:
                    raise NetError(f"{title} reads attributes of class {name!r}; say how many there are: objects={{{name!r}: 11}}")
                continue
            for attribute in ("", *read):
                columns[name, attribute] = total
                total += self.sizes[name]
        for name in self.sizes:
            if name not in self.attributes:
                known = f"{did_you_mean(name, self.attributes)} Its classes: {', '.join(self.attributes) or 'none'}"
                raise NetError(f"{title} has no object place of class {name!r}.{known}")
        return columns, total

    # -- rules ------------------------------------------------------------------------------------------------------------

    def ranges(self, t: int) -> dict[int, tuple[float, float]]:
        """Place -> (low, high): `t` is enabled iff every marking lies in its half-open range."""
        net = self.net
        found: dict[int, tuple[float, float]] = {}

        def narrow(place: int, low: float = -np.inf, high: float = np.inf) -> None:
            old = found.get(place, (-np.inf, np.inf))
            found[place] = (max(old[0], low), min(old[1], high))

        consumed, produced = dict(net.inputs.of(t)), dict(net.outputs.of(t))
        for arcs in (net.inputs, net.tests):
            for place, least in arcs.of(t):
                narrow(place, low=least)
        for place, threshold in net.inhibitors.of(t):
            narrow(place, high=threshold)
        for place in produced:
            room = capacity_limit(net, t, place, consumed, produced)
            if room < np.inf:
                narrow(place, high=room)
        return found

    def math_reads(self) -> list[set[int]]:
        """Per math place, the places it depends on, through other math places too."""
        closure: dict[str, set[int]] = {}
        for place in self.net.math:
            found: set[int] = set()
            for name in Expression(place.expression).names:
                owner = resolve_name(name, self.scope)[0]
                found |= {self.net.place_index[owner]} | closure.get(owner, set())
            closure[place.name] = found
        return list(closure.values())

    def consequences(self) -> list[tuple[list[int], list[int], list[int]]]:
        """Per transition: those its firing affects, those whose tokens it touches, math places to evaluate again."""
        net = self.net
        reads = self.math_reads()
        slots = [net.place_index[p.name] for p in net.math]
        readers: dict[int, list[int]] = {}
        needers: dict[int, list[int]] = {}
        for t, ranges in enumerate(self.conditions):
            for p, (low, _) in ranges.items():
                readers.setdefault(p, []).append(t)
                if low > 0 and net.moved[p] and net.delay[t] > 0:
                    needers.setdefault(p, []).append(t)
        found = []
        for t in range(net.n_transitions):
            consumed, produced = dict(net.inputs.of(t)), dict(net.outputs.of(t))
            arcs = consumed.keys() | produced.keys()
            changed = {p for p in arcs if consumed.get(p, 0) != produced.get(p, 0)} | {p for p, _ in net.sets.of(t)}
            moved = changed | {p for p in arcs if net.kind[p] == PlaceKind.OBJECT}
            again = [m for m, read in enumerate(reads) if read & moved]
            changed |= {slots[m] for m in again}
            affected = {t} | {u for p in changed for u in readers.get(p, ())}
            touched = {u for p in consumed for u in needers.get(p, ()) if u != t or net.servers[u] != 1}
            affected |= touched  # a clock stopped in between starts again at this instant
            found.append((sorted(affected), sorted(touched), again))
        return found

    # -- commands ---------------------------------------------------------------------------------------------------------

    def command_parameters(self) -> dict[str, dict[str, int]]:
        """Command -> parameter -> column."""
        found: dict[str, dict[str, int]] = {}
        total = 0
        for t in self.net.net.transitions:
            if t.emits is None:
                continue
            wanted = list(t.emits.params)
            if t.emits.name not in found:
                found[t.emits.name] = {key: total + i for i, key in enumerate(wanted)}
                total += len(wanted)
            elif set(found[t.emits.name]) != set(wanted):
                raise NetError(
                    f"net {self.net.net.name!r}, transition {t.name!r}: command {t.emits.name!r} with parameters {wanted}; "
                    f"elsewhere it has {list(found[t.emits.name])}"
                )
        return found

    def exclusive_groups(self) -> tuple[tuple[str, ...], ...]:
        """Groups of which one command goes out; a command that is in none is its own."""
        groups = []
        grouped: set[str] = set()
        for group in self.exclusive:
            mine = tuple(name for name in group if name in self.parameters)
            if grouped & set(mine):
                raise NetError(f"command {min(grouped & set(mine))!r} is in two exclusive groups")
            grouped |= set(mine)
            if mine:
                groups.append(mine)
        return tuple(groups) + tuple((name,) for name in self.parameters if name not in grouped)

    def command_rows(self, t: Transition) -> list[tuple[int, int, float]]:
        """Rows of PARAMETER of a transition."""
        rows = []
        for key, source in t.emits.params.items() if t.emits else ():
            column = self.parameters[t.emits.name][key] if t.emits else 0
            if isinstance(source, str):
                number = self.object_number.get(source)
                rows.append((column, self.net.place_index[source] if number is None else -2 - number, 0.0))
            else:
                rows.append((column, -1, float(source)))
        return rows

    # -- the whole ----------------------------------------------------------------------------------------------------------

    def build(self) -> tuple[Program, Layout]:
        net = self.net
        conditions, arcs, parameters, attributes = _Rows(), _Rows(), _Rows(), _Rows()
        transitions: list[tuple[Any, ...]] = []
        clock = 0
        rank = {t: i for timed in (False, True) for i, t in enumerate(self.order(timed))}
        for t, (consequence, declared) in enumerate(zip(self.consequences(), net.net.transitions)):
            row: list[Any] = [*conditions.add((p, net.moved[p], low, high) for p, (low, high) in self.conditions[t].items())]
            for kind in (net.inputs, net.outputs, net.sets):
                row += arcs.add((p, self.object_number.get(net.place_names[p], -1), value) for p, value in kind.of(t))
            for part in consequence:
                row += self.lists.add(part)
            row += [clock, clock + net.clock_count(t)]
            clock = row[-1]
            row += parameters.add(self.command_rows(declared))
            held = [self.object_number[p] for p in declared.inputs if p in self.object_number]
            row.append(held[0] if held and any(p in self.object_number for p in declared.outputs) else -1)
            command = self.commands.index(declared.emits.name) if declared.emits else -1
            group = next((g for g, names in enumerate(self.groups) if command >= 0 and self.commands[command] in names), -1)
            row += [command, group, net.delay[t], net.memory[t], net.servers[t], net.priority[t], rank[t], net.weight[t]]
            transitions.append(tuple(row))
        maths = self.math_rows()
        objects = []
        for place in self.object_places:
            mine = [(slot, self.columns[place.class_name, a]) for (p, a), slot in self.held_slots.items() if p == place.name]
            objects.append((net.place_index[place.name], *attributes.add(mine)))
        selections = self.selection_rows(attributes)
        slots = self.slot_rows()
        options = self.option_row()
        program = Program(
            transitions=_records(transitions, TRANSITION),
            conditions=_records(conditions.rows, CONDITION),
            arcs=_records(arcs.rows, ARC),
            maths=_records(maths, MATH),
            objects=_records(objects, OBJECT),
            attributes=_records(attributes.rows, ATTRIBUTE),
            selections=_records(selections, SELECTION),
            parameters=_records(parameters.rows, PARAMETER),
            slots=_records(slots, SLOT),
            lists=np.array(self.lists.rows, np.int32),
            code=self.code.code,
            constants=self.code.constants,
            options=_records([options], OPTIONS),
        )
        return program, self.layout(clock)

    def math_rows(self) -> list[tuple[Any, ...]]:
        rows = []
        for place, number in zip(self.net.math, self.maths):
            names = (resolve_name(name, self.scope) for name in Expression(place.expression).names)
            held = self.lists.add(self.held_slots[key] for key in names if key[1])
            span = self.code.start[number : number + 2]
            rows.append((self.net.place_index[place.name], *span, *held, place.default))
        return rows

    def selection_rows(self, attributes: _Rows) -> list[tuple[Any, ...]]:
        rows = []
        for place, best, where in self.selections:
            select = place.select
            assert select is not None
            name = place.class_name
            mine = [(slot, self.columns[key]) for key, slot in self.candidate_slots.items() if key[0] == name]
            spans = [*self.code.start[best : best + 2], *(self.code.start[where : where + 2] if where >= 0 else (-1, -1))]
            size = self.sizes[name]
            row = (self.object_number[place.name], *spans, select.k, size, self.columns[name, ""], *attributes.add(mine))
            rows.append((*row, -1.0 if select.minimize else 1.0))
        return rows

    def order(self, timed: bool) -> list[int]:
        """The timed or the immediate transitions in the order in which those that may fire do."""
        net = self.net
        return sorted((t for t in range(net.n_transitions) if (net.delay[t] > 0) == timed), key=lambda t: (-int(net.priority[t]), t))

    def slot_rows(self) -> list[tuple[int, ...]]:
        """Rows of SLOT: who reads a slot."""
        maths: list[list[int]] = [[] for _ in range(self.slots)]
        conditions: list[list[int]] = [[] for _ in range(self.slots)]
        own = [-1] * self.slots
        for m, place in enumerate(self.net.math):
            own[self.net.place_index[place.name]] = m
            for name in dict.fromkeys(Expression(place.expression).names):
                maths[self.slot(name)].append(m)
        for t, ranges in enumerate(self.conditions):
            for p in ranges:
                conditions[p].append(t)
        return [(*self.lists.add(maths[k]), *self.lists.add(conditions[k]), own[k]) for k in range(self.slots)]

    def option_row(self) -> tuple[int, ...]:
        net, semantics = self.net, self.net.net.semantics
        immediate, timed = self.order(False), self.order(True)
        maths = {p.name for p in net.math}
        texts = [text for place, _, _ in self.selections if place.select for text in (place.select.best, place.select.where) if text]
        early = any(name in maths for text in texts for name in Expression(text).names)
        return (
            int(semantics.persistence == "intermediate"),
            int(semantics.choice == "random"),
            semantics.max_firings,
            int(early),
            *self.lists.add(immediate),
            *self.lists.add(timed),
            *self.lists.add(t for t in timed if net.memory[t] == Memory.RESAMPLING),
            *self.lists.add(range(len(net.math))),
            *(tops_of(n) for n in (len(immediate), len(timed))),
        )

    def layout(self, n_clocks: int) -> Layout:
        net = self.net
        observing = [p for p in net.net.places if isinstance(p, Input)]
        inputs = tuple(dict.fromkeys(p.observes for p in observing))
        beliefs = tuple(name for name, kind in zip(net.place_names, net.kind) if kind == PlaceKind.BELIEF)
        return Layout(
            inputs=inputs,
            input_slots=np.array([net.place_index[p.name] for p in observing], np.int32),
            input_columns=np.array([inputs.index(p.observes) for p in observing], np.int32),
            beliefs=beliefs,
            belief_slots=np.array([net.place_index[name] for name in beliefs], np.int32),
            objects=tuple(p.name for p in self.object_places),
            attributes={name: tuple(found) for name, found in self.attributes.items()},
            columns=self.columns,
            sizes={name: self.sizes.get(name, 0) for name in self.attributes},
            n_columns=self.n_columns,
            commands=self.commands,
            groups=self.groups,
            parameters=self.parameters,
            n_parameters=sum(len(columns) for columns in self.parameters.values()),
            n_slots=self.slots,
            n_clocks=n_clocks,
            depth=self.code.depth,
            math=tuple(p.name for p in net.math),
        )


def capacity_limit(net: CompiledNet, t: int, place: int, consumed: Mapping[int, float], produced: Mapping[int, float]) -> float:
    """The marking of `place` must be below this for `t` to fit its tokens in; infinite where no capacity stands in the way."""
    amount = produced.get(place, 0)
    back = 0 if net.net.semantics.capacity == "weak" else consumed.get(place, 0)
    if net.capacity[place] == UNBOUNDED or amount <= back:
        return float("inf")
    return float(net.capacity[place]) - amount + back + 1
