"""The suite ``knowledge``: task x senses x tier, the same decisions and the same worlds for all tiers.

It says where knowledge can pay: what an oracle's would win over the best at hand (``state``, ``foresight`` less ``memory``, ``tracker``),
and what a tier wins over ``memory``, the fair rival, in pairs. Blocks are kept in the journal of benchmarks, so a run can be taken up.
"""

from __future__ import annotations

import io
import json
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ..agents.knowledge import TIERS
from ..agents.knowledge.players import PLAYERS, RIVAL
from ..envs.players.senses import Senses
from ..envs.tasks import make_task
from ..errors import CprmError, ParameterError, unknown_name
from ..files import write_atomically
from .episodes import play_episodes
from .plan import BLOCK, Block, BlockResult
from .statistics import paired_difference, wilson_interval

SENSES: dict[str, Senses] = {
    "default": Senses(), "narrow": Senses(view="narrow"), "wide": Senses(view="wide"), "asynchronous": Senses(asynchronous=True),
    "no motion": Senses(motion=False), "no numbers": Senses(numbers=False),
    "lost .3": Senses(lost=0.3), "lost .6": Senses(lost=0.6), "lost .8": Senses(lost=0.8),
    "noise .5": Senses(noise=0.5), "noise 1": Senses(noise=1.0), "noise 2": Senses(noise=2.0),
    "noise .5 lost .6": Senses(noise=0.5, lost=0.6),
    "quantise 2": Senses(quantise=2.0), "quantise 4": Senses(quantise=4.0),
    "gaussian .0125": Senses(gaussian=0.0125), "gaussian .1": Senses(gaussian=0.1),
    "ball late 1": Senses(late_ball=1), "ball late 2": Senses(late_ball=2), "ball late 3": Senses(late_ball=3),
    "ball late 4": Senses(late_ball=4), "late 2": Senses(late=2), "late 4": Senses(late=4),
}  # fmt: skip
"""Name -> senses of the agents."""
STATED: dict[str, str] = {
    "Goalie2v1": "lost .6", "Goalie3v2": "lost .8", "LostAndFound": "lost .8",
    **dict.fromkeys(("KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"), "lost .6"),
}  # fmt: skip
"""Task, with the options of its player, -> senses in which, as measured (``docs/knowledge.md``, ``docs/attackers.md``), ``foresight``
succeeds in at least 80 % and ``frozen`` in at most 50 %."""
COSTS = {"bins": 6.0, "tracker": 1.3, "belief": 4.0, "foresight": 2.0}
"""CPU time on a tier, as a multiple of that on `RIVAL`."""
EPISODES_TOGETHER = 8 * BLOCK
"""Episodes of a block: as many as make the tail, in which the last ones are played alone, short beside the rest."""
SLOTS = 250
"""Episodes played side by side."""


