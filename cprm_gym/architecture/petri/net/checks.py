"""Checks of what nets are written with: names, numbers and expressions; errors show what was given."""

from __future__ import annotations

import reprlib
import sys

from ....errors import ExpressionError, NetError
from ...expressions import CONSTANTS, FUNCTIONS, WORDS, Expression

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


class _Short(reprlib.Repr):
    def repr_int(self, x: int, level: int) -> str:
        return shown(x)


_SHORT = _Short()
_SHORT.maxother = _SHORT.maxlong = _SHORT.maxstring = 80


def check_name(name: object, what: str) -> None:
    """Refuse a name that is not short printable text."""
    if not isinstance(name, str):
        raise NetError(f"the name of a {what} is text, got {type(name).__name__}: {shown(name)}")
    if not name or len(name) > 200 or not name.isprintable() or name != name.strip():
        raise NetError(f"the name of a {what} is 1 to 200 printable characters without spaces around them, got {name[:80]!r}")
    if name in FUNCTIONS or name in CONSTANTS or name in WORDS:
        raise NetError(f"{name!r} is a word of the expression language and cannot name a {what}")


def is_word(value: object, words: tuple[str, ...]) -> bool:
    """Whether `value` is one of the words, whatever else it may be."""
    return isinstance(value, str) and value in words


def whole_number(value: object, what: str, least: int) -> int:
    """`value` as a whole number of at least `least`, or an error that names `what`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or (isinstance(value, float) and not value.is_integer()):
        raise NetError(f"{what} is a whole number, got {shown(value)}")
    if not least <= value <= MAX_WEIGHT:
        raise NetError(f"{what} is {least} to {MAX_WEIGHT}, got {shown(value)}")
    return int(value)


def real_number(value: object, what: str) -> float:
    """`value` as a finite number, or an error that names `what`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= sys.float_info.max:
        raise NetError(f"{what} is a finite number, got {shown(value)}")
    return int(value) if float(value).is_integer() and abs(value) <= MAX_WEIGHT else float(value)


def check_expression(text: object, what: str) -> None:
    """Refuse text that is no expression."""
    if not isinstance(text, str):
        raise NetError(f"{what} is an expression written as text, got {type(text).__name__}: {shown(text)}")
    try:
        Expression(text)
    except ExpressionError as error:
        raise NetError(f"{what}: {error}") from error


def place_name(name: object, where: str) -> str:
    """`name`, if it is text."""
    if not isinstance(name, str):
        raise NetError(f"{where} names places by text, got {shown(name)}")
    return name


def place_names(value: object, where: str) -> tuple[str, ...]:
    """`value` as a tuple of names."""
    if not isinstance(value, (tuple, list)) or not all(isinstance(name, str) for name in value):
        raise NetError(f"{where} takes a tuple of place names, got {shown(value)}")
    return tuple(value)
