"""The ladder of solvers: each component by the first method that gets there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels import chains as kernels
from ..kernels import mixing
from .chain import MarkovChain
from .components import Components

SMALL = 24
"""Components of so few states are eliminated at once."""
MEDIUM = 1500
"""Components of so few states are eliminated where sweeps are slow."""
SWEEPS = 40
KRYLOV = 250
"""Iterations of bi-conjugate gradients, where factors could be had instead."""
LAST = 4000
"""Iterations where they cannot."""
GOAL = 1e-15
"""Residual at which gradients stop, relative to the largest value."""
REFINED, MIXED = 8, 60
"""Most refinements in double precision of a component that mixes, and sweeps in single precision for each."""
SINGLE = 3e-6
"""Change at which sweeps in single precision are through, relative to the largest value."""
LOOK, FALLS = 6, 0.3
"""After so many sweeps changes have to be less than this share of what they were, or gradients are the better way."""
FILL = 60.0
"""Factors are tried where a component's widest level, by the square root of its size, is less."""


def solve(chain: MarkovChain, parts: Components, closed: NDArray[np.bool_], values: NDArray[np.float64]) -> dict[str, int]:
    """Fill in `values` (K, n) for all states that are not `closed`; the last row is the expected time, the others sum to one.

    Parameters
    ----------
    chain : MarkovChain
    parts : Components
    closed : (n,) bool
        States whose values are given.
    values : (K, n) float64, changed

    Returns
    -------
    dict of str to int
        Method -> how many states it solved.
    """
    sizes = np.diff(parts.start)
    largest = int(sizes[sizes <= MEDIUM].max(initial=1))
    dense, known, leave = np.empty((largest, largest)), np.empty((largest, len(values))), np.empty(largest)
    place = np.full(chain.n, -1, np.int32)
    used = np.zeros(3, np.int64)
    methods: dict[str, int] = {}
    begin, end = 0, len(sizes)
    while begin < end:
        begin = int(kernels.solve_components(chain.offsets, chain.targets, chain.chances, closed, parts.start, parts.nodes, values, begin,
                                             SMALL, MEDIUM, SWEEPS, place, dense, known, leave, used))  # fmt: skip
        if begin < end:
            method = _solve_large(chain, parts, begin, values)
            methods[method] = methods.get(method, 0) + int(sizes[begin])
            begin += 1
    names = ("from successors", "elimination", "sweeps")
    return {**{name: int(count) for name, count in zip(names, used) if count}, **methods}


def _solve_large(chain: MarkovChain, parts: Components, c: int, values: NDArray[np.float64]) -> str:
    """One component of many states: gradients, sparse factors where these get stuck and are small, else gradients to the end."""
    first, last = int(parts.start[c]), int(parts.start[c + 1])
    leave = np.zeros(chain.n)
    kernels.leaving(chain.offsets, chain.targets, chain.chances, parts.nodes, first, last, leave)
    thin = _is_thin(chain, parts, c)
    states = parts.nodes[first:last]
    # the time first: where it gets stuck, all would; of the chances one follows from the others, unless it would be small
    time, *ends = (len(values) - 1, *range(len(values) - 1))
    missing = [k for k in ends if values[k].any()]
    if 1 <= len(missing) <= 2:
        mixes = not thin and _mixing_both(chain, parts, c, values, (time, missing[0]), leave)
        if mixes or _gradients_both(chain, parts, c, values, (time, missing[0]), leave, KRYLOV if thin else LAST):
            rest = 1.0 - values[missing[0], states]
            if len(missing) == 1 or rest.min() > 0.01:
                values[missing[1:], states] = rest
                return "mixing" if mixes else "gradients"
        elif thin:
            _factors(chain, parts, c, values, leave)
            return "factors"
    scratch = [np.zeros(chain.n) for _ in range(5)]
    done = True
    for k in [time, *missing]:
        if k == missing[-1]:
            rest = 1.0 - values[missing[:-1]][:, states].sum(axis=0)
            if rest.min() > 0.01:
                values[k, states] = rest
                continue
        if not _gradients(chain, parts, c, values[k], float(k == time), leave, KRYLOV if thin else LAST, scratch):
            if thin:
                del scratch
                _factors(chain, parts, c, values, leave)
                return "factors"
            done = False
    return "gradients" if done else "gradients, not to the end"


def _is_thin(chain: MarkovChain, parts: Components, c: int) -> bool:
    """Whether a component looks like a strip or a sheet, so that its factors stay sparse."""
    nodes = parts.nodes[parts.start[c] : parts.start[c + 1]]
    inside, seen = np.zeros(chain.n, bool), np.zeros(chain.n, bool)
    inside[nodes] = True
    widest = kernels.widest_level(chain.offsets, chain.targets, inside, int(nodes[0]), seen, np.empty(chain.n, np.int32))
    return bool(widest <= FILL * len(nodes) ** 0.5 / 10)


def _gradients(
    chain: MarkovChain, parts: Components, c: int, x: NDArray[np.float64], reward: float, leave: NDArray[np.float64], limit: int,
    scratch: list[NDArray[np.float64]],
) -> bool:  # fmt: skip
    """Bi-conjugate gradients on one component, begun anew from their own answer until its true residual is small."""
    first, last = int(parts.start[c]), int(parts.start[c + 1])
    states = parts.nodes[first:last]
    where = (chain.offsets, chain.targets, chain.chances, x, reward, parts.nodes, first, last, leave)
    for _ in range(4):
        for array in scratch:
            array[states] = 0.0
        used = int(kernels.bicgstab(*where, GOAL, limit, *scratch))
        kernels.residual(*where, scratch[0])
        if np.abs(scratch[0][states]).max() <= 20 * GOAL * np.abs(x[states]).max():
            return True
        if used < 0 and limit == KRYLOV:
            break
    return False


