"""What the three sets of parameters share: documented fields, checks that explain themselves, the server's own text.

A set is a frozen dataclass whose fields are made by `real`, `integer`, `flag` and `text`; `parameter_set` adds the checks and
the documentation. A field keeps its unit, meaning, range and the lowest protocol version that is told about it in its metadata.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from ..errors import ParameterError, did_you_mean

T = TypeVar("T")
S = TypeVar("S", bound="ParameterSet")


def _field(
    kind: str,
    default: Any,
    unit: str,
    meaning: str,
    since: int,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    below: float | None = None,
) -> Any:
    metadata = {"kind": kind, "unit": unit, "meaning": meaning, "since": since, "low": low, "high": high, "above": above, "below": below}
    return dataclasses.field(default=default, metadata=metadata)


def real(default: float, unit: str, meaning: str, *, since: int = 7, **limits: float) -> Any:
    """A finite number. `limits`: ``low``, ``high`` (inclusive), ``above``, ``below`` (exclusive)."""
    return _field("real", default, unit, meaning, since, **limits)


def integer(default: int, unit: str, meaning: str, *, since: int = 7, **limits: float) -> Any:
    """A whole number. `limits` as for `real`."""
    return _field("integer", default, unit, meaning, since, **limits)


def flag(default: bool, meaning: str, *, since: int = 7) -> Any:
    """A switch."""
    return _field("flag", default, "", meaning, since)


def text(default: str, meaning: str, *, since: int = 7) -> Any:
    """A string without quotes in it."""
    return _field("text", default, "", meaning, since)


def allowed(field: dataclasses.Field[Any]) -> str:
    """In words, which values `field` takes.

    Parameters
    ----------
    field : dataclasses.Field
        Made by one of the functions above.
    """
    m = field.metadata
    if m["kind"] == "flag":
        return "True or False"
    if m["kind"] == "text":
        return 'a string without " in it'
    words = "a whole number" if m["kind"] == "integer" else "a finite number"
    bounds = [
        f"{sign} {m[name]:g}" for name, sign in (("above", ">"), ("low", ">="), ("below", "<"), ("high", "<=")) if m[name] is not None
    ]
    return " ".join([words, *([" and ".join(bounds)] if bounds else [])])


def _checked(field: dataclasses.Field[Any], value: Any) -> Any:
    """`value` as the plain Python type of `field`, or None when it is not allowed."""
    m = field.metadata
    if m["kind"] == "flag":
        return bool(value) if isinstance(value, (bool, np.bool_)) else None
    if m["kind"] == "text":
        return value if isinstance(value, str) and '"' not in value else None
    if isinstance(value, (bool, np.bool_)):
        return None
    if m["kind"] == "integer":
        if not isinstance(value, (int, np.integer)) or abs(int(value)) > 2**31 - 1:
            return None
        number: float = int(value)
    else:
        if not isinstance(value, (int, float, np.integer, np.floating)):
            return None
        try:
            number = float(value)
        except OverflowError:
            return None
    inside = (
        math.isfinite(number)
        and (m["low"] is None or number >= m["low"])
        and (m["high"] is None or number <= m["high"])
        and (m["above"] is None or number > m["above"])
        and (m["below"] is None or number < m["below"])
    )
    return number if inside else None


def _short(value: Any) -> str:
    """`value` for a message; a whole number may have too many digits to be printed at all."""
    if isinstance(value, int) and value.bit_length() > 200:
        return f"a whole number of {value.bit_length()} bits"
    return repr(value)[:80]


def parameter_set(kind: str) -> Callable[[type[T]], type[T]]:
    """Class decorator for a frozen dataclass: unknown names and values out of range raise `ParameterError`.

    Parameters
    ----------
    kind : str
        What one parameter is called in messages, "server parameter" for example.
    """

    def decorate(cls: type[T]) -> type[T]:
        fields: dict[str, dataclasses.Field[Any]] = {f.name: f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
        plain_init = cls.__init__

        def __init__(self: T, **values: Any) -> None:
            for name in values:
                if name not in fields:
                    raise ParameterError(f"unknown {kind} {name!r}.{did_you_mean(name, fields)}")
            plain_init(self, **values)
            wrong = []
            for name, field in fields.items():
                given = getattr(self, name)
                value = _checked(field, given)
                if value is None:
                    wrong.append(f"{kind} {name!r}: takes {allowed(field)}, got {_short(given)}")
                else:
                    object.__setattr__(self, name, value)
            if wrong:
                raise ParameterError("; ".join(wrong))

        __init__.__doc__ = f"Every {kind} by name; what is not given has the default.\n\nRaises ParameterError."
        cls.__init__ = __init__  # type: ignore[method-assign, assignment]
        cls.__doc__ = f"{cls.__doc__ or ''}\n\nAttributes\n----------\n" + "\n".join(
            f"{f.name} : {f.type}{', ' + f.metadata['unit'] if f.metadata['unit'] else ''}\n"
            f"    {f.metadata['meaning']} (default {f.default!r}; {allowed(f)})."
            for f in fields.values()
        )
        cls._kind = kind  # type: ignore[attr-defined]
        return cls

    return decorate


_ITEM = re.compile(r'\(\s*(\w+)\s+("[^"]*"|[^\s()"]+)\s*\)')


def items_of(message: str, head: str) -> Iterator[tuple[str, str]]:
    """The pairs (name, value text) of ``(head (name value)(name value)...)``.

    Raises
    ------
    ParameterError
        When the message does not have that form.
    """
    stripped = message.strip().rstrip("\0")
    start = f"({head}"
    body = stripped[len(start) : -1]
    if not stripped.startswith(start) or not stripped.endswith(")") or _ITEM.sub("", body).strip():
        raise ParameterError(f"not a ({head} (name value)...) message: {message[:80]!r}")
    for match in _ITEM.finditer(body):
        yield match.group(1), match.group(2)


def value_of(field: dataclasses.Field[Any], word: str, kind: str) -> Any:
    """The value that `word` of the server's text means for `field`.

    Raises
    ------
    ParameterError
        When it is not a value of that type.
    """
    try:
        match field.metadata["kind"]:
            case "flag":
                return {"0": False, "1": True, "true": True, "false": False, "on": True, "off": False}[word.lower()]
            case "text":
                return word[1:-1] if word.startswith('"') else word
            case "integer":
                return int(_written(word))
            case _:
                return float(_written(word))
    except (KeyError, ValueError):
        raise ParameterError(f"{kind} {field.name!r}: takes {allowed(field)}, got the text {word[:80]!r}") from None


def word_of(field: dataclasses.Field[Any], value: Any, digits: int = 6) -> str:
    """The server's text for `value`: ``%g`` reals, ``0``/``1`` switches, quoted strings (specification/protocol.md 5.1)."""
    match field.metadata["kind"]:
        case "flag":
            return str(int(value))
        case "text":
            return f'"{value}"'
        case "integer":
            return str(value)
        case _:
            return f"{value:.{digits}g}"


