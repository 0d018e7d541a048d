"""Markov chains as compressed rows: components one by one, Krylov steps, certificates, distributions over time.

A chain is `offsets` (n + 1,), `targets` (m,), `chances` (m,): from state i to ``targets[e]`` with ``chances[e]`` for e from
``offsets[i]`` to ``offsets[i + 1]``. What leads from a state to itself is not used: the chance of leaving is the sum of the others, so
nothing is subtracted, and a state that is left once in 1e9 cycles is as exact as any other. The rows of `values` (K, n) are the chances
of absorption and, last, the expected time; in closed states (absorbing, or caught outside of all outcomes) they are given.
"""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group
from .elimination import eliminate

kernel = kernel_group()

UNIT = 2.0**-53
"""Relative error of one rounding."""


@kernel
def sweep(offsets, targets, chances, x, reward, nodes, first, last, forward):
    """One Gauss-Seidel sweep over ``nodes[first:last]``; returns the largest relative change."""
    change = 0.0
    for step in range(last - first):
        i = nodes[first + step] if forward else nodes[last - 1 - step]
        leave = 0.0
        total = reward
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if j != i:
                leave += chances[e]
                total += chances[e] * x[j]
        new = total / leave
        moved = abs(new - x[i])
        if moved > change * new:
            change = moved / new if new > 0.0 else 1.0
        x[i] = new
    return change


@kernel
def iterate(offsets, targets, chances, x, reward, nodes, first, last, limit):
    """Sweeps until nothing changes any more; returns whether that came within `limit` sweeps. Given up as soon as it is out of reach."""
    before = 1.0
    for count in range(limit):
        change = sweep(offsets, targets, chances, x, reward, nodes, first, last, count % 2 == 1)
        if change <= 8.0 * UNIT:
            return True
        if count % 5 == 4:
            if change > 0.1 * before and (count > 5 or change > 0.5):
                return False
            before = change
    return False


@kernel
def eliminate_component(offsets, targets, chances, values, nodes, first, last, place, dense, known, leave):
    """Solve one component by elimination without subtractions (`eliminate`).

    Parameters
    ----------
    place : (n,) int32, -1 everywhere; left so
    dense : (M, M), known : (M, K), leave : (M,), scratch
    """
    m = last - first
    columns = values.shape[0]
    for a in range(m):
        place[nodes[first + a]] = a
    for a in range(m):
        i = nodes[first + a]
        for b in range(m):
            dense[a, b] = 0.0
        for k in range(columns):
            known[a, k] = 0.0
        known[a, columns - 1] = 1.0
        leave[a] = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            b = place[j]
            if b >= 0:
                if b != a:
                    dense[a, b] += chances[e]
            else:
                leave[a] += chances[e]
                for k in range(columns):
                    known[a, k] += chances[e] * values[k, j]
    eliminate(dense, known, leave, m)
    for a in range(m):
        place[nodes[first + a]] = -1
        for k in range(columns):
            values[k, nodes[first + a]] = known[a, k]


@kernel
def solve_components(
    offsets, targets, chances, closed, start, nodes, values, begin, small, medium, limit, place, dense, known, leave, used
):
    """Solve components from `begin` on, each after those it leads to; returns the first one that is too hard, or their number.

    Single states follow from their successors; up to `small` states by elimination; larger ones by sweeps, and where these are slow up to
    `medium` states by elimination.

    Parameters
    ----------
    closed : (n,) bool
        States whose values are given; all of a component or none.
    start : (C + 1,), nodes : (n,)
        Components in an order in which edges lead to lower or equal numbers.
    used : (3,) int64, updated
        States solved directly, by elimination, by sweeps.
    """
    columns = values.shape[0]
    for c in range(begin, start.shape[0] - 1):
        first = start[c]
        last = start[c + 1]
        m = last - first
        if closed[nodes[first]]:
            continue
        if m == 1:
            for k in range(columns):
                sweep(offsets, targets, chances, values[k], 1.0 if k == columns - 1 else 0.0, nodes, first, last, True)
            used[0] += 1
            continue
        if m > small:
            done = True
            for k in range(columns - 1, -1, -1):
                reward = 1.0 if k == columns - 1 else 0.0
                done = done and iterate(offsets, targets, chances, values[k], reward, nodes, first, last, limit)
            if done:
                used[2] += m
                continue
        if m > medium:
            return c
        eliminate_component(offsets, targets, chances, values, nodes, first, last, place, dense, known, leave)
        used[1] += m
    return start.shape[0] - 1


