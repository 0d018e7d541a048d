"""Choices of meaning that differ between dialects of Petri nets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ....errors import NetError
from .checks import is_word, shown, whole_number


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
            if not is_word(getattr(self, key), values):
                raise NetError(f"semantics: `{key}` is {' or '.join(map(repr, values))}, got {shown(getattr(self, key))}")
        object.__setattr__(self, "max_firings", whole_number(self.max_firings, "semantics: `max_firings`", 1))
