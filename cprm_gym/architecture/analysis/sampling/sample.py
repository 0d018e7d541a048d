"""Play runs and say what they show: outcomes, times, properties; to a width, within a budget, taken up again."""

from __future__ import annotations

import json
import math
import multiprocessing
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ....errors import FormatError, ModelError, unknown_name
from ..bounds import Bounds
from ..budget import Budget, Clock
from .intervals import clopper_pearson, lower_limit, simultaneous, upper_limit
from .properties import Property, properties
from .runs import Runs
from .sequences import confidence_sequence


class PropertyCount(NamedTuple):
    """How a property came out."""

    true: int = 0
    least: float = math.inf
    """The least robustness of a run."""
    total: float = 0.0
    """Sum of the robustness, where it was finite."""
    first_false: int = -1
    """Number of the first run of which it is false, to be played again; -1: none."""


@dataclass
class Sample:
    """What the runs so far show.

    Attributes
    ----------
    outcomes : tuple of str
    confidence : float
    seed : int
    counts : dict of str to int
        Outcome -> runs that ended so.
    cycles : dict of str to (int, int)
        Outcome -> sum and sum of squares of the cycles of its runs.
    first : dict of str to int
        Outcome -> number of the first run that ended so, to be played again with the same seed.
    properties : dict of str to PropertyCount
    reason : str
        Why sampling ended: "episodes", "width", "seconds", "interrupted".
    """

    outcomes: tuple[str, ...]
    confidence: float = 0.95
    seed: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    cycles: dict[str, tuple[int, int]] = field(default_factory=dict)
    first: dict[str, int] = field(default_factory=dict)
    properties: dict[str, PropertyCount] = field(default_factory=dict)
    reason: str = ""

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return sum(self.counts.values())

    def count(self, outcome: str) -> int:
        """Runs that ended in an outcome.

        Raises
        ------
        UnknownName
        """
        if outcome not in self.outcomes:
            raise unknown_name("outcome", outcome, self.outcomes)
        return self.counts.get(outcome, 0)

    def interval(self, outcome: str) -> Bounds:
        """Clopper-Pearson interval of one outcome, for a number of runs that was fixed beforehand."""
        return clopper_pearson(self.count(outcome), self.runs, self.confidence)

    def intervals(self) -> dict[str, Bounds]:
        """Of all outcomes, holding at once."""
        return simultaneous({name: self.count(name) for name in self.outcomes}, self.confidence)

    def at_most(self, outcome: str) -> float:
        """One-sided limit: what a failure's probability does not exceed."""
        return upper_limit(self.count(outcome), self.runs, self.confidence)

    def at_least(self, outcome: str) -> float:
        """One-sided limit: what a success's probability does not fall below."""
        return lower_limit(self.count(outcome), self.runs, self.confidence)

    def sequence(self, outcome: str) -> Bounds:
        """An interval that holds whenever one looks, also where looking decided when to stop."""
        return confidence_sequence(self.count(outcome), self.runs, self.confidence)

    def property_interval(self, name: str) -> Bounds:
        """Clopper-Pearson interval of a property's probability.

        Raises
        ------
        UnknownName
        """
        if name not in self.properties:
            raise unknown_name("property", name, self.properties)
        return clopper_pearson(self.properties[name].true, self.runs, self.confidence)

    def mean_cycles(self, outcome: str) -> float:
        """Mean cycles of the runs of an outcome, nan without any."""
        n = self.count(outcome)
        return self.cycles[outcome][0] / n if n else math.nan

    def add(self, block: Mapping[str, Any]) -> None:
        """Take in what `_tally` counted of some runs."""
        for name, count in block["counts"].items():
            self.counts[name] = self.counts.get(name, 0) + count
            a, b = self.cycles.get(name, (0, 0))
            c, d = block["cycles"][name]
            self.cycles[name] = (a + c, b + d)
            self.first[name] = min(self.first.get(name, block["first"][name]), block["first"][name])
        for name, values in block["properties"].items():
            old, new = self.properties.get(name, PropertyCount()), PropertyCount(*values)
            firsts = [k for k in (old.first_false, new.first_false) if k >= 0]
            self.properties[name] = PropertyCount(
                old.true + new.true, min(old.least, new.least), old.total + new.total, min(firsts, default=-1)
            )

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        joint = self.intervals() if self.runs else {}
        return {
            "runs": self.runs,
            "confidence": self.confidence,
            "seed": self.seed,
            "ended_by": self.reason,
            "outcomes": {
                name: {"count": self.count(name), "joint": list(joint[name]), "any_time": list(self.sequence(name)),
                       "mean_cycles": self.mean_cycles(name) if self.count(name) else None, "first_run": self.first.get(name)}
                for name in self.outcomes
                if self.runs
            },
            "properties": {
                name: {"true": p.true, "interval": list(self.property_interval(name)), "least_robustness": _finite(p.least),
                       "mean_robustness": _finite(p.total / self.runs), "first_false": None if p.first_false < 0 else p.first_false}
                for name, p in self.properties.items()
            },
        }  # fmt: skip


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def sample(
    runs: Runs,
    episodes: int = 1000,
    *,
    seed: int = 0,
    confidence: float = 0.95,
    properties_: Sequence[str] | Mapping[str, str] = (),
    width: float | None = None,
    budget: Budget | None = None,
    journal: Path | None = None,
    workers: int = 1,
    block: int = 256,
    progress: Callable[[Sample], object] | None = None,
) -> Sample:
    """Play runs until there are enough.

    Run k depends on (seed, k) alone: blocks are played by any workers in any order with the same result. Interrupted or out of time, what
    was counted is kept.

    Parameters
    ----------
    runs : Runs
        To be played; with several workers it is sent to them, and must be of an importable class.
    episodes : int
        Most runs.
    seed : int
    confidence : float
    properties_ : sequence or mapping of str
        Formulas (`Property`) to be looked at beside outcomes.
    width : float, optional
        Stop as soon as the any-time interval of every outcome is at most so wide; then `Sample.sequence` is what holds.
    budget : Budget, optional
        Its seconds.
    journal : Path, optional
        A file in which finished blocks are noted; an interrupted sample goes on from it.
    workers, block : int
        Processes, and runs that are played together.
    progress : callable, optional
        Called with the sample after every block.

    Raises
    ------
    ModelError, FormatError, ExpressionError
        When numbers make no sense; when the journal is of another sample.
    """
    if episodes < 1 or block < 1 or workers < 1 or (width is not None and not width > 0):
        raise ModelError(f"episodes {episodes}, block {block}, workers {workers}, width {width}: all must be positive")
    found = Sample(tuple(runs.outcomes), confidence, seed)
    wanted = properties(properties_)
    _, clock = (budget or Budget()).start()
    plan = {"seed": seed, "block": block, "outcomes": list(runs.outcomes), "properties": {k: p.text for k, p in wanted.items()}}
    done = _read(journal, plan) if journal is not None else {}
    starts = range(0, episodes, block)
    for k in starts:
        if k in done and k + done[k]["runs"] <= episodes:
            found.add(done[k])
    todo = [range(k, min(k + block, episodes)) for k in starts if k not in done or k + done[k]["runs"] > episodes]
    found.reason = "episodes"
    try:
        for tally in _play(runs, todo, seed, wanted, workers, clock):
            found.add(tally)
            if journal is not None:
                with journal.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(tally) + "\n")
            if progress is not None:
                progress(found)
            if width is not None and all(found.sequence(name).width <= width for name in found.outcomes):
                found.reason = "width"
                break
            if clock.spent():
                found.reason = clock.reason
                break
    except KeyboardInterrupt:
        found.reason = "interrupted"
    return found


