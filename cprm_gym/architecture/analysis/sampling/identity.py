"""What is sampled, as a short text: that a journal goes on with the same chain, environment and policy and no other.

Numbers, texts, containers and arrays count by what they hold, objects by their class and what they keep, functions by their code, what they
close over and their defaults. What a class or module defines outside of that does not count: a journal does not outlive a change of code.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import types
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any

import numpy as np

from ....errors import ModelError

DEEPEST = 200
"""Objects within objects."""


def fingerprint(thing: Any) -> str:
    """Sixteen hexadecimal digits that another thing hardly has.

    Raises
    ------
    ModelError
        For what keeps its inside to itself, such as an open file; give it an attribute ``identity``, a text.

    Examples
    --------
    >>> fingerprint((1, "a")) == fingerprint((1, "a")), fingerprint((1, "a")) == fingerprint((1, "b"))
    (True, False)
    """
    digest = hashlib.sha256()
    for part in _parts(thing, {}, 0):
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()[:16]


def _parts(thing: Any, seen: dict[int, tuple[int, Any]], depth: int) -> Iterator[bytes]:
    kind = type(thing)
    yield f"{kind.__module__}.{kind.__qualname__}".encode()
    if thing is None or isinstance(thing, (bool, int, float, complex, str, bytes, range, slice, Enum)):
        yield repr(thing).encode()
        return
    if isinstance(thing, (type, types.ModuleType, types.BuiltinFunctionType)):
        yield f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', thing.__name__)}".encode()
        return
    if id(thing) in seen:
        yield str(seen[id(thing)][0]).encode()
        return
    seen[id(thing)] = len(seen), thing  # kept, so that no other gets its place in memory
    if depth > DEEPEST:
        raise ModelError(f"a journal of {kind.__name__}: it holds objects within objects without end; give it an attribute `identity`")
    for part in _inside(thing):
        yield from _parts(part, seen, depth + 1) if not isinstance(part, _Bytes) else (bytes(part),)


class _Bytes(bytes):
    """Bytes as they are."""


def _inside(thing: Any) -> Iterator[Any]:
    """What a thing is made of."""
    own = getattr(thing, "identity", None)
    if isinstance(own, str):
        yield own
    elif isinstance(thing, np.ndarray):
        if thing.dtype.hasobject:
            yield thing.tolist()
        else:
            yield str(thing.dtype)
            yield tuple(thing.shape)
            yield _Bytes(np.ascontiguousarray(thing).tobytes())
    elif isinstance(thing, np.generic):
        yield thing.item()
    elif isinstance(thing, np.random.Generator):
        yield thing.bit_generator.state
    elif isinstance(thing, Mapping):
        yield from thing.items()
    elif isinstance(thing, (list, tuple)):
        yield len(thing)
        yield from thing
    elif isinstance(thing, (set, frozenset)):
        yield sorted(map(fingerprint, thing))
    elif isinstance(thing, types.FunctionType):
        yield thing.__qualname__
        yield thing.__code__
        yield thing.__defaults__
        yield thing.__kwdefaults__
        yield [cell.cell_contents for cell in thing.__closure__ or ()]
    elif isinstance(thing, types.CodeType):
        yield thing.co_code
        yield thing.co_names
        yield thing.co_consts
    elif isinstance(thing, types.MethodType):
        yield thing.__func__
        yield thing.__self__
    elif isinstance(thing, functools.partial):
        yield (thing.func, thing.args, thing.keywords)
    else:
        yield from _kept(thing)


def _kept(thing: Any) -> Iterator[Any]:
    """What an object keeps: its fields, or what a copy of it would be made from."""
    if dataclasses.is_dataclass(thing):
        yield {f.name: getattr(thing, f.name) for f in dataclasses.fields(thing) if f.compare and hasattr(thing, f.name)}
        return
    try:
        made = thing.__reduce_ex__(2)
    except (TypeError, ValueError, AttributeError) as error:
        raise ModelError(
            f"a journal of {type(thing).__module__}.{type(thing).__qualname__}: what it keeps cannot be seen ({error}); "
            "give it an attribute `identity`, a text that another would not have"
        ) from None
    if isinstance(made, str):
        yield made
        return
    for part in made:
        yield list(part) if isinstance(part, Iterator) else part
