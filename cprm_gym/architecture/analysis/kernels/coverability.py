"""The coverability graph of Karp and Miller (1969)."""

from __future__ import annotations

from ....compilation import kernel_group
from .table import enter, find, hash_row

kernel = kernel_group()

OMEGA = 1 << 40
"""As many tokens as you like."""


@kernel
def accelerate(nodes, parents, i, row, pumpable):
    """Put OMEGA where the way from a covered predecessor to `row` can be repeated; walks up from node `i`."""
    a = i
    while a >= 0:
        covered = True
        grows = False
        for p in range(row.shape[0]):
            if nodes[a, p] > row[p]:
                covered = False
                break
            if nodes[a, p] < row[p]:
                if not pumpable[p]:
                    covered = False
                    break
                grows = True
        if covered and grows:
            for p in range(row.shape[0]):
                if nodes[a, p] < row[p]:
                    row[p] = OMEGA
        a = parents[a]


@kernel
def grow(pre, post, need, inhibit, sets, pumpable, nodes, parents, by, table, bits, state, row, chunk):
    """Expand nodes until nothing is left (returns 0), `chunk` are done (1) or the arrays are full (2).

    Parameters
    ----------
    nodes : (capacity, P) int64; parents, by : (capacity,) int64, by which transition
    table : (2 ** bits,) uint32
    state : (2,) int64
        Next node to expand, number of nodes.
    row : (1, P) int64 scratch
    """
    room = min(nodes.shape[0], table.shape[0] // 2) - pre.shape[0]
    last = state[0] + chunk
    places = pre.shape[1]
    while state[0] < state[1]:
        if state[0] >= last:
            return 1
        if state[1] > room:
            return 2
        i = state[0]
        for t in range(pre.shape[0]):
            able = True
            for p in range(places):
                m = nodes[i, p]
                if m < need[t, p] or (inhibit[t, p] != 0 and m >= inhibit[t, p]):
                    able = False
                    break
            if not able:
                continue
            for p in range(places):
                m = nodes[i, p]
                if sets[t, p] >= 0:
                    m = sets[t, p]
                elif m < OMEGA:
                    m += post[t, p] - pre[t, p]
                row[0, p] = m
            accelerate(nodes, parents, i, row[0], pumpable)
            h = hash_row(row, 0)
            at = find(nodes, table, bits, row, 0, h)
            if at < 0:
                enter(table, bits, -1 - at, h, state[1])
                for p in range(places):
                    nodes[state[1], p] = row[0, p]
                parents[state[1]] = i
                by[state[1]] = t
                state[1] += 1
        state[0] = i + 1
    return 0
