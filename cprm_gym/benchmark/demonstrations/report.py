"""What the demonstrations show: each rate with its interval, the model less each rival in pairs, and whether the floor is met."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ...files import write_atomically
from ..plan import BlockResult
from ..statistics import paired_difference, wilson_interval
from .plan import DEMONSTRATIONS, DemonstrationPlan

HEAD = ("demonstration", "who", "n", "success %, Wilson 95 %", "model less him, paired 95 %", "floor", "")


@dataclass(frozen=True)
class Row:
    """One arm of a demonstration; the difference is the model's less his, in the same worlds, as shares."""

    demonstration: str
    arm: str
    episodes: int
    rate: float
    low: float
    high: float
    difference: float | None = None
    difference_low: float | None = None
    difference_high: float | None = None
    floor: float | None = None

    @property
    def met(self) -> bool | None:
        """Whether the point estimate reaches the floor and the interval excludes 0.

        Of a floor of 0: above -1, lower end above -2; of one below 0: not less than it.
        """
        if self.floor is None or self.difference is None or self.difference_low is None:
            return None
        if self.floor == 0:
            return self.difference > -0.01 and self.difference_low > -0.02
        return 100 * self.difference >= self.floor and (self.floor < 0 or self.difference_low > 0)

    def cells(self) -> list[str]:
        """As text."""
        rate = f"{100 * self.rate:.1f} ({100 * self.low:.1f} - {100 * self.high:.1f})"
        cells = [self.demonstration, self.arm, str(self.episodes), rate]
        if self.difference is None or self.difference_low is None or self.difference_high is None:
            return [*cells, "", "", ""]
        paired = f"{100 * self.difference:+.1f} ({100 * self.difference_low:+.1f}, {100 * self.difference_high:+.1f})"
        floor = "" if self.floor is None else "not behind" if self.floor == 0 else f"{self.floor:+g}"
        return [*cells, paired, floor, "" if self.met is None else "met" if self.met else "missed"]


@dataclass(frozen=True)
class DemonstrationReport:
    """What the suite found."""

    plan: DemonstrationPlan
    rows: tuple[Row, ...]

    def to_markdown(self) -> str:
        """The table."""
        lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
        return "\n".join(lines + ["| " + " | ".join(row.cells()) + " |" for row in self.rows]) + "\n"

    def write(self, folder: Path) -> list[Path]:
        """``demonstrations.json`` and ``demonstrations.md``."""
        data = {"plan": asdict(self.plan), "rows": [asdict(row) for row in self.rows]}
        files = {"demonstrations.json": json.dumps(data, indent=2) + "\n", "demonstrations.md": self.to_markdown()}
        for name, content in files.items():
            write_atomically(folder / name, content)
        return [folder / name for name in files]


def summarise(plan: DemonstrationPlan, results: list[BlockResult]) -> DemonstrationReport:
    """The report of the results there are; pairs are of the worlds that both have played."""
    found: dict[tuple[str, str], list[BlockResult]] = {}
    for result in results:
        name, arm = result.block.controller.rsplit("/", 1)
        found.setdefault((name, arm), []).append(result)
    success = {}
    for key, group in found.items():
        group.sort(key=lambda result: result.block.first)
        success[key] = np.concatenate([np.array(result.success, bool) for result in group])
    rows = []
    for name in plan.tasks:
        one = DEMONSTRATIONS[name]
        model = success.get((name, one.model))
        for arm in one.arms:
            good = success.get((name, arm))
            if good is None:
                continue
            low, high = wilson_interval(int(good.sum()), len(good))
            row = Row(name, arm, len(good), float(good.mean()), low, high, floor=one.floors.get(arm))
            if arm != one.model and model is not None:
                both = min(len(good), len(model))
                mean, least, most, _ = paired_difference(model[:both], good[:both])
                row = Row(**{**asdict(row), "difference": mean, "difference_low": least, "difference_high": most})
            rows.append(row)
    return DemonstrationReport(plan, tuple(rows))
