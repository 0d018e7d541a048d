"""Runs put together: of each cell the one with the most episodes, of equal ones that of the run given last; told as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ....errors import CprmError
from ...journal import Journal
from ...plan import BlockResult
from ..cells import Cell
from ..experiments import EXPERIMENTS
from ..plan import Chapter5Plan, version_of
from .whole import Chapter5Report, Run, summarise


def merged(folders: Sequence[Path]) -> Chapter5Report:
    """The report of several runs of one seed and one form, whole or not.

    Parameters
    ----------
    folders : sequence of Path
        At least one; with ``plan.json`` and ``episodes.jsonl``, or that packed. What is kept in one of a task whose players have other
        numbers by now is refused.

    Raises
    ------
    CprmError
        When there is none, seeds or forms differ, or a run cannot be read.
    """
    if not folders:
        raise CprmError("no runs given; at least one folder of a run is needed")
    played = [list(Journal(folder / "episodes.jsonl").read().values()) for folder in folders]
    plans = [Chapter5Plan.read(folder, {result.block.task for result in results}) for folder, results in zip(folders, played)]
    if len({(plan.seed, plan.size.full) for plan in plans}) > 1:
        raise CprmError(f"{', '.join(map(str, folders))}: runs of different seeds, or quick and full ones, are not put together")
    names = tuple(name for name in EXPERIMENTS if any(name in plan.experiments for plan in plans))
    wanted = {one.cell for name in names for one in EXPERIMENTS[name].wanted(plans[0].size)}
    best: dict[Cell, list[BlockResult]] = {}
    origin: dict[Cell, int] = {}
    for number, (plan, found) in enumerate(zip(plans, played)):
        run: dict[Cell, list[BlockResult]] = {}
        for result in found:
            if result.block.seed == plan.seed and Cell.of(result.block) in wanted:
                run.setdefault(Cell.of(result.block), []).append(result)
        for cell, results in run.items():
            if cell not in best or sum(r.block.count for r in results) >= sum(r.block.count for r in best[cell]):
                best[cell], origin[cell] = results, number
    size = replace(plans[0].size, table=max(plan.size.table for plan in plans), curve=max(plan.size.curve for plan in plans))
    runs = tuple(Run(command_of(folder), version_of(folder)) for folder in folders)
    report = summarise(Chapter5Plan(names, size, plans[0].seed), [r for results in best.values() for r in results])
    return replace(report, command="; ".join(dict.fromkeys(run.command for run in runs if run.command)), runs=runs, origin=origin)


def command_of(folder: Path) -> str:
    """With which command the run in a folder was begun; empty where that is not noted."""
    path = folder / "command.txt"
    return path.read_text(encoding="utf-8").strip() if path.exists() else ""
