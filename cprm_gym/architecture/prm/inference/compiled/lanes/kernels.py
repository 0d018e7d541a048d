"""The interpreter of inference plans for eight rows at a time.

As in `kernels`, a row is one component of one agent, and a plan a list of operations on a heap. Here an entry of the heap is eight
numbers, one of each row, so that whatever the lengths of loops are eight rows are computed by one instruction or two: a product with a
band of five entries (`bands`) would by itself be too short to gain by such instructions. Tables are not copied eight times: they stand
apart, addresses below their number are theirs.

What is observed moves the address of a table for every row on its own. Those operations are few and small, and go row by row.

An addition of eight numbers is written out: all are read before the first is written, which tells the compiler that it need not
fear that the operands overlap.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.compilation import kernel_group

from ..kernels import (
    A_SHIFT,
    A_SHIFT_END,
    B_SHIFT,
    B_SHIFT_END,
    BAND_ROWS,
    BAND_SUM,
    CONTRACT,
    DIVIDE,
    EXTENT,
    EXTRA,
    KIND,
    LOOP,
    LOOP_END,
    NORMALISE,
    SIZE,
    STRIDE_A,
    STRIDE_B,
    STRIDE_C,
    A,
    B,
    C,
)

kernel = kernel_group(side_by_side=True)
inlined = kernel_group(side_by_side=True, no_cpython_wrapper=True, forceinline=True)

LANES = 8
LARGEST = 1 << 14
"""Entries of a heap, without tables, up to which eight of it stay in the cache."""


@inlined
def add_scaled(to, c, heap, a, x):
    """``to[c] += heap[a] * x``."""
    y0, y1 = to[c, 0] + heap[a, 0] * x, to[c, 1] + heap[a, 1] * x
    y2, y3 = to[c, 2] + heap[a, 2] * x, to[c, 3] + heap[a, 3] * x
    y4, y5 = to[c, 4] + heap[a, 4] * x, to[c, 5] + heap[a, 5] * x
    y6, y7 = to[c, 6] + heap[a, 6] * x, to[c, 7] + heap[a, 7] * x
    to[c, 0], to[c, 1], to[c, 2], to[c, 3] = y0, y1, y2, y3
    to[c, 4], to[c, 5], to[c, 6], to[c, 7] = y4, y5, y6, y7


@inlined
def add_product(to, c, left, a, right, b):
    """``to[c] += left[a] * right[b]``."""
    y0, y1 = to[c, 0] + left[a, 0] * right[b, 0], to[c, 1] + left[a, 1] * right[b, 1]
    y2, y3 = to[c, 2] + left[a, 2] * right[b, 2], to[c, 3] + left[a, 3] * right[b, 3]
    y4, y5 = to[c, 4] + left[a, 4] * right[b, 4], to[c, 5] + left[a, 5] * right[b, 5]
    y6, y7 = to[c, 6] + left[a, 6] * right[b, 6], to[c, 7] + left[a, 7] * right[b, 7]
    to[c, 0], to[c, 1], to[c, 2], to[c, 3] = y0, y1, y2, y3
    to[c, 4], to[c, 5], to[c, 6], to[c, 7] = y4, y5, y6, y7


@inlined
def multiply(heap, a, scale):
    """``heap[a] *= scale[0]``."""
    y0, y1, y2, y3 = heap[a, 0] * scale[0, 0], heap[a, 1] * scale[0, 1], heap[a, 2] * scale[0, 2], heap[a, 3] * scale[0, 3]
    y4, y5, y6, y7 = heap[a, 4] * scale[0, 4], heap[a, 5] * scale[0, 5], heap[a, 6] * scale[0, 6], heap[a, 7] * scale[0, 7]
    heap[a, 0], heap[a, 1], heap[a, 2], heap[a, 3] = y0, y1, y2, y3
    heap[a, 4], heap[a, 5], heap[a, 6], heap[a, 7] = y4, y5, y6, y7


@kernel
def products(heap, tables, a, b, c, n, ja, jb, jc):
    """``heap[c + j jc] += a[j ja] * b[j jb]`` for j < `n`, where neither is moved by what was observed.

    An address below the number of entries of `tables` is one of them.
    """
    constants = tables.shape[0]
    if a >= constants and b >= constants:
        for j in range(n):
            add_product(heap, c + j * jc, heap, a - constants + j * ja, heap, b - constants + j * jb)
    elif a >= constants:
        for j in range(n):
            add_scaled(heap, c + j * jc, heap, a - constants + j * ja, tables[b + j * jb])
    elif b >= constants:
        for j in range(n):
            add_scaled(heap, c + j * jc, heap, b - constants + j * jb, tables[a + j * ja])
    else:
        for j in range(n):
            x = tables[a + j * ja] * tables[b + j * jb]
            for lane in range(LANES):
                heap[c + j * jc, lane] += x


@kernel
def gather(side, tables, moves, operand, at, n, stride):
    """Put the entries of a table that each row looks at side by side: ``side[j] = tables[at + its move + j stride]``."""
    for lane in range(LANES):
        first = at + moves[lane, operand]
        for j in range(n):
            side[j, lane] = tables[first + j * stride]


@kernel
def moved_products(heap, tables, left, right, moves, known, a, b, c, n, ja, jb, jc):
    """As `products`, where addresses of tables are moved by ``moves[:, 0]`` and ``moves[:, 1]`` for each row.

    left, right : (n, 8) scratch
    known : (2,) int, the addresses whose entries they hold already, -1 for none
    """
    constants = tables.shape[0]
    if a < constants and known[0] != a:
        gather(left, tables, moves, 0, a, n if ja != 0 else 1, ja)
        known[0] = a
    if b < constants and known[1] != b:
        gather(right, tables, moves, 1, b, n if jb != 0 else 1, jb)
        known[1] = b
    ka, kb = 1 if ja != 0 else 0, 1 if jb != 0 else 0
    if a < constants and b < constants:
        for j in range(n):
            add_product(heap, c + j * jc, left, j * ka, right, j * kb)
    elif a < constants:
        for j in range(n):
            add_product(heap, c + j * jc, left, j * ka, heap, b - constants + j * jb)
    else:
        for j in range(n):
            add_product(heap, c + j * jc, heap, a - constants + j * ja, right, j * kb)


@kernel
def band_rows(heap, constant, rows, values, total, a, b, c, n, count, sa, sb):
    """As `kernels.band_rows`; total : (1, 8) scratch."""
    total[0, :] = 0.0
    for k in range(count):
        at = b + k * sb
        add_scaled(total, 0, heap, at, 1.0)
        row = a + k * sa
        first = rows[row, 2]
        to = c + rows[row, 0]
        for j in range(rows[row, 1] - rows[row, 0]):
            add_scaled(heap, to + j, heap, at, values[first + j])
    for j in range(n):
        add_scaled(heap, c + j, total, 0, constant)


@kernel
def moved_band_rows(heap, constant, rows, values, moves, a, b, c, n, count, sa, sb):
    """As `band_rows`, row by row."""
    for lane in range(LANES):
        total = 0.0
        for k in range(count):
            x = heap[b + k * sb, lane]
            total += x
            row = a + moves[lane, 0] + k * sa
            first = rows[row, 2]
            to = c + rows[row, 0]
            for j in range(rows[row, 1] - rows[row, 0]):
                heap[to + j, lane] += values[first + j] * x
        total *= constant
        for j in range(n):
            heap[c + j, lane] += total


@kernel
def band_sum(heap, rows, values, moves, moved, a, b, c, n, sa):
    """As `kernels.band_sum`."""
    if not moved:
        first = rows[b, 2] - rows[b, 0]
        for k in range(rows[b, 0], rows[b, 1]):
            for j in range(n):
                add_scaled(heap, c + j, heap, a + k * sa + j, values[first + k])
        return
    for lane in range(LANES):
        row = b + moves[lane, 1]
        first = rows[row, 2] - rows[row, 0]
        for k in range(rows[row, 0], rows[row, 1]):
            for j in range(n):
                heap[c + j, lane] += heap[a + k * sa + j, lane] * values[first + k]


@kernel
def contract(heap, tables, kind, constant, rows, values, total, left, right, known, moves, moved, a, b, c, loops, first, last, counter):
    """As `kernels.contract`; with a table of bands the other operand stands on the heap."""
    constants = tables.shape[0]
    n, ja, jb, jc = 1, 0, 0, 0
    if last > first:
        n, ja, jb, jc = loops[last - 1, 0], loops[last - 1, 1], loops[last - 1, 2], loops[last - 1, 3]
    inside = 1 if kind == CONTRACT else 2  # loops of the kernels below
    outer = max(last - first - inside, 0)
    for d in range(outer):
        counter[d] = 0
    while True:
        if kind == BAND_ROWS:
            count, sa, sb = loops[last - 2, EXTENT], loops[last - 2, STRIDE_A], loops[last - 2, STRIDE_B]
            if moved:
                moved_band_rows(heap, constant, rows, values, moves, a, b - constants, c, n, count, sa, sb)
            else:
                band_rows(heap, constant, rows, values, total, a, b - constants, c, n, count, sa, sb)
        elif kind == BAND_SUM:
            band_sum(heap, rows, values, moves, moved, a - constants, b, c, n, loops[last - 2, STRIDE_A])
        elif moved:
            moved_products(heap, tables, left, right, moves, known, a, b, c, n, ja, jb, jc)
        else:
            products(heap, tables, a, b, c, n, ja, jb, jc)
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
def divide(heap, tables, a, b, c, size):
    """``heap[c] = a / b``, 0 where b is 0."""
    constants = tables.shape[0]
    for i in range(size):
        for lane in range(LANES):
            x = tables[a + i] if a < constants else heap[a - constants + i, lane]
            y = tables[b + i] if b < constants else heap[b - constants + i, lane]
            heap[c + i, lane] = x / y if y > 0.0 else 0.0


@kernel
def normalise(heap, at, size, total, scale):
    """Scale each row's table to sum to one (a sum of 0 leaves it alone); into `total`, (1, 8), the sums that they had."""
    total[0, :] = 0.0
    for i in range(at, at + size):
        add_scaled(total, 0, heap, i, 1.0)
    for lane in range(LANES):
        scale[0, lane] = 1.0 / total[0, lane] if total[0, lane] > 0.0 else 1.0
    for i in range(at, at + size):
        multiply(heap, i, scale)


