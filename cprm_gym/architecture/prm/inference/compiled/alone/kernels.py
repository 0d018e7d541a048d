"""The interpreter of all plans of a step, for one agent.

One call does what `lanes.run_plan` does for each group of components, in the same order of additions, so that an agent alone gets the
same numbers bit by bit as among others; eight rows at a time would be seven too many.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.compilation import kernel_group

from ..kernels import operate

kernel = kernel_group()

OPERATIONS, OPERATIONS_END, COPIES, COPIES_END, VALUES, VALUES_END, SOFT, SOFT_END, OUTPUTS, OUTPUTS_END, SUMS, SUMS_END = range(12)
"""Columns of the table of rows: where in each of the other tables a component's entries are."""


@kernel
def read_row(row, heap, values, copies, columns, soft_at, before, evidence, previous, soft):
    """Put a component's incoming message and likelihood vectors on the heap, and what was observed into `values`."""
    for k in range(row[COPIES], row[COPIES_END]):
        source, to = copies[k, 0], copies[k, 1]
        for i in range(copies[k, 2]):
            heap[to + i] = before[source + i]
    for k in range(row[VALUES], row[VALUES_END]):
        v = previous[columns[k, 0], 0] if columns[k, 1] else evidence[columns[k, 0], 0]
        values[k - row[VALUES]] = columns[k, 2] if v < 0 else v
    for k in range(row[SOFT], row[SOFT_END]):
        for i in range(soft_at[k, 1]):
            heap[soft_at[k, 2] + i] = soft[0, soft_at[k, 0] + i]


@kernel
def write_row(row, heap, outputs, message, marginals, sums):
    """Copy out a component's message, divided by its sum, and its marginals."""
    for p in range(row[OUTPUTS], row[OUTPUTS_END]):
        at, size, to = outputs[p, 1], outputs[p, 2], outputs[p, 3]
        if outputs[p, 0] == 0:
            total = sums[outputs[p, 4]] if outputs[p, 4] >= 0 else 1.0
            scale = 1.0 / total if total > 0.0 else 0.0
            for i in range(size):
                message[to + i] = heap[at + i] * scale
        else:
            for i in range(size):
                marginals[to + i] = heap[at + i]


@kernel
def run_step(
    ops,
    constants,
    rows,
    banded,
    loops,
    shifts,
    heap,
    counter,
    values,
    components,
    copies,
    columns,
    soft_at,
    outputs,
    before,
    evidence,
    previous,
    soft,
    message,
    marginals,
    sums,
):
    """Run the plans of all components of a step; returns ln P(readings of the slice | earlier ones).

    Parameters
    ----------
    ops, constants, rows, banded, loops, shifts, heap
        As `kernels.run_plan` takes them, of all plans that there are.
    counter, values : int scratch
    components : (R, 12) int
        Columns as named above.
    copies : (., 3) int
        Where an entry of `before` goes on the heap: first, place, how many.
    columns, soft_at : (., 3) int
        As in `kernels.run_plan`.
    outputs : (., 5) int
        As there, with columns and slots in the arrays of all components.
    before, message : (.,) float
        The arrays of the belief before and after, one behind the other.
    evidence, previous : (variables, 1) int
    soft : (1, K) float
    marginals, sums : (.,) float
    """
    increment = 0.0
    none = np.empty(0)
    for r in range(components.shape[0]):
        row = components[r]
        read_row(row, heap, values, copies, columns, soft_at, before, evidence, previous, soft)
        own = sums[row[SUMS] : row[SUMS_END]]
        for o in range(row[OPERATIONS], row[OPERATIONS_END]):
            operate(ops[o], constants[o], rows, banded, loops, shifts, counter, heap, values, own, none)
        for s in range(own.shape[0]):
            increment += np.log(own[s])
        write_row(row, heap, outputs, message, marginals, sums)
    return increment
