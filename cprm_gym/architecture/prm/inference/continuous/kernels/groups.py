"""A slice of a whole group: like parts of all agents, one after the other."""

from __future__ import annotations

import math

import numpy as np

from ......compilation import kernel_group
from .normals import wrapped
from .reduction import close_up, keep_heaviest, merge_down, renew, resample
from .steps import added, load, run_slice

kernel = kernel_group(_nrt=False)


TURNS, SETTLED = 12, 1e-3
"""How often a slice is taken in which formulas that are read bend, at most, and the log likelihood that may still change at the end."""


@kernel
def note_lines(lw, st, mu, cv, count, lines, line_mu, line_cv):
    """Where each component that was there at first has led to: mean and covariance of the heaviest that came from it."""
    for k in range(len(lines)):
        lines[k] = -np.inf
    for k in range(count):
        origin = st[k, -1]
        if lw[k] > lines[origin]:
            lines[origin] = lw[k]
            for i in range(mu.shape[1]):
                line_mu[origin, i] = mu[k, i]
                for j in range(mu.shape[1]):
                    line_cv[origin, i, j] = cv[k, i, j]


@kernel
def weight_of(lw, mu, cv, room, count, kept):
    """Log of the weight of all components; those that have left the range of numbers weigh nothing."""
    total = -np.inf
    for k in range(count):
        fine = lw[room, k] < np.inf
        for i in range(len(kept)):
            c = kept[i]
            fine = fine and abs(mu[room, k, c]) < np.inf and cv[room, k, c, c] < np.inf
        if fine:
            total = added(total, lw[room, k])
        else:
            lw[room, k] = -np.inf
    return total


@kernel
def join(lw, st, mu, cv, count, slots, columns, threshold, turns, w, cost, volume, mean, cov, lower):
    """Merge loaded components that differ by what is needed no more, where that loses less than `threshold`; how many, and the loss."""
    for k in range(count):
        w[k] = math.exp(lw[k])
    s, m, c = st[:, :slots], mu[:, :columns], cv[:, :columns, :columns]
    left, loss = merge_down(w, s, m, c, count, count, threshold, turns[:columns], cost, volume, mean, cov, lower)
    if left == count:
        return count, 0.0
    count = close_up(w, s, m, c, count)
    for k in range(count):
        lw[k] = math.log(w[k])
        st[k, -1] = k
    return count, loss


