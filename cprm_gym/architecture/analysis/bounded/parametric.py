"""Chains whose chances are expressions of a few parameters, each within its range."""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ....errors import ModelError
from ...expressions import Expression
from ..bounds import Bounds
from ..budget import Budget, Clock
from ..markov.absorption import absorption
from ..markov.chain import MarkovChain, unknown_outcome
from .interval_chain import IntervalChain
from .value_iteration import interval_bounds


@dataclass(frozen=True, eq=False)
class ParametricChain:
    """A chain with expressions for chances: one skill that is used in many states has one parameter, not one interval in each.

    Parameters
    ----------
    rows : sequence of mappings
        For each state, target -> expression over the parameters, ``"1 - p"``.
    outcomes : mapping of str to states
    initial : int

    Examples
    --------
    >>> chain = ParametricChain([{1: "p", 2: "1 - p"}, {}, {}], {"goal": [1], "lost": [2]})
    >>> chain.at({"p": 0.25}).row(0)
    {1: 0.25, 2: 0.75}
    """

    rows: Sequence[Mapping[int, str]]
    outcomes: Mapping[str, Sequence[int]]
    initial: int = 0

    def __post_init__(self) -> None:
        trees = tuple({int(j): Expression(text) for j, text in row.items()} for row in self.rows)
        object.__setattr__(self, "_trees", trees)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names that the expressions read."""
        return tuple(dict.fromkeys(name for row in self._trees for e in row.values() for name in e.names))  # type: ignore[attr-defined]

    def at(self, values: Mapping[str, float]) -> MarkovChain:
        """The chain with the given parameters.

        Raises
        ------
        ExpressionError, ModelError
            Where chances have no value, or do not sum to one.
        """
        rows = [{j: e.evaluate(values) for j, e in row.items()} for row in self._trees]  # type: ignore[attr-defined]
        return MarkovChain.from_rows(rows, self.outcomes, self.initial)

    def over(self, ranges: Mapping[str, tuple[float, float]]) -> IntervalChain:
        """An interval chain that holds every chain with parameters in the ranges; what rows share is forgotten.

        Raises
        ------
        ExpressionError, ModelError
        """
        rows: list[dict[int, tuple[float, float]]] = []
        for i, row in enumerate(self._trees):  # type: ignore[attr-defined]
            rows.append({})
            for j, expression in row.items():
                bound = expression.bounds(ranges)
                if not bound.total or bound.high < 0.0 or bound.low > 1.0:
                    raise ModelError(f"parametric chain, state {i}: {expression.text!r} is no chance over {dict(ranges)}")
                rows[-1][j] = (min(max(bound.low, 0.0), 1.0), min(max(bound.high, 0.0), 1.0))
        return IntervalChain.from_rows(rows, self.outcomes, self.initial)


class ParameterBounds(NamedTuple):
    """What an outcome's probability can be while parameters stay in their ranges."""

    least: Bounds
    """Within which its least value lies."""
    most: Bounds
    """Within which its largest value lies."""
    least_at: Mapping[str, float]
    """Parameters that give the upper end of `least`."""
    most_at: Mapping[str, float]
    boxes: int
    """How many parts of the ranges were looked at."""

    @property
    def bounds(self) -> Bounds:
        """A sound enclosure of every value."""
        return Bounds(self.least.low, self.most.high)


def parameter_bounds(
    chain: ParametricChain, ranges: Mapping[str, tuple[float, float]], outcome: str, *, gap: float = 1e-6, budget: Budget | None = None
) -> ParameterBounds:
    """Least and most probability over all parameters in their ranges, by halving the ranges where it may be decided (branch and bound).

    Every part is bounded by its interval chain, every midpoint and corner tried gives a value that is attained. Spent budgets leave the
    bounds sound and wider.

    Parameters
    ----------
    chain : ParametricChain
    ranges : mapping of str to (low, high)
    outcome : str
    gap : float
        How far apart the ends of `least`, and of `most`, may be.
    budget : Budget, optional
        Its seconds, and its states as the number of parts (default 4000).

    Raises
    ------
    UnknownName, ExpressionError, ModelError
    """
    if outcome not in chain.outcomes:
        raise unknown_outcome(outcome, chain.outcomes)
    limits, clock = (budget or Budget(states=4000)).start()
    whole = {name: (float(low), float(high)) for name, (low, high) in ranges.items()}
    least, most = _Search(chain, outcome, 1.0), _Search(chain, outcome, -1.0)
    for search in (least, most):
        search.run(whole, gap, limits.states // 2, clock)
    low, high = Bounds(least.bound, least.best), Bounds(-most.best, -most.bound)
    return ParameterBounds(low, high, least.best_at, most.best_at, least.boxes + most.boxes)


class _Search:
    """The least of `sign` times an outcome's probability, best part first."""

    def __init__(self, chain: ParametricChain, outcome: str, sign: float) -> None:
        self.chain, self.outcome, self.sign = chain, outcome, sign
        self.best, self.best_at = float("inf"), dict[str, float]()
        self.bound = -float("inf")
        self.boxes = 0

    def visit(self, box: dict[str, tuple[float, float]]) -> float:
        """A bound of the part, and values that are attained in its middle and two corners."""
        self.boxes += 1
        ends = [{name: pair[k] for name, pair in box.items()} for k in (0, 1)]
        for point in (*ends, {name: (low + high) / 2 for name, (low, high) in box.items()}):
            value = self.sign * absorption(self.chain.at(point)).probability(self.outcome).value
            if value < self.best:
                self.best, self.best_at = value, point
        found = interval_bounds(self.chain.over(box)).probabilities[self.outcome]
        return found.low if self.sign > 0 else -found.high

    def run(self, whole: dict[str, tuple[float, float]], gap: float, most: int, clock: Clock) -> None:
        """Halve the part that may hold less than any other until the bound is near what is attained."""
        heap = [(self.visit(whole), 0, whole)]
        while heap[0][0] < self.best - gap and self.boxes < most and not clock.spent():
            bound, number, box = heapq.heappop(heap)
            widest = max(box, key=lambda name: box[name][1] - box[name][0])
            low, high = box[widest]
            middle = (low + high) / 2
            if not low < middle < high:
                heapq.heappush(heap, (bound, number, box))
                break
            for part in ((low, middle), (middle, high)):
                half = {**box, widest: part}
                heapq.heappush(heap, (max(bound, self.visit(half)), self.boxes, half))
        self.bound = min(heap[0][0], self.best)
