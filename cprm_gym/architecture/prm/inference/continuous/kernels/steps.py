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
    NONLINEAR,
    NORMAL,
    SPREAD,
    append_flat,
    append_known,
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
def copied(lw, st, mu, cv, source, k, target, j, weight, first, n):
    """Copy component k of room `source` to place j of room `target`, with another weight: its columns from `first` to `n`."""
    lw[target, j] = weight
    for i in range(st.shape[2]):
        st[target, j, i] = st[source, k, i]
    for i in range(first, n):
        mu[target, j, i] = mu[source, k, i]
        for m in range(first, n):
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
def put_state(lw, st, mu, cv, room, count, k, op, first, weights, offset, hard, soft, soft_at, lost):
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
            copied(lw, st, mu, cv, room, k, 1 - room, j, total, first, op[11])
            st[1 - room, j, op[1]] = s
    return count


@kernel
def read_number(mean, cov, n, low, high, period):
    """Condition on a reading of column n - 1; gives its log likelihood."""
    if low == high:
        return condition_point(mean, cov, n, n - 1, low, period)
    return condition_interval(mean, cov, n, n - 1, low, high, period)


@kernel
def append_flat_read(mean, cov, n, limits, low, high):
    """Append a number that is as likely everywhere between limits and was read: what the reading says, and its log probability."""
    append_flat(mean, cov, n, limits[0], limits[1])
    width, seen = limits[1] - limits[0], high - low
    if not seen > 0.0:
        mean[n], cov[n, n] = low, 0.0
        return -math.log(width)
    if seen < np.inf:
        mean[n], cov[n, n] = 0.5 * (low + high), min(seen, width) ** 2 / 12.0
    return math.log(min(1.0, seen / width))


@kernel
def bends(ops, hard, at, agent):
    """Whether something that may bend is read: then all columns are kept up to date to the end, for another turn."""
    for o in range(len(ops)):
        if ops[o, 14] == 1 and hard[at[ops[o, 3]], agent] >= 0:
            return True
    return False


@kernel
def put_bins(lw, st, mu, cv, room, j, op, numbers, hard, soft, soft_at, lost, count, n):
    """Part component j of the other room by the bins of its last column; it becomes the first that is possible. The new count."""
    target, first, edges = 1 - room, True, op[10]
    period = numbers[op[9]]
    weight = lw[target, j]
    copied(lw, st, mu, cv, target, j, SPARE, 0, weight, 0, n)
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
        copied(lw, st, mu, cv, SPARE, 0, target, place, weight, 0, n)
        told = read_number(mu[target, place], cv[target, place], n, low, high, period)
        if soft_at >= 0:
            told = told + math.log(soft[soft_at + s]) if soft[soft_at + s] > 0.0 else -np.inf
        lw[target, place] = weight + told
        st[target, place, op[1]] = s
        first = False
    return count


@kernel
def put_number(
    mean, cov, states, op, first, leaf, inputs, numbers, start, code, constants, hard, low, high, at, agent, normal,
    row, stack, scratch, again, lines, line_mu, line_cv, turns, known,
):  # fmt: skip
    """Append a number to a component, and condition on what was read of it; of what is cut into bins only the first.

    Returns
    -------
    (fault, log likelihood, bends)
    """
    n, reading = op[11], at[op[3]]
    value, period = hard[reading, agent], numbers[op[9]]
    if leaf[0] == FLAT:
        limits = numbers[leaf[7] : leaf[7] + 2]
        if value >= 0 and op[0] == NUMBER:
            return FINE, append_flat_read(mean, cov, n, limits, low[reading, agent], high[reading, agent]), False
        append_flat(mean, cov, n, limits[0], limits[1])
        bend = 0.0
    elif known[0] == 1.0:
        append_known(mean, cov, n, first, leaf, inputs, known, period)
        bend = 0.0
    else:
        at_mean, at_cov, origin = mean, cov, states[-1]
        if again and (leaf[6] == NONLINEAR or leaf[6] == SPREAD) and lines[origin] > -np.inf:
            at_mean, at_cov = line_mu[origin], line_cv[origin]
        fill(leaf, inputs, numbers, at_mean, states, hard, low, at, agent, row)
        fault, bend = append_normal(
            mean, cov, n, first, leaf, inputs, numbers, start, code, constants, row, stack, period, scratch, at_mean, at_cov, turns, known
        )
        if fault != FINE:
            return fault, 0.0, False
    told = 0.0
    if op[0] == NUMBER and value >= 0:
        told = read_number(mean[first:], cov[first:, first:], n + 1 - first, low[reading, agent], high[reading, agent], period)
        mean[n] = wrapped(mean[n], period)
    elif op[0] == NUMBER and op[12] >= 0:
        condition_point(mean[first:], cov[first:, first:], n + 1 - first, n - first, mean[n] + math.sqrt(cov[n, n]) * normal, period)
    return FINE, told, value >= 0 and bend > BENT