@kernel
def step_group(
    old_lw, old_st, old_mu, old_cv, load_slots, load_columns, copies,
    ops, links, cases, weights, leaves, inputs, numbers, start, code, constants,
    hard, low, high, soft, rows, soft_rows, normals, uniforms,
    keep_slots, keep_columns, periods, turns, limit, threshold, draw,
    lw, st, mu, cv, row, stack, scratch, columns, w, cost, volume, order, mean, cov, lower, lost, lines, line_mu, line_cv, known,
    new_lw, new_st, new_mu, new_cv, increment, loss, astray, fault,
):  # fmt: skip
    """Take every part of a group through a slice: the belief after it, what the readings add to the log likelihood, and the loss.

    b = part * agents + agent everywhere. ``fault`` gets what went wrong first and in which leaf; `astray` where lines that were sought
    again did not settle, so that those through the points of the prediction were taken.
    """
    agents = hard.shape[1]
    for b in range(old_lw.shape[0]):
        part, agent = b // agents, b % agents
        room, total, before, turn, merging = 0, -np.inf, np.inf, 0, 0.0
        while True:
            lost[0], lost[1] = -np.inf, 0.0
            again = turn > 0 and turn < TURNS
            count = load(lw, st, mu, cv, old_lw, old_st, old_mu, old_cv, b, load_slots, load_columns, copies)
            if not draw and threshold > 0.0 and 1 < count <= len(cost):
                count, merging = join(
                    lw[0], st[0], mu[0], cv[0], count, len(load_slots), len(load_columns), threshold, turns,
                    w, cost, volume, mean, cov, lower,
                )  # fmt: skip
            room, count, wrong, leaf = run_slice(
                lw, st, mu, cv, count, ops, links, cases, weights, leaves, inputs, numbers, start, code, constants,
                hard, low, high, soft, rows[part], soft_rows[part], agent, normals[b], lost, row, stack, scratch, columns,
                again, lines, line_mu, line_cv, turns, known,
            )  # fmt: skip
            if wrong != 0 and not again:
                fault[0], fault[1], fault[2] = wrong, leaf, b
                return
            total = -np.inf if wrong != 0 else weight_of(lw, mu, cv, room, count, keep_columns)
            if not again and (turn == TURNS or lost[1] == 0.0 or total == -np.inf):
                break
            if again and total > -np.inf and abs(total - before) < SETTLED:
                break
            turn = TURNS if total == -np.inf else turn + 1  # where it leads astray or nowhere, all is as at first
            before = total
            if turn < TURNS:
                note_lines(lw[room], st[room], mu[room], cv[room], count, lines, line_mu, line_cv)
        astray[b] = turn == TURNS
        for k in range(new_lw.shape[1]):
            new_lw[b, k] = -np.inf
        increment[b] = total
        loss[b] = merging
        if total == -np.inf:
            continue
        for k in range(count):
            w[k] = math.exp(lw[room, k] - total)
            for i in range(len(keep_slots)):
                st[1 - room, k, i] = st[room, k, keep_slots[i]]
            for i in range(len(keep_columns)):
                mu[1 - room, k, i] = mu[room, k, keep_columns[i]]
                for j in range(len(keep_columns)):
                    cv[1 - room, k, i, j] = cv[room, k, keep_columns[i], keep_columns[j]]
        room = 1 - room
        s, m, c = st[room, :, : len(keep_slots)], mu[room, :, : len(keep_columns)], cv[room, :, : len(keep_columns), : len(keep_columns)]
        if lost[0] > -np.inf:
            loss[b] += math.log1p(math.exp(lost[0] - total))
        if draw:
            resample(w, count, limit, uniforms[b])
            if normals.shape[2] > 0 and count <= limit:  # numbers were drawn: copies will part
                renew(w, s, m, c, count, uniforms[b], order)
        elif count > 1:
            loss[b] -= math.log1p(-keep_heaviest(w, count, 2 * limit, order))
            count = close_up(w, s, m, c, count)
            if count > limit or threshold > 0.0:
                _, more = merge_down(w, s, m, c, count, limit, threshold, periods, cost, volume, mean, cov, lower)
                loss[b] += more
                loss[b] -= math.log1p(-min(keep_heaviest(w, count, limit, order), 1.0 - 1e-16))
        count = close_up(w, s, m, c, count)
        for k in range(count):
            new_lw[b, k] = math.log(w[k])
            for i in range(s.shape[1]):
                new_st[b, k, i] = s[k, i]
            for i in range(m.shape[1]):
                new_mu[b, k, i] = wrapped(m[k, i], periods[i])
                for j in range(m.shape[1]):
                    new_cv[b, k, i, j] = c[k, i, j]


@kernel
def product(a_lw, a_st, a_mu, a_cv, b_lw, b_st, b_mu, b_cv, new_lw, new_st, new_mu, new_cv, lost):
    """Components of two independent parts side by side, the heaviest of them; ``lost`` gets the share of weight that has no room."""
    for b in range(a_lw.shape[0]):
        count, gone = 0, 0.0
        for k in range(new_lw.shape[1]):
            new_lw[b, k] = -np.inf
        for i in range(a_lw.shape[1]):
            if a_lw[b, i] == -np.inf:
                continue
            for j in range(b_lw.shape[1]):
                weight = a_lw[b, i] + b_lw[b, j]
                if weight == -np.inf:
                    continue
                place = count
                if count < new_lw.shape[1]:
                    count += 1
                else:
                    place = 0
                    for k in range(1, count):
                        if new_lw[b, k] < new_lw[b, place]:
                            place = k
                    gone += math.exp(min(weight, new_lw[b, place]))
                    if new_lw[b, place] >= weight:
                        continue
                new_lw[b, place] = weight
                beside(
                    a_st[b, i],
                    a_mu[b, i],
                    a_cv[b, i],
                    b_st[b, j],
                    b_mu[b, j],
                    b_cv[b, j],
                    new_st[b, place],
                    new_mu[b, place],
                    new_cv[b, place],
                )
        for k in range(count):
            new_lw[b, k] -= math.log1p(-min(gone, 1.0 - 1e-16))
        lost[b] = -math.log1p(-min(gone, 1.0 - 1e-16))


@kernel
def beside(a_st, a_mu, a_cv, b_st, b_mu, b_cv, st, mu, cv):
    """One component of two."""
    for i in range(len(a_st)):
        st[i] = a_st[i]
    for i in range(len(b_st)):
        st[len(a_st) + i] = b_st[i]
    n = len(a_mu)
    for i in range(len(mu)):
        mu[i] = a_mu[i] if i < n else b_mu[i - n]
        for j in range(len(mu)):
            if i < n and j < n:
                cv[i, j] = a_cv[i, j]
            elif i >= n and j >= n:
                cv[i, j] = b_cv[i - n, j - n]
            else:
                cv[i, j] = 0.0
