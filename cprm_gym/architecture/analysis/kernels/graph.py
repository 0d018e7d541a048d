"""Graphs with numbered edges: components, what can be reached from where.

A graph is compressed: the edges of node i are ``offsets[i]`` to ``offsets[i + 1]``, with `targets` (-1: leads out of what is known)
and `labels`.
"""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()


@kernel
def strong_components(offsets, targets, component, index, stack, calls, at):
    """Tarjan's algorithm (1972) without recursion; returns the number of strongly connected components.

    Components are numbered so that every edge leads to the same or a lower number.

    Parameters
    ----------
    component, index, stack, calls : (N,) int32, scratch except `component`, the result
    at : (N,) int64
        Scratch: next edge of each node.
    """
    n = offsets.shape[0] - 1
    low = component  # until a node's component is known, its low link
    for i in range(n):
        index[i] = -1
        at[i] = offsets[i]
    counter = 0
    found = 0
    top = 0
    for root in range(n):
        if index[root] >= 0:
            continue
        depth = 0
        calls[0] = root
        index[root] = low[root] = counter
        counter += 1
        stack[top] = root
        top += 1
        while depth >= 0:
            v = calls[depth]
            if at[v] < offsets[v + 1]:
                w = targets[at[v]]
                at[v] += 1
                if w < 0:
                    continue
                if index[w] < 0:
                    depth += 1
                    calls[depth] = w
                    index[w] = low[w] = counter
                    counter += 1
                    stack[top] = w
                    top += 1
                elif index[w] < n:  # still on the stack
                    low[v] = min(low[v], index[w])
                continue
            depth -= 1
            if low[v] == index[v]:
                while True:
                    top -= 1
                    w = stack[top]
                    index[w] = n  # done
                    component[w] = found
                    if w == v:
                        break
                found += 1
            elif depth >= 0:
                parent = calls[depth]
                low[parent] = min(low[parent], low[v])
    return found


@kernel
def component_facts(offsets, targets, labels, component, cyclic, bottom, fires, repeats):
    """Which components are cyclic, which are bottoms, and which labels occur at all and within a component.

    Parameters
    ----------
    cyclic, bottom : (C,) bool, bottom given as True
    fires, repeats : (T,) bool, given as False
    """
    for i in range(offsets.shape[0] - 1):
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            fires[labels[e]] = True
            if j < 0 or component[j] != component[i]:
                bottom[component[i]] = False
            else:
                cyclic[component[i]] = True
                repeats[labels[e]] = True


@kernel
def group_nodes(component, start, nodes):
    """Nodes sorted by component: those of c are ``nodes[start[c]:start[c + 1]]``; `start` (C + 1,) given as zeros."""
    for i in range(component.shape[0]):
        start[component[i] + 1] += 1
    for c in range(1, start.shape[0]):
        start[c] += start[c - 1]
    for i in range(component.shape[0] - 1, -1, -1):
        c = component[i]
        start[c + 1] -= 1
        nodes[start[c + 1]] = i
    for c in range(start.shape[0] - 1):  # now start[c + 1] is where c begins
        start[c] = start[c + 1]
    start[start.shape[0] - 1] = component.shape[0]


@kernel
def count_in_bottoms(offsets, labels, start, nodes, bottom, count):
    """In how many bottom components each label occurs, into `count` (T,) given as zeros."""
    stamp = np.full(count.shape[0], -1, np.int64)
    for c in range(bottom.shape[0]):
        if not bottom[c]:
            continue
        for k in range(start[c], start[c + 1]):
            for e in range(offsets[nodes[k]], offsets[nodes[k] + 1]):
                t = labels[e]
                if stamp[t] != c:
                    stamp[t] = c
                    count[t] += 1


@kernel
def can_reach(offsets, targets, component, start, nodes, goal, unknown, result):
    """Whether each node can reach one of `goal` (N,) bool, into `result` (N,) bool.

    With `unknown`, edges that lead out of what is known count as reaching it.
    """
    for c in range(start.shape[0] - 1):
        yes = False
        for k in range(start[c], start[c + 1]):
            i = nodes[k]
            yes |= goal[i]
            for e in range(offsets[i], offsets[i + 1]):
                j = targets[e]
                if j < 0:
                    yes |= unknown
                elif component[j] != c:
                    yes |= result[j]
            if yes:
                break
        for k in range(start[c], start[c + 1]):
            result[nodes[k]] = yes


@kernel
def search(offsets, targets, starts, allowed, goal, came, queue):
    """Breadth-first search over `allowed` edges from the nodes `starts`; the first node of `goal` found, or -1.

    Parameters
    ----------
    allowed : (E,) bool
    goal : (N,) bool
    came : (N,) int64
        Given as -1; becomes the edge by which each node was found, -2 for the starts.
    queue : (N,) int64, scratch
    """
    head = 0
    tail = 0
    for k in range(starts.shape[0]):
        i = starts[k]
        if came[i] == -1:
            came[i] = -2
            queue[tail] = i
            tail += 1
    while head < tail:
        i = queue[head]
        head += 1
        if goal[i]:
            return i
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if allowed[e] and j >= 0 and came[j] == -1:
                came[j] = e
                queue[tail] = j
                tail += 1
    return -1


@kernel
def lead(starts, sources, unsure, left, lead, queue):
    """Nodes that lead to those of `lead` given, backwards: over one sure edge, or over all edges where none is sure.

    Parameters
    ----------
    starts : (N + 1,) int64
        Where the edges into each node begin in the two next.
    sources : (E,) int32; unsure : (E,) bool
    left : (N,) int64
        Of nodes with unsure edges alone their number, -1 of others; changed.
    lead : (N,) bool, updated
    queue : (N,) int64, scratch
    """
    head = 0
    tail = 0
    for i in range(lead.shape[0]):
        if lead[i]:
            queue[tail] = i
            tail += 1
    while head < tail:
        j = queue[head]
        head += 1
        for e in range(starts[j], starts[j + 1]):
            i = sources[e]
            if lead[i]:
                continue
            if unsure[e]:
                if left[i] > 0:
                    left[i] -= 1
                if left[i] != 0:
                    continue
            lead[i] = True
            queue[tail] = i
            tail += 1
