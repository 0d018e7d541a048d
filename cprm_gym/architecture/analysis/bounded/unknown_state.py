"""The text's bounds (§3.2.2): what the lower chances leave goes to an unknown state."""

from __future__ import annotations

import numpy as np

from ..bounds import Bounds
from ..markov.absorption import absorption
from ..markov.chain import MarkovChain, unknown_outcome
from ..markov.over_time import outcomes_over_time
from .interval_chain import IntervalChain

UNKNOWN = "unknown"


def unknown_state_chain(chain: IntervalChain) -> MarkovChain:
    """The chain of lower chances, with one more state, an outcome `UNKNOWN`, that takes what they leave of each row."""
    lengths = np.diff(chain.offsets)
    rows = np.repeat(np.arange(chain.n), lengths)
    left = np.clip(1.0 - np.bincount(rows, weights=chain.lower, minlength=chain.n), 0.0, 1.0)
    left[chain.absorbing] = 0.0
    keep = ~np.repeat(chain.absorbing, lengths)
    extra = left > 0.0
    new = np.where(chain.absorbing, 0, lengths) + extra
    offsets = np.concatenate(([0], np.cumsum(new), [new.sum()])).astype(np.int64)
    targets, chances = np.empty(offsets[-1], np.int32), np.empty(offsets[-1])
    last = offsets[1:-1][extra] - 1
    given = np.ones(len(targets), bool)
    given[last] = False
    targets[last], chances[last] = chain.n, left[extra]
    targets[given], chances[given] = chain.targets[keep], chain.lower[keep]
    outcomes = {**chain.outcomes, UNKNOWN: np.array([chain.n])}
    return MarkovChain(offsets, targets, chances, outcomes, np.append(chain.initial, 0.0))


def unknown_state_bounds(chain: IntervalChain, outcome: str, cycles: int | None = None) -> Bounds:
    """Bounds of an outcome's probability by the unknown state.

    The least is what ends in the outcome by lower chances alone. The text adds what ended in the unknown state for the most, which holds
    only in the limit; after finitely many cycles what is still under way may end there too, so the most is one less what ended in the
    *other* outcomes, which is the same in the limit.

    Parameters
    ----------
    chain : IntervalChain
    outcome : str
    cycles : int, optional
        The chance that the outcome has come by then; default: ever. The most is then that it ever comes.

    Raises
    ------
    UnknownName
    """
    if outcome not in chain.outcomes:
        raise unknown_outcome(outcome, chain.outcomes)
    whole = unknown_state_chain(chain)
    if cycles is None:
        found = absorption(whole)
        ended = {name: found.probability(name) for name in chain.outcomes}
        low = ended[outcome].low
        high = 1.0 - sum(p.low for name, p in ended.items() if name != outcome)
    else:
        over = outcomes_over_time(whole, cycles)
        at = {name: float(over.by(name)[-1]) for name in chain.outcomes}
        low = at[outcome] - over.error
        high = 1.0 - sum(p - over.error for name, p in at.items() if name != outcome)
    return Bounds(max(low, 0.0), min(high, 1.0))
