"""How the outcomes come about cycle by cycle."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import CostError, ModelError
from ..kernels import chains as kernels
from .chain import MarkovChain, unknown_outcome
from .lumping import worthwhile_lumping

DENSE = 3000
"""Chains of at most so many states are squared as full matrices."""


class OverTime(NamedTuple):
    """Probability of having ended in each outcome by each cycle."""

    outcomes: tuple[str, ...]
    ended: NDArray[np.float64]
    """(T + 1, outcomes) By cycle 0, 1, ... T."""
    remaining: NDArray[np.float64]
    """(T + 1,) Of not having ended yet; an outcome's final probability lies between ``ended`` and ``ended + remaining``."""
    error: float
    """Largest error of an entry, from rounding."""

    def by(self, outcome: str) -> NDArray[np.float64]:
        """(T + 1,) One outcome.

        Raises
        ------
        UnknownName
        """
        if outcome not in self.outcomes:
            raise unknown_outcome(outcome, self.outcomes)
        return self.ended[:, self.outcomes.index(outcome)]

    def quantile(self, share: float) -> int | None:
        """The first cycle by which a share of the runs has ended, None if that is later than was looked."""
        found = np.flatnonzero(self.ended.sum(axis=1) >= share)
        return int(found[0]) if found.size else None


def outcomes_over_time(chain: MarkovChain, cycles: int) -> OverTime:
    """Step by step from the start: O(cycles x edges).

    Parameters
    ----------
    chain : MarkovChain
    cycles : int
        T, from 0.

    Examples
    --------
    >>> from .chain import MarkovChain
    >>> chain = MarkovChain.from_rows([{0: 0.5, 1: 0.3, 2: 0.2}, {}, {}], {"goal": [1], "lost": [2]})
    >>> outcomes_over_time(chain, 2).by("goal").round(3).tolist()
    [0.0, 0.3, 0.45]
    """
    _check_cycles(cycles)
    blocks = worthwhile_lumping(chain)
    small = blocks.chain if blocks is not None else chain
    now, then = small.initial.copy(), np.empty(small.n)
    absorbing = small.absorbing
    offsets, targets, chances = _held(small, absorbing)
    ended = np.empty((cycles + 1, len(small.outcomes)))
    remaining = np.empty(cycles + 1)
    for t in range(cycles + 1):
        for k, states in enumerate(small.outcomes.values()):
            ended[t, k] = now[states].sum()
        remaining[t] = now[~absorbing].sum()
        if t < cycles:
            kernels.advance(offsets, targets, chances, now, then)
            now, then = then, now
    return OverTime(tuple(small.outcomes), ended, remaining, _rounding(small, cycles) + (cycles * 1e-12 if blocks is not None else 0.0))


def distribution_at(chain: MarkovChain, cycle: int, method: Literal["auto", "steps", "squaring"] = "auto") -> NDArray[np.float64]:
    """Distribution over states in one cycle.

    Parameters
    ----------
    chain : MarkovChain
    cycle : int
        From 0.
    method : {"auto", "steps", "squaring"}
        "squaring" multiplies full matrices, O(n^3 log cycle): for small chains and far cycles. (The text's O(log T) counts
        multiplications; they destroy sparsity.)

    Returns
    -------
    (n,) float64

    Raises
    ------
    CostError
        When a chain of more than `DENSE` states is to be squared.
    """
    _check_cycles(cycle)
    if method not in ("auto", "steps", "squaring"):
        raise ModelError(f"method={method!r}: allowed are 'auto', 'steps' and 'squaring'")
    n, edges = chain.n, len(chain.targets)
    if method == "squaring" and n > DENSE:
        raise CostError(f"{n} states: matrices are squared up to {DENSE}; go by steps")
    absorbing = chain.absorbing
    offsets, targets, chances = _held(chain, absorbing)
    if method == "steps" or n > DENSE or (method == "auto" and cycle * edges < 2 * n**3 * max(cycle, 2).bit_length()):
        now, then = chain.initial.copy(), np.empty(n)
        for _ in range(cycle):
            kernels.advance(offsets, targets, chances, now, then)
            now, then = then, now
        return now
    from scipy.sparse import csr_array

    power = csr_array((chances, targets, offsets), shape=(n, n)).toarray()
    now = chain.initial.copy()
    left = cycle
    while left:
        if left & 1:
            now = now @ power
        left >>= 1
        if left:
            power = power @ power
    return now


def _check_cycles(cycles: int) -> None:
    if isinstance(cycles, bool) or not isinstance(cycles, (int, np.integer)) or cycles < 0:
        raise ModelError(f"cycles: a whole number from 0, got {cycles!r}")


def _held(chain: MarkovChain, absorbing: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
    """The chain's rows with absorbing states leading to themselves alone."""
    lengths = np.diff(chain.offsets)
    held = np.flatnonzero(absorbing)
    keep = ~np.repeat(absorbing, lengths)
    new = np.where(absorbing, 1, lengths)
    offsets = np.concatenate(([0], np.cumsum(new))).astype(np.int64)
    targets, chances = np.empty(offsets[-1], np.int32), np.empty(offsets[-1])
    own = offsets[held]
    moving = np.ones(len(targets), bool)
    moving[own] = False
    targets[moving], chances[moving] = chain.targets[keep], chain.chances[keep]
    targets[own], chances[own] = held, 1.0
    return offsets, targets, chances


def _rounding(chain: MarkovChain, cycles: int) -> float:
    degree = int(np.bincount(chain.targets, minlength=1).max()) if len(chain.targets) else 1
    return float(cycles * (degree + 2) * kernels.UNIT * 1.01 + chain.n * kernels.UNIT)
