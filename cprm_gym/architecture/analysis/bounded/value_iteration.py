"""The optimal bounds: nature picks the worst row again and again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError
from ..bounds import Bounds
from ..kernels import intervals as kernels
from ..markov.absorption import absorption
from ..markov.chain import unknown_outcome
from .end_components import collapse, everlasting, kept_away
from .interval_chain import IntervalChain
from .unknown_state import unknown_state_bounds

ROUNDS = 100
"""Most times that nature changes her mind; each change improves, so that there are finitely many."""
SWEEPS = 20
"""Sweeps of value iteration from which nature's first rows are taken."""


class IntervalBounds(NamedTuple):
    """What nature can make of an interval chain; numbers are bounds of bounds, rounding and errors included."""

    probabilities: Mapping[str, Bounds]
    """Outcome -> least and most probability, over all natures."""
    time: Bounds
    """Least and most expected cycles until an outcome; infinite where nature can prevent it."""
    error: float
    """By how much the widest of them may be too wide: each end is attained by some nature up to this."""


def interval_bounds(chain: IntervalChain) -> IntervalBounds:
    """Least and most probability of each outcome, and of the expected time, over every nature.

    Nature's rows are improved until none can be (policy iteration; each nature is a chain, solved exactly), and what comes out is checked
    by one step of interval value iteration from both sides: with t the largest expected time and ``d = max |F(x) - x| / (t - max row t)``,
    the fixed point lies within x -+ d t. Where nature can avoid an outcome for ever, the least probability is 0 by the graph; where she
    can keep a run among some states for ever (an end component), these become one state that leads to any of their exits, or to nowhere,
    before the most is sought. Where some nature's runs are so long that rounding leaves nothing (about 1e12 cycles), the text's bounds are
    returned, with an infinite `error`.

    Parameters
    ----------
    chain : IntervalChain

    Examples
    --------
    >>> from .interval_chain import IntervalChain
    >>> chain = IntervalChain.from_rows([{0: (0.3, 0.6), 1: (0.2, 0.5), 2: (0.1, 0.3)}, {}, {}], {"goal": [1], "lost": [2]})
    >>> found = interval_bounds(chain)
    >>> print(found.probabilities["goal"], found.time)
    [0.4, 0.833333] [1.42857, 2.5]
    """
    endless = everlasting(chain)
    small, place = collapse(chain, endless) if endless.any() else (chain, None)
    try:
        time = _longest(small)
    except _TooLong:
        return _plain(chain)
    found: dict[str, Bounds] = {}
    error = 0.0
    for outcome in chain.outcomes:
        low = _optimum(chain if place is not None else small, outcome, False, None if place is not None else time)
        high = _optimum(small, outcome, True, time)
        found[outcome] = Bounds(max(0.0, low[0] - low[1]), min(1.0, high[0] + high[1]))
        error = max(
            error, float(np.nan_to_num(2 * low[1], nan=np.inf, posinf=np.inf)), float(np.nan_to_num(2 * high[1], nan=np.inf, posinf=np.inf))
        )
    if not np.isfinite(error):
        return _plain(chain)
    least = _shortest(chain, None if place is not None else time)
    reach = _may_reach(chain, endless)
    start = chain.initial
    most = float("inf") if reach else float(start @ time)
    return IntervalBounds(found, Bounds(least, most), error)


