"""What a finite run shows: linear temporal logic over finite traces (LTLf) and signal temporal logic (STL), with robustness.

A run is a set of signals, one number a cycle. An atom is an expression of the one small language, true where it is not 0. Operators::

    !f    f & g    f | g    f -> g
    X f       in the next cycle, and there is one           N f       in the next cycle, if there is one
    F f       now or later                                  G f       now and always later
    f U g     g comes, and f until then                     f W g     the same, or f for ever
    f R g     g holds up to and with the first f, or for ever
    F[a,b] f  G[a,b] f  f U[a,b] g    within cycles a to b from now

On a finite run what would lie after its end does not come: F is false there, G true (De Giacomo, Vardi 2013). `Property.robustness` is the
least change of the signals' margins that could change the answer (Donze, Maler 2010): of ``x < c`` it is c - x; positive means true.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ExpressionError, did_you_mean
from ...expressions import Node, parse, unparse
from ...prm.model.formulas import Formula

Signals = Mapping[str, NDArray[np.float64]]
"""Name -> (T,) values, one a cycle."""

_OPERATOR = re.compile(r"\s*(->|[!&|()]|[XNFGUWR](?![\w.]))")
_WINDOW = re.compile(r"\s*\[\s*(\d+)\s*,\s*(\d+|inf)\s*\]")
_WITHIN_ATOM = re.compile(r"\s*([-+*/%<>=]|!=|\band\b|\bor\b|\bif\b)")
NESTING = 100
"""Deepest formula."""


class _Formula(NamedTuple):
    """An operator, its operands and its window; of an atom its expression."""

    op: str
    args: tuple[_Formula, ...] = ()
    window: tuple[int, int | None] | None = None
    atom: str = ""


@dataclass(frozen=True)
class Property:
    """A formula that is true or false of a run.

    Parameters
    ----------
    text : str

    Raises
    ------
    ExpressionError
        When the text is not in the language; the message shows the place.

    Examples
    --------
    >>> import numpy as np
    >>> near = Property("F[0,3] (ball.distance < 1) & G speed <= 1.05")
    >>> run = {"ball.distance": np.array([3.0, 2.0, 0.9]), "speed": np.array([0.2, 1.0, 0.8])}
    >>> near.holds(run), round(near.robustness(run), 3)
    (True, 0.05)
    """

    text: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "_tree", _Reader(self.text).formula())

    @property
    def names(self) -> tuple[str, ...]:
        """The signals that it reads."""
        found: list[str] = []
        todo = [self._tree]  # type: ignore[attr-defined]
        while todo:
            f = todo.pop()
            todo += f.args
            if f.atom:
                found += _read(f.atom).names
        return tuple(dict.fromkeys(found))

    def holds(self, signals: Signals) -> bool:
        """Whether it is true of a run, from its first cycle.

        Raises
        ------
        ExpressionError
            When a signal is missing, or the signals are empty or of different lengths.
        """
        return bool(_values(self._tree, *_checked(self, signals), _TRUTH)[0] > 0)  # type: ignore[attr-defined]

    def robustness(self, signals: Signals) -> float:
        """By how much it is true, or false where negative; infinite where no margin matters.

        Raises
        ------
        ExpressionError
        """
        return float(_values(self._tree, *_checked(self, signals), _MARGIN)[0])  # type: ignore[attr-defined]


def _checked(what: Property, signals: Signals) -> tuple[Signals, int]:
    for name in what.names:
        if name not in signals:
            raise ExpressionError(f"property {what.text!r}: no signal {name!r}.{did_you_mean(name, signals)} Known: {', '.join(signals)}")
    lengths = {len(signals[name]) for name in what.names} or {len(v) for v in signals.values()} or {1}
    if len(lengths) > 1 or 0 in lengths:
        raise ExpressionError(f"property {what.text!r}: signals are of one length, from 1; got lengths {sorted(lengths)}")
    return {name: np.asarray(signals[name], float) for name in what.names}, lengths.pop()


class _Reader:
    """Recursive descent over the text."""

    def __init__(self, text: str) -> None:
        if not isinstance(text, str) or not text.strip():
            raise ExpressionError(f"a property is text, got {text!r}")
        self.text, self.at, self.depth = text, 0, 0

    def formula(self) -> _Formula:
        found = self.implication()
        if self.text[self.at :].strip():
            raise self.complaint("something follows that does not belong to the formula")
        return found

    def complaint(self, message: str) -> ExpressionError:
        return ExpressionError(f"property {self.text!r}, column {self.at + 1}: {message}")

    def next(self) -> str:
        found = _OPERATOR.match(self.text, self.at)
        return found[1] if found else ""

    def take(self) -> None:
        found = _OPERATOR.match(self.text, self.at)
        assert found is not None
        self.at = found.end()

    def window(self) -> tuple[int, int | None] | None:
        found = _WINDOW.match(self.text, self.at)
        if found is None:
            return None
        low, high = int(found[1]), None if found[2] == "inf" else int(found[2])
        if high is not None and high < low:
            raise self.complaint(f"window [{low}, {high}] is empty")
        self.at = found.end()
        return low, high

    def implication(self) -> _Formula:
        self.depth += 1
        if self.depth > NESTING:
            raise self.complaint(f"formulas are nested up to {NESTING} deep")
        left = self.either()
        if self.next() == "->":
            self.take()
            left = _Formula("|", (_Formula("!", (left,)), self.implication()))
        self.depth -= 1
        return left

    def either(self) -> _Formula:
        left = self.both()
        while self.next() == "|":
            self.take()
            left = _Formula("|", (left, self.both()))
        return left

    def both(self) -> _Formula:
        left = self.until()
        while self.next() == "&":
            self.take()
            left = _Formula("&", (left, self.until()))
        return left

    def until(self) -> _Formula:
        left = self.unary()
        while (op := self.next()) and op in "UWR":
            self.take()
            window = self.window() if op == "U" else None
            left = _Formula(op, (left, self.unary()), window)
        return left

    def unary(self) -> _Formula:
        op = self.next()
        if op and op in "!XNFG":
            self.take()
            window = self.window() if op in "FG" else None
            self.depth += 1
            if self.depth > NESTING:
                raise self.complaint(f"formulas are nested up to {NESTING} deep")
            found = _Formula(op, (self.unary(),), window)
            self.depth -= 1
            return found
        if op == "(" and not _WITHIN_ATOM.match(self.text, self.closing()):
            self.take()
            found = self.implication()
            if self.next() != ")":
                raise self.complaint("a closing parenthesis is missing")
            self.take()
            return found
        return self.atom()

    def closing(self) -> int:
        """The place after the parenthesis that closes the one that comes next."""
        level = 0
        for at in range(self.at, len(self.text)):
            level += {"(": 1, ")": -1}.get(self.text[at], 0)
            if level == 0 and self.text[at] == ")":
                return at + 1
        raise self.complaint("a closing parenthesis is missing")

    def atom(self) -> _Formula:
        """An expression: up to the next operator outside of its parentheses."""
        begin = at = self.at
        level = 0
        while at < len(self.text):
            found = _OPERATOR.match(self.text, at)
            word = found[1] if found else ""
            if level == 0 and word and word != "(" and not (word == "!" and self.text[found.end() : found.end() + 1] == "="):  # type: ignore[union-attr]
                boundary = at == begin or not (self.text[at - 1].isalnum() or self.text[at - 1] in "_.") or self.text[at].isspace()
                if boundary or word in "!&|)->":
                    break
            level += {"(": 1, ")": -1}.get(self.text[at], 0)
            at += 1
        text = self.text[begin:at].strip()
        if not text:
            raise self.complaint("an expression is missing")
        try:
            parse(text)
        except ExpressionError as error:
            raise self.complaint(f"{error}") from None
        self.at = at
        return _Formula("atom", atom=text)


@functools.lru_cache(maxsize=1024)
def _read(text: str) -> Formula:
    return Formula(text)


def _truth(text: str, signals: Signals, size: int) -> NDArray[np.float64]:
    """1 where an expression is not 0, -1 elsewhere."""
    return np.where(_read(text)(signals, size) != 0.0, 1.0, -1.0)


def _margin(text: str, signals: Signals, size: int) -> NDArray[np.float64]:
    """By how much an expression is true: of comparisons the difference of their sides, else infinite."""
    return _margin_of(_read(text).node, signals, size)


def _margin_of(node: Node, signals: Signals, size: int) -> NDArray[np.float64]:
    if node.op in ("and", "or"):
        return (np.minimum if node.op == "and" else np.maximum)(*(_margin_of(a, signals, size) for a in node.args))
    if node.op == "not":
        return -_margin_of(node.args[0], signals, size)
    if node.op in ("<", "<=", ">", ">=", "==", "!="):
        left, right = (_read(unparse(a))(signals, size) for a in node.args)
        gap = np.asarray(right - left if node.op in ("<", "<=") else left - right if node.op in (">", ">=") else -np.abs(left - right))
        if node.op == "!=":
            gap = -gap
        holds = _read(unparse(node))(signals, size) != 0.0
        return np.where(gap == 0.0, np.where(holds, 0.0, -0.0), gap)
    return np.where(_read(unparse(node))(signals, size) != 0.0, np.inf, -np.inf)


_TRUTH, _MARGIN = _truth, _margin


def _values(f: _Formula, signals: Signals, size: int, atom: object) -> NDArray[np.float64]:
    """Value of a formula in every cycle: minima and maxima of its atoms'."""
    if f.op == "atom":
        return atom(f.atom, signals, size)  # type: ignore[operator,no-any-return]
    parts = [_values(g, signals, size, atom) for g in f.args]
    if f.op == "!":
        return -parts[0]
    if f.op in "&|":
        return (np.minimum if f.op == "&" else np.maximum)(*parts)
    if f.op in "XN":
        return np.append(parts[0][1:], -np.inf if f.op == "X" else np.inf)
    if f.op == "F":
        return _within(parts[0], f.window)
    if f.op == "G":
        return -_within(-parts[0], f.window)
    if f.op == "U":
        return _until(parts[0], parts[1], f.window)
    if f.op == "W":  # f U g | G f
        return np.maximum(_until(parts[0], parts[1], None), -_within(-parts[0], None))
    return -_until(-parts[0], -parts[1], None)  # f R g is not (not f U not g)


