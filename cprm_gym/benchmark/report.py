"""From results of blocks to a table, a JSON report and a plot."""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from ..envs.tasks import make_task
from ..files import write_atomically
from .plan import BlockResult, Plan
from .statistics import wilson_interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REPORT_VERSION = 1
SECONDS = 0.1
"""Of a cycle."""


@dataclass(frozen=True)
class Row:
    """One task and controller."""

    task: str
    controller: str
    episodes: int
    planned: int
    successes: int
    success_rate: float | None
    wilson_low: float
    wilson_high: float
    median_cycles_to_success: float | None
    mean_reward: float | None
    error: str | None
    mean_duration: float | None = None
    """Seconds of an episode, success or not: the metric of keepaway; None for the tasks whose metric is success."""


@dataclass(frozen=True)
class Timing:
    """Times of one task and controller; the only numbers of a report that differ between equal runs."""

    task: str
    controller: str
    wall_seconds: float
    cycles_per_second: float | None
    controller_us_per_decision: float | None


@dataclass(frozen=True)
class Report:
    """What a benchmark found."""

    plan: Plan
    rows: tuple[Row, ...]
    timing: tuple[Timing, ...]

    @property
    def complete(self) -> bool:
        """Whether every planned episode was played."""
        return all(r.episodes == r.planned for r in self.rows)

    def to_json(self) -> str:
        """``report.json``: equal for equal runs but for the entry ``timing``, which comes last."""
        data: dict[str, Any] = {
            "version": REPORT_VERSION,
            "plan": asdict(self.plan),
            "complete": self.complete,
            "rows": [asdict(r) for r in self.rows],
            "timing": [asdict(t) for t in self.timing],
        }
        return json.dumps(data, indent=2) + "\n"

    def to_markdown(self) -> str:
        """The table as Markdown."""
        head = ["task", "controller", "episodes", "success (Wilson 95 %)", "median cycles to success", "mean duration, s",
                "world-cycles/s", "us per decision"]  # fmt: skip
        lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        lines += ["| " + " | ".join(cells) + " |" for cells in self._cells()]
        note = "" if self.complete else "\nInterrupted or failed: not every planned episode was played.\n"
        return f"# Benchmark, seed {self.plan.seed}\n\n" + "\n".join(lines) + "\n" + note

    def to_table(self) -> Table:
        """The table for a terminal."""
        table = Table(
            box=None, padding=(0, 1), pad_edge=False, header_style="bold underline", caption_justify="left",
            caption="n episodes; success with its Wilson 95 % interval; median cycles to success; mean seconds of a keepaway; "
            "world-cycles simulated per second; "
            "CPU time of the controller per decision",
        )  # fmt: skip
        for name in ("task", "controller"):
            table.add_column(name, no_wrap=True)
        names = ("n", "success", "95 %", "cycles", *(("seconds",) if self._durations else ()), "cycles/s", "us/act")
        for name in names:
            table.add_column(name, justify="right", no_wrap=True)
        for row, timing in zip(self.rows, self.timing):
            count = str(row.episodes) if row.episodes == row.planned else f"{row.episodes}/{row.planned}"
            if row.error is not None:
                table.add_row(row.task, row.controller, count, "error", *[""] * (len(names) - 2))
                continue
            rate = "-" if row.success_rate is None else f"{100 * row.success_rate:.1f} %"
            interval = f"{100 * row.wilson_low:.1f} - {100 * row.wilson_high:.1f}"
            seconds = [_number(row.mean_duration, ".1f")] if self._durations else []
            table.add_row(row.task, row.controller, count, rate, interval, _number(row.median_cycles_to_success, ".0f"), *seconds,
                          _number(timing.cycles_per_second, ",.0f"), _number(timing.controller_us_per_decision, ".1f"))  # fmt: skip
        return table

    @property
    def _durations(self) -> bool:
        """Whether there is a task whose metric is the duration."""
        return any(row.mean_duration is not None for row in self.rows)

    @property
    def errors(self) -> list[str]:
        """One line for each controller that raised."""
        return [f"{row.controller} on {row.task}: {row.error}" for row in self.rows if row.error is not None]

    def _cells(self) -> list[list[str]]:
        cells = []
        for row, timing in zip(self.rows, self.timing):
            if row.error is not None:
                cells.append([row.task, row.controller, f"{row.episodes}/{row.planned}", f"error: {row.error}", "", "", "", ""])
                continue
            rate = "-"
            if row.success_rate is not None:
                rate = f"{100 * row.success_rate:.1f} % ({100 * row.wilson_low:.1f} - {100 * row.wilson_high:.1f})"
            count = str(row.episodes) if row.episodes == row.planned else f"{row.episodes}/{row.planned}"
            cells.append([row.task, row.controller, count, rate, _number(row.median_cycles_to_success, ".0f"),
                          _number(row.mean_duration, ".1f"),
                          _number(timing.cycles_per_second, ",.0f"), _number(timing.controller_us_per_decision, ".1f")])  # fmt: skip
        return cells

    def write(self, folder: Path) -> list[Path]:
        """Write ``report.json``, ``report.md`` and, if matplotlib is installed, ``report.png`` into `folder`.

        Each file is written beside its name first and then put in place, so an interruption leaves the old one.

        Returns
        -------
        list of Path
            What was written.
        """
        written = []
        for name, text in (("report.json", self.to_json()), ("report.md", self.to_markdown())):
            write_atomically(folder / name, text)
            written.append(folder / name)
        picture = plot(self)
        if picture is not None:
            write_atomically(folder / "report.png", picture)
            written.append(folder / "report.png")
        return written


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def summarise(plan: Plan, results: Iterable[BlockResult]) -> Report:
    """The report of the results there are; blocks that are missing make it incomplete."""
    by_pair: dict[tuple[str, str], list[BlockResult]] = {(t, c): [] for t in plan.tasks for c in plan.controllers}
    for result in results:
        by_pair[result.block.task, result.block.controller].append(result)
    rows, timing = [], []
    for (task, controller), group in by_pair.items():
        group.sort(key=lambda r: r.block.first)
        errors = [r.error for r in group if r.error is not None]
        good = [r for r in group if r.error is None]
        success = [s for r in good for s in r.success]
        cycles = [c for r in good for c in r.cycles]
        reward = [x for r in good for x in r.reward]
        low, high = wilson_interval(sum(success), len(success))
        to_success = [c for c, s in zip(cycles, success) if s]
        lasts = statistics.fmean(cycles) * SECONDS if cycles and make_task(task).metric == "duration" else None
        rows.append(Row(task, controller, len(success), plan.episodes, sum(success), sum(success) / len(success) if success else None,
                        low, high, statistics.median(to_success) if to_success else None,
                        statistics.fmean(reward) if reward else None, errors[0] if errors else None, lasts))  # fmt: skip
        wall, played = sum(r.wall_seconds for r in good), sum(r.played for r in good)
        spent, decisions = sum(r.controller_seconds for r in good), sum(r.decisions for r in good)
        timing.append(Timing(task, controller, wall, played / wall if wall else None, 1e6 * spent / decisions if decisions else None))
    return Report(plan, tuple(rows), tuple(timing))


