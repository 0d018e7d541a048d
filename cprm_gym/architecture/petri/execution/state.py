"""What an executor takes, what it remembers, and what it met."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = ArrayLike | Mapping[str, ArrayLike]
"""An array with one column per name, or a mapping from names to numbers or (W,) arrays."""

Objects = Mapping[str, Mapping[str, ArrayLike]]
"""Class -> attribute -> values of its objects, (n,) for all copies alike or (W, n); attribute ``present`` is a mask."""


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
