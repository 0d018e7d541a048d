"""Arrays of a net: what execution and analysis compute with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....errors import NetError, did_you_mean
from ...expressions import Expression
from ...expressions.interpreter import interpret
from ..net.checks import shown
from ..net.modules import flatten
from ..net.net import MAX_PARTS, PetriNet, math_order
from ..net.places import AnyPlace, Belief, Continuous, Input, Math, ObjectPlace, Place
from ..net.transitions import INFINITE

UNBOUNDED = 2**62
"""Capacity of a place without one."""
MAX_CLOCKS = 256
"""Clocks of a transition with infinitely many servers whose input places are unbounded."""


class PlaceKind(IntEnum):
    """What a place holds and who writes it."""

    DISCRETE = 0
    OBJECT = 1
    CONTINUOUS = 2
    INPUT = 3
    BELIEF = 4
    MATH = 5


class Memory(IntEnum):
    """What happens to the clock of a timed transition that is disabled."""

    ENABLING = 0
    AGE = 1
    RESAMPLING = 2


_KINDS = {
    Place: PlaceKind.DISCRETE,
    ObjectPlace: PlaceKind.OBJECT,
    Continuous: PlaceKind.CONTINUOUS,
    Input: PlaceKind.INPUT,
    Belief: PlaceKind.BELIEF,
    Math: PlaceKind.MATH,
}


@dataclass(frozen=True, eq=False)
class Arcs:
    """Arcs of one kind, grouped by transition.

    ``place[start[t]:start[t + 1]]`` and ``value[...]`` are those of transition t.

    Parameters
    ----------
    start : (T + 1,) int32
    place : (arcs,) int32
        Index of the place.
    value : (arcs,) float64
        Weight, threshold or value to set.
    """

    start: NDArray[np.int32]
    place: NDArray[np.int32]
    value: NDArray[np.float64]

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """(arcs,) the transition of each."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))

    def of(self, t: int) -> list[tuple[int, float]]:
        """The (place, value) pairs of transition `t`."""
        low, high = self.start[t], self.start[t + 1]
        return list(zip(self.place[low:high].tolist(), self.value[low:high].tolist()))


