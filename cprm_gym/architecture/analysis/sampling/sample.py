"""Play runs and say what they show: outcomes, times, properties; to a width, within a budget, taken up again."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ....errors import FormatError, ModelError, unknown_name
from ....workers import results
from ..bounds import Bounds
from ..budget import Budget
from .identity import fingerprint
from .intervals import clopper_pearson, lower_limit, simultaneous, upper_limit
from .means import Range, mean_interval, mean_sequence
from .numbers import Number
from .numbers import numbers as read_numbers
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
    ranges : dict of str to (low, high) or None
        Numbers of the runs that were asked for, and what was stated of them.
    numbers : dict of int to mapping of str to list of float
        Number of a block's first run -> these numbers of its runs.
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
    ranges: dict[str, Range | None] = field(default_factory=dict)
    numbers: dict[int, Mapping[str, list[float]]] = field(default_factory=dict)
    reason: str = ""

    def __post_init__(self) -> None:
        if not 0.0 < self.confidence < 1.0:
            raise ModelError(f"confidence {self.confidence}: needs a number between 0 and 1")

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

    def values(self, name: str) -> list[float]:
        """One of the numbers that were asked for, run by run.

        Raises
        ------
        UnknownName
        """
        if name not in self.ranges:
            raise unknown_name("number", name, self.ranges)
        return [x for start in sorted(self.numbers) for x in self.numbers[start][name]]

    def mean(self, name: str) -> Bounds:
        """Interval of a number's mean, for a number of runs that was fixed beforehand (`mean_interval`)."""
        return mean_interval(self.values(name), self.confidence, self.ranges[name])

    def means(self) -> dict[str, Bounds]:
        """Of all numbers, holding at once."""
        each = 1.0 - (1.0 - self.confidence) / max(len(self.ranges), 1)
        return {name: mean_interval(self.values(name), each, within) for name, within in self.ranges.items()}

    def mean_sequence(self, name: str) -> Bounds:
        """An interval of a mean that holds whenever one looks (`sampling.means.mean_sequence`)."""
        return mean_sequence(self.values(name), self.confidence, self.ranges[name])

    def any_time(self, name: str) -> Bounds:
        """`mean_sequence` of a number, `sequence` of an outcome."""
        return self.mean_sequence(name) if name in self.ranges else self.sequence(name)

    def mean_cycles(self, outcome: str) -> float:
        """Mean cycles of the runs of an outcome, nan without any."""
        n = self.count(outcome)
        return self.cycles[outcome][0] / n if n else math.nan

    def add(self, block: Mapping[str, Any]) -> None:
        """Take in what `_tally` counted of some runs."""
        self.numbers[block["start"]] = block["numbers"]
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
            "numbers": {
                name: {"mean": math.fsum(values) / self.runs, "least": min(values), "most": max(values),
                       "range": None if within is None else list(within),
                       "interval": _both(self.mean(name)), "any_time": _both(self.mean_sequence(name))}
                for name, within in self.ranges.items()
                if (values := self.values(name))
            },
        }  # fmt: skip


