"""Whether what a page gives fits the types that a function names: said before the function is called, in one place for all of them."""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from inspect import Parameter, signature
from typing import Any, Union, get_args, get_origin, get_type_hints

from ..errors import ParameterError

LONGEST = 80
"""Characters of what was given that an error repeats."""
LARGEST = 2**63
"""Whole numbers lie between this and its negative."""
WORDS = {str: "a text", int: "a whole number", float: "a finite number", bool: "true or false", type(None): "null"}


@lru_cache(maxsize=512)
def types_of(function: Callable[..., Any]) -> Mapping[str, Any]:
    """Argument -> the type that a function names for it."""
    return {name: kind for name, kind in get_type_hints(function).items() if name != "return"}


def check_arguments(call: str, function: Callable[..., Any], given: Mapping[str, Any]) -> None:
    """Refuse arguments that a function does not take, or not of that type.

    Parameters
    ----------
    call : str
        As a page names it.
    function : callable
        With type hints; an argument without one may be anything.
    given : mapping of str to object
        What JSON can say.

    Raises
    ------
    ParameterError
        Names the call, the argument, what was given and what is allowed.
    """
    taken = signature(function).parameters
    for name in given:
        if name not in taken:
            allowed = ", ".join(taken) or "none"
            raise ParameterError(f"call {call!r}: unexpected keyword argument {name!r}; it takes {allowed}")
    for name, parameter in taken.items():
        if name not in given and parameter.default is Parameter.empty:
            raise ParameterError(f"call {call!r}: missing a required argument: {name!r}")
    for name, kind in types_of(function).items():
        if name in given and not fits(given[name], kind):
            raise ParameterError(f"call {call!r}, argument {name!r}: {described(kind)} is needed, got {_short(given[name])}")


def fits(value: Any, kind: Any) -> bool:
    """Whether a value is of a type, all the way down."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any:
        return True
    if origin in (Union, types.UnionType):
        return any(fits(value, one) for one in inner)
    if origin in (list, Sequence):
        return isinstance(value, list) and all(fits(one, inner[0]) for one in value)
    if origin in (dict, Mapping):
        return isinstance(value, dict) and all(fits(k, inner[0]) and fits(v, inner[1]) for k, v in value.items())
    if kind is bool or kind is str or kind is type(None):
        return isinstance(value, kind)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    if kind is int:
        return isinstance(value, int) and -LARGEST < value < LARGEST
    return -LARGEST < value < LARGEST if isinstance(value, int) else math.isfinite(value)


def described(kind: Any) -> str:
    """A type in words."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any:
        return "anything"
    if origin in (Union, types.UnionType):
        return " or ".join(described(one) for one in inner)
    if origin in (list, Sequence):
        return f"a list of {_plural(inner[0])}"
    if origin in (dict, Mapping):
        return "an object" if inner[1] is Any else f"an object of {_plural(inner[1])}"
    return WORDS.get(kind, str(kind))


def _plural(kind: Any) -> str:
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (list, Sequence):
        return f"lists of {_plural(inner[0])}"
    return {str: "texts", int: "whole numbers", float: "finite numbers", bool: "truth values"}.get(kind, "objects")


def _short(value: Any) -> str:
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**LONGEST else "a number of too many digits"
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
