"""What is remembered between steps: the most recent of what was made, and tables by their contents."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar
from weakref import ref

import numpy as np

from ...grounding.slices import GroundSlice

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Recent(OrderedDict[Key, Value], Generic[Key, Value]):
    """A dictionary that forgets what was not used for longest."""

    def __init__(self, limit: int) -> None:
        super().__init__()
        self.limit = limit

    def fetch(self, key: Key, make: Callable[[], Value]) -> Value:
        """The value of `key`, made if it is not there."""
        if key in self:
            self.move_to_end(key)
            return self[key]
        return self.keep(key, make())

    def keep(self, key: Key, value: Value) -> Value:
        """Remember a value."""
        self[key] = value
        if len(self) > self.limit:
            self.popitem(last=False)
        return value


class TableStore:
    """Numbers for tables: equal contents, equal numbers.

    Attributes
    ----------
    infos : Recent
        Slices indexed with these numbers, for all filters of an engine.
    """

    def __init__(self) -> None:
        self.infos: Recent[tuple[GroundSlice, frozenset[str]], Any] = Recent(4096)  # of SliceInfo, which imports this file
        self.tables: dict[int, np.ndarray] = {}
        self._numbers: dict[bytes, int] = {}
        self._seen: dict[int, tuple[Any, int]] = {}

    def number(self, table: np.ndarray) -> int:
        """The number of a table; the same array is hashed once."""
        known = self._seen.get(id(table))
        if known is not None and known[0]() is table:
            return known[1]
        array = np.ascontiguousarray(table, dtype=np.float64)
        digest = hashlib.blake2b(array.tobytes() + repr(array.shape).encode(), digest_size=16).digest()
        number = self._numbers.setdefault(digest, len(self._numbers))
        self.tables.setdefault(number, array)
        self._seen = {k: v for k, v in self._seen.items() if v[0]() is not None} if len(self._seen) > 4096 else self._seen
        self._seen[id(table)] = ref(table), number
        return number
