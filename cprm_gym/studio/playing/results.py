"""A benchmark's folder of results: its numbers, and the episodes behind them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...benchmark.journal import Journal
from ...benchmark.plan import Plan
from ...benchmark.statistics import wilson_interval
from ...errors import CprmError


class Results:
    """What a run of ``cprm-gym benchmark`` left.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    CprmError
        When it is none, or damaged.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.plan = Plan.read(folder)
        if self.plan.backend:
            raise CprmError(f"{folder}: was played on a server, {self.plan.backend}, and cannot be played again here")
        self.blocks = Journal(folder / "episodes.jsonl", self.plan).read()

    def table(self) -> dict[str, Any]:
        """By task and controller: episodes, successes, the rate with its Wilson interval, mean cycles; and each episode."""
        rows: dict[tuple[str, str], dict[str, Any]] = {}
        for block, result in sorted(self.blocks.items(), key=lambda entry: (entry[0].task, entry[0].controller, entry[0].first)):
            row = rows.setdefault((block.task, block.controller), {"task": block.task, "controller": block.controller, "episodes": []})
            for k, (success, length) in enumerate(zip(result.success, result.cycles)):
                row["episodes"].append({"world": block.first + k, "success": success, "cycles": length})
        for row in rows.values():
            done = sum(e["success"] for e in row["episodes"])
            interval = wilson_interval(done, len(row["episodes"]))
            cycles = [e["cycles"] for e in row["episodes"]]
            row |= {"success": done, "rate": done / len(cycles), "low": interval.low, "high": interval.high,
                    "cycles": sum(cycles) / len(cycles)}  # fmt: skip
        return {"folder": str(self.folder), "seed": self.plan.seed, "rows": list(rows.values())}

    def setup(self, task: str, controller: str, world: int) -> Mapping[str, Any]:
        """What has to be played for an episode to be seen again.

        Raises
        ------
        CprmError
            When it is not among the results.
        """
        for block in self.blocks:
            if (block.task, block.controller) == (task, controller) and block.first <= world < block.first + block.count:
                return {"task": task, "controller": controller, "seed": block.seed, "world": world}
        raise CprmError(f"{self.folder}: no episode {world} of {task} by {controller}")
