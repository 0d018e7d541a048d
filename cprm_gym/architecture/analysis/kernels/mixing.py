"""Sweeps over a component that mixes, in single precision, of two columns at once.

Rows are those of I - D^-1 Q without the diagonal, numbered within the component, eight bytes an edge. States that mix forget where they are
but for how much is left: what a sweep leaves of that one slow mode is taken out by adding a constant, which follows from the changes of the
sweep itself, since after it row i lacks ``sum over later j of p_ij change_j``.
"""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()


@kernel
def inner_edges(offsets, targets, nodes, first, last, place, start):
    """How many edges within the component lie before each of its rows, into `start` (m + 1,); `place` is -1 outside of it."""
    count = 0
    start[0] = 0
    for a in range(first, last):
        i = nodes[a]
        for e in range(offsets[i], offsets[i + 1]):
            if targets[e] != i and place[targets[e]] >= 0:
                count += 1
        start[a - first + 1] = count


@kernel
def inner_rows(offsets, targets, chances, nodes, first, last, place, leave, to, share, later):
    """The component's own rows: targets `to`, chances over what leaves `share`; into `later` (m,) what earlier rows have of each column.

    Returns
    -------
    float
        What leaves the component, over all rows.
    """
    k = 0
    later[:] = 0.0
    out = 0.0
    for a in range(first, last):
        i = nodes[a]
        stays = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            j = place[targets[e]]
            if targets[e] == i or j < 0:
                continue
            p = chances[e] / leave[i]
            to[k] = j
            share[k] = p
            stays += p
            if j > a - first:
                later[j] += p
            k += 1
        out += 1.0 - stays
    return out


@kernel
def sweep_both(start, to, share, x, right, later, out, change):
    """One sweep of x (m, 2) in place, then a constant; the largest change of each column into `change` (2,)."""
    left = np.zeros(2)
    most0, most1 = np.float32(0.0), np.float32(0.0)
    for i in range(len(start) - 1):
        s, t = right[i, 0], right[i, 1]
        for e in range(start[i], start[i + 1]):
            j, p = to[e], share[e]
            s += p * x[j, 0]
            t += p * x[j, 1]
        d, f = s - x[i, 0], t - x[i, 1]
        left[0] += later[i] * d
        left[1] += later[i] * f
        most0, most1 = max(most0, abs(d)), max(most1, abs(f))
        x[i, 0], x[i, 1] = s, t
    more0, more1 = np.float32(left[0] / out), np.float32(left[1] / out)
    for i in range(len(start) - 1):
        x[i, 0] += more0
        x[i, 1] += more1
    change[0], change[1] = most0, most1


@kernel
def largest_both(nodes, first, last, x, out):
    """The largest size of each column of x (n, 2) over the component, into `out` (2,)."""
    out[:] = 0.0
    for a in range(first, last):
        i = nodes[a]
        out[0], out[1] = max(out[0], abs(x[i, 0])), max(out[1], abs(x[i, 1]))


@kernel
def take_both(nodes, first, last, x, scale, own):
    """The component's rows of x (n, 2), divided by `scale` (2,), into `own` (m, 2) of single precision."""
    for a in range(first, last):
        i = nodes[a]
        own[a - first, 0], own[a - first, 1] = x[i, 0] / scale[0], x[i, 1] / scale[1]


@kernel
def give_both(nodes, first, last, own, scale, x):
    """The same back, added to x."""
    for a in range(first, last):
        i = nodes[a]
        x[i, 0] += own[a - first, 0] * scale[0]
        x[i, 1] += own[a - first, 1] * scale[1]
