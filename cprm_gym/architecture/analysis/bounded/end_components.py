"""Where nature can keep a run for ever."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels import intervals as kernels
from .interval_chain import IntervalChain


def kept_away(chain: IntervalChain, outcome: str) -> NDArray[np.bool_]:
    """(n,) From which states nature can avoid an outcome for sure; all other outcomes avoid it."""
    inside = np.ones(chain.n, bool)
    inside[chain.outcomes[outcome]] = False
    fixed = chain.absorbing & inside
    _shrink(chain, np.zeros(chain.n, np.int32), inside, fixed)
    return inside


def everlasting(chain: IntervalChain) -> NDArray[np.bool_]:
    """(n,) In which states nature can keep a run for ever outside of all outcomes."""
    inside = ~chain.absorbing
    _shrink(chain, np.zeros(chain.n, np.int32), inside, np.zeros(chain.n, bool))
    return inside


def end_components(chain: IntervalChain, endless: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(n,) Number of the largest end component of each state, -1 where it is in none.

    An end component is a set of states in which nature can keep a run, and come from each to each.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    inside, label = endless.copy(), np.zeros(chain.n, np.int32)
    sources = np.repeat(np.arange(chain.n), np.diff(chain.offsets))
    while True:
        edges = inside[sources] & inside[chain.targets] & (label[sources] == label[chain.targets]) & (chain.upper > 0.0)
        graph = csr_array((np.ones(int(edges.sum())), (sources[edges], chain.targets[edges])), shape=(chain.n, chain.n))
        _, fresh = connected_components(graph, connection="strong")
        before = inside.copy()
        _shrink(chain, fresh.astype(np.int32), inside, np.zeros(chain.n, bool))
        if (before == inside).all():
            return np.where(inside, np.unique(fresh, return_inverse=True)[1], -1).astype(np.int32)
        label = fresh.astype(np.int32)


def collapse(chain: IntervalChain, endless: NDArray[np.bool_]) -> tuple[IntervalChain, NDArray[np.int64]]:
    """The chain with each end component as one state, and where each state went.

    Nature may leave a component over any exit for which there is room, for sure if she likes; one without exits is closed.
    """
    part = end_components(chain, endless)
    used = np.unique(part[part >= 0])
    single = np.flatnonzero(part < 0)
    place = np.empty(chain.n, np.int64)
    place[single] = np.arange(len(single))
    place[part >= 0] = len(single) + np.searchsorted(used, part[part >= 0])
    n = len(single) + len(used)
    rows: list[dict[int, tuple[float, float]]] = [{} for _ in range(n)]
    absorbing = chain.absorbing
    for i in range(chain.n):
        if absorbing[i]:
            continue
        lo, hi = int(chain.offsets[i]), int(chain.offsets[i + 1])
        own = int(place[i])
        row = rows[own]
        if part[i] < 0:
            for e in range(lo, hi):
                to = int(place[chain.targets[e]])
                low, high = row.get(to, (0.0, 0.0))
                row[to] = (low + float(chain.lower[e]), min(1.0, high + float(chain.upper[e])))
        else:
            stays = sum(float(chain.lower[e]) for e in range(lo, hi) if place[chain.targets[e]] == own)
            for e in range(lo, hi):
                to = int(place[chain.targets[e]])
                if to != own and chain.upper[e] > 0.0 and stays < 1.0 - kernels.SLACK:
                    row[to] = (0.0, 1.0)
    outcomes = {name: place[states] for name, states in chain.outcomes.items()}
    stuck = [k for k in range(len(single), n) if not rows[k]]
    if stuck:
        outcomes["kept for ever"] = np.array(stuck)
    initial = np.asarray(np.bincount(place, weights=chain.initial, minlength=n), np.float64)
    offsets = np.cumsum([0, *(len(row) for row in rows)])
    targets = np.array([j for row in rows for j in row], np.int32)
    bounds = np.array([pair for row in rows for pair in row.values()], np.float64).reshape(-1, 2)
    return IntervalChain(offsets, targets, bounds[:, 0].copy(), bounds[:, 1].copy(), outcomes, initial), place


def _shrink(chain: IntervalChain, label: NDArray[np.int32], inside: NDArray[np.bool_], fixed: NDArray[np.bool_]) -> None:
    order = np.argsort(chain.targets, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(chain.targets, minlength=chain.n))))
    sources = np.repeat(np.arange(chain.n, dtype=np.int32), np.diff(chain.offsets))[order]
    kernels.stay_inside(chain.offsets, chain.targets, chain.lower, chain.upper, starts, order, sources, label, inside, fixed,
                        np.empty(chain.n), np.empty(chain.n, np.int64))  # fmt: skip
