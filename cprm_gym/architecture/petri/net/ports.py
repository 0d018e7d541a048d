"""The interface of a module."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ....errors import NetError
from .checks import is_word, place_name, place_names, shown, whole_number
from .values import FrozenMap


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
            object.__setattr__(self, key, place_names(value, f"ports: `{key}`"))
        for key in ("begin", "ongoing", "done"):
            value = getattr(self, key)
            if value is not None and (not isinstance(value, str) or not value):
                raise NetError(f"ports: `{key}` is the name of a place, got {shown(value)}")
        for name, count in Counter(self.all).items():
            if count > 1:
                raise NetError(f"ports: place {name!r} is named {count} times")
        object.__setattr__(self, "within", whole_number(self.within, "ports: `within`", 1))
        if not isinstance(self.answers, Mapping):
            raise NetError(f"ports: `answers` takes a mapping from interrupt to outcomes, got {shown(self.answers)}")
        answers = {
            place_name(key, "ports: `answers`"): place_names(value, f"ports: `answers` of {key!r}") for key, value in self.answers.items()
        }
        for interrupt, outcomes in answers.items():
            if interrupt not in self.interrupts:
                raise NetError(f"ports: `answers` names {interrupt!r}, which is not an interrupt")
            for outcome in outcomes:
                if outcome not in self.outcomes:
                    raise NetError(f"ports: `answers` of {interrupt!r} names {outcome!r}, which is neither done nor an error")
        object.__setattr__(self, "answers", FrozenMap(answers))
        if not is_word(self.idle_interrupts, ("consumed", "kept")):
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
