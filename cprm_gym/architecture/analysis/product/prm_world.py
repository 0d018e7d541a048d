"""A two-slice relational model used generatively."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....errors import CostError, ModelError, did_you_mean
from ...expressions import Expression
from ...prm.grounding.grounding import Grounding
from ...prm.grounding.slices import PREVIOUS, SAME, GroundSlice
from .worlds import Step

BRANCHES = 100_000
"""Successors that one state may have."""


@dataclass(frozen=True, eq=False)
class PRMWorld:
    """The variables of a model as a world: each is drawn from its CPD, given the state before.

    Parameters
    ----------
    grounding : Grounding
        Without static variables; all variables have finitely many states.
    percepts : mapping of str to str
        Observed quantity (or belief place) -> expression over variables, which are read as the index of their state, or the middle of their
        bin.
    given : mapping of str to str, optional
        Given variable -> expression over commands, 1 where one goes out: its state's index.
    relations : mapping of str to str, optional
        Relation tuple -> expression over commands (and variables of the state before): in force where it is true. So the net switches
        relations.
    ends : mapping of str to str, optional
        Outcome of the world's own -> expression over variables that is true in its states.
    only : tuple of str, optional
        A group of variables on which no others have an influence (`subdivision`): the others are left out.

    Raises
    ------
    ModelError
    """

    grounding: Grounding
    percepts_: Mapping[str, str]
    given: Mapping[str, str] = field(default_factory=dict)
    relations: Mapping[str, str] = field(default_factory=dict)
    ends: Mapping[str, str] = field(default_factory=dict)
    only: tuple[str, ...] | None = None
    names: tuple[str, ...] = field(init=False, default=())
    """Its variables."""

    def __post_init__(self) -> None:
        first = self.grounding.ground((), first=True)
        names = tuple(n for n in first.order() if n not in first.given and (self.only is None or n in self.only))
        for name in names:
            if first.variables[name].quantity is not None:
                raise ModelError(f"world: variable {name!r} is a real number; give it bins")
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "_memory", {})
        object.__setattr__(self, "_values", {n: _values(first.variables[n]) for n in names})
        for what, text in self.percepts_.items():
            for name in Expression(text).names:
                if name not in names:
                    raise ModelError(f"world, percept {what!r}: unknown variable {name!r}.{did_you_mean(name, names)}")
        for given in first.given:
            if given not in self.given:
                raise ModelError(f"world: variable {given!r} is given to the model; say by `given` what it is")

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """The first slice."""
        return [(step.state, step.chance) for step in self._draw(None, (), True)]

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """Expressions over the state's variables."""
        values = self._read(state)
        return {name: Expression(text).evaluate(values) for name, text in self.percepts_.items()}

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Every assignment of the next slice and its probability."""
        key = (state, commands)
        memory: dict[Any, Sequence[Step]] = self._memory  # type: ignore[attr-defined]
        if key not in memory:
            memory[key] = self._draw(state, commands, False)
        return memory[key]

    def ended(self, state: Hashable) -> str:
        """The first of `ends` that is true."""
        values = self._read(state)
        return next((name for name, text in self.ends.items() if Expression(text).evaluate(values)), "") if self.ends else ""

    def name(self, state: Hashable) -> str:
        """Variables and their states."""
        slice_ = self.grounding.ground((), first=True)
        pairs = zip(self.names, state)  # type: ignore[call-overload]
        return ", ".join(f"{n} {slice_.variables[n].states[k]}" for n, k in pairs)

    def _read(self, state: Hashable) -> dict[str, float]:
        return {n: float(self._values[n][k]) for n, k in zip(self.names, state)}  # type: ignore[attr-defined, call-overload]

    def _draw(self, before: Hashable | None, commands: tuple[str, ...], first: bool) -> Sequence[Step]:
        told = _Commands(commands) | (self._read(before) if before is not None else {})
        active = [r for r, text in self.relations.items() if _truth(text, told)]
        slice_ = self.grounding.ground(active, first=first)
        context = {name: round(_number(self.given[name], told)) for name in slice_.given}
        old = dict(zip(self.names, before)) if before is not None else {}  # type: ignore[call-overload]
        partial: list[tuple[dict[str, int], float]] = [(dict(context), 1.0)]
        for name in slice_.order():
            if name not in self.names:
                continue
            fresh: list[tuple[dict[str, int], float]] = []
            for values, mass in partial:
                row = _row(slice_, name, values, old)
                fresh += [({**values, name: k}, mass * float(row[k])) for k in np.flatnonzero(row).tolist()]
            partial = fresh
            if len(partial) > BRANCHES:
                raise CostError(f"world: more than {BRANCHES} successors of one state; the model has too many variables for one chain")
        merged: dict[tuple[int, ...], float] = {}
        for values, mass in partial:
            state = tuple(values[n] for n in self.names)
            merged[state] = merged.get(state, 0.0) + mass
        return [Step(state, p, p, p) for state, p in merged.items()]


class _Commands(dict[str, float]):
    """1 for the commands that go out, 0 for all other names."""

    def __init__(self, commands: tuple[str, ...]) -> None:
        super().__init__(dict.fromkeys(commands, 1.0))


def _number(text: str, values: Mapping[str, float]) -> float:
    e = Expression(text)
    return e.evaluate({name: values.get(name, 0.0) for name in e.names})


def _truth(text: str, values: Mapping[str, float]) -> bool:
    return _number(text, values) != 0.0


def _row(slice_: GroundSlice, name: str, values: Mapping[str, int], old: Mapping[str, int]) -> Any:
    cpd = slice_.by_child[name]
    at = []
    for parent, lag in cpd.parents:
        if lag == SAME:
            at.append(values[parent])
        elif lag == PREVIOUS:
            at.append(old[parent] if parent in old else values[parent])
        else:
            raise ModelError(f"world: variable {name!r} depends on {parent!r}, which is static; give such variables as relations or inputs")
    return cpd.table[tuple(at)]


def _values(variable: Any) -> Any:
    if variable.edges is None:
        return np.arange(variable.card, dtype=float)
    return (variable.edges[:-1] + variable.edges[1:]) / 2


def assignments(world: PRMWorld) -> int:
    """How many states the world has at most."""
    slice_ = world.grounding.ground((), first=True)
    return int(np.prod(np.array([slice_.variables[n].card for n in world.names])))
