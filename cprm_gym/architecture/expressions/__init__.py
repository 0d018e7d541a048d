"""One small language of expressions, written as text, for math transitions, selections and conditions.

``"clip(6 * ball.distance, 0, 100)"`` is parsed through an allow-list and never executed as Python. The same tree is

* interpreted in Python: `Expression.evaluate`;
* compiled to byte code that one kernel runs for many copies at once: `Assembler`;
* bounded: `Expression.bounds` encloses its values over ranges of its names.

**Meaning.** Every value is a real number; comparisons, ``and``, ``or`` and ``not`` give 1 or 0, and anything but 0 counts as
true. ``and``, ``or`` and ``a if c else b`` look only at the parts that decide. An operation without a finite result (division
by zero, ``sqrt(-1)``, an overflow) makes the whole expression undefined, unless one of these three passes over it: this is how
a text guards itself (``ball.distance / speed if speed > 0 else 0``). Undefined is an error, never a NaN handed on.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ...errors import ExpressionError, did_you_mean
from .compiler import Assembler, Code
from .interpreter import interpret
from .intervals import Interval, bound
from .language import CONSTANTS, FUNCTIONS, WORDS, Node, complaint, parse, unparse

__all__ = ["CONSTANTS", "FUNCTIONS", "WORDS", "Assembler", "Code", "Expression", "Interval", "Node", "parse", "unparse"]


@functools.lru_cache(maxsize=4096)
def _parsed(text: str) -> Node:
    return parse(text)


@dataclass(frozen=True)
class Expression:
    """A checked expression.

    Parameters
    ----------
    text : str
        Such as ``"abs(bearing) > 3 and ball.seen"``.

    Raises
    ------
    ExpressionError
        When the text is not in the language; the message shows the place of the mistake.
    """

    text: str
    tree: Node = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.text, str):
            raise ExpressionError(f"an expression is text, got {type(self.text).__name__}: {self.text!r}")
        object.__setattr__(self, "tree", _parsed(self.text))

    @property
    def names(self) -> tuple[str, ...]:
        """Every name it reads, in order of appearance, each once."""
        found = sorted((node.at, node.name) for node in self.tree.walk() if node.op == "name")
        return tuple(dict.fromkeys(name for _, name in found))

    def evaluate(self, values: Mapping[str, float]) -> float:
        """Its value where each name has the value in `values`.

        Raises
        ------
        ExpressionError
            When a name is missing, or the result is undefined; the message shows the operands.
        """
        for node in self.tree.walk():
            if node.op == "name" and node.name not in values:
                known = f"{did_you_mean(node.name, values)} Known: {', '.join(sorted(values)) or 'none'}"
                raise complaint(self.text, node.at, f"unknown name {node.name!r}.{known}")
        result = interpret(self.tree, values)
        if not math.isfinite(result):
            operands = ", ".join(f"{name} = {values[name]:g}" for name in self.names)
            raise ExpressionError(f"expression {self.text!r} has no finite value at {operands or 'no operands'}")
        return result

    def bounds(self, ranges: Mapping[str, tuple[float, float]]) -> Interval:
        """An enclosure of its values while every name stays within its range.

        Parameters
        ----------
        ranges : mapping
            Name -> (low, high), both finite.

        Returns
        -------
        Interval
            ``low``, ``high``, and ``total``: False when it may be undefined somewhere in the ranges.
        """
        for name in self.names:
            if name not in ranges:
                raise ExpressionError(f"expression {self.text!r}: no range for {name!r}.{did_you_mean(name, ranges)}")
            low, high = ranges[name]
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                raise ExpressionError(f"expression {self.text!r}: the range of {name!r} is (low, high), finite, got {ranges[name]}")
        return bound(self.tree, ranges)

    def rename(self, rename: Callable[[str], str]) -> Expression:
        """The same expression with every name replaced by ``rename(name)``."""
        return Expression(unparse(self.tree, rename))
