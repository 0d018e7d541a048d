"""A net as one state machine: the product of everything in it that runs at once (dissertation §5.3.1).

A state of the machine is a marking of the net's tokens with its running clocks; a rule of it is one whole cycle of the net, from what it
asks of the quantities that come from outside to the commands that it sends. Two nets that have nothing to do with each other give a
product of states, which is what makes such a machine large: `ProductMachine.explore` counts as far as a budget goes. `ProductRunner`
plays with it and knows of no net: it asks the questions of a state one after the other, sends and goes on to the next state. A machine
need not be known to its end for that: rules that were never needed are made when they are.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import LivelockError, NetError, did_you_mean
from .expressions import Assembler, Code, Expression
from .expressions.interpreter import interpret
from .expressions.kernels import run_rows
from .petri import CompiledNet, Continuous, Memory, ObjectPlace, PetriNet, Place, compile_net
from .petri.execution.program import Program, build

Marking = tuple[int, ...]
Array = NDArray[np.float64]
OFF = -1
"""A clock that does not run."""
NOWHERE = -1
"""Where a rule leads by which the net goes on firing within one instant without end."""


class Question(NamedTuple):
    """Whether a quantity is at least a number."""

    quantity: int
    least: float


class Sent(NamedTuple):
    """A command of a rule."""

    command: int
    values: tuple[tuple[int, int | None, float], ...]
    """Column of a parameter, the quantity that it has (None for a number), the number."""


class Outcome(NamedTuple):
    """The end of a rule."""

    state: int
    sends: tuple[Sent, ...]


@dataclass
class Branch:
    """A question of a state, and what follows on yes and no; None where that was not needed yet."""

    question: Question
    yes: Branch | Outcome | None = None
    no: Branch | Outcome | None = None


class _Open(Exception):
    """A cycle that hangs on a question."""

    def __init__(self, question: Question) -> None:
        super().__init__()
        self.question = question


class Explored(NamedTuple):
    """How large a machine is."""

    states: int
    """Found, whatever is observed."""
    expanded: int
    """Of them, those all of whose rules were written down."""
    rules: int
    endless: int
    """Further rules that would lead `NOWHERE`: answers that do not go together."""
    complete: bool
    """Whether nothing is left."""
    seconds: float
    """CPU time."""


class Quantities:
    """What the questions are about: observed quantities, and what the net derives of them while it holds certain tokens.

    Parameters
    ----------
    net : CompiledNet
    """

    def __init__(self, net: CompiledNet) -> None:
        self._places, self._index = net.net.places, net.place_index
        self._texts = {net.place_index[p.name]: Expression(p.expression) for p in net.math}
        self._tokens: dict[int, tuple[int, ...]] = {}
        for place, text in self._texts.items():  # in the order of evaluation
            read = [self._index[name] for name in text.names]
            held = [
                p for other in read for p in (self._tokens.get(other, ()) if other in self._texts else (other,) if net.moved[other] else ())
            ]
            self._tokens[place] = tuple(dict.fromkeys(held))
        self._numbers: dict[tuple[int, Marking], int] = {}
        self.parts: list[tuple[int, Marking, Code | None, tuple[int | float, ...]]] = []
        """Of each: place, the tokens that it reads, code, and what the code reads: quantities (int) and numbers (float)."""

    def of(self, place: int, tokens: Mapping[int, int]) -> int | float:
        """The number of a quantity as it is in a marking (int), or its value where nothing from outside is in it (float)."""
        there = self._places[place]
        if isinstance(there, Place):
            return float(tokens[place])
        if isinstance(there, Continuous):
            return float(there.value)
        held = tuple(tokens[p] for p in self._tokens.get(place, ()))
        if (place, held) in self._numbers:
            return self._numbers[place, held]
        code: Code | None = None
        read: tuple[int | float, ...] = ()
        if place in self._texts:
            text = self._texts[place]
            read = tuple(self.of(self._index[name], tokens) for name in text.names)
            if all(isinstance(value, float) for value in read):
                return interpret(text.tree, dict(zip(text.names, read)))
            assembler = Assembler(text.names.index)
            assembler.add(text.tree)
            code = assembler.finish()
        self._numbers[place, held] = len(self.parts)
        self.parts.append((place, held, code, read))
        return self._numbers[place, held]

    def name(self, quantity: int) -> str:
        """Place, and the tokens that it is of: ``gaze[passing.ongoing=1]``."""
        place, held, _, _ = self.parts[quantity]
        return self._places[place].name + "".join(f"[{self._places[p].name}={v}]" for p, v in zip(self._tokens.get(place, ()), held))


class Values:
    """The quantities of a cycle, in all worlds, worked out when they are asked for.

    Parameters
    ----------
    quantities : Quantities
    given : mapping of int to (W,) array
        Observed and believed places.
    """

    def __init__(self, quantities: Quantities, given: Mapping[int, Array]) -> None:
        self._quantities, self._given, self._known = quantities, given, dict[int, Array]()

    def of(self, quantity: int) -> Array:
        """(W,) float64; NaN where it is not defined."""
        if quantity not in self._known:
            place, _, code, read = self._quantities.parts[quantity]
            if code is None:
                self._known[quantity] = self._given[place]
            else:
                columns = [self.of(r) if isinstance(r, int) else r for r in read]
                count = next(len(c) for c in columns if isinstance(c, np.ndarray))
                rows, out = np.empty((count, len(columns))), np.empty(count)
                for k, column in enumerate(columns):
                    rows[:, k] = column
                run_rows(code.code, code.constants, 0, len(code.code), rows, np.zeros(code.depth + 1), out)
                self._known[quantity] = out
        return self._known[quantity]


class ProductMachine:
    """The state machine that a net is.

    Parameters
    ----------
    net : PetriNet or CompiledNet
        Without object places and random choice, every transition with one server and enabling memory.
    exclusive : sequence of sequences of str
        Commands of which one goes out in a cycle, as for `Executor`.

    Attributes
    ----------
    states : list
        (tokens of the discrete places, clocks of the timed transitions); the first is where it begins.

    Raises
    ------
    NetError
        For a net that has more than that.
    """

    def __init__(self, net: PetriNet | CompiledNet, exclusive: Sequence[Sequence[str]] = ()) -> None:
        self.net = net if isinstance(net, CompiledNet) else compile_net(net)
        flat = self.net.net
        if any(isinstance(p, ObjectPlace) for p in flat.places) or flat.semantics.choice == "random":
            raise NetError(f"net {flat.name!r}: object places and random choice have no state machine")
        timed = np.flatnonzero(self.net.delay > 0)
        if (self.net.memory[timed] != Memory.ENABLING).any() or (self.net.servers[timed] != 1).any():
            raise NetError(f"net {flat.name!r}: a state machine needs transitions of one server with enabling memory")
        program, self.layout = build(self.net, {}, exclusive)
        self.quantities = Quantities(self.net)
        self._rule = _Rule(self.net, program, self.quantities, timed.tolist())
        self.states: list[tuple[Marking, Marking]] = [self._rule.start]
        self._number = {self._rule.start: 0}
        self._roots: list[Branch | Outcome | None] = [None]

    def _reach(self, state: tuple[Marking, Marking]) -> int:
        if state not in self._number:
            self._number[state] = len(self.states)
            self.states.append(state)
            self._roots.append(None)
        return self._number[state]

    def _grow(self, state: int, known: Mapping[int, tuple[float, float]]) -> Branch | Outcome:
        try:
            found = self._rule.cycle(self.states[state], known)
        except _Open as still:
            return Branch(still.question)
        return Outcome(NOWHERE, ()) if found is None else Outcome(self._reach(found[0]), found[1])

    def decide(self, state: int, values: Values, world: int) -> Outcome:
        """The rule that a state takes in a world."""
        known: dict[int, tuple[float, float]] = {}
        node = self._roots[state]
        if node is None:
            node = self._roots[state] = self._grow(state, known)
        while isinstance(node, Branch):
            quantity, least = node.question
            holds = bool(values.of(quantity)[world] >= least)
            known[quantity] = _narrowed(known.get(quantity), least, holds)
            following = node.yes if holds else node.no
            if following is None:
                following = self._grow(state, known)
                if holds:
                    node.yes = following
                else:
                    node.no = following
            node = following
        return node

    def explore(self, seconds: float = 10.0, states: int = 1_000_000) -> Explored:
        """Write down rules, state by state, whatever may be observed, until all are there or the budget is spent.

        Each question may be answered either way, whatever others said of other quantities: where two hang together, a machine may have
        rules, and states behind them, that no observation leads to.

        Parameters
        ----------
        seconds : float
            CPU time.
        states : int
            At most.
        """
        begin, done, rules, endless = time.process_time(), 0, 0, 0
        while done < len(self.states):
            root = self._roots[done] = self._roots[done] or self._grow(done, {})
            waiting: list[tuple[Branch | Outcome, dict[int, tuple[float, float]]]] = [(root, {})]
            while waiting:
                node, known = waiting.pop()
                if time.process_time() - begin > seconds or len(self.states) > states:
                    return Explored(len(self.states), done, rules, endless, False, time.process_time() - begin)
                if not isinstance(node, Branch):
                    rules, endless = rules + (node.state != NOWHERE), endless + (node.state == NOWHERE)
                    continue
                quantity, least = node.question
                for holds in (True, False):
                    further = {**known, quantity: _narrowed(known.get(quantity), least, holds)}
                    if holds:
                        node.yes = following = node.yes or self._grow(done, further)
                    else:
                        node.no = following = node.no or self._grow(done, further)
                    waiting.append((following, further))
            done += 1
        return Explored(len(self.states), done, rules, endless, True, time.process_time() - begin)


def _narrowed(known: tuple[float, float] | None, least: float, holds: bool) -> tuple[float, float]:
    low, high = known or (-np.inf, np.inf)
    return (max(low, least), high) if holds else (low, min(high, least))


@dataclass
class _Moment:
    """The net within a cycle."""

    tokens: dict[int, int]
    clocks: list[int]
    known: Mapping[int, tuple[float, float]]
    quiet: bool = False
    """Whether it was quiet once, so that clocks start."""
    sent: dict[int, tuple[int, Sent]] = field(default_factory=dict)
    """Group of commands -> priority, and what goes out."""


class _Rule:
    """One cycle of the net by the rule of `cprm_gym.architecture.petri`, on a state, with what is known of the quantities."""

    def __init__(self, net: CompiledNet, program: Program, quantities: Quantities, timed: list[int]) -> None:
        self._quantities = quantities
        t = program.transitions
        self._held = np.flatnonzero(net.moved).tolist()
        self._clocked = {u: k for k, u in enumerate(timed)}
        option = program.options[0]
        self._immediate = program.lists[option["immediate"] : option["immediate_end"]].tolist()
        self._timed = program.lists[option["timed"] : option["timed_end"]].tolist()
        self._delay, self._priority = net.delay.tolist(), net.priority.tolist()
        self._in_between = bool(option["intermediate"])
        self._own: list[list[tuple[int, float, float]]] = []
        self._outer: list[list[tuple[int, float, float]]] = []
        for u in range(net.n_transitions):
            rows = program.conditions[t[u]["cond"] : t[u]["cond_end"]]
            for kind, found in ((1, self._own), (0, self._outer)):
                found.append([(int(r["place"]), float(r["low"]), float(r["high"])) for r in rows if r["moved"] == kind])
        arcs = [(int(a["place"]), int(a["value"])) for a in program.arcs]
        self._pre, self._post, self._set = (
            [arcs[t[u][kind] : t[u][f"{kind}_end"]] for u in range(net.n_transitions)] for kind in ("pre", "post", "set")
        )
        self._touched = [program.lists[t[u]["touched"] : t[u]["touched_end"]].tolist() for u in range(net.n_transitions)]
        self._command = [(int(r["command"]), int(r["group"])) for r in t]
        self._params = [[(int(p["target"]), int(p["source"]), float(p["value"])) for p in program.parameters[r["param"] : r["param_end"]]]
                        for r in t]  # fmt: skip
        self.start = (tuple(int(net.initial[p]) for p in self._held), (OFF,) * len(timed))

    def cycle(
        self, state: tuple[Marking, Marking], known: Mapping[int, tuple[float, float]]
    ) -> tuple[tuple[Marking, Marking], tuple[Sent, ...]] | None:
        """The state after it and what is sent; None where it goes on without end.

        Raises
        ------
        _Open
            At the first question that `known` does not answer.
        """
        now = _Moment(dict(zip(self._held, state[0])), [c + 1 if c >= 0 else OFF for c in state[1]], known)
        was = {u: self._enabled(u, now) for u in self._timed if now.clocks[self._clocked[u]] >= 0}
        passed: set[Marking] = set()
        while True:
            fires = next((u for u in self._immediate if self._enabled(u, now)), None)
            if fires is not None:
                tokens = tuple(now.tokens.values())
                if tokens in passed:
                    return None
                passed.add(tokens)
            else:
                passed.clear()
                if not now.quiet:
                    now.quiet = True
                    was = self._start(now)
                fires = next((u for u in self._timed if now.clocks[self._clocked[u]] >= self._delay[u]), None)
                if fires is None:
                    break
            was = self._fire(fires, now, was)
        sends = tuple(now.sent[group][1] for group in sorted(now.sent))
        return (tuple(now.tokens[p] for p in self._held), tuple(now.clocks)), sends

    def _enabled(self, u: int, now: _Moment) -> bool:
        for place, low, high in self._own[u]:
            if not low <= now.tokens[place] < high:
                return False
        return all(self._asks(place, low, now) and not self._asks(place, high, now) for place, low, high in self._outer[u])

    def _asks(self, place: int, least: float, now: _Moment) -> bool:
        """Whether a place holds at least so much."""
        if least in (np.inf, -np.inf):
            return least < 0
        quantity = self._quantities.of(place, now.tokens)
        if isinstance(quantity, float):
            return quantity >= least
        low, high = now.known.get(quantity, (-np.inf, np.inf))
        if low >= least:
            return True
        if high <= least:
            return False
        raise _Open(Question(quantity, least))

    def _start(self, now: _Moment) -> dict[int, bool]:
        """The net is quiet: clocks of what is enabled start."""
        found = {}
        for u in self._timed:
            k, found[u] = self._clocked[u], self._enabled(u, now)
            now.clocks[k] = max(now.clocks[k], 0) if found[u] else OFF
        return found

    def _fire(self, t: int, now: _Moment, was: dict[int, bool]) -> dict[int, bool]:
        """Fire a transition; returns which timed ones are enabled after it."""
        self._emit(t, now)
        if t in self._clocked:
            now.clocks[self._clocked[t]] = OFF
        for place, weight in self._pre[t]:
            now.tokens[place] -= weight
        if self._in_between:
            for u in self._touched[t]:
                if any(low > 0 and now.tokens[place] < low for place, low, _ in self._own[u]):
                    now.clocks[self._clocked[u]] = OFF
        for place, weight in self._post[t]:
            now.tokens[place] += weight
        for place, value in self._set[t]:
            now.tokens[place] = value
        found = {}
        for u in self._timed if now.quiet else was:
            k, found[u] = self._clocked[u], self._enabled(u, now)
            if was.get(u, False) and not found[u]:
                now.clocks[k] = OFF
            elif now.quiet and found[u]:
                now.clocks[k] = max(now.clocks[k], 0)
        return found

    def _emit(self, t: int, now: _Moment) -> None:
        command, group = self._command[t]
        if command < 0 or (group in now.sent and self._priority[t] <= now.sent[group][0]):
            return
        values: list[tuple[int, int | None, float]] = []
        for target, source, value in self._params[t]:
            quantity = self._quantities.of(source, now.tokens) if source >= 0 else value
            values.append((target, None, quantity) if isinstance(quantity, float) else (target, quantity, 0.0))
        now.sent[group] = self._priority[t], Sent(command, tuple(values))


class ProductRunner:
    """Plays with the machine of a net, in any number of worlds, each in its own state; sends what an `Executor` of the net would.

    Parameters
    ----------
    machine : ProductMachine
    batch : int
        W worlds.

    Attributes
    ----------
    state : (W,) int array
        In which state each is.
    sent : (W, commands) bool, (W, parameters) float
        What went out in the last cycle, in the columns of `Executor.sent`.
    """

    def __init__(self, machine: ProductMachine, batch: int = 1) -> None:
        self.machine, self.batch = machine, batch
        self.state = np.zeros(batch, np.int64)
        layout = machine.layout
        self.sent = np.zeros((batch, len(layout.commands)), np.bool_), np.zeros((batch, layout.n_parameters))

    def reset(self, worlds: NDArray[np.bool_] | None = None) -> None:
        """Bring worlds, all or those of a mask, to the first state."""
        self.state[slice(None) if worlds is None else worlds] = 0

    def step(self, inputs: Mapping[str, ArrayLike], beliefs: Mapping[str, ArrayLike] | None = None) -> None:
        """One cycle of every world.

        Parameters
        ----------
        inputs : mapping of str to number or (W,) array
            Observed quantity -> value.
        beliefs : mapping of str to number or (W,) array, optional
            Belief place -> value.

        Raises
        ------
        NetError
            For a quantity that the machine reads and is not given.
        LivelockError
            Where the net goes on firing without end.
        """
        layout, given = self.machine.layout, {}
        names = [(layout.inputs[c], int(p), inputs) for p, c in zip(layout.input_slots, layout.input_columns)]
        names += [(name, int(p), beliefs or {}) for name, p in zip(layout.beliefs, layout.belief_slots)]
        for name, place, values in names:
            if name not in values:
                raise NetError(f"machine of net {self.machine.net.net.name!r}: {name!r} is not given.{did_you_mean(name, values)}")
            given[place] = np.broadcast_to(np.asarray(values[name], np.float64), (self.batch,))
        now, (fired, value) = Values(self.machine.quantities, given), self.sent
        fired[:] = False
        for world in range(self.batch):
            outcome = self.machine.decide(int(self.state[world]), now, world)
            if outcome.state == NOWHERE:
                raise LivelockError(f"machine of net {self.machine.net.net.name!r}: the net goes on firing without end in world {world}")
            self.state[world] = outcome.state
            for sent in outcome.sends:
                fired[world, sent.command] = True
                for column, quantity, number in sent.values:
                    value[world, column] = number if quantity is None else now.of(quantity)[world]
