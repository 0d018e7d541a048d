"""What the execution kernel reads: the net's rules as flat lists, worked out once per net.

The conditions of all arcs and capacities of a transition become one list of ranges: it is enabled iff ``low <= m < high`` holds
for each. What a firing can change (other transitions, math places) is worked out beforehand, so that a firing looks at those only.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import NetError, did_you_mean
from ..expressions import Expression
from ..expressions.compiler import Assembler, Code
from .compiled import UNBOUNDED, CompiledNet, Memory, PlaceKind
from .net import resolve_name
from .places import INFINITE, ObjectPlace

Ints = NDArray[np.int32]
Reals = NDArray[np.float64]

MAX_CLOCKS = 256
"""Clocks of a transition with infinitely many servers whose input places are unbounded."""


class Program(NamedTuple):
    """The rules of a net. A list per transition t is ``list[start[t]:start[t + 1]]``; T transitions, P places, S slots of a row."""

    cond_start: Ints  # enabled iff low <= row[place] < high for all
    cond_place: Ints
    cond_low: Reals
    cond_high: Reals
    pre_start: Ints
    pre_place: Ints
    pre_weight: Reals
    post_start: Ints
    post_place: Ints
    post_weight: Reals
    set_start: Ints
    set_place: Ints
    set_value: Reals
    object_of: Ints  # (P,) number of the object place, -1 for others
    moved: NDArray[np.uint8]  # (P,) 1 for discrete and object places
    carrier: Ints  # (T,) number of the object input whose object goes on, -1 for none
    affected_start: Ints  # transitions whose enabledness a firing of t may change, t among them
    affected: Ints
    touched_start: Ints  # timed transitions that need tokens which t consumes
    touched: Ints
    remath_start: Ints  # math places that a firing of t may change, in order of evaluation
    remath: Ints
    resamplers: Ints  # transitions whose clocks any firing resets
    immediate: Ints  # immediate transitions by priority, then declaration
    timed: Ints  # timed ones
    priority: NDArray[np.int64]
    weight: Reals
    delay: Ints
    memory: NDArray[np.int8]
    servers: Ints  # -1 for infinite
    clock_start: Ints  # (T + 1,) slots of the clocks
    code: Ints  # byte code of math, then of selections
    constants: Reals
    code_start: Ints
    math_slot: Ints  # (M,) place that math m sets; its code is expression m
    math_default: Reals
    math_attr_start: Ints  # (M + 1,) slots of object attributes it reads
    math_attr: Ints
    attr_start: Ints  # (O + 1,) per object place: attribute slots to refresh when its object changes
    attr_slot: Ints
    attr_column: Ints  # first column of that attribute in the object data
    select_object: Ints  # (Z,) object place that selection z sets
    select_place: Ints
    select_class: Ints
    select_rank: Ints
    select_sign: Reals
    select_best: Ints  # number of the expression
    select_where: Ints  # -1 for none
    class_size: Ints  # (C,) objects of each class
    class_present: Ints  # column of the presence mask
    cand_start: Ints  # (C + 1,) per class: slots of the candidate's attributes
    cand_slot: Ints
    cand_column: Ints
    command_of: Ints  # (T,) number of the command it emits, -1 for none
    group_of: Ints  # (commands,)
    param_start: Ints  # (T + 1,)
    param_target: Ints  # column of the parameter
    param_source: Ints  # slot it is read from; -1 constant; -2 - o index of the object in object place o
    param_value: Reals
    options: NDArray[np.int64]  # intermediate persistence, random choice, most firings, math before selection


class Layout(NamedTuple):
    """Names of what the arrays of an execution hold."""

    inputs: tuple[str, ...]  # observed quantities, the columns of the input array
    input_slots: Ints  # place that ...
    input_columns: Ints  # ... observes that column
    beliefs: tuple[str, ...]  # belief places, the columns of the belief array
    belief_slots: Ints
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
    clock_start: Ints


def ragged(lists: Sequence[Iterable[Any]], dtype: type) -> tuple[Ints, NDArray[Any]]:
    """Lists one after the other, and where each starts."""
    rows = [list(row) for row in lists]
    start = np.zeros(len(rows) + 1, np.int32)
    np.cumsum([len(row) for row in rows], out=start[1:])
    return start, np.array([x for row in rows for x in row], dtype)


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


class _Builder:
    def __init__(self, net: CompiledNet, sizes: Mapping[str, int], exclusive: Sequence[Sequence[str]]) -> None:
        self.net = net
        self.exclusive = exclusive
        self.scope = {p.name: p for p in net.net.places}
        self.object_places = [p for p in net.net.places if isinstance(p, ObjectPlace)]
        self.object_number = {p.name: i for i, p in enumerate(self.object_places)}
        self.selections = [(p, p.select) for p in self.object_places if p.select is not None]
        self.slots = net.n_places
        self.held_slots: dict[tuple[str, str], int] = {}  # (object place, attribute) -> slot
        self.candidate_slots: dict[tuple[str, str], int] = {}  # (class, attribute) -> slot
        self.attributes: dict[str, dict[str, None]] = {p.class_name: {} for p in self.object_places}
        self.sizes = dict(sizes)

    # -- names ------------------------------------------------------------------------------------------------------------

    def slot(self, name: str) -> int:
        """Slot of a name in an expression: a place, or an attribute of a held object."""
        place, attribute = resolve_name(name, self.scope)
        if not attribute:
            return self.net.place_index[place]
        owner = self.scope[place]
        assert isinstance(owner, ObjectPlace)
        return self._new_slot(self.held_slots, (place, attribute), owner.class_name, attribute)

    def candidate_slot(self, class_name: str, name: str) -> int:
        """Slot of a name in a selection: an attribute of the candidate, or as `slot`."""
        head, _, attribute = name.partition(".")
        if head != class_name.lower() or not attribute:
            return self.slot(name)
        return self._new_slot(self.candidate_slots, (class_name, attribute), class_name, attribute)

    def _new_slot(self, table: dict[tuple[str, str], int], key: tuple[str, str], class_name: str, attribute: str) -> int:
        if key not in table:
            table[key] = self.slots
            self.slots += 1
            self.attributes[class_name][attribute] = None
        return table[key]

    # -- parts ------------------------------------------------------------------------------------------------------------

    def build(self) -> tuple[Program, Layout]:
        assembler = Assembler(self.slot)
        for place in self.net.math:
            assembler.add(Expression(place.expression).tree)
        best, where = [], []
        for _, select in self.selections:

            def slot(name: str, class_name: str = select.class_name) -> int:
                return self.candidate_slot(class_name, name)

            best.append(assembler.add(Expression(select.best).tree, slot))
            where.append(assembler.add(Expression(select.where).tree, slot) if select.where else -1)
        code = assembler.finish()
        classes, columns, n_columns = self.object_columns()
        commands, groups, parameters, n_parameters = self.commands()
        clock_start = self.clock_slots()
        parts = {
            **self.rules(),
            **self.consequences(),
            **self.objects(classes, columns),
            **self.output(commands, groups, parameters),
            **self.math_parts(code),
            "select_object": np.array([self.object_number[p.name] for p, _ in self.selections], np.int32),
            "select_place": np.array([self.net.place_index[p.name] for p, _ in self.selections], np.int32),
            "select_class": np.array([classes.index(s.class_name) for _, s in self.selections], np.int32),
            "select_rank": np.array([s.k for _, s in self.selections], np.int32),
            "select_sign": np.array([-1.0 if s.minimize else 1.0 for _, s in self.selections], np.float64),
            "select_best": np.array(best, np.int32),
            "select_where": np.array(where, np.int32),
            "clock_start": clock_start,
            "options": self.options(),
        }
        net = self.net
        inputs = list(dict.fromkeys(p.observes for p in net.net.places if hasattr(p, "observes")))
        observing = [(net.place_index[p.name], inputs.index(p.observes)) for p in net.net.places if hasattr(p, "observes")]
        beliefs = tuple(name for name, kind in zip(net.place_names, net.kind) if kind == PlaceKind.BELIEF)
        layout = Layout(
            inputs=tuple(inputs),
            input_slots=np.array([slot for slot, _ in observing], np.int32),
            input_columns=np.array([column for _, column in observing], np.int32),
            beliefs=beliefs,
            belief_slots=np.array([net.place_index[name] for name in beliefs], np.int32),
            objects=tuple(p.name for p in self.object_places),
            attributes={name: tuple(found) for name, found in self.attributes.items()},
            columns=columns,
            sizes={name: self.sizes.get(name, 0) for name in classes},
            n_columns=n_columns,
            commands=commands,
            groups=groups,
            parameters=parameters,
            n_parameters=n_parameters,
            n_slots=self.slots,
            n_clocks=int(clock_start[-1]),
            depth=code.depth,
            math=tuple(p.name for p in net.math),
            clock_start=clock_start,
        )
        return Program(**parts), layout

    def rules(self) -> dict[str, Any]:
        """Conditions and effects of the transitions."""
        net = self.net
        conditions = [self.ranges(t) for t in range(net.n_transitions)]
        parts: dict[str, Any] = {}
        parts["cond_start"], parts["cond_place"] = ragged([list(r) for r in conditions], np.int32)
        _, parts["cond_low"] = ragged([[low for low, _ in r.values()] for r in conditions], np.float64)
        _, parts["cond_high"] = ragged([[high for _, high in r.values()] for r in conditions], np.float64)
        for key, arcs, value in (("pre", net.inputs, "weight"), ("post", net.outputs, "weight"), ("set", net.sets, "value")):
            parts[f"{key}_start"], parts[f"{key}_place"], parts[f"{key}_{value}"] = arcs.start, arcs.place, arcs.value
        parts["object_of"] = np.array([self.object_number.get(name, -1) for name in net.place_names], np.int32)
        parts["moved"] = net.moved.astype(np.uint8)
        carrier = []
        for t in net.net.transitions:
            held = [self.object_number[p] for p in t.inputs if p in self.object_number]
            carrier.append(held[0] if held and any(p in self.object_number for p in t.outputs) else -1)
        parts["carrier"] = np.array(carrier, np.int32)
        order = sorted(range(net.n_transitions), key=lambda t: (-int(net.priority[t]), t))
        parts["immediate"] = np.array([t for t in order if net.delay[t] == 0], np.int32)
        parts["timed"] = np.array([t for t in order if net.delay[t] > 0], np.int32)
        parts["priority"], parts["weight"], parts["memory"] = net.priority, net.weight, net.memory
        parts["delay"], parts["servers"] = net.delay.astype(np.int32), net.servers.astype(np.int32)
        parts["resamplers"] = np.flatnonzero((net.memory == Memory.RESAMPLING) & (net.delay > 0)).astype(np.int32)
        return parts

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
        weak = net.net.semantics.capacity == "weak"
        for place, amount in produced.items():
            back = 0 if weak else consumed.get(place, 0)
            if net.capacity[place] != UNBOUNDED and amount > back:
                narrow(place, high=float(net.capacity[place]) - amount + back + 1)
        return found

    def consequences(self) -> dict[str, Any]:
        """What each firing may change."""
        net = self.net
        conditions = [set(self.ranges(t)) for t in range(net.n_transitions)]
        reads = []  # per math place: the places it depends on, through other math places too
        closure: dict[str, set[int]] = {}
        for place in net.math:
            direct: set[int] = set()
            for name in Expression(place.expression).names:
                owner = resolve_name(name, self.scope)[0]
                direct.add(net.place_index[owner])
                direct |= closure.get(owner, set())
            closure[place.name] = direct
            reads.append(direct)
        math_slots = [net.place_index[p.name] for p in net.math]
        readers: dict[int, list[int]] = {}
        for t, places in enumerate(conditions):
            for p in places:
                readers.setdefault(p, []).append(t)
        needs = [{p for p, (low, _) in self.ranges(t).items() if low > 0 and net.moved[p]} for t in range(net.n_transitions)]
        affected, remath, touched = [], [], []
        for t in range(net.n_transitions):
            consumed, produced = dict(net.inputs.of(t)), dict(net.outputs.of(t))
            changed = {p for p in consumed.keys() | produced.keys() if consumed.get(p, 0) != produced.get(p, 0)}
            changed |= {p for p, _ in net.sets.of(t)}
            moved = changed | {p for p in consumed.keys() | produced.keys() if net.kind[p] == PlaceKind.OBJECT}
            again = [m for m, read in enumerate(reads) if read & moved]
            changed |= {math_slots[m] for m in again}
            remath.append(again)
            affected.append(sorted({t} | {u for p in changed for u in readers.get(p, ())}))
            others = {u for p in consumed for u in readers.get(p, ()) if net.delay[u] > 0 and p in needs[u]}
            touched.append(sorted(u for u in others if u != t or net.servers[u] != 1))
        parts: dict[str, Any] = {}
        parts["affected_start"], parts["affected"] = ragged(affected, np.int32)
        parts["touched_start"], parts["touched"] = ragged(touched, np.int32)
        parts["remath_start"], parts["remath"] = ragged(remath, np.int32)
        return parts

    def clock_slots(self) -> Ints:
        """Where each transition's clocks start: none for immediates, one per server for timed ones."""
        net = self.net
        start = [0]
        for t in range(net.n_transitions):
            count = 0
            if net.delay[t] > 0:
                count = int(net.servers[t])
                if count == INFINITE:
                    bounds = [int(net.capacity[p] // w) for p, w in net.inputs.of(t)]
                    count = max(1, min([*bounds, MAX_CLOCKS])) if bounds else 1
            start.append(start[-1] + count)
        return np.array(start, np.int32)

    def math_parts(self, code: Code) -> dict[str, Any]:
        net = self.net
        held = []
        for place in net.math:
            names = (resolve_name(name, self.scope) for name in Expression(place.expression).names)
            held.append([self.held_slots[key] for key in names if key[1]])
        start, slots = ragged(held, np.int32)
        return {
            "code": code.code, "constants": code.constants, "code_start": code.start,
            "math_slot": np.array([net.place_index[p.name] for p in net.math], np.int32),
            "math_default": np.array([p.default for p in net.math], np.float64),
            "math_attr_start": start, "math_attr": slots,
        }  # fmt: skip

    def object_columns(self) -> tuple[list[str], dict[tuple[str, str], int], int]:
        """Where each attribute's block of columns starts in the object data."""
        classes = [name for name in self.attributes]
        columns: dict[tuple[str, str], int] = {}
        total = 0
        for name in classes:
            if name not in self.sizes:
                if self.attributes[name]:
                    raise NetError(
                        f"net {self.net.net.name!r} reads attributes of class {name!r}; say how many there are: objects={{{name!r}: 11}}"
                    )
                continue
            for attribute in ("", *self.attributes[name]):
                columns[name, attribute] = total
                total += self.sizes[name]
        for name in self.sizes:
            if name not in classes:
                raise NetError(
                    f"net {self.net.net.name!r} has no object place of class {name!r}.{did_you_mean(name, classes)} "
                    f"Its classes: {', '.join(classes) or 'none'}"
                )
        return classes, columns, total

    def objects(self, classes: list[str], columns: Mapping[tuple[str, str], int]) -> dict[str, Any]:
        held: list[list[tuple[int, int]]] = []
        for place in self.object_places:
            mine = [(slot, columns[place.class_name, attribute]) for (p, attribute), slot in self.held_slots.items() if p == place.name]
            held.append(mine)
        candidates = [[(slot, columns[key]) for key, slot in self.candidate_slots.items() if key[0] == name] for name in classes]
        parts: dict[str, Any] = {}
        parts["attr_start"], parts["attr_slot"] = ragged([[slot for slot, _ in row] for row in held], np.int32)
        _, parts["attr_column"] = ragged([[column for _, column in row] for row in held], np.int32)
        parts["cand_start"], parts["cand_slot"] = ragged([[slot for slot, _ in row] for row in candidates], np.int32)
        _, parts["cand_column"] = ragged([[column for _, column in row] for row in candidates], np.int32)
        parts["class_size"] = np.array([self.sizes.get(name, 0) for name in classes], np.int32)
        parts["class_present"] = np.array([columns.get((name, ""), 0) for name in classes], np.int32)
        return parts

    def commands(self) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...], dict[str, dict[str, int]], int]:
        """Command names, groups of which one goes out, and the columns of the parameters."""
        parameters: dict[str, dict[str, int]] = {}
        total = 0
        for t in self.net.net.transitions:
            if t.emits is None:
                continue
            wanted = sorted(t.emits.params)
            if t.emits.name not in parameters:
                parameters[t.emits.name] = {key: total + i for i, key in enumerate(wanted)}
                total += len(wanted)
            elif sorted(parameters[t.emits.name]) != wanted:
                raise NetError(
                    f"net {self.net.net.name!r}, transition {t.name!r}: command {t.emits.name!r} with parameters {wanted}; "
                    f"elsewhere it has {sorted(parameters[t.emits.name])}"
                )
        groups = []
        grouped: set[str] = set()
        for group in self.exclusive:
            mine = tuple(name for name in group if name in parameters)
            if grouped & set(mine):
                raise NetError(f"command {sorted(grouped & set(mine))[0]!r} is in two exclusive groups")
            grouped |= set(mine)
            if mine:
                groups.append(mine)
        groups += [(name,) for name in parameters if name not in grouped]
        return tuple(parameters), tuple(groups), parameters, total

    def output(
        self, commands: tuple[str, ...], groups: tuple[tuple[str, ...], ...], parameters: Mapping[str, Mapping[str, int]]
    ) -> dict[str, Any]:
        command_of = []
        rows: list[list[tuple[int, int, float]]] = []
        for t in self.net.net.transitions:
            command_of.append(commands.index(t.emits.name) if t.emits else -1)
            row = []
            for key, source in t.emits.params.items() if t.emits else ():
                column = parameters[t.emits.name][key] if t.emits else 0
                if isinstance(source, str):
                    number = self.object_number.get(source)
                    row.append((column, self.net.place_index[source] if number is None else -2 - number, 0.0))
                else:
                    row.append((column, -1, float(source)))
            rows.append(row)
        start, target = ragged([[r[0] for r in row] for row in rows], np.int32)
        return {
            "command_of": np.array(command_of, np.int32),
            "group_of": np.array([next(g for g, names in enumerate(groups) if c in names) for c in commands], np.int32),
            "param_start": start, "param_target": target,
            "param_source": ragged([[r[1] for r in row] for row in rows], np.int32)[1],
            "param_value": ragged([[r[2] for r in row] for row in rows], np.float64)[1],
        }  # fmt: skip

    def options(self) -> NDArray[np.int64]:
        semantics = self.net.net.semantics
        maths = {p.name for p in self.net.math}
        texts = [text for _, select in self.selections for text in (select.best, select.where) if text]
        early = any(name in maths for text in texts for name in Expression(text).names)
        return np.array(
            [semantics.persistence == "intermediate", semantics.choice == "random", semantics.max_firings, early], np.int64
        )