@kernel
def leaving(offsets, targets, chances, nodes, first, last, leave):
    """Chance of leaving each state of a component into `leave` (n,)."""
    for a in range(first, last):
        i = nodes[a]
        total = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            if targets[e] != i:
                total += chances[e]
        leave[i] = total


@kernel
def residual(offsets, targets, chances, x, reward, nodes, first, last, leave, out):
    """What each state of a component lacks of its equation, divided by its chance of leaving, into `out` (n,)."""
    for a in range(first, last):
        i = nodes[a]
        total = reward
        for e in range(offsets[i], offsets[i + 1]):
            total += chances[e] * (x[targets[e]] - x[i])
        out[i] = total / leave[i]


@kernel
def multiply(offsets, targets, chances, nodes, first, last, leave, x, out):
    """(I - D^-1 Q) x of a component into `out`; x (n,) is zero outside of it."""
    for a in range(first, last):
        i = nodes[a]
        total = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if j != i:
                total += chances[e] * x[j]
        out[i] = x[i] - total / leave[i]


@kernel
def bicgstab(offsets, targets, chances, x, reward, nodes, first, last, leave, goal, limit, r, shadow, p, v, t):
    """Stabilised bi-conjugate gradients on one component, scaled by the chance of leaving.

    Starts from x, which it improves in place; r, shadow, p, v, t (n,) are given as zeros. Returns the iterations, negative where it did not
    come to `goal` of the size of the values within `limit`, or is not on the way there.

    References
    ----------
    H. A. van der Vorst (1992), SIAM J. Sci. Stat. Comput. 13:631-644.
    """
    rho = 1.0
    alpha = 1.0
    omega = 1.0
    residual(offsets, targets, chances, x, reward, nodes, first, last, leave, r)
    begun = 0.0
    for a in range(first, last):
        i = nodes[a]
        shadow[i] = r[i]
        begun = max(begun, abs(r[i]))
    for count in range(limit):
        last_rho = rho
        rho = 0.0
        for a in range(first, last):
            i = nodes[a]
            rho += shadow[i] * r[i]
        if rho == 0.0 or omega == 0.0:
            return -count - 1
        beta = rho / last_rho * (alpha / omega)
        for a in range(first, last):
            i = nodes[a]
            p[i] = r[i] + beta * (p[i] - omega * v[i])
        multiply(offsets, targets, chances, nodes, first, last, leave, p, v)
        along = 0.0
        for a in range(first, last):
            i = nodes[a]
            along += shadow[i] * v[i]
        if along == 0.0:
            return -count - 1
        alpha = rho / along
        for a in range(first, last):
            i = nodes[a]
            r[i] -= alpha * v[i]
        multiply(offsets, targets, chances, nodes, first, last, leave, r, t)
        along = 0.0
        square = 0.0
        for a in range(first, last):
            i = nodes[a]
            along += t[i] * r[i]
            square += t[i] * t[i]
        omega = along / square if square > 0.0 else 0.0
        lack = 0.0
        size = 0.0
        for a in range(first, last):
            i = nodes[a]
            x[i] += alpha * p[i] + omega * r[i]
            r[i] -= omega * t[i]
            lack = max(lack, abs(r[i]))
            size = max(size, abs(x[i]))
        if not lack < np.inf:
            return -count - 1
        if lack <= goal * size:
            return count + 1
        if count == 24 or count == 59:  # is it on the way?
            done = np.log(begun / lack)
            if done <= 0.0 or np.log(lack / (goal * size)) > done * (limit - count) / (count + 1):
                return -count - 1
    return -limit


