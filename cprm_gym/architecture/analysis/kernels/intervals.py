"""Interval chains: nature picks, in every state and cycle, a row between a lower and an upper one.

The chain is compressed as in `chains`, with `lower` and `upper` (m,) instead of one chance for each edge.
"""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

UNIT = 2.0**-53
SLACK = 1e-12
"""By how much upper chances may miss a sum of one and count as one."""


@kernel
def worst_row(offsets, targets, lower, upper, x, i, largest, order, chances):
    """The row of state i with the least expectation of x (or the `largest`) into ``chances[offsets[i]:offsets[i + 1]]``; returns it.

    Lower chances first; what is left goes to the best successors in turn.

    Parameters
    ----------
    order : (D,) int64, scratch for the successors of one state
    """
    first = offsets[i]
    degree = offsets[i + 1] - first
    left = 1.0
    for a in range(degree):
        left -= lower[first + a]
        chances[first + a] = lower[first + a]
        value = x[targets[first + a]]
        at = a
        while at > 0:
            other = x[targets[first + order[at - 1]]]
            if (other < value) if largest else (other > value):
                order[at] = order[at - 1]
                at -= 1
            else:
                break
        order[at] = a
    for a in range(degree):
        if left <= 0.0:
            break
        e = first + order[a]
        more = min(upper[e] - lower[e], left)
        chances[e] += more
        left -= more
    total = 0.0
    for e in range(first, first + degree):
        total += chances[e] * x[targets[e]]
    return total


@kernel
def worst_rows(offsets, targets, lower, upper, closed, x, largest, order, chances, margin):
    """`worst_row` of every state that is not `closed`; a row changes only where that brings more than `margin` of its size."""
    changed = 0
    kept = np.empty(order.shape[0])
    for i in range(offsets.shape[0] - 1):
        if closed[i]:
            continue
        first = offsets[i]
        old = 0.0
        for e in range(first, offsets[i + 1]):
            kept[e - first] = chances[e]
            old += chances[e] * x[targets[e]]
        new = worst_row(offsets, targets, lower, upper, x, i, largest, order, chances)
        gain = new - old if largest else old - new
        if gain > margin * abs(old):
            changed += 1
        else:
            for e in range(first, offsets[i + 1]):
                chances[e] = kept[e - first]
    return changed


@kernel
def back_up(offsets, targets, lower, upper, closed, x, reward, largest, order, chances, out):
    """One step of value iteration, all states at once, into `out` (n,)."""
    for i in range(offsets.shape[0] - 1):
        out[i] = x[i] if closed[i] else reward + worst_row(offsets, targets, lower, upper, x, i, largest, order, chances)


@kernel
def sweep_values(offsets, targets, lower, upper, closed, x, reward, largest, order, chances):
    """One step of value iteration in place, from the last state to the first; returns the largest change."""
    change = 0.0
    for i in range(offsets.shape[0] - 2, -1, -1):
        if not closed[i]:
            new = reward + worst_row(offsets, targets, lower, upper, x, i, largest, order, chances)
            change = max(change, abs(new - x[i]))
            x[i] = new
    return change


@kernel
def certify(offsets, targets, lower, upper, closed, x, reward, largest, time, order, chances):
    """By how many times of `time` x can miss the fixed point of value iteration, rounding allowed for."""
    ratio = 0.0
    for i in range(offsets.shape[0] - 1):
        if closed[i]:
            continue
        best = reward + worst_row(offsets, targets, lower, upper, x, i, largest, order, chances)
        most = worst_row(offsets, targets, lower, upper, time, i, True, order, chances)
        gamma = 2.0 * (offsets[i + 1] - offsets[i] + 4) * UNIT
        w = time[i] - most - gamma * (time[i] + most)
        if not w > 0.0:
            return np.inf
        ratio = max(ratio, (abs(best - x[i]) + gamma * (abs(best) + abs(x[i]) + reward)) / w)
    return ratio * (1.0 + 16.0 * UNIT)


@kernel
def stay_inside(offsets, targets, lower, upper, starts, edges, sources, label, inside, fixed, room, queue):
    """Shrink `inside` (n,) bool to the largest set in which nature can keep a run for ever, each state among those of its label.

    Parameters
    ----------
    starts : (n + 1,), edges, sources : (m,)
        The edges into each state, and where they come from.
    label : (n,) int32
    fixed : (n,) bool
        States that stay inside whatever their rows say.
    room : (n,) scratch; queue : (n,) int64 scratch
    """
    tail = 0
    for i in range(inside.shape[0]):
        room[i] = 0.0
        if inside[i] and not fixed[i]:
            out = False
            for e in range(offsets[i], offsets[i + 1]):
                j = targets[e]
                if inside[j] and label[j] == label[i]:
                    room[i] += upper[e]
                elif lower[e] > 0.0:
                    out = True
            if out or room[i] < 1.0 - SLACK:
                room[i] = -1.0
                queue[tail] = i
                tail += 1
    head = 0
    while head < tail:
        j = queue[head]
        head += 1
        inside[j] = False
        for a in range(starts[j], starts[j + 1]):
            i = sources[a]
            if inside[i] and not fixed[i] and room[i] >= 0.0 and label[j] == label[i]:
                e = edges[a]
                room[i] -= upper[e]
                if lower[e] > 0.0 or room[i] < 1.0 - SLACK:
                    room[i] = -1.0
                    queue[tail] = i
                    tail += 1