@kernel
def entropy(heap, at, size, total):
    """``-sum p ln p`` of each row's table, in nats, into `total`, (1, 8); 0 ln 0 = 0."""
    for lane in range(LANES):
        h = 0.0
        for i in range(at, at + size):
            if heap[i, lane] > 0.0:
                h -= heap[i, lane] * np.log(heap[i, lane])
        total[0, lane] = h


@kernel
def note_moves(op, shifts, values, moves):
    """How far what was observed moves the addresses of both operands for each row; whether rows differ in it."""
    differ = False
    for lane in range(LANES):
        moves[lane, 0] = 0
        moves[lane, 1] = 0
        for s in range(op[A_SHIFT], op[A_SHIFT_END]):
            moves[lane, 0] += shifts[s, 0] * values[lane, shifts[s, 1]]
        for s in range(op[B_SHIFT], op[B_SHIFT_END]):
            moves[lane, 1] += shifts[s, 0] * values[lane, shifts[s, 1]]
        differ |= moves[lane, 0] != moves[0, 0] or moves[lane, 1] != moves[0, 1]
    return differ


@kernel
def operate(
    op, constant, rows, banded, loops, shifts, counter, heap, tables, values, moves, known, total, scale, left, right, sums, entropies
):
    """One operation of a plan for eight rows; sums, entropies : (8, .)."""
    constants = tables.shape[0]
    c = op[C] - constants
    kind = op[KIND]
    if kind == CONTRACT or kind >= BAND_ROWS:
        a, b, moved = op[A], op[B], False
        if op[A_SHIFT_END] > op[A_SHIFT] or op[B_SHIFT_END] > op[B_SHIFT]:
            moved = note_moves(op, shifts, values, moves)
            if not moved:  # all alike: the table is looked at in one place
                a, b = a + moves[0, 0], b + moves[0, 1]
        if kind != BAND_SUM:
            for i in range(c, c + op[SIZE]):
                for lane in range(LANES):
                    heap[i, lane] = 0.0
        known[:] = -1
        contract(
            heap,
            tables,
            kind,
            constant,
            rows,
            banded,
            total,
            left,
            right,
            known,
            moves,
            moved,
            a,
            b,
            c,
            loops,
            op[LOOP],
            op[LOOP_END],
            counter,
        )
    elif kind == DIVIDE:
        divide(heap, tables, op[A], op[B], c, op[SIZE])
    elif kind == NORMALISE:
        normalise(heap, c, op[SIZE], total, scale)
        for lane in range(LANES):
            sums[lane, op[EXTRA]] = total[0, lane]
    else:
        slot = op[EXTRA]
        entropy(heap, op[A] - constants, op[SIZE], total)
        for lane in range(LANES):
            entropies[lane, abs(slot) - 1] += total[0, lane] if slot > 0 else -total[0, lane]