def bounds_over_time(chain: IntervalChain, outcome: str, cycles: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least and most probability that an outcome has come by each cycle, by plain interval value iteration.

    Nature may pick other rows in every cycle, so that for one fixed unknown chain these bounds are sound and may be too wide.

    Parameters
    ----------
    chain : IntervalChain
    outcome : str
    cycles : int

    Returns
    -------
    (cycles + 1,), (cycles + 1,) float64

    Raises
    ------
    UnknownName
    """
    if outcome not in chain.outcomes:
        raise unknown_outcome(outcome, chain.outcomes)
    closed, order, chances = chain.absorbing, _order(chain), np.empty(len(chain.targets))
    both = []
    for largest in (False, True):
        now, then = np.zeros(chain.n), np.empty(chain.n)
        now[chain.outcomes[outcome]] = 1.0
        curve = [float(chain.initial @ now)]
        for _ in range(cycles):
            kernels.back_up(*_arrays(chain), closed, now, 0.0, largest, order, chances, then)
            now, then = then, now
            curve.append(float(chain.initial @ now))
        both.append(np.array(curve))
    return both[0], both[1]


def _plain(chain: IntervalChain) -> IntervalBounds:
    """The text's bounds, which hold however long runs are."""
    cycles = Bounds(_shortest(chain, None, sweeps=2000), float("inf"))
    return IntervalBounds({o: unknown_state_bounds(chain, o) for o in chain.outcomes}, cycles, float("inf"))


class _TooLong(Exception):
    """Expected times cannot be bounded in double precision."""


def _arrays(chain: IntervalChain) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    return chain.offsets, chain.targets, chain.lower, chain.upper


def _order(chain: IntervalChain) -> NDArray[np.int64]:
    return np.empty(int(np.diff(chain.offsets).max(initial=1)), np.int64)


def _optimum(chain: IntervalChain, outcome: str, largest: bool, time: NDArray[np.float64] | None) -> tuple[float, float]:
    """Value and error of an outcome's optimal probability; without `time` the states in which nature stays are cut out first."""
    closed = chain.absorbing
    if not largest:
        away = kept_away(chain, outcome)
        closed = closed | away
    value = np.zeros(chain.n)
    value[chain.outcomes[outcome]] = 1.0
    if closed.all():
        return float(chain.initial @ value), 0.0
    if time is None:
        time = _longest(chain, closed)
    x = _improved(chain, closed, value, 0.0, largest, {outcome: chain.outcomes[outcome]})
    ratio = kernels.certify(*_arrays(chain), closed, x, 0.0, largest, time, _order(chain), np.empty(len(chain.targets)))
    return float(chain.initial @ x), float(ratio * (chain.initial @ time))


def _improved(
    chain: IntervalChain, closed: NDArray[np.bool_], value: NDArray[np.float64], reward: float, largest: bool,
    ends: Mapping[str, NDArray[np.int64]],
) -> NDArray[np.float64]:  # fmt: skip
    """Policy iteration: nature's rows are improved until none gets better; values of the last chain.

    Raises
    ------
    ModelError
        When nature goes on changing her mind, which rounding alone can bring about.
    """
    order, x = _order(chain), value.copy()
    chances = chain.middle().chances.copy()
    for _ in range(SWEEPS):
        kernels.sweep_values(*_arrays(chain), closed, x, reward, largest, order, chances)
    inner = np.flatnonzero(closed & ~np.isin(np.arange(chain.n), np.concatenate([np.zeros(0, np.int64), *ends.values()])))
    outcomes = {**ends, "closed": inner}
    for _ in range(ROUNDS):
        found = absorption(chain.chain(_whole(chain, chances, closed), outcomes), lump=False)
        x = found.time if reward else found.probabilities[0]
        if not kernels.worst_rows(*_arrays(chain), closed, x, largest, order, chances, 1e-13):
            return x
    raise ModelError(f"interval chain of {chain.n} states: nature's rows did not settle within {ROUNDS} rounds")


def _whole(chain: IntervalChain, chances: NDArray[np.float64], closed: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Chances with rows of closed states as they may be: what is not looked at must still be a chain."""
    keep = np.repeat(closed, np.diff(chain.offsets))
    return np.where(keep, chain.middle().chances, chances)


def _longest(chain: IntervalChain, closed: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
    """(n,) An upper bound of every nature's expected time, tight to rounding; nature can keep no run for ever."""
    closed = chain.absorbing if closed is None else closed
    if closed.all():
        return np.zeros(chain.n)
    time = _improved(chain, closed, np.zeros(chain.n), 1.0, True, {})
    # a bound is what no step of value iteration exceeds: a little more than the values found
    time = time * (1.0 + 1e-12)
    order, out = _order(chain), np.empty(chain.n)
    for _ in range(60):
        kernels.back_up(*_arrays(chain), closed, time, 1.0, True, order, np.empty(len(chain.targets)), out)
        over = float(((out - time) / np.maximum(time, 1.0))[~closed].max())
        if over <= 0.0:
            return time
        time = np.where(closed, 0.0, time * (1.0 + 4.0 * over + 1e-13))
    raise _TooLong


def _shortest(chain: IntervalChain, time: NDArray[np.float64] | None, sweeps: int = 100_000) -> float:
    """A lower bound of every nature's expected time: value iteration from below, helped by policy iteration where no run lasts for ever."""
    closed = chain.absorbing
    if closed.all():
        return 0.0
    if time is not None:
        x = _improved(chain, closed, np.zeros(chain.n), 1.0, False, {})
        ratio = kernels.certify(*_arrays(chain), closed, x, 1.0, False, time, _order(chain), np.empty(len(chain.targets)))
        return max(0.0, float(chain.initial @ x - ratio * (chain.initial @ time)))
    x, order, chances = np.zeros(chain.n), _order(chain), np.empty(len(chain.targets))
    for _ in range(sweeps):
        if kernels.sweep_values(*_arrays(chain), closed, x, 1.0, False, order, chances) <= 1e-13 * max(1.0, float(x.max())):
            break
    return float(chain.initial @ x) * (1.0 - 1e-12)


def _may_reach(chain: IntervalChain, endless: NDArray[np.bool_]) -> bool:
    """Whether some nature leads a run from the start to where she can keep it for ever."""
    from ..kernels.chains import mark_reachable

    if not endless.any():
        return False
    reached = chain.initial > 0
    cut = np.repeat(chain.absorbing, np.diff(chain.offsets)) | (chain.upper <= 0.0)
    sources = np.repeat(np.arange(chain.n, dtype=np.int32), np.diff(chain.offsets))
    mark_reachable(chain.offsets, np.where(cut, sources, chain.targets), reached, np.empty(chain.n, np.int32))
    return bool((reached & endless).any())
