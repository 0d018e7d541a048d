"""Parents that sum up many objects: is there one, are all, how many, the least, the most, the mean, any cause.

An aggregate over n objects becomes a chain of small deterministic (or noisy) variables in the ground net, each with two
parents, and never a table over n parents.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import ClassVar

import numpy as np

from ....errors import ModelError, did_you_mean
from .domains import BOOL, Bins, Domain, Labels

MAX_STATES = 2048
"""Most states that an accumulator of a chain may have (a mean over unequal bins needs many)."""


@dataclass(frozen=True)
class Aggregate:
    """Base: one value from the attribute at the end of a path that leads to many objects.

    Attributes
    ----------
    path : str
        ``"opponents.near_ball"``, with the prefix ``prev.`` for the previous slice.
    """

    path: str
    verb: ClassVar[str] = ""

    @property
    def text(self) -> str:
        """Name of the variable it becomes, ``exists(opponents.near_ball=yes)``; every parameter that is not the default is in it."""
        state, parameters = "", ""
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name == "state":
                state = f"={value}"
            elif f.name != "path" and value != f.default:
                parameters += f", {f.name}={value}"
        return f"{self.verb}({self.path}{state}{parameters})"

    def moved(self, path: str) -> Aggregate:
        """The same aggregate over another path."""
        return replace(self, path=path)

    def domain(self, source: Domain, where: str) -> Domain:
        """Domain of the result."""
        self.check(source, where)
        return BOOL

    def check(self, source: Domain, where: str) -> None:
        """Refuse a state that the source does not have."""
        state = getattr(self, "state", None)
        if state is not None and state not in source.states:
            hint = did_you_mean(state, source.states)
            raise ModelError(f"{where}: {self.path!r} has no state {state!r}.{hint} Known: {', '.join(source.states)}")

    def start(self, source: Domain) -> float:
        """The accumulator before the first object."""
        return 0.0

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        """Distribution of the accumulator after one more object in state `index`."""
        raise NotImplementedError

    def finish(self, accumulator: float, source: Domain, count: int) -> int:
        """State index of the result."""
        return int(accumulator)


@dataclass(frozen=True)
class Exists(Aggregate):
    """Some object is in the state."""

    state: str = "yes"
    verb: ClassVar[str] = "exists"

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        return {max(accumulator, float(source.states[index] == self.state)): 1.0}


@dataclass(frozen=True)
class All(Aggregate):
    """Every object is in the state (also when there is none)."""

    state: str = "yes"
    verb: ClassVar[str] = "all"

    def start(self, source: Domain) -> float:
        return 1.0

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        return {min(accumulator, float(source.states[index] == self.state)): 1.0}


@dataclass(frozen=True)
class Count(Aggregate):
    """How many objects are in the state: ``0 .. at_most``, the last state meaning that many or more."""

    state: str = "yes"
    at_most: int = 1
    verb: ClassVar[str] = "count"

    def __post_init__(self) -> None:
        whole = isinstance(self.at_most, (int, np.integer)) and not isinstance(self.at_most, bool)
        if not whole or not 1 <= self.at_most <= MAX_STATES:
            raise ModelError(f"count({self.path}): at_most must be 1 to {MAX_STATES}, got {self.at_most!r}")

    def domain(self, source: Domain, where: str) -> Domain:
        self.check(source, where)
        return Labels((*(str(k) for k in range(self.at_most)), f"{self.at_most}+"))

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        more = int(source.states[index] == self.state)
        return {min(accumulator + more, float(self.at_most)): 1.0}


@dataclass(frozen=True)
class Min(Aggregate):
    """The lowest state; the highest when there is no object."""

    verb: ClassVar[str] = "min"

    def domain(self, source: Domain, where: str) -> Domain:
        return source

    def start(self, source: Domain) -> float:
        return float(len(source) - 1)

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        return {min(accumulator, float(index)): 1.0}


@dataclass(frozen=True)
class Max(Aggregate):
    """The highest state; the lowest when there is no object."""

    verb: ClassVar[str] = "max"

    def domain(self, source: Domain, where: str) -> Domain:
        return source

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        return {max(accumulator, float(index)): 1.0}


@dataclass(frozen=True)
class Mean(Aggregate):
    """The state that holds the mean: of bin mid-points, or of state indices (half rounds up).

    Attributes
    ----------
    empty : str
        State when there is no object.
    """

    empty: str = ""
    verb: ClassVar[str] = "mean"

    def domain(self, source: Domain, where: str) -> Domain:
        if isinstance(source, Bins) and source.circular:
            raise ModelError(f"{where}: {self.path!r} is an angle; the mean of an angle is not a number on the line")
        if self.empty and self.empty not in source.states:
            hint = did_you_mean(self.empty, source.states)
            raise ModelError(f"{where}: {self.path!r} has no state {self.empty!r}.{hint}")
        return source

    def start(self, source: Domain) -> float:
        return 0.0

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        value = source.values[index] if isinstance(source, Bins) else float(index)
        return {round(accumulator + value, 9): 1.0}

    def finish(self, accumulator: float, source: Domain, count: int) -> int:
        if count == 0:
            if not self.empty:
                raise ModelError(f"mean({self.path}): there is no object; say which state that is with `empty`")
            return source.states.index(self.empty)
        mean = accumulator / count
        if isinstance(source, Bins):
            return int(np.clip(np.searchsorted(source.edges, mean + 1e-9, side="right") - 1, 0, len(source) - 1))
        return int(np.floor(mean + 0.5 + 1e-9))


@dataclass(frozen=True)
class AnyCause(Aggregate):
    """Noisy-or over all objects: each one in the state causes the result with probability `strength`.

    Equal aggregates of an object are one variable: two attributes with the same `AnyCause` share its luck.
    """

    state: str = "yes"
    strength: float = 1.0
    leak: float = 0.0
    verb: ClassVar[str] = "any_cause"

    def __post_init__(self) -> None:
        for value in (self.strength, self.leak):
            if not isinstance(value, (int, float, np.number)) or not 0.0 <= value <= 1.0:
                raise ModelError(f"any_cause({self.path}): {value!r} is not a probability")

    def fold(self, accumulator: float, index: int, source: Domain) -> dict[float, float]:
        if accumulator == 1 or source.states[index] != self.state:
            return {accumulator: 1.0}
        return {0.0: 1.0 - self.strength, 1.0: self.strength}


@dataclass(frozen=True, eq=False)
class Link:
    """One variable of a chain: its states and P(state | state of the link before, state of one object)."""

    states: tuple[str, ...]
    table: np.ndarray


def chain(aggregate: Aggregate, source: Domain, count: int, where: str) -> tuple[Link, ...]:
    """The links that compute an aggregate over `count` objects; the last one's states are the result's.

    The first link has the source as its only parent, every other one the link before and the source. Without objects there
    is one link without parents.

    Raises
    ------
    ModelError
        If an accumulator needs more than `MAX_STATES` states.
    """
    result = aggregate.domain(source, where)
    leak = float(getattr(aggregate, "leak", 0.0))
    begin: dict[float, float] = {0.0: 1.0 - leak, 1.0: leak} if leak > 0.0 else {aggregate.start(source): 1.0}
    if count == 0:
        return (Link(result.states, _finish(aggregate, begin, result, source, 0)),)
    known = tuple(begin)
    links = []
    for k in range(count):
        moves = [[aggregate.fold(a, i, source) for i in range(len(source))] for a in known]
        reached = tuple(sorted({b for row in moves for move in row for b, p in move.items() if p > 0.0}))
        if len(reached) > MAX_STATES:
            need = f"{count} objects needs {len(reached)} intermediate states; at most {MAX_STATES}"
            raise ModelError(f"{where}: {aggregate.text} over {need}")
        last = k == count - 1
        if last:
            columns = {b: aggregate.finish(b, source, count) for b in reached}
            states = result.states
        else:
            columns = {b: j for j, b in enumerate(reached)}
            states = tuple(f"{b:.12g}" for b in reached)
        table = np.zeros((len(known), len(source), len(states)))
        for a, row in enumerate(moves):
            for i, move in enumerate(row):
                for b, p in move.items():
                    if p > 0.0:
                        table[a, i, columns[b]] += p
        if k == 0:
            table = np.tensordot(np.array([begin[a] for a in known]), table, axes=1)
        table.flags.writeable = False
        links.append(Link(states, table))
        known = reached
    return tuple(links)


def _finish(aggregate: Aggregate, begin: dict[float, float], result: Domain, source: Domain, count: int) -> np.ndarray:
    table = np.zeros(len(result))
    for accumulator, p in begin.items():
        table[aggregate.finish(accumulator, source, count)] += p
    table.flags.writeable = False
    return table
