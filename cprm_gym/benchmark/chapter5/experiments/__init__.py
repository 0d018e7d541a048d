"""The nine experiments, one file each: which cells it asks for, and what it makes of them."""

from __future__ import annotations

from typing import Protocol

from ..cells import Size, Wanted
from ..pieces import Told
from ..results import Results
from . import analysis, disturbances, explosion, making, memory, senses, slow, table, transfer


class Experiment(Protocol):
    """A module of this package."""

    TITLE: str
    QUESTION: str

    def wanted(self, size: Size) -> list[Wanted]:
        """The cells that it is made from."""

    def tell(self, results: Results, size: Size) -> Told:
        """What they say; of what was not played, nothing."""


EXPERIMENTS: dict[str, Experiment] = {
    "table": table, "senses": senses, "disturbances": disturbances, "slow": slow, "explosion": explosion, "memory": memory,
    "analysis": analysis, "transfer": transfer, "making": making,
}  # fmt: skip
"""Name -> experiment, in the order of the page."""
