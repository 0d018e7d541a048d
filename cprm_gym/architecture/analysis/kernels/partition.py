"""The coarsest partition of states that a chain respects (strong bisimulation), by splitting blocks."""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

GRAIN = 2.0**40
"""Chances that differ by less than about its inverse are taken as equal."""


@kernel
def refine(starts, sources, chances, block, begin, end, elements, place, count, most, queue, waiting, weight, touched, marked, split):
    """Split blocks until all states of a block go into each block with the same chance; returns their number, -1 if it exceeds `most`.

    Each block that came about by splitting, but the largest of its kin, splits those that lead into it.

    Parameters
    ----------
    starts : (n + 1,), sources, chances : (m,)
        Edges into each state.
    block : (n,) int32
        Of each state; `count` blocks at the beginning; changed.
    begin, end : (most + 1,) int32
        Where each block lies in `elements` (n,) int32; place (n,) int32 is where each state lies in it.
    queue, waiting : (most + 1,), weight : (n,) zeros, touched : (n,), marked, split : (most + 1,) zeros, scratch

    References
    ----------
    A. Valmari, G. Franceschinis (2010), TACAS, LNCS 6015:38-52.
    """
    tail = 0
    for b in range(count):
        queue[tail] = b
        waiting[b] = True
        tail += 1
    while tail > 0:
        tail -= 1
        splitter = queue[tail]
        waiting[splitter] = False
        found = 0
        for at in range(begin[splitter], end[splitter]):
            j = elements[at]
            for e in range(starts[j], starts[j + 1]):
                c = chances[e]
                if c > 0.0:
                    i = sources[e]
                    if weight[i] == 0.0:
                        touched[found] = i
                        found += 1
                    weight[i] += c
        blocks = 0
        for f in range(found):
            i = touched[f]
            b = block[i]
            if end[b] - begin[b] > 1:
                if marked[b] == 0:
                    split[blocks] = b
                    blocks += 1
                front = begin[b] + marked[b]
                other = elements[front]
                elements[place[i]] = other
                place[other] = place[i]
                elements[front] = i
                place[i] = front
                marked[b] += 1
        for s in range(blocks):
            b = split[s]
            first = begin[b]
            m = marked[b]
            marked[b] = 0
            last = end[b]
            keys = np.empty(m)
            low = np.inf
            high = -np.inf
            for a in range(m):
                keys[a] = np.rint(weight[elements[first + a]] * GRAIN)
                low = min(low, keys[a])
                high = max(high, keys[a])
            if low < high:
                order = np.argsort(keys)
                moved = np.empty(m, np.int32)
                for a in range(m):
                    moved[a] = elements[first + order[a]]
                for a in range(m):
                    elements[first + a] = moved[a]
                    place[moved[a]] = first + a
                keys = keys[order]
            elif m == last - first:
                continue  # all alike
            # groups: runs of equal keys, then those that were not touched
            best = last - first - m
            keep = first + m
            a = 0
            while a < m:
                z = a + 1
                while z < m and keys[z] == keys[a]:
                    z += 1
                if z - a > best:
                    best = z - a
                    keep = first + a
                a = z
            a = 0
            while a < last - first:
                z = a + 1
                if a < m:
                    while z < m and keys[z] == keys[a]:
                        z += 1
                else:
                    z = last - first
                if first + a == keep:
                    begin[b] = keep
                    end[b] = first + z
                else:
                    if count >= most:
                        return -1
                    begin[count] = first + a
                    end[count] = first + z
                    for at in range(first + a, first + z):
                        block[elements[at]] = count
                    queue[tail] = count
                    waiting[count] = True
                    tail += 1
                    count += 1
                a = z
        for f in range(found):
            weight[touched[f]] = 0.0
    return count
