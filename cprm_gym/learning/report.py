"""What a training reached: a table, curves over seeds, and the same for other programs."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..benchmark.statistics import wilson_interval
from ..errors import FormatError
from ..files import write_atomically
from .measuring import Together, figures, interquartile_mean
from .training import FLOOR, Plan, Point, read_curve

WAYS = ("drawn", "likeliest")
"""How actions are taken from a policy."""


@dataclass(frozen=True)
class Report:
    """A training, as far as it has come.

    Attributes
    ----------
    plan : Plan
    curves : dict of int to list of Point
        By seed.
    ends : dict of int to dict
        By seed that is done: ``seconds``, and for each of `WAYS` the success, cycles and reward of every episode.
    floor : dict, optional
        The same of random choices, once all seeds are done.
    """

    plan: Plan
    curves: dict[int, list[Point]]
    ends: dict[int, dict[str, Any]]
    floor: dict[str, Any] | None = None

    @classmethod
    def of(cls, folder: Path) -> Report:
        """What a folder holds.

        Raises
        ------
        FormatError
            For damaged files.
        """
        plan = Plan.read(folder)
        curves, ends = {}, {}
        for seed in range(plan.first, plan.first + plan.seeds):
            own = folder / f"seed_{seed}"
            if points := read_curve(own):
                curves[seed] = points
            if (own / "done.json").exists():
                ends[seed] = _read(own / "done.json", lambda told: all(len(told[way]["success"]) for way in WAYS))
        floor = _read(folder / FLOOR, lambda told: len(told["success"]) > 0) if (folder / FLOOR).exists() else None
        return cls(plan, curves, ends, floor)

    @property
    def complete(self) -> bool:
        """Whether all seeds are done."""
        return len(self.ends) == self.plan.seeds

    @property
    def metric(self) -> str:
        """What is counted, as columns and curves say it."""
        return "seconds" if self.plan.configuration.metric == "duration" else "success"

    def figures(self, told: dict[str, Any]) -> np.ndarray:
        """(n,) float: what counts of every episode."""
        return figures(self.plan.configuration.metric, told["success"], told["cycles"])

    def rate(self, seed: int, way: str) -> float:
        """Success, or seconds, of the best policy of a seed in the worlds that chose nothing."""
        return float(np.mean(self.figures(self.ends[seed][way])))

    def together(self, way: str) -> Together | None:
        """Over the seeds that are done."""
        return interquartile_mean([self.rate(seed, way) for seed in self.ends]) if self.ends else None

    def best(self) -> int | None:
        """The seed whose policy was best in the worlds by which each seed chose its own; those of the report do not choose."""
        worth = {seed: max(point.worth for point in self.curves[seed]) for seed in self.ends}
        return max(worth, key=lambda seed: worth[seed]) if worth else None

    def over_seeds(self, way: str) -> list[tuple[int, Together]]:
        """The curve: agent-steps, and the seeds together at the measurement with that number."""
        count = min((len(points) for points in self.curves.values()), default=0)
        return [
            (
                int(np.median([points[k].steps for points in self.curves.values()])),
                interquartile_mean([getattr(points[k], way) for points in self.curves.values()]),
            )
            for k in range(count)
        ]

    def rows(self) -> list[tuple[str, ...]]:
        """Cells of the table: one row for each seed, one for all."""
        rows = []
        for seed, told in self.ends.items():
            cells = [f"seed {seed}", *(self._shown(told[way]) for way in WAYS)]
            cells += [f"{np.mean(told['likeliest']['cycles']):.0f}", f"{told['seconds']:.0f} s"]
            rows.append(tuple(cells))
        if self.ends:
            cells = [f"{len(self.ends)} seeds, interquartile mean"]
            for way in WAYS:
                found = self.together(way)
                assert found is not None
                cells.append(f"{found.centre:.3f} [{found.low:.3f}, {found.high:.3f}]")
            rows.append((*cells, "", f"{sum(told['seconds'] for told in self.ends.values()):.0f} s"))
        if self.floor is not None:
            rows.append(("random", self._shown(self.floor), "", f"{np.mean(self.floor['cycles']):.0f}", ""))
        return rows

    def _shown(self, told: dict[str, Any]) -> str:
        """Mean and interval of 95 %: Wilson's of a rate, the normal one of seconds."""
        found = self.figures(told)
        if self.metric == "success":
            low, high = wilson_interval(int(found.sum()), len(found))
            return f"{found.mean():.3f} [{low:.3f}, {high:.3f}]"
        mean, half = float(found.mean()), 1.96 * float(found.std()) / len(found) ** 0.5
        return f"{mean:.1f} [{mean - half:.1f}, {mean + half:.1f}]"

    @property
    def head(self) -> tuple[str, ...]:
        """Of the table."""
        return ("", f"{self.metric}, drawn", f"{self.metric}, likeliest", "cycles", "processor time")

    def to_markdown(self) -> str:
        """The table and the curve."""
        c = self.plan.configuration
        lines = [
            f"# {c.algorithm} on {c.task}", "", f"`{self.plan.command}`", "",
            f"{c.steps:,} agent-steps a seed; {c.episodes} episodes a measurement, in worlds not learned from. Intervals: "
            f"{'Wilson' if self.metric == 'success' else 'normal'} for a seed, bootstrap over seeds for all; random: drawn among what "
            "can be chosen.", "",
            "| " + " | ".join(self.head) + " |", "|" + "---|" * len(self.head),
            *("| " + " | ".join(row) + " |" for row in self.rows()), "",
            "| agent-steps | drawn | likeliest |", "|---|---|---|",
        ]  # fmt: skip
        for (steps, drawn), (_, likeliest) in zip(self.over_seeds("drawn"), self.over_seeds("likeliest")):
            cells = [f"{found.centre:.3f} [{found.low:.3f}, {found.high:.3f}]" for found in (drawn, likeliest)]
            lines.append(f"| {steps:,} | {cells[0]} | {cells[1]} |")
        return "\n".join(lines) + "\n"

    def to_marl_eval(self) -> dict[str, Any]:
        """Environment -> task -> algorithm -> run, as marl-eval reads it: one run for each seed, its measurements the steps."""
        runs: dict[str, Any] = {}
        name = self.metric
        for seed, points in self.curves.items():
            run: dict[str, Any] = {}
            for k, point in enumerate(points):
                run[f"step_{k}"] = {
                    "step_count": point.steps, "elapsed_time": point.seconds, name: [point.drawn],
                    f"{name}_likeliest": [point.likeliest],
                }  # fmt: skip
            if seed in self.ends:
                told = self.ends[seed]
                run["absolute_metrics"] = {
                    name: self.figures(told["drawn"]).tolist(), "return": told["drawn"]["reward"],
                    "cycles": told["drawn"]["cycles"], f"{name}_likeliest": self.figures(told["likeliest"]).tolist(),
                }  # fmt: skip
            runs[f"seed_{seed}"] = run
        c = self.plan.configuration
        return {"cprm_gym": {c.task: {c.algorithm: runs}}}

    def to_svg(self) -> str:
        """The curve over seeds, drawing actions and taking the likeliest, with its intervals."""
        wide, high, left, foot = 560, 300, 48, 40
        series = {way: self.over_seeds(way) for way in WAYS}
        last = max((steps for points in series.values() for steps, _ in points), default=1)
        most = 1.0 if self.metric == "success" else max((t.high for points in series.values() for _, t in points), default=1.0)

        def at(steps: float, rate: float) -> str:
            return f"{left + (wide - left - 16) * steps / last:.1f},{16 + (high - foot - 16) * (1.0 - rate / most):.1f}"

        parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" font-family="sans-serif" font-size="12">',
                 f'<rect width="{wide}" height="{high}" fill="white"/>']  # fmt: skip
        for tick in (most * share for share in (0.0, 0.25, 0.5, 0.75, 1.0)):
            x, y = at(0, tick).split(",")
            parts.append(f'<line x1="{x}" y1="{y}" x2="{wide - 16}" y2="{y}" stroke="#ddd"/>')
            parts.append(f'<text x="{left - 6}" y="{float(y) + 4:.1f}" text-anchor="end">{tick:.3g}</text>')
        for (way, points), colour in zip(series.items(), ("#1f6fb4", "#c25a14")):
            if not points:
                continue
            band = [at(s, t.high) for s, t in points] + [at(s, t.low) for s, t in reversed(points)]
            parts.append(f'<polygon points="{" ".join(band)}" fill="{colour}" fill-opacity="0.18"/>')
            line = " ".join(at(s, t.centre) for s, t in points)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"><title>{way}</title></polyline>')
        parts.append(
            f'<text x="{left}" y="{high - 22}">0</text><text x="{wide - 16}" y="{high - 22}" text-anchor="end">{last:,} agent-steps</text>'
        )
        c = self.plan.configuration
        parts.append(
            f'<text x="{left}" y="{high - 6}">{c.algorithm} on {c.task}, {len(self.curves)} seeds: {self.metric}, '
            '<tspan fill="#1f6fb4">actions drawn</tspan>, <tspan fill="#c25a14">likeliest actions</tspan></text></svg>'
        )
        return "\n".join(parts) + "\n"

    def to_json(self) -> dict[str, Any]:
        """All of it."""
        seeds = {}
        for seed, told in self.ends.items():
            reached = {way: {"success": sum(told[way]["success"]), "episodes": len(told[way]["success"])} for way in WAYS}
            seeds[str(seed)] = {"curve": [list(p) for p in _plain(self.curves[seed])], **reached, "seconds": told["seconds"]}
        together = {way: found._asdict() for way in WAYS if (found := self.together(way)) is not None}
        configuration = self.plan.configuration.as_json()
        return {
            "configuration": configuration, "command": self.plan.command, "complete": self.complete, "seeds": seeds, "together": together,
        }  # fmt: skip

    def write(self, folder: Path) -> list[Path]:
        """``report.md``, ``report.json``, ``curve.svg`` and ``marl_eval.json``."""
        files = {
            "report.md": self.to_markdown(), "report.json": json.dumps(self.to_json(), indent=1) + "\n", "curve.svg": self.to_svg(),
            "marl_eval.json": json.dumps(self.to_marl_eval()) + "\n",
        }  # fmt: skip
        for name, text in files.items():
            write_atomically(folder / name, text)
        return [folder / name for name in files]


def _read(place: Path, whole: Callable[[Any], bool]) -> dict[str, Any]:
    """The figures of a file."""
    try:
        told: dict[str, Any] = json.loads(place.read_text("utf-8"))
        assert whole(told)
    except (ValueError, KeyError, TypeError, AssertionError):
        raise FormatError(f"{place}: no result of a training") from None
    return told


def _plain(points: list[Point]) -> list[tuple[float, ...]]:
    return [(point.steps, point.drawn, point.likeliest, point.seconds) for point in points]