class ParameterSet:
    """Methods of every set of parameters."""

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Every parameter's name, in the order of the documentation."""
        return tuple(f.name for f in dataclasses.fields(cls))  # type: ignore[arg-type]

    @classmethod
    def describe(cls, name: str) -> Mapping[str, Any]:
        """Unit, meaning, default, range and protocol version of one parameter.

        Raises
        ------
        ParameterError
            When there is no such parameter; the message suggests the nearest.
        """
        field = cls._field_named(name)
        return {"name": name, "default": field.default, "allowed": allowed(field), **field.metadata}

    @classmethod
    def from_mapping(cls: type[S], values: Mapping[str, Any]) -> S:
        """A set from the numbers of a JSON log or recording: switches may be 0 or 1, an ``id`` is passed over.

        Raises
        ------
        ParameterError
            When a name is unknown or a value not allowed.
        """
        plain: dict[str, Any] = {}
        for name, value in values.items():
            if name == "id":
                continue
            match cls._field_named(name).metadata["kind"]:
                case "flag" if type(value) is int and value in (0, 1):
                    plain[name] = bool(value)
                case "text" if isinstance(value, str):
                    plain[name] = value.strip('"')
                case _:
                    plain[name] = value
        return cls(**plain)

    @classmethod
    def _field_named(cls, name: str) -> dataclasses.Field[Any]:
        for field in dataclasses.fields(cls):  # type: ignore[arg-type]
            if field.name == name:
                return field
        kind: str = cls._kind  # type: ignore[attr-defined]
        raise ParameterError(f"unknown {kind} {name!r}.{did_you_mean(name, cls.names())}")

    @classmethod
    def _values(cls, items: Iterator[tuple[str, str]]) -> dict[str, Any]:
        """The values of the items of a message; unknown names and unreadable values raise `ParameterError`."""
        kind: str = cls._kind  # type: ignore[attr-defined]
        return {name: value_of(cls._field_named(name), word, kind) for name, word in items}

    def _message(self, head: str, version: int | None, alphabetical: bool, digits: int = 6) -> str:
        """``(head (name value)...)`` with the parameters that a client of protocol `version` is told (None: all)."""
        if version is not None and version < 8:
            raise ParameterError(f"clients of protocol 8 and newer are told names and values, got version {version!r}")
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        if alphabetical:
            fields = tuple(sorted(fields, key=lambda f: f.name))
        told = (f for f in fields if version is None or 0 < f.metadata["since"] <= version)
        return f"({head}" + "".join(f"({f.name} {word_of(f, getattr(self, f.name), digits)})" for f in told) + ")"


def _written(word: str) -> str:
    """`word`, unless it is a number to Python alone."""
    if "_" in word or not word.isascii():
        raise ValueError(word)
    return word