def _play(
    runs: Runs, todo: Sequence[range], seed: int, wanted: Mapping[str, Property], workers: int, clock: Clock
) -> Iterator[dict[str, Any]]:
    """Tallies of blocks, as they are finished, in their order."""
    if workers == 1:
        for numbers in todo:
            yield _tally(runs, numbers, seed, wanted)
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        waiting: list[Future[dict[str, Any]]] = []
        rest = iter(todo)
        try:
            for numbers in rest:
                waiting.append(pool.submit(_tally, runs, numbers, seed, wanted))
                if len(waiting) >= 2 * workers:
                    yield waiting.pop(0).result()
                if clock.spent():
                    break
            while waiting:
                yield waiting.pop(0).result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _tally(runs: Runs, numbers: range, seed: int, wanted: Mapping[str, Property]) -> dict[str, Any]:
    """Counts of some runs, as plain values."""
    counts: dict[str, int] = {}
    cycles: dict[str, list[int]] = {}
    first: dict[str, int] = {}
    found = {name: PropertyCount() for name in wanted}
    for number, run in zip(numbers, runs.play(numbers, seed, bool(wanted))):
        if run.outcome not in runs.outcomes:
            raise ModelError(f"run {number} ended in {run.outcome!r}, which is none of the outcomes {', '.join(runs.outcomes)}")
        counts[run.outcome] = counts.get(run.outcome, 0) + 1
        sums = cycles.setdefault(run.outcome, [0, 0])
        sums[0] += run.cycles
        sums[1] += run.cycles**2
        first.setdefault(run.outcome, number)
        for name, what in wanted.items():
            true, margin, old = what.holds(run.signals), what.robustness(run.signals), found[name]
            finite = margin if math.isfinite(margin) else 0.0
            false_at = number if not true and old.first_false < 0 else old.first_false
            found[name] = PropertyCount(old.true + true, min(old.least, margin), old.total + finite, false_at)
    return {"start": numbers.start, "runs": len(numbers), "counts": counts, "cycles": cycles, "first": first,
            "properties": {name: list(p) for name, p in found.items()}}  # fmt: skip


