"""State spaces of timed nets in their environment, cycle by cycle.

A node is a row of 16-bit integers: tokens of the places, cells of what the environment sets, clocks of the timed transitions, phase.

* Cell 0 of a variable: not asked for yet in this cycle; -1: must be asked anew before anything else; -2: likewise, and it was known
  before; 1, 2, ...: which cell.
* Clock 0: off; c > 0: shows c - 1 cycles. The clocks of one transition stand oldest first. When the cycle is over, c < 0: stands (age
  memory) and shows -c - 1 cycles. Within an instant which of them run follows from the tokens: as many as the transition is enabled
  times, the oldest.
* Phase `INSTANT`: something may still happen at this instant; `BOUNDARY`: the cycle is over, clocks of enabled transitions run.

The environment is asked only for what the net looks at, and its answer holds until the cycle ends. What a firing changes (a math place that
reads tokens, a selected object that is taken) is asked for anew; the transitions whose clocks that may stop are marked by negative clocks
until the answer is there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....compilation import kernel_group
from .table import enter, find, hash_row

kernel = kernel_group()
inlined = kernel_group(forceinline=True)  # a call costs much more than they do: the arrays of the net are passed one by one

INSTANT, BOUNDARY = 0, 1
IMMEDIATE, TIMED, OUTSIDE = 0, 1, 2
"""Classes of transitions; those of the outside may fire at any instant and pre-empt nothing."""
ENABLING, AGE, RESAMPLING = 0, 1, 2
ASKING, FIRING, DUE, QUIET, OVER, STOPPING = 0, 1, 2, 3, 4, 5
"""What a node is: asks for a cell before an immediate transition can be judged; immediate transitions are enabled; a timed
transition is due; nothing more happens at this instant; the cycle is over; clocks stop whose transitions the environment has
disabled."""
DONE, CHUNK, GROW, OVERFLOW = 0, 1, 2, 3


class TimedNet(NamedTuple):
    """Arrays of a timed net. P places, X variables of the environment, C timed transitions."""

    n_places: int
    n_cells: int
    n_own: int  # transitions of the net; those of the outside follow
    guard_start: np.ndarray  # (T + 1,)
    guard: np.ndarray  # (., 3) place, tokens needed, inhibitor threshold (0 none)
    cell_start: np.ndarray  # (T + 1,)
    cell: np.ndarray  # (., 2) variable, bit mask of the cells that satisfy
    take_start: np.ndarray  # (T + 1,)
    take: np.ndarray  # (., 2) place, tokens
    put_start: np.ndarray  # (T + 1,)
    put: np.ndarray  # (., 2) place, tokens
    set_start: np.ndarray  # (T + 1,)
    set: np.ndarray  # (., 2) place, value
    write_start: np.ndarray  # (T + 1,)
    write: np.ndarray  # (., 2) variable, new cell
    immediate: np.ndarray  # transitions, by priority then declaration
    group_end: np.ndarray  # ends of the priority groups in `immediate`
    timed: np.ndarray  # (C,) transitions, by priority then declaration
    clock_start: np.ndarray  # (C + 1,) columns of their clocks
    delay: np.ndarray  # (C,)
    memory: np.ndarray  # (C,) ENABLING, AGE, RESAMPLING
    touches: np.ndarray  # (T, C) bool: takes tokens that the other needs, where persistence looks at the marking in between
    shifts: np.ndarray  # (C,) bool: enabling memory, and reads a variable that firings change
    shifting: bool  # whether there are such
    outside: np.ndarray  # transitions of the outside
    cells: np.ndarray  # (X,) number of cells
    first_label: np.ndarray  # (X,) label of "variable x is in cell 1"
    fixed: np.ndarray  # (X,) bool: keeps its cell for ever
    stop_label: int
    end_label: int
    tick_label: int
    limit: int  # tokens beyond which a place counts as unbounded
    joint: np.ndarray  # (X,) where the record of each variable's group begins, -1 none; (X,) 1 if what was known of it is forgotten by
    # firings that change it; records: group, columns, rows, 1 if what is in no row cannot be, the columns of a node, the rows
    losing: bool  # whether any is forgotten


@inlined
def holds(net, t, row):
    """Whether the tokens allow transition `t`."""
    for k in range(net.guard_start[t], net.guard_start[t + 1]):
        v = row[net.guard[k, 0]]
        if v < net.guard[k, 1]:
            return False
        below = net.guard[k, 2]
        if below != 0 and v >= below:
            return False
    return True


@inlined
def cells_hold(net, t, row):
    """1 if the cells allow transition `t`, 0 if not, -1 - x if that depends on variable x, not asked yet."""
    answer = 1
    for k in range(net.cell_start[t], net.cell_start[t + 1]):
        x = net.cell[k, 0]
        c = row[net.n_places + x]
        if c <= 0:
            answer = -1 - x
        elif (net.cell[k, 1] >> c) & 1 == 0:
            return 0
    return answer


@kernel
def unknown_cell(net, t, row):
    """A variable that transition `t` reads and that is not asked for yet, -1 if there is none."""
    for k in range(net.cell_start[t], net.cell_start[t + 1]):
        if row[net.n_places + net.cell[k, 0]] == 0:
            return net.cell[k, 0]
    return -1


@inlined
def degree(net, t, row):
    """How often the tokens in `row` let `t` be enabled at once; test and inhibitor arcs aside."""
    least = 1 if net.take_start[t] == net.take_start[t + 1] else net.limit
    for k in range(net.take_start[t], net.take_start[t + 1]):
        least = min(least, row[net.take[k, 0]] // net.take[k, 1])
    return least


@inlined
def keep_oldest(net, c, row, keep):
    """Forget all clocks of timed transition `c` but the `keep` oldest."""
    for k in range(net.clock_start[c] + keep, net.clock_start[c + 1]):
        row[k] = 0


@inlined
def adjust(net, c, row, was):
    """Stop the clocks that timed transition `c` (enabling memory) has too many of; `was`: it was enabled before the firing."""
    t = net.timed[c]
    if holds(net, t, row) and cells_hold(net, t, row) != 0:
        keep_oldest(net, c, row, degree(net, t, row))
    elif was:
        keep_oldest(net, c, row, 0)


@kernel
def adjust_marked(net, row):
    """`adjust` what waited for an answer of the environment, now that none is missing; negative clocks: it was enabled."""
    for x in range(net.n_cells):
        if row[net.n_places + x] < 0:
            return
    for c in range(net.timed.shape[0]):
        if net.shifts[c]:
            was = row[net.clock_start[c]] < 0
            for k in range(net.clock_start[c], net.clock_start[c + 1]):
                row[k] = abs(row[k])
            adjust(net, c, row, was)


@inlined
def adjust_clocks(net, c, u, row, out, between):
    """The clocks of timed transition `c` after transition `u` has led from the node `row` to `out`.

    between : its tokens with those taken and none put yet
    """
    t, low, high = net.timed[c], net.clock_start[c], net.clock_start[c + 1]
    if net.memory[c] == RESAMPLING and u < net.n_own:  # what is written from outside is no firing
        keep_oldest(net, c, out, 0)
        return
    if t == u:  # its oldest clock has done its work
        for k in range(low, high - 1):
            out[k] = out[k + 1]
        out[high - 1] = 0
    if net.memory[c] == AGE:
        return
    if net.touches[u, c]:
        keep_oldest(net, c, out, degree(net, t, between) if holds(net, t, between) else 0)
    if not net.shifts[c]:
        adjust(net, c, out, True)
    elif holds(net, t, row) and cells_hold(net, t, row) == 1:
        for k in range(low, high):
            out[k] = -out[k]


@kernel
def fire(net, u, row, out, between):
    """Write the node after transition `u` to `out`; False if a place holds too many tokens."""
    for i in range(row.shape[0]):
        out[i] = row[i]
    for k in range(net.take_start[u], net.take_start[u + 1]):
        out[net.take[k, 0]] -= net.take[k, 1]
    for i in range(net.n_places + net.n_cells):
        between[i] = out[i]
    for k in range(net.put_start[u], net.put_start[u + 1]):
        p = net.put[k, 0]
        out[p] += net.put[k, 1]
        if out[p] > net.limit:
            return False
    for k in range(net.set_start[u], net.set_start[u + 1]):
        out[net.set[k, 0]] = net.set[k, 1]
    for k in range(net.write_start[u], net.write_start[u + 1]):
        x = net.write[k, 0]
        known = row[net.n_places + x] > 0 or row[net.n_places + x] == -2
        lost = known and net.losing and net.write[k, 1] < 0 and net.joint[net.n_cells + x] == 1
        out[net.n_places + x] = -2 if lost else net.write[k, 1]
    for c in range(net.timed.shape[0]):
        if out[net.clock_start[c]] != 0:
            adjust_clocks(net, c, u, row, out, between)
    if net.shifting:
        adjust_marked(net, out)
    return True


@kernel
def allowed(joint, at, n_places, row, first, last):
    """Whether one of the rows `first` to `last` - 1 of the group whose record begins at `at` agrees with all that is known in a node."""
    width = joint[at + 1]
    for r in range(first, last):
        agrees = True
        for k in range(width):
            column = joint[at + 4 + k]
            value = row[column]
            if value != joint[at + 4 + width * (r + 1) + k] and (value > 0 or column < n_places):
                agrees = False
                break
        if agrees:
            return True
    return False


@kernel
def ask(net, x, row, out, labels, n):
    """One successor for every cell that variable `x` can be in; returns how many successors there are now."""
    at = net.joint[x]
    cut = at >= 0 and net.joint[at + 3] == 1
    for c in range(1, net.cells[x] + 1):
        for i in range(row.shape[0]):
            out[n, i] = row[i]
        out[n, net.n_places + x] = c
        if cut and not allowed(net.joint, at, net.n_places, out[n], 0, net.joint[at + 2]):
            continue
        if net.shifting:
            adjust_marked(net, out[n])
        labels[n] = net.first_label[x] + c - 1
        n += 1
    return n


@kernel
def outside_moves(net, row, out, labels, n, between):
    """What the outside may do at this instant; returns how many successors there are now, -1 if a place overflows."""
    for k in range(net.outside.shape[0]):
        t = net.outside[k]
        if holds(net, t, row):
            if not fire(net, t, row, out[n], between):
                return -1 - t
            labels[n] = t
            n += 1
    return n


@kernel
def enabled_clocks(net, c, row):
    """How many clocks of timed transition `c` run in a node in which nothing else happens; its cells are known."""
    t = net.timed[c]
    if holds(net, t, row) and cells_hold(net, t, row) == 1:
        return min(degree(net, t, row), net.clock_start[c + 1] - net.clock_start[c])
    return 0


@kernel
def end_cycle(net, row, out):
    """Write the node at the end of the cycle to `out`: clocks of the enabled run, the environment's answers are forgotten."""
    for i in range(row.shape[0]):
        out[i] = row[i]
    for c in range(net.timed.shape[0]):
        running = net.clock_start[c] + enabled_clocks(net, c, row)
        for k in range(net.clock_start[c], net.clock_start[c + 1]):
            if k < running:
                out[k] = max(row[k], 1)
            else:
                out[k] = -row[k] if net.memory[c] == AGE and row[k] > 1 else 0
    for x in range(net.n_cells):
        if not net.fixed[x]:
            out[net.n_places + x] = 0
    out[row.shape[0] - 1] = BOUNDARY


