"""Runs of a Markov chain: plainly, weighted, and split (chains compressed as in `chains`)."""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group
from .draws import stream, uniform

kernel = kernel_group()


@kernel
def successor(offsets, targets, chances, i, u):
    """The edge that a draw u in [0, 1) takes from state i."""
    last = offsets[i + 1] - 1
    for e in range(offsets[i], last):
        u -= chances[e]
        if u < 0.0:
            return e
    while chances[last] <= 0.0 and last > offsets[i]:
        last -= 1
    return last


@kernel
def run_many(offsets, targets, chances, final, starts, cumulative, key, numbers, limit, end, length):
    """Runs until a final state or `limit` steps.

    Parameters
    ----------
    final : (n,) bool
    starts : (s,) states, cumulative : (s,) their distribution, summed up
    key : uint64, numbers : (W,) int64
        Which random numbers each run gets.
    end, length : (W,) int64, results
        Last state, steps made.
    """
    state = np.zeros(1, np.uint64)
    for w in range(numbers.shape[0]):
        state[0] = stream(key, numbers[w])
        i = starts[min(np.searchsorted(cumulative, uniform(state, 0), side="right"), starts.shape[0] - 1)]
        t = 0
        while t < limit and not final[i]:
            i = targets[successor(offsets, targets, chances, i, uniform(state, 0))]
            t += 1
        end[w] = i
        length[w] = t


@kernel
def run_one(offsets, targets, chances, final, starts, cumulative, key, number, path):
    """The states of one run into `path`; returns their number."""
    state = np.zeros(1, np.uint64)
    state[0] = stream(key, number)
    i = starts[min(np.searchsorted(cumulative, uniform(state, 0), side="right"), starts.shape[0] - 1)]
    path[0] = i
    t = 0
    while t + 1 < path.shape[0] and not final[i]:
        i = targets[successor(offsets, targets, chances, i, uniform(state, 0))]
        t += 1
        path[t] = i
    return t + 1


@kernel
def weighted_runs(offsets, targets, chances, bias, final, rare, start, share, key, first, limit, weight, steps):
    """Importance sampling: runs under a mixture of biased and plain chances, with the likelihood ratio of each.

    From state i edge e is taken with ``(1 - share) bias[e] + share chances[e]``.

    Parameters
    ----------
    bias : (m,) chances that sum to one in each row
    final, rare : (n,) bool
    weight : (W,) results
        Likelihood ratio of the whole run, negative where it did not end in a rare state.
    steps : (1,) int64, updated
        Steps made by all.
    """
    state = np.zeros(1, np.uint64)
    for w in range(weight.shape[0]):
        state[0] = stream(key, first + w)
        i = start
        ratio = 1.0
        t = 0
        while t < limit and not final[i]:
            u = uniform(state, 0)
            last = offsets[i + 1] - 1
            taken = last
            for e in range(offsets[i], last + 1):
                q = (1.0 - share) * bias[e] + share * chances[e]
                u -= q
                if u < 0.0 or (e == last):
                    taken = e
                    break
            q = (1.0 - share) * bias[taken] + share * chances[taken]
            while q <= 0.0:
                taken -= 1
                q = (1.0 - share) * bias[taken] + share * chances[taken]
            ratio *= chances[taken] / q
            i = targets[taken]
            t += 1
        steps[0] += t
        weight[w] = ratio if rare[i] else -ratio


@kernel
def climb(offsets, targets, chances, final, level, i, state, path, at):
    """Go on from state i until a final state, writing states into `path` from `at` on; returns (length or -1 if full, highest level)."""
    high = level[i]
    while not final[i]:
        if at >= path.shape[0]:
            return -1, high
        i = targets[successor(offsets, targets, chances, i, uniform(state, 0))]
        path[at] = i
        at += 1
        high = max(high, level[i])
    return at, high


@kernel
def split_runs(offsets, targets, chances, final, rare, level, start, killed, key, paths, lengths, highs, steps):
    """One repetition of adaptive multilevel splitting; returns the estimate, or -1 where a path does not fit.

    Parameters
    ----------
    level : (n,) float64
        How far on the way each state is; the rare states have the highest.
    killed : int
        How many runs a round takes back at least.
    paths : (N, L) int32, lengths : (N,), highs : (N,) scratch
    steps : (1,) int64, updated

    References
    ----------
    F. Cerou, A. Guyader (2007), Stoch. Anal. Appl. 25:417-443; C.-E. Brehier et al. (2016), Ann. Appl. Probab. 26:3559-3601.
    """
    n = paths.shape[0]
    state = np.zeros(1, np.uint64)
    state[0] = stream(key, 0)
    for w in range(n):
        paths[w, 0] = start
        at, high = climb(offsets, targets, chances, final, level, start, state, paths[w], 1)
        if at < 0:
            return -1.0
        steps[0] += at - 1
        lengths[w] = at
        highs[w] = np.inf if rare[paths[w, at - 1]] else high
    factor = 1.0
    alive = np.empty(n, np.int64)
    while True:
        z = np.sort(highs)[killed - 1]
        if z == np.inf:
            break
        survivors = 0
        for w in range(n):
            if highs[w] > z:
                alive[survivors] = w
                survivors += 1
        if survivors == 0:
            return 0.0
        factor *= survivors / n
        for w in range(n):
            if highs[w] <= z:
                donor = alive[min(int(uniform(state, 0) * survivors), survivors - 1)]
                at = 0
                while True:
                    paths[w, at] = paths[donor, at]
                    at += 1
                    if level[paths[w, at - 1]] > z:
                        break
                before = at
                at, high = climb(offsets, targets, chances, final, level, paths[w, at - 1], state, paths[w], at)
                if at < 0:
                    return -1.0
                steps[0] += at - before
                lengths[w] = at
                highs[w] = np.inf if rare[paths[w, at - 1]] else high
    reached = 0
    for w in range(n):
        reached += rare[paths[w, lengths[w] - 1]]
    return factor * reached / n
