"""Numbers of a run: what it was given, how long it was, or what its signals come to."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....errors import ExpressionError, ModelError, did_you_mean
from ...prm.model.formulas import Formula
from .means import Range
from .runs import Run

LENGTH = "length"
"""The cycles of a run."""
OVER = {"sum": np.sum, "mean": np.mean, "max": np.max, "min": np.min, "first": lambda x: x[0], "last": lambda x: x[-1]}
"""What can be made of a signal's values."""


@dataclass(frozen=True)
class Number:
    """A number that every run has.

    Parameters
    ----------
    text : str
        ``"length"``; the name of a value that runs carry, such as ``"return"``; or one of sum, mean, max, min, first, last and an
        expression over signals: ``"max hypot(obs.o0, obs.o1)"``.
    within : (low, high), optional
        Between which it lies, whatever happens.

    Raises
    ------
    ModelError, ExpressionError

    Examples
    --------
    >>> Number("max 2 * speed").of(Run("goal", 2, {"speed": np.array([0.1, 0.4, 0.2])}))
    0.8
    """

    text: str
    within: Range | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.text, str) or not self.text.strip():
            raise ModelError(f"a number of a run is named by a text, got {self.text!r}")
        if self.within is not None:
            try:
                low, high = self.within
                right = math.isfinite(low) and math.isfinite(high) and low <= high
            except (TypeError, ValueError):
                right = False
            if not right:
                raise ModelError(f"number {self.text!r}: the range {self.within!r} needs two finite numbers that do not fall")
        word, _, rest = self.text.strip().partition(" ")
        formula = Formula(rest.strip()) if word in OVER and rest.strip() else None
        object.__setattr__(self, "_formula", formula)
        object.__setattr__(self, "_over", word)

    @property
    def signals(self) -> bool:
        """Whether it is made of signals."""
        return self._formula is not None  # type: ignore[attr-defined,no-any-return]

    def of(self, run: Run) -> float:
        """Its value in a run.

        Raises
        ------
        ModelError, ExpressionError
            When the run does not have it, or it is not finite or outside of the range.
        """
        value = self._of(run)
        if not math.isfinite(value):
            raise ModelError(f"number {self.text!r}: {value} is not finite")
        if self.within is not None and not self.within[0] <= value <= self.within[1]:
            raise ModelError(
                f"number {self.text!r}: {value:g} lies outside of the stated range from {self.within[0]:g} to {self.within[1]:g}"
            )
        return value

    def _of(self, run: Run) -> float:
        formula: Formula | None = self._formula  # type: ignore[attr-defined]
        if formula is not None:
            for name in formula.names:
                if name not in run.signals:
                    known = ", ".join(run.signals) or "none"
                    raise ExpressionError(f"number {self.text!r}: no signal {name!r}.{did_you_mean(name, run.signals)} Known: {known}")
            size = len(next(iter(run.signals.values()), (0.0,)))
            return float(OVER[self._over](formula(run.signals, size)))  # type: ignore[attr-defined,operator]
        if self.text in run.values:
            return float(run.values[self.text])
        if self.text == LENGTH:
            return float(run.cycles)
        names = (LENGTH, *run.values)
        raise ModelError(
            f"number {self.text!r}: runs do not have it.{did_you_mean(self.text, names)} Known: {', '.join(names)}, and "
            f"{', '.join(OVER)} of an expression over signals"
        )


def numbers(given: Sequence[str] | Mapping[str, Range | None]) -> dict[str, Number]:
    """Numbers by their texts; those with a range have it stated.

    Raises
    ------
    ModelError, ExpressionError
    """
    pairs = given.items() if isinstance(given, Mapping) else ((text, None) for text in given)
    return {text: Number(text, within) for text, within in pairs}