@kernel
def begin_cycle(net, row, out):
    """Write the first node of the next cycle to `out`: running clocks advance."""
    for i in range(row.shape[0]):
        out[i] = row[i]
    for c in range(net.timed.shape[0]):
        for k in range(net.clock_start[c], net.clock_start[c + 1]):
            out[k] = min(row[k] + 1, net.delay[c] + 1) if row[k] > 0 else -row[k]
    out[row.shape[0] - 1] = INSTANT


@kernel
def to_ask(net, row):
    """A variable that must be known before anything fires, -1 if there is none.

    What a firing has changed comes first, then what decides whether a clock runs that a firing may stop.
    """
    for x in range(net.n_cells):
        if row[net.n_places + x] < 0:
            return x
    if net.shifting:
        for c in range(net.timed.shape[0]):
            if net.shifts[c] and row[net.clock_start[c]] != 0:
                x = unknown_cell(net, net.timed[c], row)
                if x >= 0:
                    return x
    return -1


@kernel
def stop_clocks(net, row, out):
    """Write the node without the clocks of what is not enabled to `out`, once no immediate transition is; False if none stops."""
    found = False
    for i in range(row.shape[0]):
        out[i] = row[i]
    for c in range(net.timed.shape[0]):
        if net.shifts[c] and row[net.clock_start[c]] != 0:
            running = net.clock_start[c] + enabled_clocks(net, c, row)
            for k in range(running, net.clock_start[c + 1]):
                found |= out[k] != 0
                out[k] = 0
    return found


