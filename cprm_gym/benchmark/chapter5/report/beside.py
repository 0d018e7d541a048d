"""A run of another seed beside the first."""

from __future__ import annotations

from ....errors import CprmError
from ..claims import CLAIMS
from ..comparisons import Comparison
from ..pieces import UNKNOWN, sentence
from .again import Again
from .whole import Chapter5Report

Key = tuple[str, str, str, str, str]


def beside(first: Chapter5Report, second: Chapter5Report) -> Again:
    """The second beside the first.

    Raises
    ------
    CprmError
        For two runs of one seed, or a quick one and a full one.
    """
    one, other = first.plan, second.plan
    if one.seed == other.seed:
        raise CprmError(f"both runs are of seed {one.seed}; another seed is needed to see what hangs on it")
    if one.size.full != other.size.full:
        raise CprmError("a quick run and a full one are not put beside each other")
    mine, its = first.verdicts(), second.verdicts()
    verdicts = {key: its[key][0] for key in CLAIMS if UNKNOWN not in (mine[key][0], its[key][0])}
    hangs = tuple(key for key, verdict in verdicts.items() if verdict != mine[key][0])
    ours, theirs = _comparisons(first), _comparisons(second)
    shared = [key for key in ours if key in theirs]
    pairs = [(ours[key], theirs[key]) for key in shared]
    once = [(sentence(a), f"seed {one.seed}") for a, b in pairs if a.better and not b.better]
    once += [(sentence(b), f"seed {other.seed}") for a, b in pairs if b.better and not a.better]
    return Again(
        other.seed, second.episodes(), verdicts, hangs, {key: its[key][1] for key in hangs}, len(shared),
        sum(bool(a.better) and a.better == b.better for a, b in pairs), sum(not a.better and not b.better for a, b in pairs), tuple(once),
        tuple(sentence(a) for a, b in pairs if a.better and b.better and a.better != b.better),
    )  # fmt: skip


def _comparisons(report: Chapter5Report) -> dict[Key, Comparison]:
    return {(one.name, c.task, c.condition, c.first, c.second): c for one in report.told for c in one.comparisons}