def plot(report: Report) -> bytes | None:
    """Success rates with their intervals, and cycles to success, as a PNG; None without matplotlib."""
    import io

    figure = figure_of(report)
    if figure is None:
        return None
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=120)
    return buffer.getvalue()


def figure_of(report: Report) -> Figure | None:
    """What `plot` draws; of what was not played, nothing."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return None
    tasks, controllers = report.plan.tasks, report.plan.controllers
    figure = Figure(figsize=(2.2 + 1.1 * max(3, len(tasks) * len(controllers)), 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    width = 0.8 / len(controllers)
    rows = {(r.task, r.controller): r for r in report.rows}
    for k, controller in enumerate(controllers):
        places = [i + (k - (len(controllers) - 1) / 2) * width for i in range(len(tasks))]
        found = [rows[t, controller] for t in tasks]
        rates = [math.nan if r.success_rate is None else r.success_rate for r in found]
        errors = [[max(0.0, x - r.wilson_low) for x, r in zip(rates, found)],
                  [max(0.0, r.wilson_high - x) for x, r in zip(rates, found)]]  # fmt: skip
        left.bar(places, [100 * x for x in rates], width * 0.92, label=controller,
                 yerr=[[100 * e for e in side] for side in errors], capsize=3)  # fmt: skip
        right.bar(places, [r.median_cycles_to_success or 0.0 for r in found], width * 0.92, label=controller)
    for axis, label in ((left, "success, % (Wilson 95 %)"), (right, "median cycles to success")):
        axis.set_xticks(range(len(tasks)), tasks)
        axis.set_ylabel(label)
        axis.spines[["top", "right"]].set_visible(False)
    left.set_ylim(0, 105)
    left.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, 1.13), ncols=len(controllers))
    return figure
