"""Percepts that stand in one array."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping, Sequence

import numpy as np
from numpy.typing import NDArray


class PerceptNames:
    """Names of the columns of a table of percepts; made once, so that whoever reads many tables finds his columns once.

    Parameters
    ----------
    names : sequence of str
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.at = {name: k for k, name in enumerate(self.names)}


class PerceptTable(MutableMapping[str, NDArray[np.float64]]):
    """A mapping from the name of a percept to its (W,) numbers, most of which are columns of an array.

    Parameters
    ----------
    columns : PerceptNames
    table : (W, n) float array
        What is said of a name among `columns` later is written into it; other names are kept beside it.
    """

    def __init__(self, columns: PerceptNames, table: NDArray[np.float64]) -> None:
        self.columns, self.table = columns, table
        self.others: dict[str, NDArray[np.float64]] = {}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        at = self.columns.at.get(name)
        return self.others[name] if at is None else self.table[:, at]

    def __setitem__(self, name: str, value: NDArray[np.float64]) -> None:
        at = self.columns.at.get(name)
        if at is None:
            self.others[name] = value
        else:
            self.table[:, at] = value

    def __delitem__(self, name: str) -> None:
        if name in self.columns.at:
            raise TypeError(f"percept {name!r} is a column of a table and stays there")
        del self.others[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns.at or name in self.others

    def __iter__(self) -> Iterator[str]:
        yield from self.columns.names
        yield from self.others

    def __len__(self) -> int:
        return len(self.columns.names) + len(self.others)
