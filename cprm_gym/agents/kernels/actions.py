"""From the commands that a net sent out to actions of the environment, world by world."""

from __future__ import annotations

import numpy as np

from ...compilation import kernel_group

kernel = kernel_group(_nrt=False)

COMMAND, KIND, FIRST, COUNT = range(4)
"""Columns of the table of body commands: column of `fired`, `CommandKind`, first of its parameters, how many."""


@kernel
def within(x, low, high):
    """`x`, at least `low` and at most `high`."""
    return min(max(x, low), high)


@kernel
def norm(angle):
    """Degrees, -180 to less than 180."""
    return (angle + 180.0) % 360.0 - 180.0


@kernel
def argument(value, column, w):
    """A parameter of a command of copy `w`; 0 for one that the net does not say."""
    return value[w, column] if column >= 0 else 0.0


@kernel
def act(body, columns, scales, side, limits, fired, value, speed, neck, turn_kind, kind, params, turn_neck, view, turned):
    """Actions of every copy; all but `turned` begin at 0.

    Parameters
    ----------
    body : (n, 4) int
        Columns as named above; a later one counts more.
    columns : (m,) int
        Column of `value` of every parameter, -1 for none.
    scales : (m,) float
        What 1 means for it.
    side : (3, 2) int
        For ``turn_neck``, ``look`` and ``change_view`` the column of `fired`, -1 for none, and that of its parameter.
    limits : (4,) float
        Inertia of the body, least and largest angle of the neck, degrees, and degrees that 1 means for it.
    fired : (W, .) bool
    value : (W, .) float
    speed, neck : (W,) float
        m / cycle and degrees, as felt.
    turn_kind : int
        The `CommandKind` of a turn.
    kind, params, turn_neck, view : (W,), (W, 4), (W, 1), (W,)
        Overwritten.
    turned : (W,) float
        Degrees that each body turns, overwritten.
    """
    for w in range(len(kind)):
        turned[w] = 0.0
        for c in range(len(body)):
            if fired[w, body[c, COMMAND]]:
                kind[w] = body[c, KIND]
                for p in range(4):
                    params[w, p] = 0.0
                for p in range(body[c, COUNT]):
                    at = body[c, FIRST] + p
                    params[w, p] = within(argument(value, columns[at], w) / scales[at], -1.0, 1.0)
                if body[c, KIND] == turn_kind:
                    turned[w] = argument(value, columns[body[c, FIRST]], w) / (1.0 + limits[0] * speed[w])
        if side[0, 0] >= 0 and fired[w, side[0, 0]]:
            turn_neck[w, 0] = within(argument(value, side[0, 1], w) / limits[3], -1.0, 1.0)
        if side[1, 0] >= 0 and fired[w, side[1, 0]]:
            wanted = within(norm(argument(value, side[1, 1], w) - turned[w]), limits[1], limits[2])
            turn_neck[w, 0] = within((wanted - neck[w]) / limits[3], -1.0, 1.0)
        if side[2, 0] >= 0 and fired[w, side[2, 0]]:
            view[w] = int(np.rint(argument(value, side[2, 1], w)))
