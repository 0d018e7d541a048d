"""A skill, read off the agents' own: the same thresholds, formulas and commands, run as a state machine with registers.

A skill of `cprm_gym.agents.skills` has one token that goes from state to state. Written down as such it is a machine: its places are the
states, its transitions in the order of their priorities the rules, its counters registers; a module in it is a machine called by a state.
So whoever decides, and in whatever structure, acts with the same knowledge of how to run, kick and catch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cprm_gym.architecture.petri import Belief, Command, Continuous, Input, Math, PetriNet, Place, Transition
from cprm_gym.errors import ModelError

from .sheet import Sheet

Mask = NDArray[np.bool_]
NOTHING = -1
MOVES = 16
"""Rules that one cycle may take in a row."""


class Rule(NamedTuple):
    """A transition as a rule of a machine."""

    name: str
    source: int
    """State in which it holds; NOTHING for any."""
    target: int
    """State that follows; NOTHING for the same one."""
    ends: int
    """Outcome in which the skill ends; NOTHING for none."""
    at_least: tuple[tuple[str, float], ...]
    below: tuple[tuple[str, float], ...]
    registers_at_least: tuple[tuple[int, float], ...]
    registers_below: tuple[tuple[int, float], ...]
    adds: tuple[tuple[int, float], ...]
    sets: tuple[tuple[int, float], ...]
    delay: int
    clock: int
    """Column of its clock; NOTHING where it takes no time."""
    emits: int
    """Number of its command; NOTHING for none."""
    awaits: tuple[int, int] | None
    """Module, and the outcome of it that it needs."""
    begins: int
    """Module that it starts; NOTHING for none."""
    breaks: bool
    """Whether it stops the module that runs."""


@dataclass
class State:
    """Of a skill in all worlds."""

    at: NDArray[np.int64]
    """Its state; NOTHING while it does not run."""
    registers: NDArray[np.float64]
    clocks: NDArray[np.int64]
    """Cycles for which a rule that takes time has held; NOTHING where it does not."""
    runs: NDArray[np.int64]
    """The module at work."""
    told: NDArray[np.int64]
    """The outcome of the module that has ended."""
    inner: list[State] = field(default_factory=list)

    def copy(self) -> State:
        """Another one that is equal."""
        return State(*(a.copy() for a in (self.at, self.registers, self.clocks, self.runs, self.told)), [s.copy() for s in self.inner])

    def take(self, worlds: Mask, other: State) -> None:
        """That of `other` in some worlds."""
        for name in ("at", "registers", "clocks", "runs", "told"):
            getattr(self, name)[worlds] = getattr(other, name)[worlds]
        for mine, its in zip(self.inner, other.inner):
            mine.take(worlds, its)


class Step(NamedTuple):
    """What a skill would do in this cycle, for all worlds."""

    state: State
    emits: NDArray[np.int64]
    """Number of the command; NOTHING for none."""
    outcome: NDArray[np.int64]
    """How it has ended; NOTHING while it goes on."""


class Skill:
    """A skill as a machine on a sheet.

    Parameters
    ----------
    name : str
        Of its columns: ``name.quantity``.
    net : PetriNet
        A behaviour module of one token, or of one that calls modules of one.
    sheet : Sheet
        Gets its quantities.
    given : mapping of str to str
        Its parameters that the behaviour around it knows -> columns.

    Attributes
    ----------
    outcomes : tuple of str
        The one that is meant first.
    registers : list of str
        Its counters and outputs.
    commands : list of (str, dict)
        Name, and parameter -> column or number; those of its modules too.

    Raises
    ------
    ModelError
        For a net that does not run as one machine.
    """

    def __init__(self, name: str, net: PetriNet, sheet: Sheet, given: Mapping[str, str]) -> None:
        self.name, self.net, self._sheet = name, net, sheet
        ports = net.ports
        discrete = [p for p in net.places if isinstance(p, Place)]
        ways = {ports.begin, ports.ongoing, ports.done, *ports.errors, *ports.interrupts}
        self._states = [p.name for p in discrete if p.name not in ways and p.name not in ports.outputs and p.capacity == 1]
        self.registers = [p.name for p in discrete if p.name not in ways and p.name not in self._states]
        self._room = {p.name: float(p.capacity) for p in discrete if p.name in self.registers and p.capacity is not None}
        self.outcomes: tuple[str, ...] = tuple(o for o in (ports.done, *ports.errors) if o is not None)
        self._names = _quantities(name, net, sheet, given)
        self.modules = {inner: Skill(f"{name}.{inner}", module, sheet, self._given(inner, module)) for inner, module in net.modules.items()}
        self._order = list(self.modules)
        self.commands: list[tuple[str, dict[str, str | float]]] = []
        self._offset: list[int] = []
        self._clocks = 0
        self._rules = self._read()
        for inner in self._order:
            self._offset.append(len(self.commands))
            self.commands += self.modules[inner].commands

    def _given(self, inner: str, module: PetriNet) -> dict[str, str]:
        fused = {port: self.net.fuse.get(f"{inner}.{port}") for port in module.ports.parameters}
        return {port: self._names[place] for port, place in fused.items() if place is not None}

    # ------------------------------------------------------------------ from the net

    def _read(self) -> list[tuple[int, list[Rule]]]:
        """The rules by the state in which they hold."""
        ports = self.net.ports
        refused = set(ports.interrupts)
        start = next(t for t in self.net.transitions if ports.begin in t.inputs)
        self._initial = [self._states.index(p) for p in start.outputs if p in self._states]
        if len(self._initial) != 1:
            raise ModelError(f"skill {self.name!r}: {start.name!r} marks {len(self._initial)} states; a machine is in one")
        self._counted = [float({**start.outputs, **start.sets}.get(p, 0.0)) for p in self.registers]
        self._begins = self._begun(start)
        rules = [
            self._rule(t) for t in self.net.transitions
            if t is not start and not refused & set(t.inputs) and not any(p.startswith("stopping_") for p in t.inputs)
        ]  # fmt: skip
        order = sorted(rules, key=lambda pair: -pair[0])  # stable: equal ones stay as they were written
        return [(at, [rule for _, rule in order if rule.source == at]) for at in (NOTHING, *range(len(self._states)))]

    def _begun(self, t: Transition) -> int:
        return next((k for k, inner in enumerate(self._order) if f"{inner}.{self.modules[inner].net.ports.begin}" in t.outputs), NOTHING)

    def _rule(self, t: Transition) -> tuple[int, Rule]:
        ports = self.net.ports
        sources = [self._states.index(p) for p in t.inputs if p in self._states]
        if len(sources) > 1:
            raise ModelError(f"skill {self.name!r}: {t.name!r} leaves {len(sources)} states at once; a machine is in one")
        targets = [self._states.index(p) for p in t.outputs if p in self._states]
        ends = [self.outcomes.index(p) for p in t.outputs if p in self.outcomes]
        awaits = None
        for k, inner in enumerate(self._order):
            for o, outcome in enumerate(self.modules[inner].outcomes):
                if f"{inner}.{outcome}" in t.inputs:
                    awaits = (k, o)
        emits, clock = NOTHING, NOTHING
        if t.emits is not None:
            emits = len(self.commands)
            self.commands.append(self._command(t.emits))
        if t.delay:
            clock, self._clocks = self._clocks, self._clocks + 1
        count = self.registers.index
        consumed = [(count(p), float(w)) for p, w in t.inputs.items() if p in self.registers]
        adds = [(r, -w) for r, w in consumed] + [(count(p), float(w)) for p, w in t.outputs.items() if p in self.registers]
        quantities = [p for p in (*t.tests, *t.inhibitors) if p in self._names]
        rule = Rule(
            t.name, sources[0] if sources else NOTHING, targets[0] if targets else NOTHING, ends[0] if ends else NOTHING,
            tuple((self._names[p], float(v)) for p, v in t.tests.items() if p in quantities),
            tuple((self._names[p], float(v)) for p, v in t.inhibitors.items() if p in quantities),
            (*consumed, *((count(p), float(v)) for p, v in t.tests.items() if p in self.registers)),
            (
                *((count(p), float(v)) for p, v in t.inhibitors.items() if p in self.registers),
                *((count(p), self._room[p] - w + 1.0) for p, w in t.outputs.items() if p in self._room),
            ),
            tuple(adds), tuple((count(p), float(v)) for p, v in t.sets.items() if p in self.registers),
            t.delay, clock, emits, awaits, self._begun(t),
            any(f"{inner}.{i}" in t.outputs for inner in self._order for i in self.modules[inner].net.ports.interrupts),
        )  # fmt: skip
        known = {*ports.outputs, *self._states, *self.registers, *self._names, ports.ongoing, ports.begin, *ports.interrupts}
        for place in (*t.tests, *t.inhibitors):
            if place not in known:
                raise ModelError(f"skill {self.name!r}: {t.name!r} asks for the tokens of {place!r}, which a machine does not have")
        return t.priority, rule

    def _command(self, command: Command) -> tuple[str, dict[str, str | float]]:
        return command.name, {k: self._names[v] if isinstance(v, str) else float(v) for k, v in command.params.items()}

    # ------------------------------------------------------------------ at work

    def idle(self, worlds: int) -> State:
        """The state in which it does not run."""
        nothing = np.full(worlds, NOTHING, np.int64)
        return State(
            nothing.copy(), np.zeros((worlds, len(self.registers))), np.full((worlds, self._clocks), NOTHING, np.int64), nothing.copy(),
            nothing.copy(), [self.modules[inner].idle(worlds) for inner in self._order],
        )  # fmt: skip

    def begun(self, worlds: int) -> State:
        """The state in which it begins."""
        state = self.idle(worlds)
        state.at[:], state.registers[:] = self._initial[0], self._counted
        if self._begins != NOTHING:
            self._call(state, self._begins, np.ones(worlds, np.bool_))
        return state

    def _call(self, state: State, module: int, worlds: Mask) -> None:
        state.runs[worlds], state.told[worlds] = module, NOTHING
        state.inner[module].take(worlds, self.modules[self._order[module]].begun(len(worlds)))

    def advance(self, state: State) -> Step:
        """One cycle from a state, which stays as it is; the sheet is filled."""
        s, n = state.copy(), len(state.at)
        emits, outcome = np.full(n, NOTHING, np.int64), np.full(n, NOTHING, np.int64)
        worked = np.zeros((n, len(self._order)), np.bool_)
        self._tick(s, first=True)
        for _ in range(MOVES):
            moved = False
            for at, rules in self._rules:
                free = s.at >= 0 if at == NOTHING else s.at == at
                for rule in rules:
                    if not free.any():
                        break
                    fires = free & self._holds(rule, s)
                    if fires.any():
                        moved = True
                        free &= ~fires
                        self._fire(rule, fires, s, worked, emits, outcome)
            # what interrupts a module goes before the module's own cycle
            if not self._work(s, worked, emits) and not moved:
                break
        self._tick(s, first=False)
        return Step(s, emits, outcome)

    def _work(self, s: State, worked: NDArray[np.bool_], emits: NDArray[np.int64]) -> bool:
        """The modules at work take their cycle; whether any did."""
        any_due = False
        for k, inner in enumerate(self._order):
            due = (s.at >= 0) & (s.runs == k) & ~worked[:, k]
            if due.any():
                any_due = True
                step = self.modules[inner].advance(s.inner[k])
                s.inner[k].take(due, step.state)
                sends = due & (step.emits >= 0)
                emits[sends] = step.emits[sends] + self._offset[k]
                ended = due & (step.outcome >= 0)
                s.told[ended] = step.outcome[ended]
                worked[due, k] = True
        return any_due

    def _holds(self, rule: Rule, s: State) -> Mask:
        """Where a rule would be taken, in whatever state."""
        holds = self._enabled(rule, s)
        if rule.clock != NOTHING:
            holds = holds & (s.clocks[:, rule.clock] >= rule.delay)
        return holds

    def _enabled(self, rule: Rule, s: State) -> Mask:
        holds = np.ones(len(s.at), np.bool_)
        for name, least in rule.at_least:
            holds &= self._sheet[name] >= least
        for name, most in rule.below:
            holds &= self._sheet[name] < most
        for register, least in rule.registers_at_least:
            holds &= s.registers[:, register] >= least
        for register, most in rule.registers_below:
            holds &= s.registers[:, register] < most
        if rule.awaits is not None:
            holds &= (s.runs == rule.awaits[0]) & (s.told == rule.awaits[1])
        return holds

    def _fire(
        self, rule: Rule, where: Mask, s: State, worked: NDArray[np.bool_], emits: NDArray[np.int64], outcome: NDArray[np.int64]
    ) -> None:
        if rule.source != NOTHING:
            for _, rules in self._rules:
                for other in rules:  # whatever waited in that state begins to wait anew
                    if other.clock != NOTHING and other.source == rule.source:
                        s.clocks[where, other.clock] = NOTHING
        for register, by in rule.adds:
            s.registers[where, register] += by
        for register, value in rule.sets:
            s.registers[where, register] = value
        if rule.emits != NOTHING:
            emits[where] = rule.emits
        if rule.awaits is not None:
            s.runs[where] = s.told[where] = NOTHING
        if rule.breaks:
            module = int(s.runs[where][0])  # all are in one state, so it is the same one
            s.told[where], worked[where, module] = self.modules[self._order[module]].outcomes.index("aborted"), True
        if rule.begins != NOTHING:
            self._call(s, rule.begins, where)
            worked[where, rule.begins] = False
        if rule.ends != NOTHING:
            outcome[where], s.at[where] = rule.ends, NOTHING
        elif rule.target != NOTHING:
            s.at[where] = rule.target

    def _tick(self, s: State, first: bool) -> None:
        """The clocks of the rules that take time: they run while the rule holds."""
        for at, rules in self._rules:
            for rule in rules:
                if rule.clock != NOTHING:
                    clock = s.clocks[:, rule.clock]
                    holds = ((s.at >= 0) if at == NOTHING else (s.at == at)) & self._enabled(rule, s)
                    s.clocks[:, rule.clock] = np.where(holds, clock + 1 if first else np.maximum(clock, 0), NOTHING)


def _quantities(name: str, net: PetriNet, sheet: Sheet, given: Mapping[str, str]) -> dict[str, str]:
    """Adds the quantities of a net to a sheet; place -> column."""
    names = dict(given)
    for place in net.places:
        if place.name in given or isinstance(place, Place):
            continue
        if isinstance(place, Input):
            names[place.name] = sheet.observe(place.observes)
        elif isinstance(place, Continuous):
            names[place.name] = sheet.constant(f"{name}.{place.name}", place.value)
        elif isinstance(place, Math):
            names[place.name] = f"{name}.{place.name}"
        elif isinstance(place, Belief):
            raise ModelError(f"skill {name!r}: {place.name!r} is a belief; a machine is given what it knows")
    for place in net.places:
        if isinstance(place, Math) and place.name not in given:
            sheet.derive(names[place.name], place.expression, names)
    return names