@kernel
def put_chance(lw, st, mu, cv, room, made, k, op, first, leaf, weight, inputs, numbers, start, code, constants, hard, low, at, agent,
               soft, soft_at, lost, row, stack, scratch, columns):  # fmt: skip
    """Give the child of component k its two states, by a chance that depends on numbers; the new count, -1 where that is none."""
    fill(leaf, inputs, numbers, mu[room, k], st[room, k], hard, low, at, agent, row)
    total = chance_moments(cv[room, k], leaf, inputs, numbers, start, code, constants, row, stack, scratch)
    if total != total:
        return -1
    total = min(max(total, 0.0), 1.0)
    value = hard[at[op[3]], agent]
    for s in range(2):
        if value >= 0 and s != value:
            continue
        j, made = room_for(lw, 1 - room, made, weight, lost)
        if j < 0:
            continue
        copied(lw, st, mu, cv, room, k, 1 - room, j, weight, first, op[11])
        told = weigh(mu[1 - room, j], cv[1 - room, j], first, op[11], leaf, inputs, total, s == 1, scratch, columns)
        if soft_at >= 0:
            told = told + math.log(soft[soft_at + s]) if soft[soft_at + s] > 0.0 else -np.inf
        lw[1 - room, j] = weight + told
        st[1 - room, j, op[1]] = s
    return made


@kernel
def run_slice(
    lw, st, mu, cv, count, ops, links, cases, weights, leaves, inputs, numbers, start, code, constants,
    hard, low, high, soft, at, soft_at, agent, normals, lost, row, stack, scratch, columns,
    again, lines, line_mu, line_cv, turns, known,
):  # fmt: skip
    """Take the components of one agent through a program; gives the room they end in, how many they are, and what went wrong where.

    ``lost[1]`` becomes 1 where a formula that was read bends. With `again`, those that bend are taken where the slice leads to, `line_mu`
    and `line_cv` of the component from which each came, its last slot (iterated posterior linearisation, Garcia-Fernandez and others 2015).
    A row of `known` is for the line of a leaf that is the same for all components.

    Returns
    -------
    (room, count, fault, leaf)
    """
    room, whole = 0, bends(ops, hard, at, agent)
    for a in range(len(leaves)):
        known[a, 0] = 0.0
    for o in range(len(ops)):
        op = ops[o]
        value, likelihood = hard[at[op[3]], agent], soft_at[op[3]]
        if op[2] == 1 and value < 0 and likelihood < 0:
            continue
        first = 0 if whole else op[13]
        made = 0
        for k in range(count):
            if lw[room, k] == -np.inf:
                continue
            case = row_of(op, links, st[room, k], hard, at, agent)
            if op[0] == TABLE:
                made = put_state(
                    lw, st, mu, cv, room, made, k, op, first, numbers, op[8] + case * op[4], value, soft[agent], likelihood, lost
                )
                continue
            for a in range(cases[op[7] + case, 0], cases[op[7] + case, 1]):
                leaf, weight = leaves[a], lw[room, k] + weights[a]
                if leaf[0] == NORMAL or leaf[0] == FLAT:
                    to, j = room, k
                    if op[15] == 0:
                        to = 1 - room
                        j, made = room_for(lw, to, made, weight, lost)
                        if j < 0:
                            continue
                        copied(lw, st, mu, cv, room, k, to, j, weight, first, op[11])
                    normal = normals[j % normals.shape[0], op[12]] if op[12] >= 0 else 0.0
                    fault, told, bent = put_number(
                        mu[to, j], cv[to, j], st[to, j], op, first, leaf, inputs, numbers, start, code, constants, hard, low, high, at,
                        agent, normal, row, stack, scratch, again, lines, line_mu, line_cv, turns, known[a],
                    )  # fmt: skip
                    if fault != FINE:
                        return room, count, fault, a
                    lw[to, j] = weight + told
                    if bent:
                        lost[1] = 1.0
                    if op[0] == BIN:
                        made = put_bins(lw, st, mu, cv, room, j, op, numbers, value, soft[agent], likelihood, lost, made, op[11] + 1)
                elif leaf[0] == CHANCE:
                    made = put_chance(
                        lw, st, mu, cv, room, made, k, op, first, leaf, weight, inputs, numbers, start, code, constants, hard, low, at,
                        agent, soft[agent], likelihood, lost, row, stack, scratch, columns,
                    )  # fmt: skip
                    if made < 0:
                        return room, count, NO_CHANCE, a
                else:
                    before, lw[room, k] = lw[room, k], weight
                    made = put_state(lw, st, mu, cv, room, made, k, op, first, numbers, leaf[7], value, soft[agent], likelihood, lost)
                    lw[room, k] = before
        if op[15] == 1:
            continue
        room, count = 1 - room, made
        if count == 0:
            return room, 0, FINE, -1
    return room, count, FINE, -1
