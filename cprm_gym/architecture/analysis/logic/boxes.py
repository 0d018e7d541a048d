"""Claims over boxes: proved by interval arithmetic with outward rounding, refuted by a point, or left undecided."""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from dataclasses import dataclass, field

from ....errors import ExpressionError
from ...expressions import Expression
from ..budget import Budget

PARTS = 50_000
"""Boxes that a claim may be cut into."""


@dataclass(frozen=True)
class Claim:
    """Wherever all assumptions are true, so is the conclusion.

    Parameters
    ----------
    name : str
    assumptions : tuple of str
    conclusion : str
    """

    name: str
    assumptions: tuple[str, ...]
    conclusion: str


@dataclass(frozen=True)
class BoxVerdict:
    """What became of a claim.

    Attributes
    ----------
    name : str
    holds : bool or None
        Proved, refuted, or undecided.
    why : str
    point : mapping of str to float
        Where it is false; or, undecided, the middle of a box that was left over.
    boxes : int
        How many were looked at.
    """

    name: str
    holds: bool | None
    why: str = ""
    point: Mapping[str, float] = field(default_factory=dict)
    boxes: int = 0

    def __str__(self) -> str:
        word = {True: "proved", False: "refuted", None: "undecided"}[self.holds]
        at = " at " + ", ".join(f"{k} = {v:.6g}" for k, v in self.point.items()) if self.point else ""
        return f"{self.name}: {word}{at}" + (f" ({self.why})" if self.why else "")


def prove(claim: Claim, ranges: Mapping[str, tuple[float, float]], *, budget: Budget | None = None) -> BoxVerdict:
    """Decide a claim over ranges by cutting boxes where it is neither true nor void, the largest first.

    Parameters
    ----------
    claim : Claim
    ranges : mapping of str to (low, high)
        Of every name that the claim reads.
    budget : Budget, optional
        Its seconds, and its states as the number of boxes (default `PARTS`).

    Raises
    ------
    ExpressionError
        For a name without a range.

    Examples
    --------
    >>> print(prove(Claim("square", ("x > 0.5",), "x * x > 0.2"), {"x": (0.0, 1.0)}))
    square: proved
    >>> prove(Claim("square", ("x > 0.5",), "x * x > 0.3"), {"x": (0.0, 1.0)}).holds
    False
    """
    limits, clock = (budget or Budget(states=PARTS)).start()
    assumptions = [Expression(text) for text in claim.assumptions]
    conclusion = Expression(claim.conclusion)
    used = {name for e in (*assumptions, conclusion) for name in e.names}
    whole = {name: ranges[name] for name in ranges if name in used}
    for name in used - set(whole):
        raise ExpressionError(f"claim {claim.name!r}: no range for {name!r}")
    width = {name: max(high - low, 1e-300) for name, (low, high) in whole.items()}
    heap: list[tuple[float, int, dict[str, tuple[float, float]]]] = [(-1.0, 0, dict(whole))]
    boxes = 0
    while heap:
        if boxes >= limits.states or clock.spent():
            _, _, left = heap[0]
            why = "time is over" if clock.spent() else f"{boxes} boxes were not enough"
            return BoxVerdict(claim.name, None, why, {n: (a + b) / 2 for n, (a, b) in left.items()}, boxes)
        _, _, box = heapq.heappop(heap)
        boxes += 1
        if any(_never(e, box) for e in assumptions) or _always(conclusion, box):
            continue
        point = _refuting(assumptions, conclusion, box)
        if point is not None:
            return BoxVerdict(claim.name, False, "", point, boxes)
        widest = max(box, key=lambda n: (box[n][1] - box[n][0]) / width[n])
        low, high = box[widest]
        middle = (low + high) / 2
        if not low < middle < high:
            return BoxVerdict(claim.name, None, "boxes cannot be cut any further", {n: a for n, (a, _) in box.items()}, boxes)
        for part in ((low, middle), (middle, high)):
            half = {**box, widest: part}
            heapq.heappush(heap, (-max((b - a) / width[n] for n, (a, b) in half.items()), 2 * boxes + (part[0] == middle), half))
    return BoxVerdict(claim.name, True, "", {}, boxes)


def _always(e: Expression, box: Mapping[str, tuple[float, float]]) -> bool:
    found = e.bounds(box)
    return found.total and not found.empty and (found.low > 0.0 or found.high < 0.0)


def _never(e: Expression, box: Mapping[str, tuple[float, float]]) -> bool:
    found = e.bounds(box)
    return found.total and found.low == found.high == 0.0


def _refuting(assumptions: list[Expression], conclusion: Expression, box: Mapping[str, tuple[float, float]]) -> dict[str, float] | None:
    """A point of the box where the claim is false: its middle, or one of two corners."""
    for share in (0.5, 0.0, 1.0):
        point = {n: a + share * (b - a) for n, (a, b) in box.items()}
        try:
            if all(e.evaluate(point) for e in assumptions) and not conclusion.evaluate(point):
                return point
        except ExpressionError:
            continue
    return None
