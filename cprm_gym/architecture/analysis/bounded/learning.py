"""Intervals from counts: what was seen bounds what may be (Clopper-Pearson, Bonferroni over all that was learned)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ....errors import ModelError
from ..markov.chain import start_at
from ..sampling.intervals import clopper_pearson
from .interval_chain import IntervalChain

UNSEEN = "unseen"


def intervals_from_counts(
    counts: Sequence[Mapping[int, int]],
    outcomes: Mapping[str, Sequence[int]],
    initial: int | Mapping[int, float] = 0,
    *,
    confidence: float = 0.95,
    unseen: bool = False,
    names: Sequence[str] | Callable[[int], str] = (),
) -> IntervalChain:
    """The interval chain that holds the true one with the given confidence, all rows at once.

    Each learned entry gets a Clopper-Pearson interval of confidence 1 - (1 - confidence) / m, with m the number of them; so all hold at
    once, and with them whatever is derived from the chain.

    Parameters
    ----------
    counts : sequence of mappings
        For each state that is no outcome, target -> how often it was followed by it; a target with 0 says that it could be.
    outcomes, initial, names : as of `MarkovChain.from_rows`
    confidence : float
    unseen : bool
        Each row also leads, with what its count cannot exclude, to one more state, the outcome `UNSEEN`: successors that never came.

    Raises
    ------
    ModelError
        For a state that was never seen; the message names it.
    """
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")
    n = len(counts)
    final = {int(s) for states in outcomes.values() for s in states}
    entries = 0
    for i, row in enumerate(counts):
        if i in final:
            continue
        if not row or sum(row.values()) <= 0 or min(row.values()) < 0:
            raise ModelError(f"counts of state {i}: it was never seen to go on; give it counts, or make it an outcome")
        entries += len(row) + unseen if len(row) + unseen > 1 else 0
    level = 1.0 - (1.0 - confidence) / max(entries, 1)
    rows: list[dict[int, tuple[float, float]]] = []
    for i, row in enumerate(counts):
        if i in final:
            rows.append({})
            continue
        total = sum(row.values())
        if len(row) + unseen == 1:
            rows.append({next(iter(row)): (1.0, 1.0)})
            continue
        rows.append({int(j): tuple(clopper_pearson(c, total, level)) for j, c in row.items()})  # type: ignore[misc]
        if unseen:
            rows[-1][n] = tuple(clopper_pearson(0, total, level))  # type: ignore[assignment]
    given = {name: list(states) for name, states in outcomes.items()}
    if unseen:
        rows.append({})
        given[UNSEEN] = [n]
    start = np.append(start_at(n, initial), [0.0] * unseen)
    return IntervalChain.from_rows(rows, given, {int(i): float(start[i]) for i in np.flatnonzero(start)}, names)
