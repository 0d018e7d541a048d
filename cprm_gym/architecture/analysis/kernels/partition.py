"""The coarsest partition of states that a chain respects (strong bisimulation), by splitting blocks."""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

GRAIN = 2.0**40
"""Chances that differ by less than about its inverse are taken as equal."""


@kernel
def weigh(starts, sources, chances, elements, first, last, weight, touched):
    """Sum up with which chance each state goes into the block `elements[first:last]`; returns how many do, named in `touched`."""
    found = 0
    for at in range(first, last):
        j = elements[at]
        for e in range(starts[j], starts[j + 1]):
            c = chances[e]
            if c > 0.0:
                i = sources[e]
                if weight[i] == 0.0:
                    touched[found] = i
                    found += 1
                weight[i] += c
    return found


@kernel
def bring_forward(touched, found, block, begin, end, elements, place, marked, split):
    """Put the states that were touched first in their blocks; returns how many blocks of several states these are, named in `split`."""
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
    return blocks


@kernel
def sort_touched(weight, elements, place, first, m, whole):
    """Sort the m touched states of a block by their weight; returns its rounded values, nothing where all `whole` states are alike."""
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
        return keys[order]
    if m == whole:
        return keys[:0]
    return keys


@kernel
def largest_group(keys, whole):
    """Where the largest group of equal keys begins; those without a key, up to `whole`, are one group too."""
    m = keys.shape[0]
    best = whole - m
    keep = m
    a = 0
    while a < m:
        z = a + 1
        while z < m and keys[z] == keys[a]:
            z += 1
        if z - a > best:
            best = z - a
            keep = a
        a = z
    return keep


@kernel
def part(b, keys, block, begin, end, elements, count, most, queue, waiting, tail):
    """Make each group of a block a block of its own, but the largest, which keeps the number; returns the number of blocks, or -1."""
    first = begin[b]
    whole = end[b] - first
    m = keys.shape[0]
    keep = largest_group(keys, whole)
    a = 0
    while a < whole:
        z = a + 1
        if a < m:
            while z < m and keys[z] == keys[a]:
                z += 1
        else:
            z = whole
        if a == keep:
            begin[b] = first + a
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
    return count


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
        found = weigh(starts, sources, chances, elements, begin[splitter], end[splitter], weight, touched)
        blocks = bring_forward(touched, found, block, begin, end, elements, place, marked, split)
        for s in range(blocks):
            b = split[s]
            keys = sort_touched(weight, elements, place, begin[b], marked[b], end[b] - begin[b])
            marked[b] = 0
            if keys.shape[0] > 0:
                before = count
                count = part(b, keys, block, begin, end, elements, count, most, queue, waiting, tail)
                if count < 0:
                    return -1
                tail += count - before
        for f in range(found):
            weight[touched[f]] = 0.0
    return count
