"""Transitions with their arcs (input, output, test, inhibitor and set arcs), and the commands that they emit."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ....errors import NetError
from .checks import MAX_WEIGHT, check_name, is_word, place_name, real_number, shown, whole_number
from .values import FrozenMap

ArcSpec = Mapping[str, float] | tuple[str, ...]
"""How arcs are written: ``("p", "q", "q")``, a repeated name adding weight, or ``{"p": 1, "q": 2}``."""

INFINITE = -1
"""`Transition.servers` of a transition with one clock for every time it is enabled at once."""


@dataclass(frozen=True, init=False)
class Command:
    """What an output transition sends to the body: ``Command("kick", power="power", direction=0)``.

    Parameters
    ----------
    name : str
    **params : str or float
        Each the name of the place it is read from at the moment of firing, or a number. The value of an object place is the
        index of the object it holds, -1 for none.
    """

    name: str
    params: FrozenMap[str | float]

    def __init__(self, name: str, /, **params: str | float) -> None:
        check_name(name, "command")
        for key, value in params.items():
            if not isinstance(value, str):
                params[key] = real_number(value, f"command {name!r}: parameter {key!r} is the name of a place, or")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "params", FrozenMap(params))


_NONE: FrozenMap[Any] = FrozenMap()


def _weights(spec: object, where: str) -> FrozenMap[int]:
    if isinstance(spec, tuple) and not spec:
        return _NONE
    if isinstance(spec, str):
        raise NetError(f"{where} takes a tuple of place names, got the string {spec!r}; write ({spec!r},)")
    if isinstance(spec, Mapping):
        return FrozenMap(
            {place_name(place, where): whole_number(weight, f"{where}: weight of {place!r}", 1) for place, weight in spec.items()}
        )
    if isinstance(spec, (tuple, list)) and all(isinstance(place, str) for place in spec):
        return FrozenMap(dict(Counter(spec)))
    raise NetError(f"{where} takes a tuple of place names or a mapping from place to weight, got {shown(spec)}")


def _thresholds(spec: object, where: str) -> FrozenMap[float]:
    if isinstance(spec, tuple) and not spec:
        return _NONE
    if isinstance(spec, str):
        raise NetError(f"{where} takes a mapping from place to threshold, got the string {spec!r}; write {{{spec!r}: 1}}")
    if isinstance(spec, Mapping):
        return FrozenMap(
            {place_name(place, where): real_number(value, f"{where}: threshold of {place!r}") for place, value in spec.items()}
        )
    return FrozenMap(dict(_weights(spec, where)))


@dataclass(frozen=True, init=False)
class Transition:
    """A transition: immediate, or timed with a fixed delay.

    Parameters
    ----------
    name : str
    inputs, outputs : tuple of names or mapping from name to weight
        Tokens consumed and produced.
    tests : tuple of names or mapping from name to threshold
        Enabled only while the marking is at least the threshold (default 1); consumes nothing.
    inhibitors : tuple of names or mapping from name to threshold
        Enabled only while the marking is below the threshold (default 1): the dissertation's "more than a certain number of
        tokens" (§2.2.3), that number being threshold - 1.
    sets : mapping from name to tokens
        Set arcs (§4.1): applied last. An object place can only be set to 0.
    delay : int
        Cycles it must stay enabled before it fires; 0 for an immediate transition.
    priority : int
        The higher fires first.
    emits : Command, optional
        Makes it an output transition.
    weight : float
        Share in a random choice among equal priorities, when the net's semantics ask for one.
    memory : {"enabling", "age", "resampling"}
        Whether its clock is forgotten when it is disabled (default), kept, or reset by any firing.
    servers : int
        Clocks that may run at once: 1 (default), a number, or `INFINITE` for one per time it is enabled.
    set_wins : bool
        Allow a set arc and an output arc to the same place; the set value then stands.
    """

    name: str
    inputs: FrozenMap[int]
    outputs: FrozenMap[int]
    tests: FrozenMap[float]
    inhibitors: FrozenMap[float]
    sets: FrozenMap[int]
    delay: int
    priority: int
    emits: Command | None
    weight: float
    memory: Literal["enabling", "age", "resampling"]
    servers: int
    set_wins: bool

    def __init__(
        self,
        name: str,
        inputs: ArcSpec = (),
        outputs: ArcSpec = (),
        *,
        tests: ArcSpec = (),
        inhibitors: ArcSpec = (),
        sets: Mapping[str, float] | None = None,
        delay: int = 0,
        priority: int = 0,
        emits: Command | None = None,
        weight: float = 1.0,
        memory: Literal["enabling", "age", "resampling"] = "enabling",
        servers: int = 1,
        set_wins: bool = False,
    ) -> None:
        check_name(name, "transition")
        where = f"transition {name!r}"
        if sets is not None and not isinstance(sets, Mapping):
            raise NetError(f"{where}: `sets` takes a mapping from place to tokens, got {shown(sets)}")
        if emits is not None and not isinstance(emits, Command):
            raise NetError(f"{where}: `emits` takes a Command, got {shown(emits)}")
        if not is_word(memory, ("enabling", "age", "resampling")):
            raise NetError(f"{where}: `memory` is 'enabling', 'age' or 'resampling', got {shown(memory)}")
        if isinstance(servers, bool) or not (isinstance(servers, int) and (servers == INFINITE or 1 <= servers <= 64)):
            raise NetError(f"{where}: `servers` is 1 to 64 or INFINITE, got {shown(servers)}")
        if not (isinstance(weight, (int, float)) and 0.0 < weight <= sys.float_info.max):
            raise NetError(f"{where}: `weight` is a positive number, got {shown(weight)}")
        if isinstance(priority, bool) or not isinstance(priority, int) or abs(priority) > MAX_WEIGHT:
            raise NetError(f"{where}: `priority` is a whole number of up to {MAX_WEIGHT}, got {shown(priority)}")
        if not isinstance(set_wins, bool):
            raise NetError(f"{where}: `set_wins` is True or False, got {shown(set_wins)}")
        values = {
            "name": name,
            "inputs": _weights(inputs, f"{where}: `inputs`"),
            "outputs": _weights(outputs, f"{where}: `outputs`"),
            "tests": _thresholds(tests, f"{where}: `tests`"),
            "inhibitors": _thresholds(inhibitors, f"{where}: `inhibitors`"),
            "sets": FrozenMap(
                {place_name(p, f"{where}: `sets`"): whole_number(v, f"{where}: `sets` of {p!r}", 0) for p, v in (sets or {}).items()}
            ),
            "delay": whole_number(delay, f"{where}: `delay`", 0),
            "priority": int(priority),
            "emits": emits,
            "weight": float(weight),
            "memory": memory,
            "servers": servers,
            "set_wins": set_wins,
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def is_timed(self) -> bool:
        """Whether it waits for its delay."""
        return self.delay > 0
