"""One slice for every agent and every part of a group: components go through the operations of a program.

A component has a log weight, states in slots, and a mean and a covariance of columns. There are two rooms of components; an operation that
makes several of one writes into the other room.
"""

from __future__ import annotations

import math

import numpy as np

from ......compilation import kernel_group
from .leaves import (
    CHANCE,
    FINE,
    FLAT,
    NO_CHANCE,
    NORMAL,
    append_flat,
    append_normal,
    chance_moments,
    fill,
    weigh,
)  # fmt: skip
from .normals import condition_interval, condition_point, wrapped

kernel = kernel_group(_nrt=False)

TABLE, NUMBER, STATE, BIN = 0, 1, 2, 3
BENT = 0.01
"""How much of the noise a formula that is read may bend away from a line before the slice is taken again."""
SPARE = 2
"""A third room, for one component."""


@kernel
def copied(lw, st, mu, cv, source, k, target, j, weight):
    """Copy component k of room `source` to place j of room `target`, with another weight."""
    lw[target, j] = weight
    for i in range(st.shape[2]):
        st[target, j, i] = st[source, k, i]
    for i in range(mu.shape[2]):
        mu[target, j, i] = mu[source, k, i]
        for m in range(mu.shape[2]):
            cv[target, j, i, m] = cv[source, k, i, m]


@kernel
def room_for(lw, target, count, weight, lost):
    """A place for a component: a free one, or that of the lightest, which is lost; -1 where it is lost itself. With the new count."""
    if count < lw.shape[1]:
        return count, count + 1
    lightest = 0
    for k in range(1, count):
        if lw[target, k] < lw[target, lightest]:
            lightest = k
    if lw[target, lightest] >= weight:
        lost[0] = added(lost[0], weight)
        return -1, count
    lost[0] = added(lost[0], lw[target, lightest])
    return lightest, count


@kernel
def added(a, b):
    """``log(exp(a) + exp(b))``."""
    if a < b:
        a, b = b, a
    return a if b == -np.inf else a + math.log1p(math.exp(b - a))


@kernel
def row_of(op, links, states, hard, at, agent):
    """Which row of a table, or which case, the states of the parents choose."""
    index = 0
    for i in range(op[5], op[5] + op[6]):
        value = states[links[i, 1]] if links[i, 0] == 0 else hard[at[links[i, 1]], agent]
        index += value * links[i, 2]
    return index


