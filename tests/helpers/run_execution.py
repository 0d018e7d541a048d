"""Runs that analysis shows, performed by the reference interpreter with values that are observed, found by trying."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from reference_interpreter import Reference
from run_replay import read_cell

from cprm_gym.architecture.petri import Input, PetriNet, Place, Ports, Transition, flatten
from cprm_gym.errors import ExpressionError


class IllegalStep(Exception):
    """The interpreter cannot do what the run says."""


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
        self.observes = {p.name: p.observes for p in flat.places if isinstance(p, Input)}
        self.names = sorted({p.observes for p in flat.places if isinstance(p, Input)})
        fine = {v for x in grid for v in (x, math.nextafter(x, -math.inf))}
        self.values = [dict(zip(self.names, point)) for point in itertools.product(*([sorted(fine)] * len(self.names)))]

    def perform(self, run: Iterable, loop: Iterable = ()) -> Reference | None:
        """The interpreter at the end of a run, None if no values that were tried allow it."""
        steps, loop = list(run), list(loop)
        cycles: dict[int, list] = {}
        for step in steps:
            cycles.setdefault(step.cycle, []).append(step)
        last = max(cycles, default=0)
        start = Reference(self.net)
        return self._from(start, [cycles.get(k, []) for k in range(last + 1)], 0, loop)

    def _from(self, state: Reference, cycles: list[list], at: int, loop: list) -> Reference | None:
        """Depth first over the values of each cycle; equal ends of a cycle are followed once."""
        seen = set()
        for values in self._values(cycles[at]):
            here = copy.copy(state)
            here.marking = dict(state.marking)
            here.running, here.paused = ({name: list(c) for name, c in clocks.items()} for clocks in (state.running, state.paused))
            try:
                final = at == len(cycles) - 1
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
            key = (tuple(here.marking[n] for n in sorted(here.places)), repr(here.running), repr(here.paused))
            key = tuple(v for n, v in here.marking.items() if isinstance(here.places[n], Place)), *key[1:]
            if key in seen:
                continue
            seen.add(key)
            found = self._from(here, cycles, at + 1, loop)
            if found is not None:
                return found
        return None

    def _values(self, steps: list) -> list[dict[str, float]]:
        """The values that lie in the cells in which inputs are found."""
        cells = [read_cell(step.what) for step in steps if step.kind == "observed"]
        shown = [(self.observes[name], low, high) for name, low, high in cells if name in self.observes]
        return [values for values in self.values if all(low <= values[name] < high for name, low, high in shown)]

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
