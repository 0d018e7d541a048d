"""What the suite is made of: cells, each played once and used by every experiment that asks for it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..plan import Block

TOGETHER = 1000
"""Most episodes of a block."""
FACT = 0
"""Episodes of a cell in which nothing is played, but something is found out once."""


@dataclass(frozen=True)
class Cell:
    """Who plays what, and how.

    Parameters
    ----------
    task : str
        Of `cprm_gym.envs.tasks`; of a fact, what is looked at.
    condition : str
        Of `conditions.CONDITIONS`; of a fact, the name under which `facts.FACTS` has it.
    player : str
        As `players.make_player` reads it: ``fsm``, ``net on belief``, ``code watched``.
    """

    task: str
    condition: str
    player: str

    @classmethod
    def of(cls, block: Block) -> Cell:
        """The cell that a block is part of."""
        condition, player = block.controller.split("/", 1)
        return cls(block.task, condition, player)

    @property
    def key(self) -> str:
        """The controller of its blocks."""
        return f"{self.condition}/{self.player}"


@dataclass(frozen=True)
class Wanted:
    """A cell that an experiment asks for, with so many episodes; `FACT` for what is found out once."""

    cell: Cell
    episodes: int = FACT


@dataclass(frozen=True)
class Size:
    """How much is played.

    Parameters
    ----------
    table : int
        Episodes of a cell of the table.
    curve : int
        Of a cell of a curve.
    full : bool
        Whether all tasks, conditions and sizes are looked at; otherwise a few of each.
    """

    table: int = 2000
    curve: int = 300
    full: bool = True


FULL, QUICK = Size(), Size(table=100, curve=60, full=False)


def blocks_of(wanted: Iterable[Wanted], seed: int) -> list[Block]:
    """Blocks of all cells, each with the most episodes that anybody asks for."""
    most: dict[Cell, int] = {}
    for one in wanted:
        most[one.cell] = max(most.get(one.cell, FACT), one.episodes)
    blocks = []
    for cell, count in most.items():
        for first in range(0, max(count, 1), TOGETHER):
            blocks.append(Block(cell.task, cell.key, first, min(TOGETHER, count - first), seed))
    return blocks
