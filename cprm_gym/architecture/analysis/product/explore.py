"""The reachable states of a net in a world."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ....errors import NetError, did_you_mean
from ...petri import CompiledNet, Executor, PetriNet, PlaceKind, compile_net
from ...petri.execution.state import Snapshot
from ..bounded.interval_chain import IntervalChain
from ..budget import Budget
from ..markov.chain import MarkovChain
from .worlds import World, heeded

UNEXPLORED = "unexplored"
"""The outcome of runs that come to where the budget ended."""
BATCH = 512
"""States that the net is run from at once."""
STATES = 200_000
"""States of a product unless a budget says otherwise."""


@dataclass(frozen=True, eq=False)
class Product:
    """A net in its world, as a chain.

    Attributes
    ----------
    chain : MarkovChain
        With the world's likeliest chances.
    bounded : IntervalChain
        With the intervals within which they lie.
    states : tuple of (int, world state)
        Net state (row of `markings`) and world state of each; of an outcome (-1, its name).
    markings : tuple of mappings
        Marked places of each net state, and the clocks that run.
    commands : tuple of tuples of str
        What goes out in each state.
    complete : bool
        Whether all reachable states are there.
    ended : mapping of int to int
        State in whose cycle the net comes to an outcome -> the net state (row of `markings`) in which it then is.
    """

    chain: MarkovChain
    bounded: IntervalChain
    states: tuple[tuple[int, Hashable], ...]
    markings: tuple[Mapping[str, float], ...]
    commands: tuple[tuple[str, ...], ...]
    complete: bool
    ended: Mapping[int, int] = field(default_factory=dict)

    def tell(self, run: Sequence[int]) -> list[str]:
        """A run of the chain in words, cycle by cycle."""
        return [
            f"cycle {t}: {self.chain.name(s)}" + (f" -> {', '.join(self.commands[s])}" if self.commands[s] else "")
            for t, s in enumerate(run)
        ]


def product(
    net: PetriNet | CompiledNet, world: World, outcomes: Mapping[str, str], *, budget: Budget | None = None,
    begun: Sequence[tuple[Mapping[str, float], Hashable]] = (),
) -> Product:  # fmt: skip
    """Run a net from every state that it can reach in a world.

    Parameters
    ----------
    net : PetriNet or CompiledNet
        Deterministic: its choices have no random ones.
    world : World
    outcomes : mapping of str to str
        Outcome -> the place whose mark ends the run; the first that is marked counts.
    budget : Budget, optional
        Its states (default `STATES`) and seconds; where they end the chain has the outcome `UNEXPLORED`.
    begun : sequence of (marking, world state), optional
        Where it begins, all equally likely, instead of with the net's own marking where the world does; a marking names the tokens.

    Raises
    ------
    NetError
        For a place that is not there, a percept that the world does not give, or random choices.
    """
    limits, clock = (budget or Budget(states=STATES)).start()
    runner, heeds = NetStates(net, outcomes), heeded(world)
    index: dict[tuple[int, Hashable], int] = {}
    ends = {name: k for k, name in enumerate(outcomes)}
    states: list[tuple[int, Hashable]] = [(-1, name) for name in outcomes]
    rows: list[list[tuple[int, float, float, float]]] = [[] for _ in outcomes]
    commands: list[tuple[str, ...]] = [() for _ in outcomes]

    def number(key: tuple[int, Hashable]) -> int:
        own = world.ended(key[1])
        if own:  # the world's own outcome
            key = (-1, own)
            if own not in ends:
                ends[own] = index[key] = len(states)
            elif key not in index:
                index[key] = ends[own]
        if key not in index or index[key] == len(states):
            index[key] = len(states)
            states.append(key)
            rows.append([])
            commands.append(())
        return index[key]

    initial: dict[int, float] = {}
    starts = [(0, s, p) for s, p in world.start()] if not begun else [(runner.number(m), s, 1.0 / len(begun)) for m, s in begun]
    for m, state, p in starts:
        i = number((m, state))
        initial[i] = initial.get(i, 0.0) + p
    done, came = len(outcomes), dict[int, int]()
    while done < len(states) and len(states) < limits.states and not clock.spent():
        last = min(done + BATCH, len(states))
        chunk = [i for i in range(done, last) if states[i][0] >= 0]
        after, fired, ended = runner.step([states[i][0] for i in chunk], [world.percepts(states[i][1]) for i in chunk])
        for k, i in enumerate(chunk):
            at = states[i][1]
            commands[i] = fired[k]
            if ended[k] is not None:
                rows[i] = [(ends[str(ended[k])], 1.0, 1.0, 1.0)]
                came[i] = after[k]
                continue
            merged: dict[int, tuple[float, float, float]] = {}
            for step in world.next(at, fired[k] + runner.marks(after[k], heeds)):
                j = number((after[k], step.state))
                a, b, c = merged.get(j, (0.0, 0.0, 0.0))
                merged[j] = (a + step.chance, b + step.low, min(1.0, c + step.high))
            rows[i] = [(j, *values) for j, values in merged.items()]
        done = last
    complete = done == len(states)
    final = {name: [k] for name, k in ends.items()}
    if not complete:
        final[UNEXPLORED] = [i for i in range(done, len(states)) if states[i][0] >= 0]
    return replace(_assembled(rows, final, initial, states, runner.markings, commands, world, complete), ended=came)


def _assembled(
    rows: list[list[tuple[int, float, float, float]]], final: dict[str, list[int]], initial: dict[int, float],
    states: list[tuple[int, Hashable]], markings: list[Mapping[str, float]], commands: list[tuple[str, ...]], world: World, complete: bool,
) -> Product:  # fmt: skip
    offsets = np.cumsum([0, *map(len, rows)])
    flat = [edge for row in rows for edge in row]
    targets = np.array([e[0] for e in flat], np.int32)
    chances, low, high = (np.array([e[k] for e in flat], float) for k in (1, 2, 3))
    start = np.zeros(len(states))
    for i, p in initial.items():
        start[i] = p
    outcomes = {name: np.array(at, np.int64) for name, at in final.items()}

    def name(i: int) -> str:
        m, w = states[i]
        if m < 0:
            return str(w)
        marked = " ".join(f"{place}{'' if n == 1 else f'={n:g}'}" for place, n in markings[m].items())
        return f"[{marked}] {world.name(w)}"

    chain = MarkovChain(offsets, targets, chances, outcomes, start, name)
    bounded = IntervalChain(offsets, targets, low, high, outcomes, start, name)
    return Product(chain, bounded, tuple(states), tuple(markings), tuple(commands), complete)


class NetStates:
    """The states of a net, numbered, and what one cycle makes of them.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    outcomes : mapping of str to str
        Outcome -> place.
    batch : int

    Raises
    ------
    NetError
    """

    def __init__(self, net: PetriNet | CompiledNet, outcomes: Mapping[str, str], batch: int = BATCH) -> None:
        self.net = net if isinstance(net, CompiledNet) else compile_net(net)
        if self.net.net.semantics.choice == "random":
            raise NetError(f"net {self.net.net.name!r} draws among transitions; the product follows deterministic nets")
        names = self.net.place_names
        for outcome, place in outcomes.items():
            if place not in names:
                raise NetError(f"outcome {outcome!r}: unknown place {place!r}.{did_you_mean(place, names)}")
        self.executor = Executor(self.net, batch)
        self.batch = batch
        kinds = np.asarray(self.net.kind)
        self._kept = np.flatnonzero(np.isin(kinds, [PlaceKind.DISCRETE, PlaceKind.OBJECT, PlaceKind.CONTINUOUS]))
        self._shown = np.flatnonzero(kinds == PlaceKind.DISCRETE)
        self._ends = [(outcome, self.net.place(place)) for outcome, place in outcomes.items()]
        self._first = self.executor.snapshot()
        self._index: dict[bytes, int] = {}
        self._rows: list[NDArray[np.float64]] = []
        self._clocks: list[NDArray[np.int32]] = []
        self.markings: list[Mapping[str, float]] = []
        """Marked places of each net state; state 0 is the initial one."""
        self._number(self._first.row[0], self._first.clock[0])

    def number(self, marking: Mapping[str, float]) -> int:
        """The net state with these tokens, no others, and no clock running."""
        row, names = self._first.row[0].copy(), self.net.place_names
        row[self._shown] = 0.0
        for k in self._shown:
            row[k] = marking.get(names[k], 0.0)
        return self._number(row, self._first.clock[0])

    def _number(self, row: NDArray[np.float64], clock: NDArray[np.int32]) -> int:
        key = row[self._kept].tobytes() + clock.tobytes()
        if key not in self._index:
            self._index[key] = len(self._rows)
            self._rows.append(row.copy())
            self._clocks.append(clock.copy())
            names = self.net.place_names
            marked = {names[k]: float(row[k]) for k in self._shown if row[k]}
            running = {f"clock {k}": float(c) for k, c in enumerate(clock) if c > 0}
            self.markings.append({**marked, **running})
        return self._index[key]

    def step(
        self, numbers: Sequence[int], percepts: Sequence[Mapping[str, float]]
    ) -> tuple[list[int], list[tuple[str, ...]], list[str | None]]:
        """One cycle from net states with percepts.

        Returns
        -------
        (net states after it, commands, outcomes that it ended in or None)

        Raises
        ------
        NetError
            When a percept is missing.
        """
        count = len(numbers)
        if not count:
            return [], [], []
        if count > self.batch:
            raise NetError(f"{count} states at once; the batch is {self.batch}")
        row, clock = self._first.row.copy(), self._first.clock.copy()
        row[:count] = [self._rows[m] for m in numbers]
        clock[:count] = [self._clocks[m] for m in numbers]
        self.executor.restore(self._first._replace(row=row, clock=clock))
        self.executor.observe({name: self._column(name, percepts) for name in self.executor.input_names})
        if self.executor.belief_names:
            self.executor.believe({name: self._column(name, percepts) for name in self.executor.belief_names})
        sent = self.executor.run()
        found: Snapshot = self.executor.snapshot()
        fired = [tuple(c for c in self.executor.command_names if sent.fired[c][k]) for k in range(count)]
        ended = [next((o for o, place in self._ends if found.row[k, place] > 0), None) for k in range(count)]
        return [self._number(found.row[k], found.clock[k]) for k in range(count)], fired, ended

    def marks(self, number: int, heeds: Sequence[str]) -> tuple[str, ...]:
        """What a world is told that heeds some places: ``"turns=2"`` for each that is marked in a net state."""
        marking = self.markings[number]
        return tuple(f"{place}={marking[place]:g}" for place in heeds if place in marking)

    def _column(self, name: str, percepts: Sequence[Mapping[str, float]]) -> NDArray[np.float64]:
        if percepts and name not in percepts[0]:
            raise NetError(f"net {self.net.net.name!r} observes {name!r}; the world gives {', '.join(percepts[0]) or 'nothing'}")
        column = np.zeros(self.batch)
        column[: len(percepts)] = [p[name] for p in percepts]
        return column
