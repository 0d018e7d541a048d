"""What every analysis answers: yes, no or unknown, why, and a run that shows it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

TITLES: Mapping[str, str] = {
    "start": "a token in begin marks ongoing in the same instant",
    "exclusive end": "every run that ends, ends in exactly one outcome, and ongoing is empty in that instant",
    "clean": "at the end every inside place is as at the start (or begin overwrites it) and no clock is left",
    "interruption": "an interrupt is answered in time, in an outcome declared for it, and leaves nothing",
    "idle interrupt": "an interrupt while idle does what the ports declare",
    "no spontaneous activity": "without begin nothing fires",
    "bounded": "no place without a capacity fills up",
    "may end": "from everywhere some behaviour of the environment leads to an end",
    "becomes quiet": "immediate transitions never fire for ever within one instant",
}
"""Clause of a module's contract -> what it promises."""


@dataclass(frozen=True)
class Step:
    """One step of a run.

    Attributes
    ----------
    cycle : int
        0 throughout where time is left out.
    what : str
        The transition that fires, or the cell that a variable is found in.
    kind : str
        ``"fires"``, ``"outside"``, ``"observed"``.
    marking : dict
        The marked places afterwards; empty where time is left out.
    """

    cycle: int
    what: str
    kind: str = "fires"
    marking: Mapping[str, int] = field(default_factory=dict)

    def to_json(self) -> list[Any]:
        """As plain values."""
        return [self.cycle, self.kind, self.what, dict(self.marking)]

    def __str__(self) -> str:
        return f"cycle {self.cycle}: {self.what}" + (" fires" if self.kind == "fires" else "")


@dataclass(frozen=True)
class Verdict:
    """An answer, and what shows it.

    Attributes
    ----------
    holds : bool or None
        None: not known.
    why : str
        What is wrong, what proves it, or why it is not known.
    run : tuple of Step
        A shortest run from the start that shows it.
    loop : tuple of Step
        What may follow for ever.
    marking : dict from place to tokens
        Where the run ends.
    name : str
        Of a contract's clause: a key of `TITLES`.
    """

    holds: bool | None
    why: str = ""
    run: tuple[Step, ...] = ()
    loop: tuple[Step, ...] = ()
    marking: Mapping[str, int] = field(default_factory=dict)
    name: str = ""

    @property
    def title(self) -> str:
        """What a clause promises, in words."""
        return TITLES.get(self.name, self.name)

    @property
    def firings(self) -> tuple[str, ...]:
        """The transitions of the net that fire in `run`, in order."""
        return tuple(step.what for step in self.run if step.kind == "fires")

    def to_json(self) -> dict[str, Any]:
        """As plain values; empty parts are left out."""
        out: dict[str, Any] = {"clause": self.name, "promise": self.title} if self.name else {}
        out["holds"] = self.holds
        parts = {"why": self.why, "run": [s.to_json() for s in self.run], "loop": [s.to_json() for s in self.loop]}
        return {**out, **{key: value for key, value in {**parts, "marking": dict(self.marking)}.items() if value}}

    def __str__(self) -> str:
        return {True: "yes", False: "no", None: "unknown"}[self.holds] + (f" ({self.why})" if self.why else "")


UNKNOWN = Verdict(None)


def untimed_run(firings: Iterable[str]) -> tuple[Step, ...]:
    """A firing sequence of the untimed view as steps."""
    return tuple(Step(0, name) for name in firings)
