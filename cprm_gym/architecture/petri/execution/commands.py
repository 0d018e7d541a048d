"""What a cycle sends to the body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Commands(NamedTuple):
    """The commands of one cycle, for W copies. The arrays are views that the next cycle overwrites."""

    fired: Mapping[str, NDArray[np.bool_]]  # command -> (W,) whether it goes out
    values: Mapping[str, Mapping[str, NDArray[np.float64]]]  # command -> parameter -> (W,), meaningful where fired
    source: Mapping[str, NDArray[np.int32]]  # command -> (W,) index of the transition that emitted it
    overruled: NDArray[np.bool_]  # (W, T) transitions whose command gave way to another of its group

    def of(self, copy: int = 0) -> dict[str, dict[str, float]]:
        """The commands of one copy: ``{"turn": {"moment": 12.0}}``."""
        return {
            name: {key: float(value[copy]) for key, value in self.values[name].items()} for name, out in self.fired.items() if out[copy]
        }
