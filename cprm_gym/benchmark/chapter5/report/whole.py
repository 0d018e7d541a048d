"""The report of a run: everything told, in the forms in which it is written."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from ....files import write_atomically
from ...plan import BlockResult
from ..about import machine, revision
from ..cells import Cell
from ..claims import CLAIMS
from ..experiments import EXPERIMENTS
from ..pieces import UNKNOWN, Told, listed, sentence
from ..plan import SUITE, Chapter5Plan
from ..results import Results
from .again import Again
from .guide import Advice, guide
from .page import page

VERSION = 1


class Run(NamedTuple):
    """One of the runs that were put together."""

    command: str
    version: str
    """With which it was begun; empty where that is not noted."""


@dataclass(frozen=True)
class Chapter5Report:
    """What the suite found.

    Attributes
    ----------
    plan : Chapter5Plan
    results : Results
    told : tuple of Told
    advice : tuple of (str, str, str)
    complete : bool
    command : str
    runs : tuple of Run
        Of which it is put together.
    origin : mapping of Cell to int
        Of which of the runs a cell is; the first, if it is not said.
    again : Again, optional
        What another seed says.
    """

    plan: Chapter5Plan
    results: Results
    told: tuple[Told, ...]
    advice: tuple[Advice, ...]
    complete: bool
    command: str
    runs: tuple[Run, ...] = ()
    origin: Mapping[Cell, int] = field(default_factory=dict)
    again: Again | None = None

    @property
    def errors(self) -> list[tuple[str, str]]:
        """Who failed where, and how."""
        return [(f"{cell.player} on {cell.task}, {cell.condition}", error) for cell, error in self.results.errors]

    def verdicts(self) -> dict[str, tuple[str, str]]:
        """Claim -> verdict and figure, for all claims."""
        said = {f.claim: (f.verdict, f.figure) for one in self.told for f in one.findings}
        return {key: said.get(key, (UNKNOWN, "")) for key in CLAIMS}

    def to_data(self) -> dict[str, Any]:
        """For ``report.json``: equal for equal runs but for times, and what `machine` says."""
        return {
            "suite": SUITE, "version": VERSION, "plan": asdict(self.plan), "complete": self.complete, "command": self.command,
            "runs": [run._asdict() for run in self.runs],
            "again": None if self.again is None else {**asdict(self.again), "said": self.again.said},
            "errors": [list(e) for e in self.errors],
            "claims": {key: {"claim": CLAIMS[key].says, "section": CLAIMS[key].section, "experiment": CLAIMS[key].experiment,
                             "verdict": verdict, "figure": figure} for key, (verdict, figure) in self.verdicts().items()},
            "guide": [list(row) for row in self.advice],
            "experiments": [_told(one) for one in self.told],
            "cells": [
                {"task": cell.task, "condition": cell.condition, "player": cell.player, "run": self.origin.get(cell, 0), "n": p.n,
                 "successes": int(p.success.sum()),
                 "cycles": float(p.cycles.mean()), "reward": float(p.reward.mean()), "microseconds": round(p.microseconds, 1)}
                for cell, p in self.results.cells.items() if p.n
            ],
            "machine": machine(),
        }  # fmt: skip

    def to_marl_eval(self) -> dict[str, Any]:
        """Environment -> task -> algorithm -> run, as marl-eval reads it: one run, its episodes the absolute metrics."""
        tasks: dict[str, dict[str, Any]] = {}
        for cell, p in self.results.cells.items():
            if p.n:
                name = cell.task if cell.condition == "default" else f"{cell.task}, {cell.condition}"
                metrics = {"success": p.success.astype(float).tolist(), "return": p.reward.tolist(), "cycles": p.cycles.tolist()}
                step = {"step_count": 0, **metrics, "elapsed_time": 0}
                tasks.setdefault(name, {})[cell.player] = {f"seed_{self.plan.seed}": {"step_0": step, "absolute_metrics": metrics}}
        return {"cprm_gym": tasks}

    def to_markdown(self) -> str:
        """Advice and claims first, then all tables."""
        lines = ["# Chapter 5, measured", "", self.episodes(), ""]
        lines += [f"Failed: {who}: {error}\n" for who, error in self.errors]
        if self.advice:
            lines += ["| when | take | why |", "|---|---|---|", *("| " + " | ".join(row) + " |" for row in self.advice), ""]
        lines += ["| claim | verdict | figure |", "|---|---|---|"]
        lines += [f"| {CLAIMS[key].says} | {verdict} | {figure} |" for key, (verdict, figure) in self.verdicts().items()]
        if self.again is not None:
            lines += ["", f"{self.again.said} {self.again.episodes}"]
            lines += [f"* {CLAIMS[key].says} With seed {self.again.seed}: {self.again.verdicts[key]}." for key in self.again.hangs]
        for number, one in enumerate(self.told, 1):
            lines += ["", f"## {number}. {one.title}", "", one.question, ""]
            lines += [f"{f.figure} {f.more}\n" for f in one.findings]
            for table in sorted(one.tables, key=lambda t: not t.brief):
                lines += [f"**{table.title}**", "", table.to_markdown()]
            lines += [f"* {sentence(c)}" for c in one.better]
            lines += ["", *one.notes]
        return "\n".join(lines) + "\n"

    def episodes(self) -> str:
        """How much was played."""
        size = self.plan.size
        kind = "" if size.full else "Quick form: a few tasks, few episodes, so little is decided. "
        counts = sorted(p.n for p in self.results.cells.values() if p.n) or [0]
        each = f"{counts[0]:,}" if counts[0] == counts[-1] else f"{counts[0]:,} to {counts[-1]:,}"
        return f"{kind}{sum(counts):,} episodes, {each} in a cell."

    def to_html(self) -> str:
        """The page."""
        about = {
            "command": self.command, "seed": self.plan.seed, "episodes": self.episodes(), "complete": self.complete, "machine": machine(),
            "errors": self.errors, "seconds": self.results.seconds,
        }  # fmt: skip
        return page(self.told, self.advice, about, self.again)

    def write(self, folder: Path) -> list[Path]:
        """``report.html``, ``report.md``, ``report.json`` and ``marl_eval.json``; each is put in place when it is whole."""
        files = {
            "report.html": self.to_html(), "report.md": self.to_markdown(), "report.json": json.dumps(self.to_data(), indent=1) + "\n",
            "marl_eval.json": json.dumps(self.to_marl_eval()) + "\n",
        }  # fmt: skip
        for name, text in files.items():
            write_atomically(folder / name, text)
        return [folder / name for name in files]


def _told(one: Told) -> dict[str, Any]:
    return {
        "name": one.name, "title": one.title, "question": one.question, "tables": [asdict(t) for t in one.tables],
        "comparisons": [asdict(c) for c in one.comparisons], "better": [sentence(c) for c in one.better],
        "findings": [asdict(f) for f in one.findings], "notes": list(one.notes),
    }  # fmt: skip


def _with_gaps(told: Told, results: Results, plan: Chapter5Plan) -> Told:
    """With a note of what was planned and is not there."""
    cells = {one.cell for one in EXPERIMENTS[told.name].wanted(plan.size)}
    missing = [cell for cell in cells if cell not in results.cells or results.cells[cell].error]
    if not missing:
        return told
    tasks = sorted({cell.task for cell in missing})
    return replace(told, notes=(*told.notes, f"{len(missing)} of {len(cells)} cells planned were not played, in {listed(tasks)}."))


def summarise(plan: Chapter5Plan, results: Iterable[BlockResult], command: str = "") -> Chapter5Report:
    """The report of the results there are."""
    played: Sequence[BlockResult] = list(results)
    found = Results(played)
    told = tuple(_with_gaps(EXPERIMENTS[name].tell(found, plan.size), found, plan) for name in plan.experiments)
    complete = {r.block for r in played if r.error is None} == set(plan.blocks())
    runs = (Run(command, revision()),)
    return Chapter5Report(plan, found, told, tuple(guide(found, list(told))), complete, command, runs)
