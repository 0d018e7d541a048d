"""What an executor takes, what it remembers, and what it met."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = ArrayLike | Mapping[str, ArrayLike]
"""An array with one column per name, or a mapping from names to numbers or (W,) arrays."""

Objects = Mapping[str, Mapping[str, ArrayLike]]
"""Class -> attribute -> values of its objects, (n,) for all copies alike or (W, n); attribute ``present`` is a mask."""


class ObjectTable(Mapping[str, NDArray[np.float64]]):
    """Attributes of the objects of a class in one array: attribute -> (W, n).

    Parameters
    ----------
    names : tuple of str
        The same object in every cycle, so that whoever reads the table finds his columns once.
    table : (attributes, W, n) float array
    """

    def __init__(self, names: tuple[str, ...], table: NDArray[np.float64]) -> None:
        self.names, self.table = names, table

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self.names:
            raise KeyError(name)
        return self.table[self.names.index(name)]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


class Snapshot(NamedTuple):
    """The whole state of an executor; W copies."""

    row: NDArray[np.float64]  # (W, S) marking, then attributes of objects
    held: NDArray[np.int32]  # (W, object places) index of the object, -1 for none
    clock: NDArray[np.int32]  # (W, clocks)
    random: NDArray[np.uint64]  # (W,)
    cycle: NDArray[np.int64]  # (W,)
    data: NDArray[np.float64]  # (W, columns) attributes of all objects


class Conflict(NamedTuple):
    """Execution picked one of several legal behaviours: firing one transition disabled another of equal priority."""

    fired: str
    disabled: str
    times: int