@kernel
def load(lw, st, mu, cv, old_lw, old_st, old_mu, old_cv, b, slots, columns, copies):
    """Components of an agent from the belief before, those columns and slots that the program needs; how many."""
    count, there = 0, 0
    for k in range(old_lw.shape[1]):
        if old_lw[b, k] > -np.inf:
            there += 1
    each = max(1, copies // max(1, there))
    for k in range(old_lw.shape[1]):
        if old_lw[b, k] == -np.inf:
            continue
        for _ in range(each):
            lw[0, count] = old_lw[b, k] - math.log(each)
            for i in range(len(slots)):
                st[0, count, i] = old_st[b, k, slots[i]]
            for i in range(len(columns)):
                mu[0, count, i] = old_mu[b, k, columns[i]]
                for j in range(len(columns)):
                    cv[0, count, i, j] = old_cv[b, k, columns[i], columns[j]]
            st[0, count, -1] = count
            count += 1
    return count


@kernel
def put_state(lw, st, mu, cv, room, count, k, op, weights, offset, hard, soft, soft_at, lost):
    """Give the child of a component every state that it can have, by ``weights[offset:]``; the new count in the other room."""
    for s in range(op[4]):
        weight = weights[offset + s]
        if weight <= 0.0:
            continue
        if soft_at >= 0:
            weight *= soft[soft_at + s]
            if weight <= 0.0:
                continue
        if hard >= 0 and s != hard:
            continue
        total = lw[room, k] + math.log(weight)
        j, count = room_for(lw, 1 - room, count, total, lost)
        if j >= 0:
            copied(lw, st, mu, cv, room, k, 1 - room, j, total)
            st[1 - room, j, op[1]] = s
    return count


@kernel
def read_number(mean, cov, n, low, high, period):
    """Condition on a reading of column n - 1; gives its log likelihood."""
    if low == high:
        return condition_point(mean, cov, n, n - 1, low, period)
    return condition_interval(mean, cov, n, n - 1, low, high, period)


@kernel
def put_bins(lw, st, mu, cv, room, j, op, numbers, hard, soft, soft_at, lost, count, n):
    """Part component j of the other room by the bins of its last column; it becomes the first that is possible. The new count."""
    target, first, edges = 1 - room, True, op[10]
    period = numbers[op[9]]
    weight = lw[target, j]
    copied(lw, st, mu, cv, target, j, SPARE, 0, weight)
    for s in range(op[4]):
        if hard >= 0 and s != hard:
            continue
        low, high = numbers[edges + s], numbers[edges + s + 1]
        if period == 0.0 and s == 0:
            low = -np.inf
        if period == 0.0 and s == op[4] - 1:
            high = np.inf
        place = j
        if not first:
            place, count = room_for(lw, target, count, weight, lost)
            if place < 0:
                continue
        copied(lw, st, mu, cv, SPARE, 0, target, place, weight)
        told = read_number(mu[target, place], cv[target, place], n, low, high, period)
        if soft_at >= 0:
            told = told + math.log(soft[soft_at + s]) if soft[soft_at + s] > 0.0 else -np.inf
        lw[target, place] = weight + told
        st[target, place, op[1]] = s
        first = False
    return count


@kernel
def run_slice(
    lw, st, mu, cv, count, ops, links, cases, weights, leaves, inputs, numbers, start, code, constants,
    hard, low, high, soft, at, soft_at, agent, normals, lost, row, stack, scratch, columns,
    again, lines, line_mu, line_cv, turns,
):  # fmt: skip
    """Take the components of one agent through a program; gives the room they end in, how many they are, and what went wrong where.

    ``lost[1]`` becomes 1 where a formula that was read bends. With `again`, formulas are taken where the slice leads to, `line_mu` and
    `line_cv` of the component from which each came, its last slot (iterated posterior linearisation, Garcia-Fernandez and others 2015).

    Returns
    -------
    (room, count, fault, leaf)
    """
    room = 0
    for o in range(len(ops)):
        op = ops[o]
        kind, n = op[0], op[11]
        value = hard[at[op[3]], agent]
        likelihood = soft_at[op[3]]
        if op[2] == 1 and value < 0 and likelihood < 0:
            continue
        period = numbers[op[9]]
        made = 0
        for k in range(count):
            if lw[room, k] == -np.inf:
                continue
            case = row_of(op, links, st[room, k], hard, at, agent)
            if kind == TABLE:
                made = put_state(lw, st, mu, cv, room, made, k, op, numbers, op[8] + case * op[4], value, soft[agent], likelihood, lost)
                continue
            for a in range(cases[op[7] + case, 0], cases[op[7] + case, 1]):
                leaf = leaves[a]
                weight = lw[room, k] + weights[a]
                if leaf[0] == NORMAL or leaf[0] == FLAT:
                    j, made = room_for(lw, 1 - room, made, weight, lost)
                    if j < 0:
                        continue
                    copied(lw, st, mu, cv, room, k, 1 - room, j, weight)
                    mean, cov = mu[1 - room, j], cv[1 - room, j]
                    if leaf[0] == FLAT and value >= 0:  # as likely everywhere
                        width = numbers[leaf[7] + 1] - numbers[leaf[7]]
                        append_flat(mean, cov, n, numbers[leaf[7]], numbers[leaf[7] + 1])
                        mean[n], cov[n, n] = 0.5 * (low[at[op[3]], agent] + high[at[op[3]], agent]), 0.0
                        seen = high[at[op[3]], agent] - low[at[op[3]], agent]
                        if seen > 0.0:
                            cov[n, n] = min(seen, width) ** 2 / 12.0
                            lw[1 - room, j] = weight + math.log(min(1.0, seen / width))
                            if seen == np.inf:
                                append_flat(mean, cov, n, numbers[leaf[7]], numbers[leaf[7] + 1])
                        else:
                            lw[1 - room, j] = weight - math.log(width)
                        continue
                    if leaf[0] == FLAT:
                        append_flat(mean, cov, n, numbers[leaf[7]], numbers[leaf[7] + 1])
                    else:
                        at_mean, at_cov = mean, cov
                        origin = st[room, k, -1]
                        if again and lines[origin] > -np.inf:
                            at_mean, at_cov = line_mu[origin], line_cv[origin]
                        fill(leaf, inputs, numbers, at_mean, st[1 - room, j], hard, low, at, agent, row)
                        fault, bend = append_normal(
                            mean, cov, n, leaf, inputs, numbers, start, code, constants, row, stack, period, scratch, at_mean, at_cov, turns
                        )
                        if fault != FINE:
                            return room, count, fault, a
                        if value >= 0 and bend > BENT:
                            lost[1] = 1.0
                    if kind == BIN:
                        made = put_bins(lw, st, mu, cv, room, j, op, numbers, value, soft[agent], likelihood, lost, made, n + 1)
                    elif value >= 0:
                        told = read_number(mean, cov, n + 1, low[at[op[3]], agent], high[at[op[3]], agent], period)
                        mean[n] = wrapped(mean[n], period)
                        lw[1 - room, j] = weight + told
                    elif op[12] >= 0:
                        drawn = mean[n] + math.sqrt(cov[n, n]) * normals[j % normals.shape[0], op[12]]
                        condition_point(mean, cov, n + 1, n, drawn, period)
                elif leaf[0] == CHANCE:
                    total = numbers[leaf[7]]
                    fill(leaf, inputs, numbers, mu[room, k], st[room, k], hard, low, at, agent, row)
                    total = chance_moments(cv[room, k], leaf, inputs, numbers, start, code, constants, row, stack, scratch)
                    if total != total:
                        return room, count, NO_CHANCE, a
                    total = min(max(total, 0.0), 1.0)
                    for s in range(2):
                        if value >= 0 and s != value:
                            continue
                        j, made = room_for(lw, 1 - room, made, weight, lost)
                        if j < 0:
                            continue
                        copied(lw, st, mu, cv, room, k, 1 - room, j, weight)
                        told = weigh(mu[1 - room, j], cv[1 - room, j], n, leaf, inputs, total, s == 1, scratch, columns)
                        if likelihood >= 0:
                            told = told + math.log(soft[agent, likelihood + s]) if soft[agent, likelihood + s] > 0.0 else -np.inf
                        lw[1 - room, j] = weight + told
                        st[1 - room, j, op[1]] = s
                else:
                    before = lw[room, k]
                    lw[room, k] = weight
                    made = put_state(lw, st, mu, cv, room, made, k, op, numbers, leaf[7], value, soft[agent], likelihood, lost)
                    lw[room, k] = before
        room, count = 1 - room, made
        if count == 0:
            return room, 0, FINE, -1
    return room, count, FINE, -1
