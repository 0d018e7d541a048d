"""Runs that analysis shows, performed by the reference interpreter with values that are observed, found by trying.

What a cycle does depends on a value only through what arcs and expressions make of it. So points at which every threshold is passed or
not passed alike, at all markings through which the run says that the cycle goes, are tried once.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from reference_interpreter import Reference
from run_replay import read_cell

from cprm_gym.architecture.analysis.timed.regions import evaluate
from cprm_gym.architecture.expressions import Expression
from cprm_gym.architecture.petri import Input, Math, PetriNet, Place, Ports, Transition, flatten
from cprm_gym.errors import ExpressionError

LOOSE = 20_000
"""Points tried beyond the grid, where the grid has none that fits."""


class IllegalStep(Exception):
    """The interpreter cannot do what the run says."""


class Points:
    """Points of what is observed, and what a net makes of them.

    Parameters
    ----------
    net : PetriNet
        Flat.
    maths : sequence of Math
        In order.
    columns : mapping from observed quantity to (N,) values
    """

    def __init__(self, net: PetriNet, maths: Sequence[Math], columns: dict[str, np.ndarray]) -> None:
        self.columns = columns
        self.size = len(next(iter(columns.values())))
        self.shown = {p.name: columns[p.observes] for p in net.places if isinstance(p, Input)}
        self.maths = [(m.name, Expression(m.expression)) for m in maths]
        self.read = sorted({n for _, e in self.maths for n in e.names} - self.shown.keys() - {name for name, _ in self.maths})
        named = {p.name for p in net.places if isinstance(p, (Input, Math))}
        arcs = {(p, w) for t in net.transitions for kind in (t.inputs, t.tests, t.inhibitors) for p, w in kind.items() if p in named}
        self.thresholds = sorted(arcs)
        self._known: dict[tuple[float, ...], tuple[dict[str, np.ndarray], np.ndarray]] = {}

    def at(self, index: int) -> dict[str, float]:
        """One point: observed quantity -> value."""
        return {name: float(column[index]) for name, column in self.columns.items()}

    def seen(self, tokens: dict[str, float]) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """The values of all places and the class of each point, (N,), while places hold these tokens."""
        key = tuple(tokens[name] for name in self.read)
        if key not in self._known:
            values = self.shown | {name: np.full(self.size, tokens[name]) for name in self.read}
            for name, expression in self.maths:
                values[name] = evaluate(expression.tree, values, self.size)
            code = np.zeros(self.size, np.int64)
            for name, _ in self.maths:
                code = _joined(code, np.isnan(values[name]))
            for name, threshold in self.thresholds:
                code = _joined(code, values[name] >= threshold)
            self._known[key] = values, code
        return self._known[key]

    def classes(self, moments: Sequence[dict[str, float]], cells: Sequence[tuple[int, str, float, float]]) -> list[int]:
        """The first point of each class that lies in all cells (number of the moment, place, low, high)."""
        code = np.zeros(self.size, np.int64)
        for tokens in moments:
            code = _joined(code, self.seen(tokens)[1])
        fits = np.ones(self.size, bool)
        for moment, name, low, high in cells:
            values = self.seen(moments[moment])[0][name]
            fits &= (values >= low) & (values < high)
        index = np.flatnonzero(fits)
        _, first = np.unique(code[fits], return_index=True)
        return index[np.sort(first)].tolist()


def _joined(code: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Classes of points that are alike in both, numbered from 0."""
    return np.unique(code * (int(other.max()) + 1) + other, return_inverse=True)[1]


