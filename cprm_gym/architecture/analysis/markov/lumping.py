"""States that no outcome tells apart, put together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels import partition
from .chain import MarkovChain

WORTH = 4
"""Lumping is worth while where it leaves at most one in so many states."""
FEW = 200
"""Chains of so few states are solved as they are."""


class Lumping(NamedTuple):
    """A chain of blocks of states."""

    chain: MarkovChain
    """One state for each block; outcomes and times are those of the states in it."""
    block: NDArray[np.int32]
    """(n,) The block of each state."""


def lump(chain: MarkovChain) -> Lumping:
    """The coarsest lumping that keeps every outcome's probability in every cycle (strong bisimulation).

    Chances are compared to about 1e-12.

    Parameters
    ----------
    chain : MarkovChain

    Examples
    --------
    >>> from .chain import MarkovChain
    >>> chain = MarkovChain.from_rows([{1: 0.5, 2: 0.5}, {3: 0.9, 4: 0.1}, {3: 0.9, 4: 0.1}, {}, {}], {"goal": [3], "lost": [4]})
    >>> lump(chain).chain.n
    4
    """
    found = _refined(chain, chain.n)
    assert found is not None
    return found


def worthwhile_lumping(chain: MarkovChain) -> Lumping | None:
    """The lumping if it leaves at most one state in `WORTH`; given up as soon as it does not."""
    if chain.n < FEW:
        return None
    ends = chain.matrix @ chain.absorbing.astype(float)  # states that end with different chances are never put together
    if len(np.unique(np.rint(ends * partition.GRAIN))) > chain.n // WORTH:
        return None
    return _refined(chain, chain.n // WORTH)


def _refined(chain: MarkovChain, most: int) -> Lumping | None:
    n = chain.n
    block = np.zeros(n, np.int32)
    for k, states in enumerate(chain.outcomes.values()):
        block[states] = k + 1
    block = np.unique(block, return_inverse=True)[1].astype(np.int32)
    count = int(block.max()) + 1
    if count > most:
        return None
    absorbing = chain.absorbing
    matrix = chain.matrix
    if (np.repeat(absorbing, np.diff(chain.offsets))).any():
        data = np.where(np.repeat(absorbing, np.diff(chain.offsets)), 0.0, chain.chances)
        from scipy.sparse import csr_array

        matrix = csr_array((data, chain.targets, chain.offsets), shape=(n, n))
    into = matrix.tocsc()
    elements = np.argsort(block, kind="stable").astype(np.int32)
    place = np.empty(n, np.int32)
    place[elements] = np.arange(n, dtype=np.int32)
    sizes = np.bincount(block, minlength=count)
    begin, end = np.zeros(most + 1, np.int32), np.zeros(most + 1, np.int32)
    end[:count] = np.cumsum(sizes)
    begin[:count] = end[:count] - sizes
    count = int(
        partition.refine(
            into.indptr, into.indices, into.data, block, begin, end, elements, place, count, most,
            np.empty(most + 1, np.int32), np.zeros(most + 1, bool), np.zeros(n), np.empty(n, np.int32),
            np.zeros(most + 1, np.int32), np.empty(most + 1, np.int32),
        )
    )  # fmt: skip
    return None if count < 0 else _quotient(chain, block, elements[begin[:count]])


def _quotient(chain: MarkovChain, block: NDArray[np.int32], chosen: NDArray[np.int32]) -> Lumping:
    """The chain of blocks, each with the row of one of its states."""
    from scipy.sparse import coo_array

    n = len(chosen)
    lengths = np.diff(chain.offsets)[chosen]
    rows = np.repeat(np.arange(n), lengths)
    at = np.repeat(chain.offsets[chosen], lengths) + np.arange(len(rows)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    matrix = coo_array((chain.chances[at], (rows, block[chain.targets[at]])), shape=(n, n)).tocsr()
    outcomes = {name: np.unique(block[states]).astype(np.int64) for name, states in chain.outcomes.items()}
    initial = np.asarray(np.bincount(block, weights=chain.initial, minlength=n), np.float64)
    small = MarkovChain(matrix.indptr, matrix.indices, matrix.data, outcomes, initial, lambda b: chain.name(int(chosen[b])))
    return Lumping(small, block)
