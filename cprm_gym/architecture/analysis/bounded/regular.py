"""Useful bounds from few runs: what most runs keep to is bounded row by row, what the others do is counted once.

Where every row of a learned world gets intervals that all hold at once, a row that was seen three times may lead anywhere, and hundreds of
such rows leave nothing to be said. Here the runs are divided. The first half says which rows and edges are *regular*: begun often enough,
or taken at all. The second half, which had no part in that, gives

* intervals for the chances of the regular edges, given that no other is taken (Clopper-Pearson, Bonferroni over these edges), and
* one limit u for the probability that a run ever leaves what is regular: how many of its runs did (Clopper-Pearson, one-sided).

With Q(o) the probability of an outcome along regular edges alone, and R that of coming to a row that is not regular,

    least Q(o or R) - u  <=  P(o)  <=  most Q(o) + u.

For a run that stays regular has under the true chances at most the probability that it has under Q, whose rows are the true ones divided by
what stays regular. So P(o) exceeds Q(o) by no more than what leaves, and 1 - P(o) exceeds the Q of all else that stays by no more
either. What is beyond may be any outcome; no prior is assumed. Several ways to divide regular from rare hold at once by sharing the
confidence, and the best of each end is taken.

The runs of the second half have to be runs of the chain: those in which the behaviour did what the chain does not say of it count as having
left. That the next cell depends on this one and what is told of the net is assumed as for every chain of cells; u needs no assumption but
that runs are independent.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError
from ..bounds import Bounds
from ..sampling.intervals import clopper_pearson, upper_limit
from .interval_chain import IntervalChain
from .value_iteration import bounds_over_time, interval_bounds

OFTEN = (1, 3, 10, 40)
"""How often a row is begun in the first half to be regular: each is tried."""
LEFT = "unseen"
"""The outcome of a chain of regular rows where these end."""
Told = tuple[str, ...] | None
"""What went out in a cell; None at the end of a run."""
Path = Sequence[tuple[Hashable, Told]]
"""A run, cell by cell; one that did not end has something in its last."""


class Division(NamedTuple):
    """One way to divide regular from rare."""

    often: int
    """Least times that a regular row was begun."""
    rows: int
    """Rows that are regular."""
    edges: int
    """Chances that were bounded."""
    left: int
    """Runs of the second half that left what is regular."""
    most_left: float
    """u: the most that the probability of leaving it can be."""


Curves = tuple[NDArray[np.float64], NDArray[np.float64]]
"""(T + 1,) Least and most probability that an outcome has come by each cycle."""


@dataclass
class RegularBounds:
    """Bounds of each outcome, all at once.

    Attributes
    ----------
    runs : int
        Of the second half.
    least, most : mapping of str to (float, Division)
        Each end, and the division by which it was found.
    over_time : mapping of str to Curves
    """

    runs: int
    least: dict[str, tuple[float, Division]] = field(default_factory=dict)
    most: dict[str, tuple[float, Division]] = field(default_factory=dict)
    over_time: dict[str, Curves] = field(default_factory=dict)

    @property
    def probabilities(self) -> dict[str, Bounds]:
        """Outcome -> bounds."""
        return {o: Bounds(low, max(low, self.most[o][0])) for o, (low, _) in self.least.items()}

    def useful(self, division: Division) -> bool:
        """Whether another division can still move some end: not where more leave than all ends so far are apart from 0 and 1."""
        if not self.least:
            return True
        u = division.most_left
        return any(1.0 - u > low for low, _ in self.least.values()) or any(u < high for high, _ in self.most.values())

    def take(self, chain: IntervalChain, division: Division, outcomes: Sequence[str], cycles: int | None, late: int = 1) -> None:
        """Move the ends inward where the chain of a division's regular rows says so.

        Parameters
        ----------
        chain : IntervalChain
            Its outcome `LEFT` is what u counts; others that are none of `outcomes` may be anything, and are not counted.
        division : Division
        outcomes : sequence of str
        cycles : int, optional
        late : int
            Cycles by which the chain comes later than what it stands for.
        """
        u = division.most_left
        for o in outcomes:
            unknown = [at for name, at in chain.outcomes.items() if name not in (*outcomes, LEFT)]
            good = _one(chain, o, np.concatenate([chain.outcomes[o], chain.outcomes.get(LEFT, np.zeros(0, np.int64))]))
            bad = _one(chain, o, np.concatenate([chain.outcomes[o], *unknown]))
            least = max(0.0, interval_bounds(good).probabilities[o].low - u)
            most = min(1.0, interval_bounds(bad).probabilities[o].high + u)
            if o not in self.least or least > self.least[o][0]:
                self.least[o] = (least, division)
            if o not in self.most or most < self.most[o][0]:
                self.most[o] = (most, division)
            if cycles is not None:
                low = bounds_over_time(good, o, cycles + late)[0][late:] - u
                high = bounds_over_time(bad, o, cycles + late)[1][late:] + u
                new = np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)
                old = self.over_time.get(o, new)
                self.over_time[o] = np.maximum(old[0], new[0]), np.minimum(old[1], new[1])


def every_row_bounds(chain: IntervalChain, outcomes: Sequence[str]) -> dict[str, Bounds]:
    """Bounds from a chain in which every row by itself is bounded; its outcomes that are none of the given may be any of them.

    Parameters
    ----------
    chain : IntervalChain
    outcomes : sequence of str
    """
    found = {}
    for o in outcomes:
        beyond = [at for name, at in chain.outcomes.items() if name not in outcomes]
        least = interval_bounds(_one(chain, o, chain.outcomes[o])).probabilities[o].low
        most = interval_bounds(_one(chain, o, np.concatenate([chain.outcomes[o], *beyond]))).probabilities[o].high
        found[o] = Bounds(least, max(least, most))
    return found


def _one(chain: IntervalChain, outcome: str, states: NDArray[np.int64]) -> IntervalChain:
    """The chain with one outcome, and all others as another."""
    rest = np.setdiff1d(np.concatenate(list(chain.outcomes.values())), states)
    outcomes = {outcome: states} | ({"other": rest} if rest.size else {})
    return IntervalChain(chain.offsets, chain.targets, chain.lower, chain.upper, outcomes, chain.initial)


@dataclass(eq=False)
class Regular:
    """What is regular in runs of which the later half was held out.

    Parameters
    ----------
    first : mapping of (cell, told) to mapping of cell to int
        Counts of the first half.
    begins : mapping of cell to int
        Where the runs of the first half began.
    later : sequence of Path
        The runs that were held out.
    often : int
    confidence : float
        With which all intervals hold at once.
    strays : collection of int
        Numbers of later runs that are none of the chain's, whatever cells they come to: they count as having left.
    """

    first: Mapping[tuple[Hashable, Told], Mapping[Hashable, int]]
    begins: Mapping[Hashable, int]
    later: Sequence[Path]
    often: int
    confidence: float
    strays: Collection[int] = ()

    def __post_init__(self) -> None:
        self.rows = {key: row for key, row in self.first.items() if sum(row.values()) >= self.often}
        branching = sum(len(row) for row in self.rows.values() if len(row) > 1)
        self.edges = branching + (len(self.begins) if len(self.begins) > 1 else 0)
        self.level = 1.0 - (1.0 - self.confidence) / max(self.edges, 1)
        self._counts = counted(self.later)

    @property
    def division(self) -> Division:
        """In numbers."""
        left = sum(k in self.strays or not self.keeps(run) for k, run in enumerate(self.later))
        return Division(self.often, len(self.rows), self.edges, left, upper_limit(left, len(self.later), self.confidence))

    def keeps(self, run: Path) -> bool:
        """Whether a run keeps to regular rows and edges to its end."""
        if run[0][0] not in self.begins or run[-1][1] is not None:
            return False
        return all(then in self.rows.get((cell, told), ()) for (cell, told), (then, _) in pairwise(run))

    def start(self) -> dict[Hashable, Bounds]:
        """Within what the chances lie of where a run begins."""
        counts = dict.fromkeys(self.begins, 0)
        for run in self.later:
            if run[0][0] in counts:
                counts[run[0][0]] += 1
        return self._intervals(counts)

    def row(self, key: tuple[Hashable, Told]) -> dict[Hashable, tuple[float, Bounds]]:
        """Likeliest chance and interval of each regular edge of a row; empty where the row is none."""
        row = self.rows.get(key, {})
        later = self._counts.get(key, {})
        counts = {then: later.get(then, 0) for then in row}
        total = sum(row.values()) + sum(counts.values())
        return {then: ((row[then] + counts[then]) / total, interval) for then, interval in self._intervals(counts).items()}

    def _intervals(self, counts: Mapping[Hashable, int]) -> dict[Hashable, Bounds]:
        if len(counts) == 1:
            return dict.fromkeys(counts, Bounds(1.0, 1.0))
        total = sum(counts.values())
        if not total:
            return dict.fromkeys(counts, Bounds(0.0, 1.0))
        return {cell: clopper_pearson(n, total, self.level) for cell, n in counts.items()}


def counted(runs: Sequence[Path]) -> dict[tuple[Hashable, Told], dict[Hashable, int]]:
    """How often what followed what."""
    counts: dict[tuple[Hashable, Told], dict[Hashable, int]] = {}
    for run in runs:
        for key, (then, _) in pairwise(run):
            row = counts.setdefault(key, {})
            row[then] = row.get(then, 0) + 1
    return counts


def shared_confidence(confidence: float) -> float:
    """With which each of the two statements of each division holds, so that all do with the given one."""
    return 1.0 - (1.0 - confidence) / (2 * len(OFTEN))


def path_bounds(
    first: Sequence[Sequence[Hashable]], later: Sequence[Sequence[Hashable]], outcomes: Sequence[Hashable], confidence: float = 0.95
) -> RegularBounds:
    """Bounds of how runs end that are known as the states which they went through.

    Parameters
    ----------
    first, later : sequence of paths
        The runs that say what is regular, and those that had no part in that. A path ends with one of `outcomes` where the run ended, else
        with any other state: a later one that did not end counts as having left.
    outcomes : sequence of hashable
        Known by their texts in the answer.
    confidence : float

    Raises
    ------
    ModelError
        For no runs, or a path without states.
    """
    if not first or not later or not all(map(len, (*first, *later))):
        raise ModelError(f"regular bounds: needs runs of both kinds, each with a state; got {len(first)} and {len(later)}")
    ends = set(outcomes)
    told: list[list[tuple[Hashable, Told]]] = [[(s, None if s in ends else ()) for s in path] for path in (*first, *later)]
    counts, begins = counted(told[: len(first)]), dict[Hashable, int]()
    for path in first:
        begins[path[0]] = begins.get(path[0], 0) + 1
    found = RegularBounds(len(later))
    for often in OFTEN:
        regular = Regular(counts, begins, told[len(first) :], often, shared_confidence(confidence))
        if found.useful(regular.division):
            found.take(_chain_of(regular, outcomes), regular.division, [str(o) for o in outcomes], None)
    return found


def _chain_of(regular: Regular, outcomes: Sequence[Hashable]) -> IntervalChain:
    """The chain of regular rows alone, with a state before it from which nature picks where it begins."""
    place: dict[Hashable, int] = {o: k for k, o in enumerate(outcomes)}
    left = len(place)
    place |= {cell: left + 1 + k for k, (cell, _) in enumerate(regular.rows)}
    rows: list[dict[int, tuple[float, float]]] = [{} for _ in range(left + 1)]

    def row(chances: Mapping[Hashable, Bounds]) -> dict[int, tuple[float, float]]:
        merged: dict[int, tuple[float, float]] = {}
        for then, b in chances.items():
            low, high = merged.get(place.get(then, left), (0.0, 0.0))
            merged[place.get(then, left)] = (low + b.low, min(1.0, high + b.high))
        return merged

    rows += [row({then: b for then, (_, b) in regular.row(key).items()}) for key in regular.rows]
    rows.append(row(regular.start()))
    ends = {str(o): [k] for k, o in enumerate(outcomes)} | {LEFT: [left]}
    return IntervalChain.from_rows(rows, ends, len(rows) - 1)
