"""What was played, by cell."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..plan import BlockResult
from ..statistics import wilson_interval
from .cells import FACT, Cell
from .comparisons import Pair
from .conditions import metric_of


@dataclass
class Played:
    """All episodes of a cell.

    Attributes
    ----------
    success : (n,) bool array
    cycles : (n,) int array
    reward : (n,) float array
    more : dict of str to list
        What else was measured, an entry for each episode; of a fact, what was found.
    microseconds : float
        CPU time of a decision.
    error : str
        Of a player who failed.
    """

    success: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    cycles: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    reward: np.ndarray = field(default_factory=lambda: np.zeros(0))
    more: dict[str, Any] = field(default_factory=dict)
    microseconds: float = 0.0
    error: str = ""

    @property
    def n(self) -> int:
        """Episodes."""
        return len(self.success)

    def first(self, n: int) -> Played:
        """The first n episodes of them, without what else was measured."""
        return replace(self, success=self.success[:n], cycles=self.cycles[:n], reward=self.reward[:n], more={})

    def percents(self) -> tuple[float, float, float]:
        """`rate` in percent."""
        rate, low, high = self.rate()
        return 100 * rate, 100 * low, 100 * high

    def rate(self) -> tuple[float, float, float]:
        """Success and its Wilson interval."""
        low, high = wilson_interval(int(self.success.sum()), self.n)
        return float(self.success.mean()) if self.n else float("nan"), low, high


class Results:
    """The results of a run.

    Parameters
    ----------
    results : iterable of BlockResult
    """

    def __init__(self, results: Iterable[BlockResult]) -> None:
        groups: dict[Cell, list[BlockResult]] = {}
        for result in results:
            groups.setdefault(Cell.of(result.block), []).append(result)
        self.cells = {cell: _join(group) for cell, group in groups.items()}
        self.seconds = sum(result.wall_seconds for group in groups.values() for result in group)

    def played(self, task: str, condition: str, player: str) -> Played | None:
        """The cell, if all of it went well and anything was played."""
        found = self.cells.get(Cell(task, condition, player))
        return found if found is not None and not found.error and found.n else None

    def fact(self, condition: str, task: str, player: str) -> dict[str, Any] | None:
        """What was found out, if it was."""
        found = self.cells.get(Cell(task, condition, player))
        return found.more if found is not None and not found.error else None

    def pair(self, task: str, condition: str, first: str, second: str) -> Pair | None:
        """Two players in the same worlds, by `conditions.metric_of` the task."""
        one, other = self.played(task, condition, first), self.played(task, condition, second)
        if one is None or other is None:
            return None
        n, metric = min(one.n, other.n), metric_of(task)
        ones, others = ({"success": p.success, "cycles": p.cycles, "goals": p.reward}[metric][:n] for p in (one, other))
        return Pair(task, condition, first, second, metric, ones, others)

    @property
    def errors(self) -> list[tuple[Cell, str]]:
        """Players who failed, and how."""
        return [(cell, found.error) for cell, found in self.cells.items() if found.error]


def _join(group: list[BlockResult]) -> Played:
    group = sorted(group, key=lambda r: r.block.first)
    errors = [r.error for r in group if r.error]
    if errors:
        return Played(error=errors[0])
    if group[0].block.count == FACT:
        return Played(more=group[0].more)
    more: dict[str, Any] = {}
    for result in group:
        for name, values in result.more.items():
            more.setdefault(name, []).extend(values)
    decisions = sum(r.decisions for r in group)
    spent = sum(r.controller_seconds for r in group)
    return Played(
        np.array([s for r in group for s in r.success], bool), np.array([c for r in group for c in r.cycles], np.int64),
        np.array([x for r in group for x in r.reward], float), more, 1e6 * spent / decisions if decisions else 0.0,
    )  # fmt: skip


def median(values: Iterable[float | None]) -> float | None:
    """Of those that there are; None if there are none."""
    found = [v for v in values if v is not None]
    return float(statistics.median(found)) if found else None