class RunExecution:
    """A net with its caller, ready to perform runs.

    Parameters
    ----------
    net : PetriNet
    moves : sequence of Transition
        What the caller may do.
    extra : mapping from name to tokens
        The caller's books.
    grid : sequence of float
        Values tried for what is observed.
    """

    def __init__(self, net: PetriNet, moves: Sequence[Transition], extra: dict[str, int], grid: Sequence[float]) -> None:
        flat = flatten(net)
        books = tuple(Place(name, tokens=tokens) for name, tokens in extra.items())
        semantics = replace(flat.semantics, choice="declared")
        self.net = replace(flat, places=(*flat.places, *books), ports=Ports(), semantics=semantics)
        self.moves = {t.name: t for t in moves}
        self.own = {t.name: t for t in self.net.transitions}
        self.start = Reference(self.net)
        self.names = sorted({p.observes for p in flat.places if isinstance(p, Input)})
        fine = sorted({v for x in grid for v in (x, math.nextafter(x, -math.inf), math.nextafter(x, math.inf))})
        columns = [column.ravel() for column in np.meshgrid(*[fine] * len(self.names))]
        self.grid = Points(self.net, self.start.maths, dict(zip(self.names, columns)))
        self._loose: Points | None = None
        self._fine = fine

    @property
    def loose(self) -> Points:
        """Many points between and beyond those of the grid."""
        if self._loose is None:
            draw = np.random.default_rng(0)
            columns = {}
            for name in self.names:
                near = draw.choice(self._fine, LOOSE)
                some = near + draw.normal(size=LOOSE) * draw.choice([0.01, 0.1, 1.0, 10.0, 100.0], LOOSE)
                columns[name] = np.where(draw.random(LOOSE) < 0.4, near, some)
            self._loose = Points(self.net, self.start.maths, columns)
        return self._loose

    def perform(self, run: Iterable, loop: Iterable = ()) -> Reference | None:
        """The interpreter at the end of a run, None if no values that were tried allow it."""
        cycles: dict[int, list] = {}
        for step in run:
            cycles.setdefault(step.cycle, []).append(step)
        steps, loop = [cycles.get(k, []) for k in range(max(cycles, default=0) + 1)], list(loop)
        found = self._from(self.start, steps, 0, loop, (self.grid,))
        return found if found is not None else self._from(self.start, steps, 0, loop, (self.grid, self.loose))

    def _from(self, state: Reference, cycles: list[list], at: int, loop: list, points: Sequence[Points]) -> Reference | None:
        """Depth first over the values of each cycle; equal ends of a cycle are followed once."""
        seen = set()
        final = at == len(cycles) - 1
        for values in self._values(state, [*cycles[at], *(loop if final else [])], points):
            here = copy.copy(state)
            here.marking = dict(state.marking)
            here.running, here.paused = ({name: list(c) for name, c in clocks.items()} for clocks in (state.running, state.paused))
            try:
                self._cycle(here, cycles[at], values, not final)
                if final:
                    if loop:
                        before = dict(here.marking)
                        self._items(here, loop)
                        if here.marking != before:
                            raise IllegalStep("the loop does not return")
                    return here
            except (IllegalStep, ExpressionError):
                continue
            key = tuple(v for n, v in here.marking.items() if isinstance(here.places[n], Place)), repr(here.running), repr(here.paused)
            if key in seen:
                continue
            seen.add(key)
            found = self._from(here, cycles, at + 1, loop, points)
            if found is not None:
                return found
        return None

    def _values(self, state: Reference, steps: list, points: Sequence[Points]) -> Iterable[dict[str, float]]:
        """One point of each class that lies in the cells that are shown, while the tokens go as the steps say."""
        moments, cells = [state.marking], []
        for step in steps:
            if step.kind == "observed":
                cells.append((len(moments) - 1, *read_cell(step.what)))
            else:
                moments.append(dict.fromkeys(state.marking, 0) | dict(step.marking))
        for some in points:
            for index in some.classes(moments, cells):
                yield some.at(index)

    def _cycle(self, state: Reference, steps: list, values: dict[str, float], whole: bool) -> None:
        """One cycle; `whole`: it ends, and the next begins."""
        for clocks in state.running.values():
            clocks[:] = [c + 1 for c in clocks]
        for place in state.net.places:
            if isinstance(place, Input):
                state.marking[place.name] = values[place.observes]
        state.fired, state.sent, state.may_start = [], [], False
        state.evaluate()
        self._items(state, steps)
        if whole:
            self._settled(state)
            self._start_clocks(state)
            if any(t.is_timed and state.enabled(t) and state.is_due(t) for t in state.net.transitions):
                raise IllegalStep("the cycle ends although something is due")
            state.cycle += 1

    def _items(self, state: Reference, steps: list) -> None:
        for step in steps:
            if step.kind == "observed":
                name, low, high = read_cell(step.what)
                if not low <= state.marking[name] < high:
                    raise IllegalStep(step)
                continue
            if step.kind == "outside":
                t = self.moves[step.what]
                if not state.enabled(t):
                    raise IllegalStep(step)
                kept = {u.name: list(state.running[u.name]) for u in state.net.transitions if u.memory == "resampling" and u.is_timed}
                state.fire(t)
                for u in state.net.transitions:
                    if u.name in kept:  # what is written from outside is no firing
                        state.running[u.name] = kept[u.name]
                        state.adjust(u, state.enabled(u))
            else:
                self._fire(state, self.own[step.what])
            shown = {name: n for name, n in state.marking.items() if isinstance(state.places[name], Place) and n}
            if shown != dict(step.marking):
                raise IllegalStep(step)

    def _fire(self, state: Reference, t: Transition) -> None:
        if not state.enabled(t):
            raise IllegalStep(t.name)
        if t.is_timed:
            self._settled(state)
            self._start_clocks(state)
            due = [u for u in state.net.transitions if u.is_timed and state.enabled(u) and state.is_due(u)]
            if t not in due or t != max(due, key=lambda u: u.priority):
                raise IllegalStep(t.name)
        elif any(u.priority > t.priority and state.enabled(u) for u in state.net.transitions if not u.is_timed):
            raise IllegalStep(t.name)
        state.fire(t)

    def _settled(self, state: Reference) -> None:
        if any(not u.is_timed and state.enabled(u) for u in state.net.transitions):
            raise IllegalStep("something immediate is enabled")

    def _start_clocks(self, state: Reference) -> None:
        if not state.may_start:
            state.may_start = True
            for u in state.net.transitions:
                if u.is_timed:
                    state.adjust(u, state.enabled(u))