@dataclass(frozen=True)
class KnowledgePlan:
    """What is measured.

    Raises
    ------
    UnknownName
        For a task, senses or a tier that there are not.
    ParameterError
        For none of them, the same one twice, or fewer episodes than one.
    """

    tasks: tuple[str, ...] = tuple(PLAYERS)
    senses: tuple[str, ...] = tuple(SENSES)
    tiers: tuple[str, ...] = tuple(TIERS)
    episodes: int = 1000
    seed: int = 0

    def __post_init__(self) -> None:
        for kind, names, known in (("task", self.tasks, PLAYERS), ("senses", self.senses, SENSES), ("tier", self.tiers, TIERS)):
            if not names:
                raise ParameterError(f"{kind}: none given; known are {', '.join(known)}")
            for i, name in enumerate(names):
                if name not in known:
                    raise unknown_name(kind, str(name), list(known))
                if name in names[:i]:
                    raise ParameterError(f"{kind} {name!r} is named twice")
        for number, value, least in (("episodes", self.episodes, 1), ("seed", self.seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least {least} is needed")

    @classmethod
    def quick(cls, seed: int = 0) -> KnowledgePlan:
        """The goalie, five senses, all tiers: a minute or two."""
        return cls(("Goalie",), ("default", "lost .3", "noise 1", "asynchronous", "ball late 2"), episodes=125, seed=seed)

    def blocks(self) -> list[Block]:
        """All blocks, in the order of the report; the controller of a block is ``senses/tier``."""
        return [
            Block(task, f"{senses}/{tier}", first, count, seed)
            for task in self.tasks
            for senses in self.senses
            for tier in self.tiers
            if tier in PLAYERS[task].tiers
            for first, count, seed in self.spread(PLAYERS[task].seeds)
        ]

    def spread(self, seeds: int) -> list[tuple[int, int, int]]:
        """First world, number of worlds and seed of the blocks of a task whose episodes are spread over so many seeds."""
        most = min(EPISODES_TOGETHER, -(-self.episodes // seeds))
        firsts = range(0, self.episodes, most)
        return [(first, min(most, self.episodes - first), self.seed + (k if seeds > 1 else 0)) for k, first in enumerate(firsts)]

    @property
    def seconds(self) -> float:
        """CPU time of all of it, about: what the players' registrations say."""
        return sum(b.count / 1000 * PLAYERS[b.task].seconds * COSTS.get(b.controller.rsplit("/", 1)[1], 1.0) for b in self.blocks())

    def constants(self) -> dict[str, dict[str, dict[str, float]]]:
        """What everybody plays with: task -> ``senses/tier`` -> name -> number."""
        found: dict[str, dict[str, dict[str, float]]] = {task: {} for task in self.tasks}
        for task, senses, tier in product(self.tasks, self.senses, self.tiers):
            if tier in PLAYERS[task].tiers:
                numbers = PLAYERS[task].numbers(tier, SENSES[senses])
                found[task][f"{senses}/{tier}"] = {} if numbers is None else numbers.to_dict()
        return found

    def write(self, folder: Path) -> None:
        """Note in the folder of a run what is to be played there (``plan.json``)."""
        write_atomically(
            folder / "plan.json", json.dumps({"suite": "knowledge", **asdict(self), "constants": self.constants()}, indent=2) + "\n"
        )

    @classmethod
    def read(cls, folder: Path) -> KnowledgePlan:
        """The plan noted by `write`.

        Raises
        ------
        CprmError
            When there is none, it is of something else, or the players' constants are others by now.
        """
        path = folder / "plan.json"
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            if data.pop("suite", None) != "knowledge":
                raise ValueError("of another suite")
            constants = data.pop("constants")
            values: Any = {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
            plan = cls(**values)
        except (OSError, KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
            raise CprmError(f"{path}: not the plan of a run of the suite 'knowledge': {error}") from None
        now = plan.constants()
        for task, where in [(name, where) for name in now for where in now[name]]:
            if constants.get(task, {}).get(where) != now[task][where]:
                raise CprmError(f"{path}: the constants of {task} on {where} are others by now; begin anew without --resume")
        return plan


def play_block(block: Block, _: float = math.inf) -> BlockResult:
    """Play the episodes of one block; its players are ours, and no decision of theirs is timed."""
    senses_name, tier = block.controller.rsplit("/", 1)
    task, senses = make_task(block.task, **PLAYERS[block.task].options), SENSES[senses_name]
    begin, spent = time.perf_counter(), time.process_time()
    found = play_episodes(task, PLAYERS[block.task].on(tier, senses), block.count, block.seed, block.first, senses, SLOTS)
    played = int(found.cycles.max()) * block.count
    return BlockResult(
        block, found.success.tolist(), found.cycles.tolist(), found.success.astype(float).tolist(),
        wall_seconds=time.perf_counter() - begin, controller_seconds=time.process_time() - spent, decisions=played, played=played,
    )  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One task, senses and tier; where the player's constants come from; the difference is to `RIVAL` in the same worlds."""

    task: str
    senses: str
    tier: str
    episodes: int
    successes: int
    rate: float
    low: float
    high: float
    constants: str
    difference: float | None = None
    difference_low: float | None = None
    difference_high: float | None = None
    p: float | None = None

    def cells(self) -> list[str]:
        """As text: rate with its Wilson interval, difference with its paired interval, p."""
        rate = f"{100 * self.rate:.1f} ({100 * self.low:.1f} - {100 * self.high:.1f})"
        if self.difference is None or self.difference_low is None or self.difference_high is None or self.p is None:
            return [self.task, self.senses, self.tier, self.constants, str(self.episodes), rate, "", ""]
        paired = f"{100 * self.difference:+.1f} ({100 * self.difference_low:+.1f}, {100 * self.difference_high:+.1f})"
        return [self.task, self.senses, self.tier, self.constants, str(self.episodes), rate, paired, f"{self.p:.2g}"]


HEAD = ("task", "senses", "tier", "constants", "n", "success %, Wilson 95 %", f"less {RIVAL}, paired 95 %", "p")


@dataclass(frozen=True)
class KnowledgeReport:
    """What the suite found."""

    plan: KnowledgePlan
    rows: tuple[Row, ...]

    def to_markdown(self) -> str:
        """The table."""
        lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
        return "\n".join(lines + ["| " + " | ".join(row.cells()) + " |" for row in self.rows]) + "\n"

    def write(self, folder: Path) -> list[Path]:
        """``knowledge.json``, ``knowledge.md`` and, with matplotlib, ``knowledge.png``."""
        data = {"plan": asdict(self.plan), "rows": [asdict(row) for row in self.rows]}
        files: list[tuple[str, str | bytes]] = [("knowledge.json", json.dumps(data, indent=2) + "\n"), ("knowledge.md", self.to_markdown())]
        picture = plot(self)
        if picture is not None:
            files.append(("knowledge.png", picture))
        for name, content in files:
            write_atomically(folder / name, content)
        return [folder / name for name, _ in files]


def summarise(plan: KnowledgePlan, results: list[BlockResult]) -> KnowledgeReport:
    """The report of the results there are."""
    found: dict[tuple[str, str, str], list[BlockResult]] = {}
    order = {block: k for k, block in enumerate(plan.blocks())}
    for result in sorted(results, key=lambda result: order[result.block]):  # workers finish them in any order
        senses, tier = result.block.controller.rsplit("/", 1)
        found.setdefault((result.block.task, senses, tier), []).append(result)
    success = {
        key: np.concatenate([np.array(r.success, bool) for r in sorted(group, key=lambda r: r.block.first)]) for key, group in found.items()
    }
    rows = []
    for (task, senses, tier), good in success.items():
        low, high = wilson_interval(int(good.sum()), len(good))
        rival = success.get((task, senses, RIVAL))
        row = Row(task, senses, tier, len(good), int(good.sum()), float(good.mean()), low, high, PLAYERS[task].origin(tier, SENSES[senses]))
        if tier != RIVAL and rival is not None and len(rival) == len(good):
            mean, least, most, p = paired_difference(good, rival)
            row = replace(row, difference=mean, difference_low=least, difference_high=most, p=p)
        rows.append(row)
    return KnowledgeReport(plan, tuple(rows))


def plot(report: KnowledgeReport) -> bytes | None:
    """Rates with their intervals, one panel for each task; None without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return None
    plan = report.plan
    figure = Figure(figsize=(3.0 + 1.1 * len(plan.senses), 3.6 * len(plan.tasks)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(plan.tasks), 1))
    for axis, task in zip(axes, plan.tasks):
        _bars(axis, [row for row in report.rows if row.task == task], lambda row: row.senses)
        axis.set_ylabel(f"{task}: success, %")
    return _picture(figure, axes[0])


def plot_groups(rows: Sequence[Row]) -> bytes:
    """One panel with a group of bars for each task and senses; needs matplotlib.

    Parameters
    ----------
    rows : sequence of Row
    """
    from matplotlib.figure import Figure

    tasks = len({row.task for row in rows})
    name: Callable[[Row], str] = (lambda row: f"{row.task}\n{row.senses}") if tasks > 1 else (lambda row: row.senses)
    figure = Figure(figsize=(2.0 + (1.6 if tasks > 1 else 0.5) * len({name(row) for row in rows}), 4.2), layout="constrained")
    axis = figure.subplots()
    _bars(axis, rows, name)
    axis.set_ylabel("success, %" if tasks > 1 else f"{rows[0].task}: success, %")
    return _picture(figure, axis)


def _bars(axis: Any, rows: Sequence[Row], name: Callable[[Row], str]) -> None:
    """Rates by tier, side by side in groups; Wilson intervals. A tier has one colour everywhere."""
    groups = list(dict.fromkeys(name(row) for row in rows))
    tiers = [tier for tier in TIERS if any(row.tier == tier for row in rows)]
    width = 0.8 / max(1, len(tiers))
    for k, tier in enumerate(tiers):
        own = [row for row in rows if row.tier == tier]
        places = [groups.index(name(row)) + (k - (len(tiers) - 1) / 2) * width for row in own]
        errors = [[max(0.0, 100 * (r.rate - r.low)) for r in own], [max(0.0, 100 * (r.high - r.rate)) for r in own]]
        color = f"C{list(TIERS).index(tier)}"
        axis.bar(places, [100 * r.rate for r in own], 0.92 * width, yerr=errors, capsize=2, label=tier, color=color)
    turned = any("\n" not in group for group in groups)
    axis.set_xticks(range(len(groups)), groups, rotation=30 if turned else 0, ha="right" if turned else "center")
    axis.set_ylim(0, 105)
    axis.spines[["top", "right"]].set_visible(False)


def _picture(figure: Any, axis: Any) -> bytes:
    """As PNG, with the legend above an axis."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, loc="outside upper center", ncols=len(labels))
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()