@kernel
def multiply_both(offsets, targets, chances, nodes, first, last, leave, x, out):
    """(I - D^-1 Q) of two columns side by side, x (n, 2), which are read together: what one row costs is to find its targets."""
    for a in range(first, last):
        i = nodes[a]
        s = 0.0
        t = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if j != i:
                s += chances[e] * x[j, 0]
                t += chances[e] * x[j, 1]
        out[i, 0] = x[i, 0] - s / leave[i]
        out[i, 1] = x[i, 1] - t / leave[i]


@kernel
def residual_both(offsets, targets, chances, x, rewards, nodes, first, last, leave, out):
    """As `residual`, of two columns side by side."""
    for a in range(first, last):
        i = nodes[a]
        s = rewards[0]
        t = rewards[1]
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            s += chances[e] * (x[j, 0] - x[i, 0])
            t += chances[e] * (x[j, 1] - x[i, 1])
        out[i, 0] = s / leave[i]
        out[i, 1] = t / leave[i]


@kernel
def products(nodes, first, last, x, y, out):
    """Inner products of the columns of x and y (n, 2) into out (2,)."""
    s = 0.0
    t = 0.0
    for a in range(first, last):
        i = nodes[a]
        s += x[i, 0] * y[i, 0]
        t += x[i, 1] * y[i, 1]
    out[0] = s
    out[1] = t


@kernel
def advance_both(nodes, first, last, x, p, r, t, alpha, omega, lack, size):
    """x += alpha p + omega r and r -= omega t, by columns; the largest of r and x into `lack` and `size` (2,)."""
    lack[:] = 0.0
    size[:] = 0.0
    for a in range(first, last):
        i = nodes[a]
        for k in range(2):
            x[i, k] += alpha[k] * p[i, k] + omega[k] * r[i, k]
            r[i, k] -= omega[k] * t[i, k]
            lack[k] = max(lack[k], abs(r[i, k]))
            size[k] = max(size[k], abs(x[i, k]))


@kernel
def bicgstab_both(offsets, targets, chances, x, rewards, nodes, first, last, leave, goal, limit, r, shadow, p, v, t):
    """As `bicgstab`, of two columns side by side (n, 2); one that has come to its goal stays while the other goes on."""
    rho, alpha, omega = np.ones(2), np.ones(2), np.ones(2)
    beta, along, square, lack, size = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    live = np.ones(2, np.bool_)
    residual_both(offsets, targets, chances, x, rewards, nodes, first, last, leave, r)
    begun = np.zeros(2)
    for a in range(first, last):
        i = nodes[a]
        for k in range(2):
            shadow[i, k] = r[i, k]
            begun[k] = max(begun[k], abs(r[i, k]))
    for count in range(limit):
        products(nodes, first, last, shadow, r, along)
        for k in range(2):
            if live[k]:
                if along[k] == 0.0 or omega[k] == 0.0:
                    return -count - 1
                beta[k] = along[k] / rho[k] * (alpha[k] / omega[k])
                rho[k] = along[k]
            else:
                beta[k] = 0.0
        for a in range(first, last):
            i = nodes[a]
            for k in range(2):
                p[i, k] = r[i, k] + beta[k] * (p[i, k] - omega[k] * v[i, k])
        multiply_both(offsets, targets, chances, nodes, first, last, leave, p, v)
        products(nodes, first, last, shadow, v, along)
        for k in range(2):
            if live[k] and along[k] == 0.0:
                return -count - 1
            alpha[k] = rho[k] / along[k] if live[k] else 0.0
        for a in range(first, last):
            i = nodes[a]
            for k in range(2):
                r[i, k] -= alpha[k] * v[i, k]
        multiply_both(offsets, targets, chances, nodes, first, last, leave, r, t)
        products(nodes, first, last, t, r, along)
        products(nodes, first, last, t, t, square)
        for k in range(2):
            omega[k] = along[k] / square[k] if live[k] and square[k] > 0.0 else 0.0
        advance_both(nodes, first, last, x, p, r, t, alpha, omega, lack, size)
        for k in range(2):
            if live[k] and not lack[k] < np.inf:
                return -count - 1
            if lack[k] <= goal * size[k]:
                live[k] = False
            elif live[k] and (count == 24 or count == 59):  # is it on the way?
                done = np.log(begun[k] / lack[k])
                if done <= 0.0 or np.log(lack[k] / (goal * size[k])) > done * (limit - count) / (count + 1):
                    return -count - 1
        if not (live[0] or live[1]):
            return count + 1
    return -limit


