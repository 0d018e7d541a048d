"""What an experiment tells: tables, panels, comparisons, findings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from .comparisons import Comparison

HOLDS, IN_PART, FAILS, UNDECIDED, UNKNOWN = "holds", "in part", "does not hold", "not decided", "not yet measured"
"""Verdicts; not decided where there were too few episodes to tell."""
MATTERS = 0.05
"""A difference of rates that matters."""


@dataclass(frozen=True)
class Table:
    """Rows of text under a head.

    Parameters
    ----------
    title : str
    head : tuple of str
    rows : tuple of tuple of str
    brief : bool
        Whether it is to be read first; other tables are to look something up.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    brief: bool = False

    def to_markdown(self) -> str:
        """As a table of Markdown."""
        lines = ["| " + " | ".join(self.head) + " |", "|" + "---|" * len(self.head)]
        return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in self.rows]) + "\n"


@dataclass(frozen=True)
class Point:
    """A value with its interval, at a place of the axis."""

    x: float
    y: float
    low: float
    high: float


@dataclass(frozen=True)
class Series:
    """What one player or tier did along an axis."""

    name: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Curves:
    """Small multiple of lines.

    Parameters
    ----------
    title : str
    series : tuple of Series
    ticks : tuple of (float, str)
        Of the axis.
    x, y : str
        What stands on the axes, with units.
    log : bool
        Whether the values are shown by their logarithm.
    """

    title: str
    series: tuple[Series, ...]
    ticks: tuple[tuple[float, str], ...]
    x: str
    y: str = "success, %"
    log: bool = False


@dataclass(frozen=True)
class Dots:
    """Small multiple of players in rows, each with a value and its interval.

    Parameters
    ----------
    title : str
    rows : tuple of (str, float, float, float)
        Name, value, low, high.
    x : str
    most : float
        End of the axis; 0 for the largest value.
    """

    title: str
    rows: tuple[tuple[str, float, float, float], ...]
    x: str = "success, %"
    most: float = 100.0


@dataclass(frozen=True)
class Finding:
    """What an experiment says of a claim.

    Parameters
    ----------
    claim : str
        Key of `claims.CLAIMS`.
    verdict : str
        `HOLDS`, `IN_PART`, `FAILS`, `UNDECIDED` or `UNKNOWN`.
    figure : str
        The numbers behind it, in a sentence or two.
    more : str
        What else has to be known to judge it.
    """

    claim: str
    verdict: str
    figure: str
    more: str = ""


@dataclass(frozen=True)
class Told:
    """All of an experiment."""

    name: str
    title: str
    question: str
    tables: tuple[Table, ...] = ()
    panels: tuple[Curves | Dots, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def better(self) -> tuple[Comparison, ...]:
        """Comparisons that are decided."""
        return tuple(c for c in self.comparisons if c.better)


def verdict_of(ahead: int, compared: Sequence[Comparison]) -> str:
    """Whether the first is better than the second: in all, in some, in none, or in none but perhaps by an amount that matters."""
    if ahead:
        return HOLDS if ahead == len(compared) else IN_PART
    return UNDECIDED if any(c.high > MATTERS for c in compared) else FAILS


def sentence(c: Comparison) -> str:
    """``code > net on Goalie, noise 1: +3.8 (+1.8, +5.7), h .09, n 500``; only of decided comparisons."""
    other = c.second if c.better == c.first else c.first
    if c.better == c.second:  # told as the better one's
        c = replace(c, difference=-c.difference, low=-c.high, high=-c.low, effect=-c.effect)
    where = f"{c.task}, {c.condition}" if c.condition != "default" else c.task
    return f"{c.better} > {other} in {where}: {numbers(c)}"


def numbers(c: Comparison) -> str:
    """Difference, corrected interval, effect, n."""
    scale, digits = {"success": (100.0, 1), "goals": (1.0, 2)}.get(c.metric, (1.0, 1))
    low, high = scale * c.low, scale * c.high
    name = "h" if c.metric == "success" else "d"
    unit = "points" if c.metric == "success" else c.metric
    return f"{scale * c.difference:+.{digits}f} {unit} ({low:+.{digits}f}, {high:+.{digits}f}), {name} = {c.effect:+.2f}, n = {c.n}"


def points(c: Comparison) -> str:
    """``+3.8 points (+1.8, +5.7)``: what `numbers` says first."""
    return numbers(c).split("),")[0] + ")"


def percent(rate: tuple[float, float, float]) -> str:
    """``84.2 (80.3 - 87.5)``."""
    return f"{100 * rate[0]:.1f} ({100 * rate[1]:.1f} - {100 * rate[2]:.1f})"


def listed(names: Sequence[str]) -> str:
    """``a, b and c``."""
    return ", ".join(names[:-1]) + f" and {names[-1]}" if len(names) > 1 else "".join(names)
