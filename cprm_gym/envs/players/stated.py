"""Frozen values that are also given as mappings of their fields, as options of environments are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from ...errors import ParameterError, did_you_mean

Stated = TypeVar("Stated")


def stated(kind: type[Stated], given: Stated | Mapping[str, Any], what: str, entry: str = "") -> Stated:
    """A value of a dataclass, or the one that a mapping of its fields means; what is left out is the default.

    Parameters
    ----------
    kind : dataclass
    given : a value of it, or a mapping
    what : str
        The option's name, for messages.
    entry : str
        What a field is called in messages.

    Raises
    ------
    ParameterError
        For what is neither, or a field that there is not.
    """
    if isinstance(given, kind):
        return given
    if not isinstance(given, Mapping):
        raise ParameterError(f"{what}: {type(given).__name__} {given!r:.60} given; expected {kind.__name__} or a mapping of its fields")
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    for name in given:
        if name not in known:
            hint = did_you_mean(str(name), known)
            raise ParameterError(f"{what}: there is no {entry}{' ' if entry else ''}{name!r}.{hint} There are: {', '.join(known)}.")
    return kind(**given)
