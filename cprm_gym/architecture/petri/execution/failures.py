"""What to say when a cycle fails, or a transition does not fire."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import CommandError, CprmError, ExpressionError, LivelockError, NetError
from ...expressions import Expression
from ..net.places import ObjectPlace
from .compiled_net import CompiledNet
from .kernels import arrays
from .program import Layout, Program, capacity_limit


def failure(
    net: CompiledNet, program: Program, layout: Layout, state: arrays.State, scratch: arrays.Scratch, status: int, copy: int, detail: int
) -> CprmError:
    """The error for what a kernel answered.

    Parameters
    ----------
    net, program, layout, state, scratch
        Of the executor.
    status : int
        `arrays.LIVELOCK`, `arrays.CLOCKS` or `arrays.UNDEFINED`.
    copy : int
        Where it happened.
    detail : int
        The transition or math place.
    """
    where = f"net {net.net.name!r}, copy {copy}, cycle {state.cycle[copy]}"
    if status == arrays.LIVELOCK:
        names = net.transition_names
        loop = _period(scratch.loop[: scratch.counts[arrays.LOOPED]].tolist())
        circle = " -> ".join(names[t] for t in [*loop, loop[0]])
        if len(loop) > 20:
            circle = f"among {', '.join(names[t] for t in dict.fromkeys(loop))}"
        most = net.net.semantics.max_firings
        return LivelockError(f"{where}: more than {most} immediate firings without becoming quiet: {circle}")
    if status == arrays.CLOCKS:
        name = net.transition_names[detail]
        return NetError(
            f"{where}: transition {name!r} has infinite servers and is enabled more often than it has clocks "
            f"({program.transitions['clock_end'][detail] - program.transitions['clock'][detail]}); "
            f"give its input places capacities"
        )
    place = net.math[detail]
    operands = ", ".join(f"{name} = {_operand(net, layout, state, name, copy):g}" for name in Expression(place.expression).names)
    what = f"math place {place.name!r} = {place.expression!r}"
    return ExpressionError(f"{where}: {what} has no finite value at {operands or 'no operands'}")


def _operand(net: CompiledNet, layout: Layout, state: arrays.State, name: str, copy: int) -> float:
    """What an expression read under a name."""
    index = net.place_index.get(name)
    if index is not None:
        return float(state.row[copy, index])
    place, _, attribute = name.rpartition(".")
    owner = net.net.place(place)
    assert isinstance(owner, ObjectPlace)
    held = int(state.held[copy, layout.objects.index(place)])
    return float(state.data[copy, layout.columns[owner.class_name, attribute] + held])


def two_commands(net: CompiledNet, program: Program, layout: Layout, state: arrays.State, out: arrays.Output) -> CommandError:
    """The error for two commands of one group in one cycle."""
    copy, loser = np.argwhere(out.overruled)[0]
    command, group = (int(program.transitions[key][loser]) for key in ("command", "group"))
    winner = int(out.winner[copy, group])
    names, commands = net.transition_names, layout.commands
    return CommandError(
        f"net {net.net.name!r}, copy {copy}, cycle {state.cycle[copy] - 1}: two commands in one cycle, "
        f"{commands[winner]!r} of {names[out.source[copy, winner]]!r} and {commands[command]!r} of {names[loser]!r}"
    )


class Condition(NamedTuple):
    """One condition of a transition: it holds iff ``low <= has < high``."""

    place: str
    low: float
    high: float
    has: float
    full: bool  # the bound above is the place's capacity

    @property
    def holds(self) -> bool:
        """Whether it does."""
        return self.low <= self.has < self.high

    def reason(self) -> str:
        """What it needs and has, where it does not hold."""
        if self.has < self.low:
            return f"{self.place} needs {self.low:g}, has {self.has:g}"
        return f"{self.place} is full with {self.has:g}" if self.full else f"{self.place} must be below {self.high:g}, has {self.has:g}"


def conditions_of(net: CompiledNet, program: Program, row: NDArray[np.float64], t: int) -> list[Condition]:
    """All conditions of transition `t` in the marking `row` of one copy."""
    consumed, produced = dict(net.inputs.of(t)), dict(net.outputs.of(t))
    found = []
    span = program.transitions[t]
    for place, _, low, high in program.conditions[span["cond"] : span["cond_end"]].tolist():
        full = high == capacity_limit(net, t, place, consumed, produced)
        found.append(Condition(net.place_names[place], low, high, float(row[place]), full))
    return found


def missing_conditions(net: CompiledNet, program: Program, row: NDArray[np.float64], t: int) -> list[str]:
    """The conditions of transition `t` that do not hold in the marking `row` of one copy, with what each needs and has."""
    return [condition.reason() for condition in conditions_of(net, program, row, t) if not condition.holds]


def _period(sequence: Sequence[int]) -> list[int]:
    """The shortest piece whose repetition ends `sequence`; all of it when there is none."""
    n = len(sequence)
    for length in range(1, n // 2 + 1):
        if all(sequence[n - 1 - i] == sequence[n - 1 - i - length] for i in range(n - length)):
            return list(sequence[n - length :])
    return list(sequence)