@kernel
def successors(net, row, out, labels, between, ties):
    """Every node one step away. Returns their number (-1 - t if firing t overflows) and what the node is."""
    if row[row.shape[0] - 1] == BOUNDARY:
        begin_cycle(net, row, out[0])
        labels[0] = net.tick_label
        return 1, OVER
    x = to_ask(net, row)
    if x >= 0:
        return ask(net, x, row, out, labels, 0), ASKING
    begin = 0
    for g in range(net.group_end.shape[0]):
        n = 0
        for k in range(begin, net.group_end[g]):
            t = net.immediate[k]
            if holds(net, t, row):
                able = cells_hold(net, t, row)
                if able < 0:
                    return ask(net, -1 - able, row, out, labels, 0), ASKING
                if able == 1:
                    if not fire(net, t, row, out[n], between):
                        return -1 - t, FIRING
                    labels[n] = t
                    n += 1
        if n > 0:
            return outside_moves(net, row, out, labels, n, between), FIRING
        begin = net.group_end[g]
    if net.shifting and stop_clocks(net, row, out[0]):
        labels[0] = net.stop_label
        return outside_moves(net, row, out, labels, 1, between), STOPPING
    first = -1
    for c in range(net.timed.shape[0]):
        t = net.timed[c]
        if row[net.clock_start[c]] > net.delay[c] and holds(net, t, row):
            able = cells_hold(net, t, row)
            if able < 0:
                return ask(net, -1 - able, row, out, labels, 0), ASKING
            if able == 1:
                if first < 0:
                    first = t
                else:
                    ties[first, t] = True
    if first >= 0:
        if not fire(net, first, row, out[0], between):
            return -1 - first, DUE
        labels[0] = first
        return outside_moves(net, row, out, labels, 1, between), DUE
    for c in range(net.timed.shape[0]):
        t = net.timed[c]
        if holds(net, t, row):
            able = cells_hold(net, t, row)
            if able < 0:
                n = ask(net, -1 - able, row, out, labels, 0)
                return outside_moves(net, row, out, labels, n, between), QUIET
    end_cycle(net, row, out[0])
    labels[0] = net.end_label
    return outside_moves(net, row, out, labels, 1, between), QUIET


