"""Places: discrete, continuous, input, belief, math and object places, and the selection of objects."""

from __future__ import annotations

from dataclasses import dataclass

from ....errors import NetError
from .checks import check_expression, check_name, is_word, real_number, shown, whole_number


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
            object.__setattr__(self, "capacity", whole_number(self.capacity, f"place {self.name!r}: capacity", 1))
        object.__setattr__(self, "tokens", whole_number(self.tokens, f"place {self.name!r}: tokens", 0))
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
        object.__setattr__(self, "value", real_number(self.value, f"place {self.name!r}: value"))


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
        object.__setattr__(self, "value", real_number(self.value, f"place {self.name!r}: value"))


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
        object.__setattr__(self, "value", real_number(self.value, f"place {self.name!r}: value"))


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
        check_expression(self.expression, f"math place {self.name!r}")
        object.__setattr__(self, "default", real_number(self.default, f"place {self.name!r}: default"))


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
        check_expression(self.best, f"selection of a {self.class_name}: best")
        if not is_word(self.where, ("",)):
            check_expression(self.where, f"selection of a {self.class_name}: where")
        object.__setattr__(self, "k", whole_number(self.k, "selection: k", 1))
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
