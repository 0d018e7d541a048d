"""The compiled reading of percepts: expressions over percepts and places, and the states that their values are."""

from __future__ import annotations

import numpy as np

from ...compilation import kernel_group
from ..expressions.kernels import run

kernel = kernel_group(_nrt=False)

FIRST_EDGE, CARD, ROUND, CLIP, TARGET = range(5)
"""Columns of the table of readings: first of its edges, -1 for named states; how many states; whether circular, whether beyond the edges
is in the bins at the ends; and the row of states that it goes to."""


@kernel
def state_of(value, edges, reading):
    """The state that a value is; -2 where it is none."""
    card, first = reading[CARD], reading[FIRST_EDGE]
    if first < 0:
        return np.int64(value) if -1.0 <= value < card else -2
    low, high = edges[first], edges[first + card]
    if reading[ROUND]:
        value = low + np.mod(value - low, high - low)
    if reading[CLIP]:
        value = min(max(value, low), high)
    if value < low or value > high:
        return -2
    below, above = first, first + card + 1  # the first edge beyond the value is among these
    while below < above:
        middle = (below + above) // 2
        if edges[middle] <= value:
            below = middle + 1
        else:
            above = middle
    return min(below - first - 1, card - 1)


@kernel
def read_states(code, constants, start, rows, stack, readings, edges, told, values, shown, states):
    """What a model is told: False where something has no finite value, or is no state.

    Parameters
    ----------
    code, constants, start : arrays
        Of expressions: of reading s its value, then whether it was made.
    rows : (W, N) float
        What the expressions read.
    stack : scratch
    readings : (n, 5) int
        Columns as named above.
    edges : (.,) float
        Of all bins, one behind the other.
    told : (n,) bool
        Which readings the model may be told.
    values : (n, W) float, overwritten
    shown : (n, W) bool, overwritten
    states : (m, W) int
        -1 everywhere; overwritten where a reading was made.
    """
    for w in range(rows.shape[0]):
        for s in range(readings.shape[0]):
            value = run(code, constants, start[2 * s], start[2 * s + 1], rows[w], stack)
            made = run(code, constants, start[2 * s + 1], start[2 * s + 2], rows[w], stack)
            if not (np.isfinite(value) and np.isfinite(made)):
                return False
            if readings[s, FIRST_EDGE] < 0:
                value = np.rint(value)
            values[s, w] = value
            shown[s, w] = made >= 0.5 and told[s]
            if shown[s, w]:
                state = state_of(value, edges, readings[s])
                if state < -1:
                    return False
                if state >= 0:
                    states[readings[s, TARGET], w] = state
    return True
