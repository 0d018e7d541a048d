"""Kernels from actions to commands."""

from __future__ import annotations

from ...simulator.state import CommandKind
from . import kernel

DASH_KIND, KICK_KIND = int(CommandKind.DASH), int(CommandKind.KICK)


@kernel
def write_hybrid(kind, params, neck, view, scales, neck_scale, nothing, rows, out):
    """Commands of hybrid actions; (-1, -1), or the part (0 kind, 1 params, 2 neck, 3 view) and flat index of the first bad entry.

    kind, view : (W, A); params : (W, A, 4); neck : (W, A, 1); scales : (kinds, 4); nothing : (1,) COMMAND; out : (W, 22) COMMAND
    """
    agents = kind.shape[1]
    for n in range(kind.shape[0]):
        for k in range(agents):
            flat = n * agents + k
            if not 0 <= kind[n, k] < scales.shape[0]:
                return 0, flat
            for i in range(4):
                if not abs(params[n, k, i]) <= 1.0:
                    return 1, 4 * flat + i
            if not abs(neck[n, k, 0]) <= 1.0:
                return 2, flat
            if not 0 <= view[n, k] <= 3:
                return 3, flat
            j = rows[k]
            out[n, j] = nothing[0]
            c = out[n, j]
            c.kind = kind[n, k]
            c.a = params[n, k, 0] * scales[kind[n, k], 0]
            c.b = params[n, k, 1] * scales[kind[n, k], 1]
            c.c = params[n, k, 2] * scales[kind[n, k], 2]
            c.d = params[n, k, 3] * scales[kind[n, k], 3]
            if neck[n, k, 0] != 0.0:
                c.turn_neck = neck[n, k, 0] * neck_scale
            c.view_width = view[n, k]
    return -1, -1


@kernel
def fill(c, kind, power, direction, neck):
    """One command from a kind, a power and one direction that every kind uses in its own way."""
    c.kind = kind
    if kind == DASH_KIND or kind == KICK_KIND:
        c.a = power
        c.b = direction if kind == KICK_KIND else 0.0
    else:
        c.a = direction
        c.b = 0.0
    if neck != 0.0:
        c.turn_neck = neck


@kernel
def write_discrete(index, kinds, powers, directions, necks, nothing, rows, out):
    """Commands of discrete actions (W, A, 4); -1, or the flat index of the first entry that chooses nothing."""
    agents = index.shape[1]
    for n in range(index.shape[0]):
        for k in range(agents):
            i = index[n, k]
            flat = 4 * (n * agents + k)
            if not 0 <= i[0] < kinds.shape[0]:
                return flat
            if not 0 <= i[1] < powers.shape[0]:
                return flat + 1
            if not 0 <= i[2] < directions.shape[0]:
                return flat + 2
            if not 0 <= i[3] < necks.shape[0]:
                return flat + 3
            out[n, rows[k]] = nothing[0]
            fill(out[n, rows[k]], kinds[i[0]], powers[i[1]], directions[i[2]], necks[i[3]])
    return -1


@kernel
def write_box(values, kinds, nothing, rows, out):
    """Commands of box actions (W, A, kinds + 3); -1, or the flat index of the first entry outside -1 to 1."""
    agents, size, count = values.shape[1], values.shape[2], kinds.shape[0]
    for n in range(values.shape[0]):
        for k in range(agents):
            best = 0
            for i in range(size):
                if not abs(values[n, k, i]) <= 1.0:
                    return (n * agents + k) * size + i
                if i < count and values[n, k, i] > values[n, k, best]:
                    best = i
            out[n, rows[k]] = nothing[0]
            power, direction, neck = 50.0 * (values[n, k, count] + 1.0), 180.0 * values[n, k, count + 1], 90.0 * values[n, k, count + 2]
            fill(out[n, rows[k]], kinds[best], power, direction, neck)
    return -1