@kernel
def certify(offsets, targets, chances, closed, values, ratio):
    """How far the values can be from the true ones: ``ratio[k]`` times the expected time of the state; returns whether that holds.

    With h the computed time, w = (I - Q) h > 0 and r the residual of a column, |x - x*| <= max(|r| / w) h, since (I - Q)^-1 >= 0. Rounding
    in r and w is bounded term by term. Where some w is not positive nothing is known: False.

    Parameters
    ----------
    closed : (n,) bool
    values : (K, n); the last row is h
    ratio : (K,), given as zeros
    """
    columns = values.shape[0]
    h = values[columns - 1]
    for i in range(offsets.shape[0] - 1):
        if closed[i]:
            continue
        gamma = 1.01 * (offsets[i + 1] - offsets[i] + 4) * UNIT
        w = 0.0
        size = 0.0
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if j != i:
                w += chances[e] * (h[i] - h[j])
                size += chances[e] * (h[i] + abs(h[j]))
        off = max(abs(w - 1.0) + gamma * (size + 1.0), 0.0)
        w -= gamma * size
        if not w > 0.0:
            return False
        ratio[columns - 1] = max(ratio[columns - 1], off / w)
        for k in range(columns - 1):
            x = values[k]
            own = x[i]
            lack = 0.0
            size = 0.0
            for e in range(offsets[i], offsets[i + 1]):
                j = targets[e]
                if j != i:
                    lack += chances[e] * (x[j] - own)
                    size += chances[e] * (abs(x[j]) + abs(own))
            ratio[k] = max(ratio[k], (abs(lack) + gamma * size) / w)
    for k in range(columns):
        ratio[k] *= 1.0 + 16.0 * UNIT
    return True


@kernel
def advance(offsets, targets, chances, now, then):
    """Distribution over states one cycle on, into `then` (n,)."""
    then[:] = 0.0
    for i in range(offsets.shape[0] - 1):
        mass = now[i]
        if mass != 0.0:
            for e in range(offsets[i], offsets[i + 1]):
                then[targets[e]] += mass * chances[e]


@kernel
def mark_reachable(offsets, targets, reached, queue):
    """Extend `reached` (n,) bool over all edges; queue (n,) int32 is scratch."""
    tail = 0
    for i in range(reached.shape[0]):
        if reached[i]:
            queue[tail] = i
            tail += 1
    head = 0
    while head < tail:
        i = queue[head]
        head += 1
        for e in range(offsets[i], offsets[i + 1]):
            j = targets[e]
            if not reached[j]:
                reached[j] = True
                queue[tail] = j
                tail += 1


@kernel
def widest_level(offsets, targets, inside, root, seen, queue):
    """Most states of a component that are equally far from `root`; inside (n,) bool, seen (n,) bool given as False, queue (n,) scratch."""
    queue[0] = root
    seen[root] = True
    head = 0
    tail = 1
    widest = 1
    while head < tail:
        end = tail
        widest = max(widest, end - head)
        while head < end:
            i = queue[head]
            head += 1
            for e in range(offsets[i], offsets[i + 1]):
                j = targets[e]
                if inside[j] and not seen[j]:
                    seen[j] = True
                    queue[tail] = j
                    tail += 1
    return widest