def _read(journal: Path, plan: dict[str, Any]) -> dict[int, dict[str, Any]]:
    """Finished blocks of a journal that was begun with the same plan; begins one where there is none.

    Raises
    ------
    FormatError
        When it is of another sample or damaged; a last line that an interruption cut short is dropped.
    """
    if not journal.exists():
        journal.write_text(json.dumps(plan) + "\n", encoding="utf-8")
        return {}
    lines = journal.read_text(encoding="utf-8").split("\n")
    whole, torn = lines[:-1], lines[-1]
    try:
        head = json.loads(whole[0]) if whole else None
        if head != plan:
            raise FormatError(f"{journal}: the journal of another sample: {head}, not {plan}")
        blocks = [json.loads(line) for line in whole[1:]]
        found = {int(b["start"]): b for b in blocks}
        if any(not {"runs", "counts", "cycles", "first", "properties"} <= b.keys() for b in blocks):
            raise FormatError(f"{journal}: a block is not whole")
        if not all(_adds_up(b, plan) for b in blocks):
            raise FormatError(f"{journal}: a block does not add up")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"{journal}: {error}") from None
    if torn:
        journal.write_text("".join(f"{line}\n" for line in whole), encoding="utf-8")
    return found


def _adds_up(block: Mapping[str, Any], plan: Mapping[str, Any]) -> bool:
    """Whether the tallies of a block are of this sample's outcomes and properties, and of as many runs as it says."""
    counts, runs = block["counts"], block["runs"]
    return (
        0 < runs == sum(counts.values())
        and min(counts.values()) > 0
        and set(counts) <= set(plan["outcomes"])
        and all(counts.keys() == block[key].keys() for key in ("cycles", "first"))
        and block["properties"].keys() == plan["properties"].keys()
        and all(0 <= true <= runs for true, *_ in block["properties"].values())
    )
