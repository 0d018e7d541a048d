"""The compiled interpreter of inference plans.

A plan (`plans.py`) is a list of small tensor operations on one flat array, the *heap*, which holds the constant tables and
the intermediate results of one row. A row is one component of one agent: rows are independent, so the interpreter runs the
whole plan for one row, whose tables stay in the cache, before it turns to the next.

Evidence never changes a plan. An observed variable moves the address of a table (``base += stride * value``), and an
unobserved reading is one more state, `missing`, for which its table holds ones.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.compilation import kernel_group

kernel = kernel_group()

CONTRACT, DIVIDE, NORMALISE, ENTROPY, BAND_ROWS, BAND_SUM, IN_ORDER = 0, 1, 2, 3, 4, 5, 6
"""What an operation does; `IN_ORDER` is `CONTRACT` whose sums are taken one term after the other, as `lanes` takes them."""

KIND, A, B, C, SIZE, LOOP, LOOP_END, A_SHIFT, A_SHIFT_END, B_SHIFT, B_SHIFT_END, EXTRA = range(12)
"""Columns of the table of operations."""

EXTENT, STRIDE_A, STRIDE_B, STRIDE_C = range(4)
"""Columns of the table of loops, the outermost loop of an operation first."""


@kernel
def axpy(heap, a, b, c, n, count, sa, sb, sc):
    """``heap[c + k sc + j] += heap[a + k sa + j] * heap[b + k sb]`` for k < `count`, j < `n`."""
    for k in range(count):
        x = heap[b + k * sb]
        if x != 0.0:
            ai = np.uint64(a + k * sa)
            ci = np.uint64(c + k * sc)
            for j in range(np.uint64(n)):
                heap[ci + j] += heap[ai + j] * x


@kernel
def multiply_add(heap, a, b, c, n, count, sa, sb, sc):
    """``heap[c + k sc + j] += heap[a + k sa + j] * heap[b + k sb + j]``."""
    for k in range(count):
        ai = np.uint64(a + k * sa)
        bi = np.uint64(b + k * sb)
        ci = np.uint64(c + k * sc)
        for j in range(np.uint64(n)):
            heap[ci + j] += heap[ai + j] * heap[bi + j]


@kernel
def dot(heap, a, b, c, n, count, sa, sb, sc, step_b):
    """``heap[c + k sc] += sum_j heap[a + k sa + j] * heap[b + k sb + j step_b]``, in four partial sums."""
    for k in range(count):
        ai = np.uint64(a + k * sa)
        bi = np.uint64(b + k * sb)
        s0 = 0.0
        s1 = 0.0
        s2 = 0.0
        s3 = 0.0
        full = np.uint64(n - n % 4)
        if step_b == 0:
            for j in range(np.uint64(0), full, np.uint64(4)):
                s0 += heap[ai + j]
                s1 += heap[ai + j + np.uint64(1)]
                s2 += heap[ai + j + np.uint64(2)]
                s3 += heap[ai + j + np.uint64(3)]
            for j in range(full, np.uint64(n)):
                s0 += heap[ai + j]
            heap[c + k * sc] += ((s0 + s1) + (s2 + s3)) * heap[bi]
        else:
            for j in range(np.uint64(0), full, np.uint64(4)):
                s0 += heap[ai + j] * heap[bi + j]
                s1 += heap[ai + j + np.uint64(1)] * heap[bi + j + np.uint64(1)]
                s2 += heap[ai + j + np.uint64(2)] * heap[bi + j + np.uint64(2)]
                s3 += heap[ai + j + np.uint64(3)] * heap[bi + j + np.uint64(3)]
            for j in range(full, np.uint64(n)):
                s0 += heap[ai + j] * heap[bi + j]
            heap[c + k * sc] += (s0 + s1) + (s2 + s3)


@kernel
def dot_in_order(heap, a, b, c, n, count, sa, sb, sc, ja, jb):
    """``heap[c + k sc] += sum_j heap[a + k sa + j ja] * heap[b + k sb + j jb]``, one term after the other; four sums side by side."""
    k = 0
    while sc != 0 and k + 4 <= count:
        ai, bi, ci = a + k * sa, b + k * sb, c + k * sc
        s0, s1, s2, s3 = heap[ci], heap[ci + sc], heap[ci + 2 * sc], heap[ci + 3 * sc]
        for _ in range(n):
            s0 += heap[ai] * heap[bi]
            s1 += heap[ai + sa] * heap[bi + sb]
            s2 += heap[ai + 2 * sa] * heap[bi + 2 * sb]
            s3 += heap[ai + 3 * sa] * heap[bi + 3 * sb]
            ai, bi = ai + ja, bi + jb
        heap[ci], heap[ci + sc], heap[ci + 2 * sc], heap[ci + 3 * sc] = s0, s1, s2, s3
        k += 4
    while k < count:
        ai, bi = a + k * sa, b + k * sb
        s0 = heap[c + k * sc]
        for _ in range(n):
            s0 += heap[ai] * heap[bi]
            ai, bi = ai + ja, bi + jb
        heap[c + k * sc] = s0
        k += 1


@kernel
def strided(heap, a, b, c, n, count, sa, sb, sc, ja, jb, jc):
    """``heap[c + k sc + j jc] += heap[a + k sa + j ja] * heap[b + k sb + j jb]``, any strides."""
    for k in range(count):
        for j in range(n):
            heap[c + k * sc + j * jc] += heap[a + k * sa + j * ja] * heap[b + k * sb + j * jb]


@kernel
def band_rows(heap, constant, rows, values, a, b, c, n, count, sa, sb):
    """``heap[c + j] += T[a + k sa, j] * heap[b + k sb]`` summed over k < `count`, where row r of T is `constant` outside of
    ``rows[r]`` (first column, first after it, where its values stand)."""
    total = 0.0
    for k in range(count):
        x = heap[b + k * sb]
        if x == 0.0:
            continue
        total += x
        row = a + k * sa
        at = np.uint64(rows[row, 2])
        to = np.uint64(c + rows[row, 0])
        for j in range(np.uint64(rows[row, 1] - rows[row, 0])):
            heap[to + j] += values[at + j] * x
    total *= constant
    for j in range(np.uint64(n)):
        heap[np.uint64(c) + j] += total


@kernel
def band_sum(heap, rows, values, a, b, c, n, sa):
    """``heap[c + j] += heap[a + k sa + j] * V[b, k]`` summed over the columns k of the band of row `b` of a table."""
    at = rows[b, 2] - rows[b, 0]
    for k in range(rows[b, 0], rows[b, 1]):
        x = values[at + k]
        ai = np.uint64(a + k * sa)
        for j in range(np.uint64(n)):
            heap[np.uint64(c) + j] += heap[ai + j] * x


@kernel
def contract(heap, kind, constant, rows, values, a, b, c, loops, first, last, counter):
    """Add the sum of products that the loops ``loops[first:last]`` describe to the table at `c`.

    kind : `CONTRACT` or `IN_ORDER`
        Or `BAND_ROWS` or `BAND_SUM`, where the table at `a` or `b` is one of bands and its address the number of a row.
    counter : (at least last - first,) int scratch
    """
    n, ja, jb, jc = 1, 0, 0, 0
    count, sa, sb, sc = 1, 0, 0, 0
    if last > first:
        n, ja, jb, jc = loops[last - 1, 0], loops[last - 1, 1], loops[last - 1, 2], loops[last - 1, 3]
    if last > first + 1:
        count, sa, sb, sc = loops[last - 2, 0], loops[last - 2, 1], loops[last - 2, 2], loops[last - 2, 3]
    outer = max(last - first - 2, 0)
    for d in range(outer):
        counter[d] = 0
    while True:
        if kind == BAND_ROWS:
            band_rows(heap, constant, rows, values, a, b, c, n, count, sa, sb)
        elif kind == BAND_SUM:
            band_sum(heap, rows, values, a, b, c, n, sa)
        elif jc == 1 and ja == 1 and jb == 0:
            axpy(heap, a, b, c, n, count, sa, sb, sc)
        elif jc == 1 and ja == 1 and jb == 1:
            multiply_add(heap, a, b, c, n, count, sa, sb, sc)
        elif jc == 0 and kind == IN_ORDER:
            dot_in_order(heap, a, b, c, n, count, sa, sb, sc, ja, jb)
        elif jc == 0 and ja == 1 and jb <= 1:
            dot(heap, a, b, c, n, count, sa, sb, sc, jb)
        else:
            strided(heap, a, b, c, n, count, sa, sb, sc, ja, jb, jc)
        d = outer - 1
        while d >= 0:
            counter[d] += 1
            a += loops[first + d, STRIDE_A]
            b += loops[first + d, STRIDE_B]
            c += loops[first + d, STRIDE_C]
            if counter[d] < loops[first + d, EXTENT]:
                break
            a -= loops[first + d, STRIDE_A] * loops[first + d, EXTENT]
            b -= loops[first + d, STRIDE_B] * loops[first + d, EXTENT]
            c -= loops[first + d, STRIDE_C] * loops[first + d, EXTENT]
            counter[d] = 0
            d -= 1
        if d < 0:
            return


@kernel
def normalise(heap, at, size):
    """Scale the table at `at` to sum to one, in place; returns the sum it had (0 leaves the table alone)."""
    total = 0.0
    for i in range(at, at + size):
        total += heap[i]
    scale = 1.0 / total if total > 0.0 else 1.0
    for i in range(at, at + size):
        heap[i] *= scale
    return total


@kernel
def entropy(heap, at, size):
    """``-sum p ln p`` of the table at `at`, in nats; 0 ln 0 = 0."""
    h = 0.0
    for i in range(at, at + size):
        if heap[i] > 0.0:
            h -= heap[i] * np.log(heap[i])
    return h


@kernel
def read_row(heap, values, columns, evidence, previous, soft, soft_at, w):
    """Put the observed values of agent `w` into `values`, and its likelihood vectors on the heap."""
    for k in range(columns.shape[0]):
        v = previous[columns[k, 0], w] if columns[k, 1] else evidence[columns[k, 0], w]
        values[k] = columns[k, 2] if v < 0 else v
    for q in range(soft_at.shape[0]):
        for i in range(soft_at[q, 1]):
            heap[soft_at[q, 2] + i] = soft[w, soft_at[q, 0] + i]


@kernel
def operate(op, constant, rows, banded, loops, shifts, counter, heap, values, sums, entropies):
    """One operation of a plan for one row."""
    a, b, c, size = op[A], op[B], op[C], op[SIZE]
    for s in range(op[A_SHIFT], op[A_SHIFT_END]):
        a += shifts[s, 0] * values[shifts[s, 1]]
    for s in range(op[B_SHIFT], op[B_SHIFT_END]):
        b += shifts[s, 0] * values[shifts[s, 1]]
    kind = op[KIND]
    if kind == CONTRACT or kind >= BAND_ROWS:
        if kind != BAND_SUM:  # that adds to what an operation before has left
            for i in range(c, c + size):
                heap[i] = 0.0
        contract(heap, kind, constant, rows, banded, a, b, c, loops, op[LOOP], op[LOOP_END], counter)
    elif kind == DIVIDE:
        for i in range(size):
            heap[c + i] = heap[a + i] / heap[b + i] if heap[b + i] > 0.0 else 0.0
    elif kind == NORMALISE:
        sums[op[EXTRA]] = normalise(heap, c, size)
    else:
        slot = op[EXTRA]
        entropies[abs(slot) - 1] += entropy(heap, a, size) if slot > 0 else -entropy(heap, a, size)


@kernel
def run_plan(
    ops, constants, rows, banded, loops, shifts, counter, heap, values, message_at, message, columns, evidence, previous, soft, soft_at,
    outputs, new_message, marginals, sums, entropies, increment, first, last,
):  # fmt: skip
    """Run a plan for every object and the agents from `first` to before `last`.

    Parameters
    ----------
    ops : (O, 12) int
        Operations, columns as named above; `EXTRA` is the slot of a sum, or the sign and slot of an entropy.
    constants : (O,) float
        What stands outside of the bands of an operation's table.
    rows : (R, 3) int
        Of tables of bands: first column of the band, first after it, where its values stand.
    banded : (B,) float
        Values in bands, beyond the constant.
    loops : (L, 4) int
    shifts : (S, 2) int
        Stride and index into `values`: how an observed variable moves the address of a table.
    counter : (D,) int scratch
    heap : (H,) float
        Constants and room for one row.
    values : (V,) int scratch
        Values of the observed variables of the row, in the order of `columns`.
    message_at : int
        Where the row's incoming message goes on the heap.
    message : (B * W, M) float
        Incoming message, row ``b * W + w`` for object b and agent w.
    columns : (B, V, 3) int
        Variable (row of `evidence` or `previous`), 1 if it is of the previous slice, and the value a missing reading stands for.
    evidence, previous : (variables, W) int
        Values of this and of the previous slice; -1 where not observed.
    soft : (W, K) float
        Likelihood vectors.
    soft_at : (B, Q, 3) int
        Column in `soft`, length and place on the heap of each likelihood vector that a row needs.
    outputs : (P, 5) int
        What to copy out: 0 for `new_message` or 1 for `marginals`, place on the heap, size, column, and the slot of the sum by
        which to divide (-1: none).
    new_message : (B * W, M') float
    marginals : (B * W, N) float
    sums : (B * W, R) float
        Normalising constants.
    entropies : (B * W, E) float
    increment : (W,) float
        The logarithm of every normalising constant of an agent is added to it.
    first, last : int
        Agents. Threads may share all arrays but the scratch and the heap.
    """
    batch = evidence.shape[1]
    for k in range(columns.shape[0] * (last - first)):
        b = k // (last - first)
        w = first + k % (last - first)
        row = b * batch + w
        for i in range(message.shape[1]):
            heap[message_at + i] = message[row, i]
        read_row(heap, values, columns[b], evidence, previous, soft, soft_at[b], w)
        for e in range(entropies.shape[1]):
            entropies[row, e] = 0.0
        for o in range(ops.shape[0]):
            operate(ops[o], constants[o], rows, banded, loops, shifts, counter, heap, values, sums[row], entropies[row])
        for r in range(sums.shape[1]):
            increment[w] += np.log(sums[row, r])
        for p in range(outputs.shape[0]):
            at, size, column = outputs[p, 1], outputs[p, 2], outputs[p, 3]
            if outputs[p, 0] == 0:
                total = sums[row, outputs[p, 4]] if outputs[p, 4] >= 0 else 1.0
                scale = 1.0 / total if total > 0.0 else 0.0
                for i in range(size):
                    new_message[row, column + i] = heap[at + i] * scale
            else:
                for i in range(size):
                    marginals[row, column + i] = heap[at + i]


@kernel
def draw(table, rows, likelihood, uniforms, weights, out):
    """Draw a variable for every particle from ``P(x | parents) L(x)`` and multiply its weight by the sum over x.

    Where that sum is zero the particle is drawn from the CPD alone, and its weight is zero.

    Parameters
    ----------
    table : (R, K) float
        Rows of the CPD.
    rows : (W, P) int
        Row that each particle's parents select.
    likelihood : (W, K) float
        Likelihood of the readings that depend on this variable alone.
    uniforms : (W, P) float
        In [0, 1).
    weights : (W, P) float, multiplied
    out : (W, P) int, overwritten
    """
    card = table.shape[1]
    for w in range(rows.shape[0]):
        for p in range(rows.shape[1]):
            row = rows[w, p]
            total = 0.0
            for k in range(card):
                total += table[row, k] * likelihood[w, k]
            possible = total > 0.0
            threshold = uniforms[w, p] * (total if possible else 1.0)
            reached = 0.0
            value = card - 1
            for k in range(card):
                reached += table[row, k] * likelihood[w, k] if possible else table[row, k]
                if reached > threshold:
                    value = k
                    break
            out[w, p] = value
            weights[w, p] *= total


@kernel
def histogram(values, weights, out):
    """Add each particle's weight to the entry of its value: ``out[w, values[w, p]] += weights[w, p]``."""
    for w in range(values.shape[0]):
        for p in range(values.shape[1]):
            out[w, values[w, p]] += weights[w, p]


@kernel
def systematic(weights, offsets, out):
    """Systematic resampling: ancestors of evenly spaced points in the cumulated weights.

    weights : (W, P) float, each row sums to one
    offsets : (W,) float in [0, 1)
    out : (W, N) int, overwritten
    """
    count = out.shape[1]
    for w in range(weights.shape[0]):
        reached = weights[w, 0]
        ancestor = 0
        for n in range(count):
            point = (n + offsets[w]) / count
            while reached < point and ancestor < weights.shape[1] - 1:
                ancestor += 1
                reached += weights[w, ancestor]
            out[w, n] = ancestor
