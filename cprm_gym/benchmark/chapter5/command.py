"""``cprm-gym benchmark --suite chapter5``: plan, play, report."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ...errors import CprmError
from ...workers import check_workers
from ..plan import BlockResult
from ..runner import again_with, run
from .plan import SUITE, Chapter5Plan
from .playing import play_cell
from .report.whole import Chapter5Report, summarise


class Asked(NamedTuple):
    """The options that were given."""

    quick: bool = False
    only: tuple[str, ...] = ()
    episodes: int | None = None
    seed: int | None = None


class Ended(NamedTuple):
    """How it ended."""

    report: Chapter5Report
    written: list[Path]
    interrupted: bool
    again: str
    """The command that goes on."""


def plan_of(asked: Asked) -> Chapter5Plan:
    """The plan that the options mean.

    Raises
    ------
    UnknownName, ParameterError
        As `Chapter5Plan`.
    """
    plan = Chapter5Plan.quick() if asked.quick else Chapter5Plan()
    if asked.only:
        plan = replace(plan, experiments=asked.only)
    if asked.seed is not None:
        plan = replace(plan, seed=asked.seed)
    return plan if asked.episodes is None else plan.at_most(asked.episodes)


def spoken(asked: Asked, workers: int | None) -> str:
    """The command as it would be typed."""
    words = ["cprm-gym", "benchmark", "--suite", SUITE] + ["--quick"] * asked.quick
    words += [word for name in asked.only for word in ("--only", name)]
    for name in ("episodes", "seed"):
        value = getattr(asked, name)
        words += [] if value is None else [f"--{name}", str(value)]
    return shlex.join(words) + again_with(workers)


def benchmark(
    asked: Asked, resume: Path | None, new_folder: Callable[[], Path], workers: int | None, timeout: float, complaints: Console,
    duration: Callable[[float], str],
) -> Ended:  # fmt: skip
    """Play what is asked for, or go on with the run in a folder, and write the report.

    Parameters
    ----------
    asked : Asked
    resume : Path, optional
    new_folder : callable
        Makes the folder of a new run.
    workers : int, optional
        None: as many as pay.
    timeout : float
        Seconds that a decision may take.
    complaints : Console
        Where progress is shown.
    duration : callable
        Seconds as text.

    Raises
    ------
    CprmError
        For options that do not go together, a plan that cannot be read, a damaged journal.
    """
    check_workers(workers)
    if not timeout > 0:
        raise CprmError(f"--timeout {timeout:g}: a number of seconds above 0 is needed")
    if resume is not None:
        if asked != Asked():
            raise CprmError("--resume takes up a run as it was planned: leave --quick and what is to be played out")
        plan, folder = Chapter5Plan.read(resume), resume
        command = (folder / "command.txt").read_text(encoding="utf-8").strip() if (folder / "command.txt").exists() else ""
    else:
        plan, command = plan_of(asked), spoken(asked, workers)
        folder = new_folder()
        plan.write(folder)
        (folder / "command.txt").write_text(command + "\n", encoding="utf-8")
    blocks = plan.blocks()
    episodes = sum(block.count for block in blocks)
    complaints.print(f"{episodes:,} episodes, about {duration(plan.seconds)} of CPU time", highlight=False)
    results, interrupted = _played(plan, folder, workers, timeout, complaints, len(blocks))
    report = summarise(plan, results, command)
    again = f"cprm-gym benchmark --suite {SUITE} --resume {shlex.quote(str(folder))}{again_with(workers)}"
    return Ended(report, report.write(folder), interrupted, again)


def _played(
    plan: Chapter5Plan, folder: Path, workers: int | None, timeout: float, complaints: Console, total: int
) -> tuple[list[BlockResult], bool]:
    results: list[BlockResult] = []

    def said(what: str) -> None:
        complaints.print(what, highlight=False)

    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                   console=complaints, transient=True, disable=not complaints.is_terminal)  # fmt: skip
    with bar:
        line = bar.add_task("starting", total=total)
        try:
            for result in run(plan, workers=workers, journal=folder / "episodes.jsonl", timeout=timeout, play=play_cell, told=said):
                results.append(result)
                bar.update(line, advance=1, description=f"{result.block.task} {result.block.controller}"[:60])
        except KeyboardInterrupt:
            return results, True
    return results, False
