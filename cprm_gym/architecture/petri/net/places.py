"""Places, transitions, commands, selections and ports: the frozen parts that a net is made of."""

from __future__ import annotations

import reprlib
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ....errors import ExpressionError, NetError
from ...expressions import CONSTANTS, FUNCTIONS, WORDS, Expression
from .values import FrozenMap

ArcSpec = Mapping[str, float] | tuple[str, ...]
"""How arcs are written: ``("p", "q", "q")``, a repeated name adding weight, or ``{"p": 1, "q": 2}``."""

INFINITE = -1
"""`Transition.servers` of a transition with one clock for every time it is enabled at once."""
MAX_WEIGHT = 2**31 - 1
"""Largest weight, capacity and number of tokens that can be written."""


def shown(value: object) -> str:
    """A value as an error shows it: its first 80 characters, however large it is."""
    if isinstance(value, int) and value.bit_length() > 10_000:  # longer ones cannot be written in digits
        return f"a whole number of {value.bit_length()} bits"
    if isinstance(value, int) and value.bit_length() > 200:
        return f"{str(value)[:40]}..."
    if isinstance(value, str):
        return repr(value if len(value) <= 80 else value[:80] + "...")
    if isinstance(value, (int, float, type(None))):
        return repr(value)
    text = _SHORT.repr(value)
    return text if len(text) <= 160 else text[:160] + "..."


_SHORT = reprlib.Repr()
_SHORT.maxother = _SHORT.maxlong = _SHORT.maxstring = 80


def check_name(name: object, what: str) -> None:
    """Refuse a name that is not short printable text."""
    if not isinstance(name, str):
        raise NetError(f"the name of a {what} is text, got {type(name).__name__}: {shown(name)}")
    if not name or len(name) > 200 or not name.isprintable() or name != name.strip():
        raise NetError(f"the name of a {what} is 1 to 200 printable characters without spaces around them, got {name[:80]!r}")
    if name in FUNCTIONS or name in CONSTANTS or name in WORDS:
        raise NetError(f"{name!r} is a word of the expression language and cannot name a {what}")


