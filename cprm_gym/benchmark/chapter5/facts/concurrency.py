"""The same k concurrent skills as one machine, as machines side by side, and as a net (dissertation §5.3.1): how large each becomes.

A skill rests; while its signal is there it works, and sends its command; then it recovers for a cycle. The skills share nothing, which is
the case in which a product machine has most to write down.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ....architecture.analysis.budget import Budget
from ....architecture.analysis.report import analyze
from ....architecture.equivalences import MachineRunner, Rule, StateMachine
from ....architecture.petri import Command, Executor, Input, PetriNet, Place, Transition
from ....errors import ParameterError

STATES = ("rest", "work", "recover")
MOVES = (
    ("rest", 1, "work", True), ("rest", 0, "rest", False), ("work", 1, "work", True), ("work", 0, "recover", False),
    ("recover", None, "rest", False),
)  # fmt: skip
"""(state, signal or None for any, next state, whether it sends) of one skill."""
FORMS = ("product machine", "subsumption", "net")
CYCLES = 200
"""Cycles of random signals on which they are compared."""
SECONDS = 20.0
"""That an analysis may take."""


class Product(NamedTuple):
    """One machine for all k skills."""

    rules: Mapping[tuple[int, ...], tuple[tuple[tuple[int | None, ...], tuple[int, ...], tuple[int, ...]], ...]]
    """State -> (signals, next state, skills that send)."""

    def step(self, state: tuple[int, ...], signals: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The next state, and who sends."""
        for wanted, to, sends in self.rules[state]:
            if all(w is None or w == s for w, s in zip(wanted, signals)):
                return to, sends
        raise ParameterError(f"product machine: no rule of {state} for {signals}")


def product(k: int) -> Product:
    """Every state with a rule for each combination of what the skills can do."""
    of_state = [[(signal, STATES.index(to), sends) for source, signal, to, sends in MOVES if source == state] for state in STATES]
    rules = {}
    for state in itertools.product(range(len(STATES)), repeat=k):
        rules[state] = tuple(
            (tuple(m[0] for m in moves), tuple(m[1] for m in moves), tuple(i for i, m in enumerate(moves) if m[2]))
            for moves in itertools.product(*(of_state[s] for s in state))
        )
    return Product(rules)


def layers(k: int) -> list[StateMachine]:
    """A machine for each skill, side by side, as the layers of a subsumption architecture that suppress nothing of each other."""
    when = {1: "signal > 0", 0: "signal <= 0", None: ""}
    return [
        StateMachine(
            f"skill_{i}", STATES,
            tuple(Rule(a, b, when[s], Command(f"work_{i}") if sends else None) for a, s, b, sends in MOVES),
            percepts={"signal": f"signal_{i}"},
        )
        for i in range(k)
    ]  # fmt: skip


def net(k: int) -> PetriNet:
    """The skills side by side in one net, a token in each."""
    places: list[Any] = []
    transitions = []
    for i in range(k):
        places.append(Input(f"signal_{i}", observes=f"signal_{i}"))
        for state in STATES:
            places += [Place(f"{state}_{i}", capacity=1, tokens=int(state == "rest")), Place(f"{state}_{i}.next", capacity=1)]
            transitions.append(Transition(f"{state}_{i}.tick", (f"{state}_{i}.next",), (f"{state}_{i}",), delay=1))
        for number, (source, signal, to, sends) in enumerate(MOVES):
            transitions.append(
                Transition(
                    f"move_{i}_{number}",
                    (f"{source}_{i}",),
                    (f"{to}_{i}.next",),
                    tests={f"signal_{i}": 1} if signal == 1 else {},
                    inhibitors={f"signal_{i}": 1} if signal == 0 else {},
                    emits=Command(f"work_{i}") if sends else None,
                ),
            )
    return PetriNet(f"skills_{k}", tuple(places), tuple(transitions))


def sent_by(form: str, k: int, signals: np.ndarray) -> list[frozenset[int]]:
    """Who sends in each cycle.

    Parameters
    ----------
    form : str
        Of `FORMS`.
    k : int
    signals : (cycles, k) int array of 0 and 1
    """
    if form == "product machine":
        machine, state, sent = product(k), (0,) * k, []
        for row in signals.tolist():
            state, sends = machine.step(state, tuple(row))
            sent.append(frozenset(sends))
        return sent
    if form == "subsumption":
        runners = [MachineRunner(machine) for machine in layers(k)]
        return [frozenset(i for i, r in enumerate(runners) if r.step({f"signal_{i}": float(row[i])})) for row in signals]
    executor = Executor(net(k), 1)
    found = []
    for row in signals:
        commands = executor.step({f"signal_{i}": np.array([float(row[i])]) for i in range(k)})
        found.append(frozenset(i for i in range(k) if f"work_{i}" in commands.of(0)))
    return found


def measure(k: int, form: str, seed: int) -> dict[str, Any]:
    """Size, time to make and to analyse, and whether it acts as the net does.

    Parameters
    ----------
    k : int
    form : str
        Of `FORMS`.
    seed : int
        Of the signals.

    Returns
    -------
    dict
        ``states``, ``transitions``, ``lines`` (one for each of both), ``build`` and ``analyse`` in CPU seconds, ``explored`` markings or
        states that the analysis went through, ``whole`` whether it came to its end, ``apart`` CPU seconds to analyse skill by skill, None
        where the form has no parts; ``alike``.
    """
    signals = (np.random.default_rng([seed, k]).random((CYCLES, k)) < 0.5).astype(int)
    clock = time.process_time
    analyze(net(1), contract=False)  # what has to be compiled is
    begin = clock()
    made: Any = {"product machine": product, "subsumption": layers, "net": net}[form](k)
    build = clock() - begin
    begin = clock()
    apart: float | None = None
    if form == "net":
        states, transitions = len(made.places) - k, len(made.transitions)
        report = analyze(made, budget=Budget(seconds=SECONDS), contract=False)
        explored = report.timed.nodes if report.timed is not None else report.untimed.states
        whole = bool(report.timed is not None and report.timed.complete)
        analyse = clock() - begin
        begin = clock()
        for _ in range(k):
            analyze(net(1), budget=Budget(seconds=SECONDS), contract=False)
        apart = clock() - begin
    else:
        machine = made if form == "product machine" else product(k)
        explored, whole = len(_reached(machine, k)), True
        analyse = clock() - begin
        if form == "product machine":
            states, transitions = len(made.rules), sum(map(len, made.rules.values()))
        else:
            states, transitions = sum(len(m.states) for m in made), sum(len(m.rules) for m in made)
    alike = sent_by(form, k, signals) == sent_by("net", k, signals)
    return {
        "states": states, "transitions": transitions, "lines": states + transitions, "build": build, "analyse": analyse,
        "explored": explored, "whole": whole, "apart": apart, "alike": alike,
    }  # fmt: skip


def _reached(machine: Product, k: int) -> set[tuple[int, ...]]:
    """States of a product machine that can be reached under any signals."""
    found, fresh = {(0,) * k}, [(0,) * k]
    while fresh:
        for _, to, _ in machine.rules[fresh.pop()]:
            if to not in found:
                found.add(to)
                fresh.append(to)
    return found