def _mixing_both(
    chain: MarkovChain, parts: Components, c: int, values: NDArray[np.float64], columns: tuple[int, int], leave: NDArray[np.float64]
) -> bool:  # fmt: skip
    """Sweeps in single precision, refined in double: of components that mix, given up soon where one does not."""
    first, last = int(parts.start[c]), int(parts.start[c + 1])
    states, pair, m = parts.nodes[first:last], list(columns), last - first
    place = np.full(chain.n, -1, np.int32)
    place[states] = np.arange(m, dtype=np.int32)
    start = np.empty(m + 1, np.int64)
    mixing.inner_edges(chain.offsets, chain.targets, parts.nodes, first, last, place, start)
    to, share, later = np.empty(start[-1], np.int32), np.empty(start[-1], np.float32), np.empty(m, np.float32)
    out = float(mixing.inner_rows(chain.offsets, chain.targets, chain.chances, parts.nodes, first, last, place, leave, to, share, later))
    del place
    if not out > 0.0:
        return False
    rewards = np.array([float(k == len(values) - 1) for k in pair])
    x, lack, size, largest = np.ascontiguousarray(values[pair].T), np.zeros((chain.n, 2)), np.empty(2), np.empty(2)
    right, step, own = np.empty((m, 2), np.float32), np.empty((m, 2), np.float32), (parts.nodes, first, last)
    for _ in range(REFINED):
        kernels.residual_both(chain.offsets, chain.targets, chain.chances, x, rewards, *own, leave, lack)
        mixing.largest_both(*own, lack, size)
        mixing.largest_both(*own, x, largest)
        if (size <= 20 * GOAL * largest).all():
            for at, k in enumerate(pair):
                values[k, states] = x[states, at]
            return True
        size[size == 0.0] = 1.0
        mixing.take_both(*own, lack, size, right)
        step[:] = 0.0
        if not _swept(start, to, share, step, right, later, out):
            return False
        mixing.give_both(*own, step, size, x)
    return False


def _swept(
    start: NDArray[np.int64], to: NDArray[np.int32], share: NDArray[np.float32], step: NDArray[np.float32], right: NDArray[np.float32],
    later: NDArray[np.float32], out: float,
) -> bool:  # fmt: skip
    """Sweeps until nothing changes by more than single precision tells; whether changes fell fast enough for that."""
    before, change, largest = np.full(2, np.inf), np.empty(2), np.empty(2)
    every = np.arange(len(step), dtype=np.int32)
    for count in range(1, MIXED + 1):
        mixing.sweep_both(start, to, share, step, right, later, out, change)
        if not np.isfinite(change).all():
            return False
        mixing.largest_both(every, 0, len(step), step, largest)
        if (change <= SINGLE * largest).all():
            return True
        if count % LOOK == 0:
            if (change > FALLS * before).any():
                return False
            before = change.copy()
    return False


def _gradients_both(
    chain: MarkovChain, parts: Components, c: int, values: NDArray[np.float64], columns: tuple[int, int], leave: NDArray[np.float64],
    limit: int,
) -> bool:  # fmt: skip
    """The same of two columns at once: rows of a large chain lie all over memory, and are fetched once for both."""
    first, last = int(parts.start[c]), int(parts.start[c + 1])
    states, pair = parts.nodes[first:last], list(columns)
    rewards = np.array([float(k == len(values) - 1) for k in pair])
    x = np.ascontiguousarray(values[pair].T)
    where = (chain.offsets, chain.targets, chain.chances, x, rewards, parts.nodes, first, last, leave)
    done = False
    for _ in range(4):
        scratch = [np.zeros((chain.n, 2)) for _ in range(5)]
        used = int(kernels.bicgstab_both(*where, GOAL, limit, *scratch))
        kernels.residual_both(*where, scratch[0])
        lack = np.abs(scratch[0][states]).max(axis=0)
        done = bool((lack <= 20 * GOAL * np.abs(x[states]).max(axis=0)).all())
        if done or (used < 0 and limit == KRYLOV):
            break
    for at, k in enumerate(pair):
        values[k, states] = x[states, at]
    return done


def _factors(chain: MarkovChain, parts: Components, c: int, values: NDArray[np.float64], leave: NDArray[np.float64]) -> None:
    """Sparse factors of one component, pivots on the diagonal, and one step of refinement."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    first, last = int(parts.start[c]), int(parts.start[c + 1])
    states = parts.nodes[first:last]
    m = len(states)
    place = np.full(chain.n, -1, np.int32)
    place[states] = np.arange(m, dtype=np.int32)
    lengths = np.diff(chain.offsets)[states]
    rows = np.repeat(np.arange(m, dtype=np.int32), lengths)
    at = np.repeat(chain.offsets[states], lengths) + np.arange(len(rows)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    columns = place[chain.targets[at]]
    keep = (columns >= 0) & (columns != rows)
    data = np.concatenate((-chain.chances[at[keep]], leave[states]))
    diagonal = np.arange(m, dtype=np.int32)
    system = csc_array((data, (np.concatenate((rows[keep], diagonal)), np.concatenate((columns[keep], diagonal)))), shape=(m, m))
    del rows, at, columns, keep, data
    factors = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    values[:, states] = 0.0
    lack = np.zeros(chain.n)
    for k, x in enumerate(values):
        for _ in range(2):
            reward = float(k == len(values) - 1)
            kernels.residual(chain.offsets, chain.targets, chain.chances, x, reward, parts.nodes, first, last, leave, lack)
            x[states] += factors.solve(lack[states] * leave[states])