@kernel
def read(heap, constants, values, message_at, message, columns, evidence, previous, soft, soft_at, lane, b, w):
    """Put message, observed values and likelihood vectors of a row into its lane."""
    row = b * evidence.shape[1] + w
    for i in range(message.shape[1]):
        heap[message_at - constants + i, lane] = message[row, i]
    for k in range(columns.shape[1]):
        v = previous[columns[b, k, 0], w] if columns[b, k, 1] else evidence[columns[b, k, 0], w]
        values[lane, k] = columns[b, k, 2] if v < 0 else v
    for q in range(soft_at.shape[1]):
        for i in range(soft_at[b, q, 1]):
            heap[soft_at[b, q, 2] - constants + i, lane] = soft[w, soft_at[b, q, 0] + i]


@kernel
def write(heap, constants, outputs, new_message, marginals, sums, lane, row):
    """Copy out what a row's lane holds."""
    for p in range(outputs.shape[0]):
        at, size, column = outputs[p, 1] - constants, outputs[p, 2], outputs[p, 3]
        if outputs[p, 0] == 0:
            total = sums[lane, outputs[p, 4]] if outputs[p, 4] >= 0 else 1.0
            scale = 1.0 / total if total > 0.0 else 0.0
            for i in range(size):
                new_message[row, column + i] = heap[at + i, lane] * scale
        else:
            for i in range(size):
                marginals[row, column + i] = heap[at + i, lane]


