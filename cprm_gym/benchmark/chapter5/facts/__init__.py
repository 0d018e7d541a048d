"""What is found out once, without episodes: name of the condition of a cell -> (task, player, seed) -> what was found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import concurrency, contained
from .analysing import tried
from .learned import record
from .sizes import size_of, tuned

CONCURRENCY, CONTAINED, ANALYSIS, SIZE, TUNING, TRAINING = "concurrency", "contained", "analysis", "size", "tuning", "training"


def _concurrent(task: str, player: str, seed: int) -> dict[str, Any]:
    return concurrency.measure(int(task), player, seed)


def _contained(task: str, player: str, seed: int) -> dict[str, Any]:
    return contained.same(player, seed)


FACTS: dict[str, Callable[[str, str, int], dict[str, Any]]] = {
    CONCURRENCY: _concurrent, CONTAINED: _contained, ANALYSIS: tried, SIZE: size_of, TUNING: tuned, TRAINING: record,
}  # fmt: skip
"""Name -> measurement."""