@dataclass(frozen=True, eq=False)
class CompiledNet:
    """A net as flat arrays; P places and T transitions in the order of declaration of the flat net.

    Parameters
    ----------
    net : PetriNet
        The flat net.
    source : PetriNet
        What was given.
    kind : (P,) int8
        `PlaceKind`.
    capacity : (P,) int64
        `UNBOUNDED` for none; 1 for object places.
    initial : (P,) float64
        Initial marking: tokens, 0 for object places, values, math evaluated where it is defined.
    inputs, outputs, tests, inhibitors, sets : Arcs
    delay, priority : (T,) int64
        Delay 0: immediate.
    weight : (T,) float64
    memory : (T,) int8
        `Memory`.
    servers : (T,) int64
        `INFINITE` (-1) or the number of clocks.
    """

    net: PetriNet
    source: PetriNet
    kind: NDArray[np.int8]
    capacity: NDArray[np.int64]
    initial: NDArray[np.float64]
    inputs: Arcs
    outputs: Arcs
    tests: Arcs
    inhibitors: Arcs
    sets: Arcs
    delay: NDArray[np.int64]
    priority: NDArray[np.int64]
    weight: NDArray[np.float64]
    memory: NDArray[np.int8]
    servers: NDArray[np.int64]

    @cached_property
    def place_names(self) -> tuple[str, ...]:
        """Names of the places, in order."""
        return tuple(p.name for p in self.net.places)

    @cached_property
    def transition_names(self) -> tuple[str, ...]:
        """Names of the transitions, in order."""
        return tuple(t.name for t in self.net.transitions)

    @cached_property
    def place_index(self) -> Mapping[str, int]:
        """Name -> index."""
        return {name: i for i, name in enumerate(self.place_names)}

    @cached_property
    def transition_index(self) -> Mapping[str, int]:
        """Name -> index."""
        return {name: i for i, name in enumerate(self.transition_names)}

    @property
    def n_places(self) -> int:
        """P."""
        return len(self.net.places)

    @property
    def n_transitions(self) -> int:
        """T."""
        return len(self.net.transitions)

    def clock_count(self, t: int) -> int:
        """Most clocks of transition `t` that can run at once: none of an immediate one, else one per server, as far as its input places
        can hold tokens for them (`MAX_CLOCKS` of infinite servers if they can hold any number)."""
        if self.delay[t] == 0:
            return 0
        room = [int(self.capacity[p] // w) for p, w in self.inputs.of(t)] or [1]
        servers = MAX_CLOCKS if self.servers[t] == INFINITE else int(self.servers[t])
        return max(1, min(*room, servers))

    @cached_property
    def pre(self) -> NDArray[np.int64]:
        """(T, P) tokens consumed."""
        return self._dense(self.inputs, 0).astype(np.int64)

    @cached_property
    def post(self) -> NDArray[np.int64]:
        """(T, P) tokens produced."""
        return self._dense(self.outputs, 0).astype(np.int64)

    @cached_property
    def incidence(self) -> NDArray[np.int64]:
        """(T, P) ``post - pre``; set arcs are not in it."""
        return self.post - self.pre

    @cached_property
    def test(self) -> NDArray[np.float64]:
        """(T, P) thresholds of test arcs, -inf for none."""
        return self._dense(self.tests, -np.inf)

    @cached_property
    def inhibit(self) -> NDArray[np.float64]:
        """(T, P) thresholds of inhibitor arcs, +inf for none."""
        return self._dense(self.inhibitors, np.inf)

    @cached_property
    def set_to(self) -> NDArray[np.int64]:
        """(T, P) values of set arcs, -1 for none."""
        return self._dense(self.sets, -1).astype(np.int64)

    @cached_property
    def math(self) -> tuple[Math, ...]:
        """The math places, each after those it reads."""
        return math_order(self.net.places, {p.name: p for p in self.net.places})

    @cached_property
    def moved(self) -> NDArray[np.bool_]:
        """(P,) True for discrete and object places: those that transitions change."""
        return np.asarray((self.kind == PlaceKind.DISCRETE) | (self.kind == PlaceKind.OBJECT))

    def place(self, name: str) -> int:
        """Index of a place."""
        if name not in self.place_index:
            raise NetError(f"net {self.net.name!r}: unknown place {name!r}.{did_you_mean(name, self.place_index)}")
        return self.place_index[name]

    def transition(self, name: str) -> int:
        """Index of a transition."""
        if name not in self.transition_index:
            raise NetError(f"net {self.net.name!r}: unknown transition {name!r}.{did_you_mean(name, self.transition_index)}")
        return self.transition_index[name]

    def _dense(self, arcs: Arcs, nothing: float) -> NDArray[np.float64]:
        table = np.full((self.n_transitions, self.n_places), nothing, dtype=np.float64)
        table[arcs.rows, arcs.place] = arcs.value
        return table


def initial_marking(net: PetriNet) -> NDArray[np.float64]:
    """(P,) what each place of a flat net holds at first.

    Math places have the value of their expression; where it is not defined yet, or reads an object, their default.
    """
    marking: dict[str, float] = {}
    for place in net.places:
        marking[place.name] = 0.0
        if isinstance(place, Place):
            marking[place.name] = float(place.tokens)
        elif isinstance(place, (Continuous, Input, Belief)):
            marking[place.name] = float(place.value)
    for math_place in math_order(net.places, {p.name: p for p in net.places}):
        expression = Expression(math_place.expression)
        value = interpret(expression.tree, marking) if all(name in marking for name in expression.names) else np.nan
        marking[math_place.name] = value if np.isfinite(value) else math_place.default
    return np.array(list(marking.values()), np.float64)


def compile_net(net: PetriNet, max_parts: int = MAX_PARTS) -> CompiledNet:
    """The arrays of `net`, flattened if it has modules.

    Parameters
    ----------
    net : PetriNet
    max_parts : int
        As for `flatten`.

    Raises
    ------
    NetError
        When the hierarchy has more parts, or does not flatten to a valid net.
    """
    if not isinstance(net, PetriNet):
        raise NetError(f"a net is a PetriNet, got {shown(net)}")
    flat = flatten(net, max_parts)
    index = {p.name: i for i, p in enumerate(flat.places)}

    def arcs(kind: str) -> Arcs:
        start, place, value = [0], [], []
        for t in flat.transitions:
            given: Mapping[str, float] = getattr(t, kind)
            place += [index[name] for name in given]
            value += list(given.values())
            start.append(len(place))
        return Arcs(np.array(start, np.int32), np.array(place, np.int32), np.array(value, np.float64))

    def capacity(place: AnyPlace) -> int:
        if isinstance(place, ObjectPlace):
            return 1
        return place.capacity if isinstance(place, Place) and place.capacity is not None else UNBOUNDED

    memories = {"enabling": Memory.ENABLING, "age": Memory.AGE, "resampling": Memory.RESAMPLING}
    return CompiledNet(
        net=flat,
        source=net,
        kind=np.array([_KINDS[type(p)] for p in flat.places], np.int8),
        capacity=np.array([capacity(p) for p in flat.places], np.int64),
        initial=initial_marking(flat),
        inputs=arcs("inputs"),
        outputs=arcs("outputs"),
        tests=arcs("tests"),
        inhibitors=arcs("inhibitors"),
        sets=arcs("sets"),
        delay=np.array([t.delay for t in flat.transitions], np.int64),
        priority=np.array([t.priority for t in flat.transitions], np.int64),
        weight=np.array([t.weight for t in flat.transitions], np.float64),
        memory=np.array([memories[t.memory] for t in flat.transitions], np.int8),
        servers=np.array([t.servers for t in flat.transitions], np.int64),
    )