@kernel
def run_plan(
    ops, band_constants, rows, banded, loops, shifts, counter, heap, tables, values, moves, message_at, message, columns, evidence,
    previous, soft, soft_at, outputs, new_message, marginals, sums, entropies, increment, first, last,
):  # fmt: skip
    """As `kernels.run_plan`, eight rows at a time; the last eight are filled up with the last row.

    heap : (H, 8) float scratch
    tables : (C,) float
    values : (8, V) int scratch
    moves : (8, 2) int scratch
    """
    constants, batch = tables.shape[0], evidence.shape[1]
    total, scale = np.empty((1, LANES)), np.empty((1, LANES))
    longest = 1
    for k in range(loops.shape[0]):
        longest = max(longest, loops[k, EXTENT])
    left, right = np.empty((longest, LANES)), np.empty((longest, LANES))
    known = np.empty(2, np.int64)
    lane_sums = np.empty((LANES, sums.shape[1]))
    lane_entropies = np.empty((LANES, entropies.shape[1]))
    share = last - first
    count = columns.shape[0] * share
    for low in range(0, count, LANES):
        for lane in range(LANES):
            k = min(low + lane, count - 1)
            read(heap, constants, values, message_at, message, columns, evidence, previous, soft, soft_at, lane,
                 k // share, first + k % share)  # fmt: skip
        lane_entropies[:] = 0.0
        for o in range(ops.shape[0]):
            operate(ops[o], band_constants[o], rows, banded, loops, shifts, counter, heap, tables, values, moves, known, total, scale,
                    left, right, lane_sums, lane_entropies)  # fmt: skip
        for lane in range(min(LANES, count - low)):
            k = low + lane
            w = first + k % share
            row = k // share * batch + w
            for r in range(sums.shape[1]):
                sums[row, r] = lane_sums[lane, r]
                increment[w] += np.log(lane_sums[lane, r])
            for e in range(entropies.shape[1]):
                entropies[row, e] = lane_entropies[lane, e]
            write(heap, constants, outputs, new_message, marginals, lane_sums, lane, row)