def _both(bounds: Bounds) -> list[float | None]:
    return [_finite(bounds.low), _finite(bounds.high)]


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def sample(
    runs: Runs,
    episodes: int = 1000,
    *,
    seed: int = 0,
    confidence: float = 0.95,
    properties_: Sequence[str] | Mapping[str, str] = (),
    numbers: Sequence[str] | Mapping[str, Range | None] = (),
    width: float | Mapping[str, float] | None = None,
    budget: Budget | None = None,
    journal: Path | None = None,
    workers: int = 1,
    block: int = 256,
    progress: Callable[[Sample], object] | None = None,
    ray: str | None = None,
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
    numbers : sequence of str or mapping of str to (low, high), optional
        Numbers of runs whose means are wanted (`Number`): ``{"return": (0, 500), "length": (0, 500), "max obs.o0": None}``. With a range,
        between which they lie whatever happens, their intervals hold for certain; without one approximately.
    width : float or mapping of str to float, optional
        Stop as soon as the any-time interval of every outcome is at most so wide; of a mapping those of the outcomes and numbers in it.
        Then `Sample.sequence` and `Sample.mean_sequence` are what holds.
    budget : Budget, optional
        Its seconds.
    journal : Path, optional
        A file in which finished blocks are noted; an interrupted sample goes on from it. It knows chain, environment and policy
        (`fingerprint`), and one of others is refused.
    workers, block : int
        Processes, and runs that are played together.
    progress : callable, optional
        Called with the sample after every block.
    ray : str, optional
        A Ray cluster that plays instead of `workers` (`cprm_gym.workers.results`).

    Raises
    ------
    ModelError, FormatError, ExpressionError
        When numbers make no sense; when the journal is of another sample.
    """
    if episodes < 1 or block < 1 or workers < 1:
        raise ModelError(f"episodes {episodes}, block {block}, workers {workers}: all must be positive")
    wanted, counted = properties(properties_), read_numbers(numbers)
    found = Sample(tuple(runs.outcomes), confidence, seed, ranges={name: n.within for name, n in counted.items()})
    widths = _widths(width, found)
    _, clock = (budget or Budget()).start()
    done: dict[int, dict[str, Any]] = {}
    if journal is not None:
        ranges = {name: None if within is None else list(map(float, within)) for name, within in found.ranges.items()}
        plan = {"runs": fingerprint(runs), "seed": seed, "block": block, "outcomes": list(runs.outcomes),
                "properties": {k: p.text for k, p in wanted.items()}, "numbers": ranges}  # fmt: skip
        done = _read(journal, plan)
    starts = range(0, episodes, block)
    for k in starts:
        if k in done and k + done[k]["runs"] <= episodes:
            found.add(done[k])
    todo = [range(k, min(k + block, episodes)) for k in starts if k not in done or k + done[k]["runs"] > episodes]
    found.reason = "episodes"
    try:
        for tally in _play(runs, todo, seed, (wanted, counted), workers, ray):
            found.add(tally)
            if journal is not None:
                with journal.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(tally) + "\n")
            if progress is not None:
                progress(found)
            if widths and all(found.any_time(name).width <= most for name, most in widths.items()):
                found.reason = "width"
                break
            if clock.spent():
                found.reason = clock.reason
                break
    except KeyboardInterrupt:
        found.reason = "interrupted"
    return found


def _widths(width: float | Mapping[str, float] | None, found: Sample) -> dict[str, float]:
    """How wide the interval of each outcome or number may be."""
    if width is None:
        return {}
    given = dict(width) if isinstance(width, Mapping) else dict.fromkeys(found.outcomes, width)
    for name, w in given.items():
        if name not in found.outcomes and name not in found.ranges:
            raise unknown_name("width, outcome or number", name, (*found.outcomes, *found.ranges))
        if not w > 0:
            raise ModelError(f"width {w} of {name!r}: must be positive")
    return given


_Wanted = tuple[Mapping[str, Property], Mapping[str, Number]]


def _play(runs: Runs, todo: Sequence[range], seed: int, wanted: _Wanted, workers: int, ray: str | None) -> Iterator[dict[str, Any]]:
    """Tallies of blocks, as they are finished, in their order."""
    if workers == 1 and ray is None:
        for numbers in todo:
            yield _tally(runs, numbers, seed, wanted)
        return
    yield from results(_tally, [(runs, numbers, seed, wanted) for numbers in todo], workers, ray, ordered=True)


def _tally(runs: Runs, numbers: range, seed: int, asked: _Wanted) -> dict[str, Any]:
    """Counts of some runs, as plain values."""
    wanted, numbered = asked
    values: dict[str, list[float]] = {name: [] for name in numbered}
    counts: dict[str, int] = {}
    cycles: dict[str, list[int]] = {}
    first: dict[str, int] = {}
    found = {name: PropertyCount() for name in wanted}
    for number, run in zip(numbers, runs.play(numbers, seed, bool(wanted) or any(n.signals for n in numbered.values()))):
        if run.outcome not in runs.outcomes:
            raise ModelError(f"run {number} ended in {run.outcome!r}, which is none of the outcomes {', '.join(runs.outcomes)}")
        counts[run.outcome] = counts.get(run.outcome, 0) + 1
        sums = cycles.setdefault(run.outcome, [0, 0])
        sums[0] += run.cycles
        sums[1] += run.cycles**2
        first.setdefault(run.outcome, number)
        for name, number_ in numbered.items():
            try:
                values[name].append(number_.of(run))
            except ModelError as error:
                raise ModelError(f"run {number}: {error}") from None
        for name, what in wanted.items():
            true, margin, old = what.holds(run.signals), what.robustness(run.signals), found[name]
            finite = margin if math.isfinite(margin) else 0.0
            false_at = number if not true and old.first_false < 0 else old.first_false
            found[name] = PropertyCount(old.true + true, min(old.least, margin), old.total + finite, false_at)
    return {"start": numbers.start, "runs": len(numbers), "counts": counts, "cycles": cycles, "first": first,
            "properties": {name: list(p) for name, p in found.items()}, "numbers": values}  # fmt: skip


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
        if any(not {"runs", "counts", "cycles", "first", "properties", "numbers"} <= b.keys() for b in blocks):
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
        and block["numbers"].keys() == plan["numbers"].keys()
        and all(len(values) == runs and all(map(math.isfinite, values)) for values in block["numbers"].values())
    )