def _within(x: NDArray[np.float64], window: tuple[int, int | None] | None) -> NDArray[np.float64]:
    """Largest value from now on, or within a window; nothing lies after the end."""
    low, high = window or (0, None)
    out = np.full(len(x), -np.inf)
    if low >= len(x):
        return out
    if high is None or high >= len(x):
        out[: len(x) - low] = np.maximum.accumulate(x[::-1])[::-1][low:]
        return out
    for k in range(low, high + 1):
        shifted = x[k:]
        out[: len(shifted)] = np.maximum(out[: len(shifted)], shifted)
    return out


def _until(f: NDArray[np.float64], g: NDArray[np.float64], window: tuple[int, int | None] | None) -> NDArray[np.float64]:
    """Best of g at some cycle and the worst of f before."""
    if window is None:
        out = np.empty(len(f))
        later = -np.inf
        for t in range(len(f) - 1, -1, -1):
            later = max(g[t], min(f[t], later))
            out[t] = later
        return out
    low, high = window
    last = len(f) - 1 if high is None else min(high, len(f) - 1)
    out = np.full(len(f), -np.inf)
    held = np.full(len(f), np.inf)  # the worst of f over the k cycles from now
    for k in range(last + 1):
        m = len(f) - k
        if k >= low:
            out[:m] = np.maximum(out[:m], np.minimum(g[k:], held[:m]))
        held[:m] = np.minimum(held[:m], f[k:])
    return out


def properties(texts: Sequence[str] | Mapping[str, str]) -> dict[str, Property]:
    """Properties by name; texts without names are their own.

    Raises
    ------
    ExpressionError
    """
    return {name: Property(text) for name, text in (texts.items() if isinstance(texts, Mapping) else ((t, t) for t in texts))}