@kernel
def expand(net, rows, parents, kinds, offsets, targets, labels, table, bits, out, step, between, ties, progress, chunk):
    """Expand nodes in order until nothing is left, `chunk` are done, the arrays are full or a place overflows.

    Parameters
    ----------
    rows : (capacity, S) int16; parents : (capacity,) int32; kinds : (capacity,) int8; offsets : (capacity + 1,) int64
    targets, labels : (edges,) int32
    table : (2 ** bits,) uint32
    out, step : scratch for the successors of one node
    between : (S,) int16 scratch
    ties : (T, T) bool
        Pairs of timed transitions due at one instant; updated.
    progress : (4,) int64
        0 next node to expand, 1 number of nodes, 2 number of edges, 3 the transition that overflowed.
    """
    i = progress[0]
    last = i + chunk
    nodes = progress[1]
    at = progress[2]
    room = min(rows.shape[0], table.shape[0] * 6 // 10) - out.shape[0]
    edge_room = targets.shape[0] - out.shape[0]
    code = DONE
    while i < nodes:
        if i >= last:
            code = CHUNK
            break
        if nodes > room or at > edge_room:
            code = GROW
            break
        n, kind = successors(net, rows[i], out, step, between, ties)
        if n < 0:
            progress[3] = -1 - n
            code = OVERFLOW
            break
        kinds[i] = kind
        for k in range(n):
            h = hash_row(out, k)
            j = find(rows, table, bits, out, k, h)
            if j < 0:
                enter(table, bits, -1 - j, h, nodes)
                for s in range(out.shape[1]):
                    rows[nodes, s] = out[k, s]
                parents[nodes] = i
                j = nodes
                nodes += 1
            targets[at] = j
            labels[at] = step[k]
            at += 1
        i += 1
        offsets[i] = at
    progress[0] = i
    progress[1] = nodes
    progress[2] = at
    return code


@kernel
def conflicts(net, rows, kinds, offsets, targets, labels, own, expanded, found, where):
    """Pairs of immediate transitions of equal priority whose order matters.

    Parameters
    ----------
    own : int
        Labels below are the net's transitions.
    found : (T, T) int8, given as zeros
        ``found[t, u]``: bit 1 if firing t disables u, 2 if both orders end in different markings, 4 if something is asked in between.
    where : (T, T) int64
        A node at which it happens.
    """
    for i in range(expanded):
        if kinds[i] != FIRING:
            continue
        for a in range(offsets[i], offsets[i + 1]):
            t = labels[a]
            if t >= own:
                continue
            for b in range(offsets[i], offsets[i + 1]):
                u = labels[b]
                if u >= own or u == t or found[t, u] & 1:
                    continue
                j = targets[a]
                if not holds(net, u, rows[j]) or cells_hold(net, u, rows[j]) == 0:
                    found[t, u] |= 1
                    where[t, u] = i
                elif u > t and found[t, u] & 2 == 0:
                    k = targets[b]
                    if j >= expanded or k >= expanded:
                        continue
                    x = -1
                    y = -2
                    for e in range(offsets[j], offsets[j + 1]):
                        if labels[e] == u:
                            x = targets[e]
                    for e in range(offsets[k], offsets[k + 1]):
                        if labels[e] == t:
                            y = targets[e]
                    if (x < 0 and kinds[j] == ASKING) or (y < 0 and kinds[k] == ASKING):
                        if found[t, u] == 0:
                            found[t, u] = 4
                            where[t, u] = i
                    elif x != y:
                        found[t, u] |= 2
                        where[t, u] = i


@kernel
def unsure_edges(net, sure, starts, variable, rows, offsets, targets, labels, found):
    """Edges by which the environment answers what it may not be able to answer, into `found` (E,) bool.

    Parameters
    ----------
    sure : (K,) bool
        Rows that can be for sure, of all groups.
    starts : (G,) int64
        Where those of each group begin.
    variable : (L,) int64
        Which variable a label is about, -1 none.
    """
    for i in range(offsets.shape[0] - 1):
        for e in range(offsets[i], offsets[i + 1]):
            x = variable[labels[e]]
            if x < 0:
                continue
            at = net.joint[x]
            if rows[i, net.n_places + x] == -2:
                found[e] = True
            elif at >= 0:
                found[e] = True
                first = starts[net.joint[at]]
                for r in range(net.joint[at + 2]):
                    if sure[first + r] and allowed(net.joint, at, net.n_places, rows[targets[e]], r, r + 1):
                        found[e] = False
                        break