def _count(value: object, what: str, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or (isinstance(value, float) and not value.is_integer()):
        raise NetError(f"{what} is a whole number, got {shown(value)}")
    if not least <= value <= MAX_WEIGHT:
        raise NetError(f"{what} is {least} to {MAX_WEIGHT}, got {shown(value)}")
    return int(value)


def _real(value: object, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= sys.float_info.max:
        raise NetError(f"{what} is a finite number, got {shown(value)}")
    return int(value) if float(value).is_integer() and abs(value) <= MAX_WEIGHT else float(value)


def _expression(text: object, what: str) -> None:
    if not isinstance(text, str):
        raise NetError(f"{what} is an expression written as text, got {type(text).__name__}: {shown(text)}")
    try:
        Expression(text)
    except ExpressionError as error:
        raise NetError(f"{what}: {error}") from error


@dataclass(frozen=True)
class Place:
    """A discrete place: holds tokens, moved by transitions.

    Parameters
    ----------
    name : str
    capacity : int, optional
        Most tokens it may hold; a transition that would exceed it is not enabled. Default: unbounded.
    tokens : int
        Tokens in the initial marking.
    """

    name: str
    capacity: int | None = None
    tokens: int = 0

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        if self.capacity is not None:
            object.__setattr__(self, "capacity", _count(self.capacity, f"place {self.name!r}: capacity", 1))
        object.__setattr__(self, "tokens", _count(self.tokens, f"place {self.name!r}: tokens", 0))
        if self.capacity is not None and self.tokens > self.capacity:
            raise NetError(f"place {self.name!r}: {self.tokens} tokens exceed its capacity {self.capacity}")


@dataclass(frozen=True)
class Continuous:
    """A continuous place that nothing in its net writes: a constant, or a parameter fused by the net around it.

    Only test arcs, inhibitor arcs, math transitions and command parameters read it (§2.2.5).
    """

    name: str
    value: float = 0.0

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        object.__setattr__(self, "value", _real(self.value, f"place {self.name!r}: value"))


@dataclass(frozen=True)
class Input:
    """A place that an observation sets at the start of every cycle (§2.2.4).

    Parameters
    ----------
    name : str
    observes : str
        Name of the observed quantity; several places, in several modules, may observe one. Default: the place's name.
    value : float
        Until the first observation.
    """

    name: str
    observes: str = ""
    value: float = 0.0

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        if isinstance(self.observes, str) and not self.observes:
            object.__setattr__(self, "observes", self.name)
        check_name(self.observes, "observation")
        object.__setattr__(self, "value", _real(self.value, f"place {self.name!r}: value"))


@dataclass(frozen=True)
class Belief:
    """A place whose value is a function of the posterior of a random variable (§2.3.1, Fig. 2.17).

    Parameters
    ----------
    name : str
    variable : str
        ``"ball.distance"``. Where the first part names an object place of the net, the attribute of the object that it holds
        (Fig. 2.23).
    view : str
        What of the posterior: ``expectation``, ``variance``, ``mode``, ``probability``, ``entropy``, or another that the model
        knows.
    state : str
        The state whose probability is viewed; with ``probability`` only.
    value : float
        Before the first inference, and while the object is absent.
    """

    name: str
    variable: str
    view: str = "expectation"
    state: str = ""
    value: float = 0.0

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        check_name(self.variable, "variable")
        check_name(self.view, "view")
        if not isinstance(self.state, str):
            raise NetError(f"belief place {self.name!r}: `state` is text, got {shown(self.state)}")
        if (self.view == "probability") != bool(self.state):
            given = f"view={self.view!r}, state={self.state!r}"
            raise NetError(f"belief place {self.name!r}: `state` goes with view='probability', got {given}")
        object.__setattr__(self, "value", _real(self.value, f"place {self.name!r}: value"))


@dataclass(frozen=True)
class Math:
    """A continuous place and the math transition that keeps it equal to an expression of other places (§2.2.5).

    Parameters
    ----------
    name : str
    expression : str
        Over the places of the net by name; ``target.distance`` reads an attribute of the object in the object place ``target``.
    default : float
        Value while an object that it reads is absent, or that object's attribute is unknown.
    """

    name: str
    expression: str
    default: float = 0.0

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        _expression(self.expression, f"math place {self.name!r}")
        object.__setattr__(self, "default", _real(self.default, f"place {self.name!r}: default"))


@dataclass(frozen=True)
class Selection:
    """The object that an object place receives every cycle, the best of its class in some respect (§2.3.4).

    The second most open teammate, if at least 10 m open:
    ``Selection("Teammate", best="teammate.openness", where="teammate.openness >= 10", k=2)``

    Parameters
    ----------
    class_name : str
        The class of the candidates. In the expressions its lower-case form names the candidate; other names are places.
    best : str
        The expression that ranks the candidates, largest first; equal values in order of the candidates.
    where : str
        The condition a candidate must meet; empty for none.
    k : int
        1 for the best, 2 for the second best. With fewer candidates the place stays empty.
    minimize : bool
        Rank smallest first.
    """

    class_name: str
    best: str
    where: str = ""
    k: int = 1
    minimize: bool = False

    def __post_init__(self) -> None:
        check_name(self.class_name, "class")
        _expression(self.best, f"selection of a {self.class_name}: best")
        if self.where != "":
            _expression(self.where, f"selection of a {self.class_name}: where")
        object.__setattr__(self, "k", _count(self.k, "selection: k", 1))
        if not isinstance(self.minimize, bool):
            raise NetError(f"selection of a {self.class_name}: `minimize` is True or False, got {shown(self.minimize)}")

    @property
    def candidate(self) -> str:
        """The name of the candidate in the expressions."""
        return self.class_name.lower()


@dataclass(frozen=True)
class ObjectPlace:
    """A place that holds at most one object of a class (§2.3.4).

    Transitions move the object from their object input to their object outputs. With a selection the place is set at the start
    of every cycle; without, it starts empty.
    """

    name: str
    class_name: str
    select: Selection | None = None

    def __post_init__(self) -> None:
        check_name(self.name, "place")
        check_name(self.class_name, "class")
        if self.select is not None and not isinstance(self.select, Selection):
            raise NetError(f"object place {self.name!r}: `select` takes a Selection, got {shown(self.select)}")
        if self.select is not None and self.select.class_name != self.class_name:
            raise NetError(f"object place {self.name!r} holds a {self.class_name}, its selection a {self.select.class_name}")


AnyPlace = Place | Continuous | Input | Belief | Math | ObjectPlace
"""A place of any kind."""
PLACE_KINDS = (Place, Continuous, Input, Belief, Math, ObjectPlace)


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
                params[key] = _real(value, f"command {name!r}: parameter {key!r} is the name of a place, or")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "params", FrozenMap(params))


def _place(name: object, where: str) -> str:
    if not isinstance(name, str):
        raise NetError(f"{where} names places by text, got {shown(name)}")
    return name


def _weights(spec: object, where: str) -> FrozenMap[int]:
    if isinstance(spec, str):
        raise NetError(f"{where} takes a tuple of place names, got the string {spec!r}; write ({spec!r},)")
    if isinstance(spec, Mapping):
        return FrozenMap({_place(place, where): _count(weight, f"{where}: weight of {place!r}", 1) for place, weight in spec.items()})
    if isinstance(spec, (tuple, list)) and all(isinstance(place, str) for place in spec):
        return FrozenMap(dict(Counter(spec)))
    raise NetError(f"{where} takes a tuple of place names or a mapping from place to weight, got {shown(spec)}")


def _thresholds(spec: object, where: str) -> FrozenMap[float]:
    if isinstance(spec, str):
        raise NetError(f"{where} takes a mapping from place to threshold, got the string {spec!r}; write {{{spec!r}: 1}}")
    if isinstance(spec, Mapping):
        return FrozenMap({_place(place, where): _real(value, f"{where}: threshold of {place!r}") for place, value in spec.items()})
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
        if memory not in ("enabling", "age", "resampling"):
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
            "sets": FrozenMap({_place(p, f"{where}: `sets`"): _count(v, f"{where}: `sets` of {p!r}", 0) for p, v in (sets or {}).items()}),
            "delay": _count(delay, f"{where}: `delay`", 0),
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


def _names(value: object, where: str) -> tuple[str, ...]:
    if not isinstance(value, (tuple, list)) or not all(isinstance(name, str) for name in value):
        raise NetError(f"{where} takes a tuple of place names, got {shown(value)}")
    return tuple(value)


@dataclass(frozen=True)
class Ports:
    """The interface of a module (§2.2.6, §4.2): the only places that the net around it may touch.

    Parameters
    ----------
    begin, ongoing, done : str, optional
        Of a behaviour module, each of capacity 1: a token in `begin` starts it, `ongoing` holds one while it works, `done`
        receives one as `ongoing` loses it.
    errors, interrupts : tuple of str
        Of capacity 1: outcomes other than success; requests from outside to end otherwise.
    inputs, outputs : tuple of str
        Further places: the net around may only put tokens into inputs, and only take tokens from outputs. Continuous, input,
        belief and math places among the outputs can be read.
    parameters : tuple of str
        Object and continuous places that the net around fuses with its own, or (object places) puts an object into.
    within : int
        Cycles within which an interrupt is answered.
    answers : mapping
        Interrupt -> tuple of the outcomes it may end in. Default: any error.
    idle_interrupts : {"consumed", "kept"}
        What becomes of an interrupt that comes while the module is idle.
    """

    begin: str | None = None
    ongoing: str | None = None
    done: str | None = None
    errors: tuple[str, ...] = ()
    interrupts: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    within: int = 1
    answers: Mapping[str, tuple[str, ...]] = field(default_factory=FrozenMap)
    idle_interrupts: Literal["consumed", "kept"] = "consumed"

    def __post_init__(self) -> None:
        for key in ("errors", "interrupts", "inputs", "outputs", "parameters"):
            value = getattr(self, key)
            if isinstance(value, str):
                raise NetError(f"ports: `{key}` takes a tuple of place names, got the string {value!r}; write ({value!r},)")
            object.__setattr__(self, key, _names(value, f"ports: `{key}`"))
        for key in ("begin", "ongoing", "done"):
            value = getattr(self, key)
            if value is not None and (not isinstance(value, str) or not value):
                raise NetError(f"ports: `{key}` is the name of a place, got {shown(value)}")
        for name, count in Counter(self.all).items():
            if count > 1:
                raise NetError(f"ports: place {name!r} is named {count} times")
        object.__setattr__(self, "within", _count(self.within, "ports: `within`", 1))
        if not isinstance(self.answers, Mapping):
            raise NetError(f"ports: `answers` takes a mapping from interrupt to outcomes, got {shown(self.answers)}")
        answers = {_place(key, "ports: `answers`"): _names(value, f"ports: `answers` of {key!r}") for key, value in self.answers.items()}
        for interrupt, outcomes in answers.items():
            if interrupt not in self.interrupts:
                raise NetError(f"ports: `answers` names {interrupt!r}, which is not an interrupt")
            for outcome in outcomes:
                if outcome not in self.outcomes:
                    raise NetError(f"ports: `answers` of {interrupt!r} names {outcome!r}, which is neither done nor an error")
        object.__setattr__(self, "answers", FrozenMap(answers))
        if self.idle_interrupts not in ("consumed", "kept"):
            raise NetError(f"ports: `idle_interrupts` is 'consumed' or 'kept', got {shown(self.idle_interrupts)}")

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Where a run may end: `done` and the errors."""
        return ((self.done,) if self.done else ()) + self.errors

    @property
    def entries(self) -> tuple[str, ...]:
        """Places into which the net around may put tokens."""
        return ((self.begin,) if self.begin else ()) + self.interrupts + self.inputs

    @property
    def exits(self) -> tuple[str, ...]:
        """Places from which the net around may take tokens."""
        return ((self.ongoing,) if self.ongoing else ()) + self.outcomes + self.outputs

    @property
    def all(self) -> tuple[str, ...]:
        """Every port."""
        return self.entries + self.exits + self.parameters


@dataclass(frozen=True)
class Semantics:
    """The choices that the dissertation leaves open; the defaults are explained in `cprm_gym.architecture.petri`.

    Parameters
    ----------
    capacity : {"strong", "weak"}
        ``strong``: after consuming and producing no place exceeds its capacity. ``weak``: not even before consuming.
    persistence : {"intermediate", "atomic"}
        Whether a firing that takes and returns what a timed transition needs restarts its clock.
    choice : {"declared", "random"}
        Which of several enabled immediate transitions of equal priority fires: the first declared, or a seeded random one.
    max_firings : int
        Immediate firings in one instant beyond which the net is said never to become quiet.
    """

    capacity: Literal["strong", "weak"] = "strong"
    persistence: Literal["intermediate", "atomic"] = "intermediate"
    choice: Literal["declared", "random"] = "declared"
    max_firings: int = 10_000

    def __post_init__(self) -> None:
        allowed = {"capacity": ("strong", "weak"), "persistence": ("intermediate", "atomic"), "choice": ("declared", "random")}
        for key, values in allowed.items():
            if getattr(self, key) not in values:
                raise NetError(f"semantics: `{key}` is {' or '.join(map(repr, values))}, got {shown(getattr(self, key))}")
        object.__setattr__(self, "max_firings", _count(self.max_firings, "semantics: `max_firings`", 1))
