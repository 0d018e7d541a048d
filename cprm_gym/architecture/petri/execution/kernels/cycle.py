"""The cycle of a net, for many copies at once.

`cycle` runs the rule that stands in words at the top of this package. One copy is one row of every state array. Between calls the state
arrays are all that counts: the scratch arrays hold nothing of worth, and the cache nothing that does not follow from the state.

A cycle looks only at what is another than it was: slots are compared with those of the cycle before, the math places that read a changed
slot are evaluated, and the conditions of transitions that read one are looked at. What may fire stands in sets in the order in which it
fires (`bit_sets`): so a firing costs the same in a net of ten transitions and of thousands.

Compiled without numba's reference counts (``_nrt=False``): nothing is allocated here, and counting the views of rows cost four
times the work itself.
"""

from __future__ import annotations

import numpy as np

from .....compilation import kernel_group
from .arrays import CLOCKS, DETAIL, FULL, LIVELOCK, LOOP, LOOPED, OK, START, UNDEFINED
from .bit_sets import clear, least, put
from .clocks import adjust_clocks, clocks_fit, is_due
from .firing import fire
from .held_objects import hold, select
from .renewal import compare, enable, mark_all, meets, renew_enabled, renew_math

kernel = kernel_group(_nrt=False)
inner = kernel_group(_nrt=False, no_cpython_wrapper=True)  # called by other kernels only
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)  # too short for the cost of a call


@inlined
def draw(random, w):
    """A number in [0, 1) from the stream of copy `w` (splitmix64)."""
    random[w] += np.uint64(0x9E3779B97F4A7C15)
    z = random[w]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.float64(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@inlined
def next_immediate(p, s, c, w):
    """The enabled immediate transition that fires next, -1 for none."""
    rank = least(c.ready[w], p.options[0].ready_tops)
    if rank < 0:
        return -1
    first, last = p.options[0].immediate + rank, p.options[0].immediate_end
    chosen = p.lists[first]
    if p.options[0].random == 1:
        priority = p.transitions[chosen].priority
        total = 0.0
        for i in range(first, last):
            u = p.lists[i]
            if c.enabled[w, u] == 1 and p.transitions[u].priority == priority:
                total += p.transitions[u].weight
        left = draw(s.random, w) * total
        for i in range(first, last):
            u = p.lists[i]
            if c.enabled[w, u] == 1 and p.transitions[u].priority == priority and left >= 0.0:
                chosen = u
                left -= p.transitions[u].weight
    return chosen


@inlined
def next_due(p, x):
    """The timed transition that is due next at this instant, -1 for none."""
    rank = least(x.due, p.options[0].due_tops)
    return p.lists[p.options[0].timed + rank] if rank >= 0 else -1


@inlined
def start_clocks(p, s, c, x, w):
    """When the copy is quiet for the first time in a cycle: clocks of what is enabled now start, and it is seen what is due."""
    x.counts[START] = 1
    clear(x.due)
    for i in range(p.options[0].timed, p.options[0].timed_end):
        t = p.lists[i]
        now = c.enabled[w, t] == 1
        if not clocks_fit(p, s, x, w, t, now) and adjust_clocks(p, s, x, w, t, now) != OK:
            return CLOCKS
        if now and is_due(p, s, w, t):
            put(x.due, p.options[0].due_tops, p.transitions[t].rank)
    return OK


@inlined
def prepare(p, s, c, out, x, w):
    """The part of a cycle before the first firing: clocks advance, objects are selected, math is evaluated."""
    for k in range(s.clock.shape[1]):
        if s.clock[w, k] >= 0:
            s.clock[w, k] += 1
    for k in range(out.fired.shape[1]):
        out.fired[w, k] = False
    for g in range(out.winner.shape[1]):
        out.winner[w, g] = -1
    for t in range(out.overruled.shape[1]):
        out.overruled[w, t] = False
    for o in range(p.objects.shape[0]):
        hold(p, s, w, o, s.held[w, o])
    passes = 1 + p.options[0].early
    for turn in range(passes):
        if turn == passes - 1:
            for z in range(p.selections.shape[0]):
                hold(p, s, w, p.selections[z].object, select(p, s, x, w, z))
        if c.valid[w]:
            compare(p, c, x, w)
        else:
            mark_all(p, c, x, w)
        if not renew_math(p, s, c, x, w):
            return UNDEFINED
    renew_enabled(p, s, c, x, w)
    return OK


@inlined
def advance(p, s, c, out, x, w):
    """One cycle of copy `w`, after its inputs and beliefs have been written."""
    status = prepare(p, s, c, out, x, w)
    x.counts[START] = 0
    count = 0  # immediate firings in a row
    while status == OK:
        t = next_immediate(p, s, c, w)
        if t >= 0:
            count += 1
            beyond = count - p.options[0].most - 1
            if beyond >= LOOP:
                return LIVELOCK
            if beyond >= 0:  # go on for a while, to see what goes round
                x.loop[beyond] = t
                x.counts[LOOPED] = beyond + 1
        elif count > p.options[0].most:
            return LIVELOCK
        else:
            count = 0
            if x.counts[START] == 0 and start_clocks(p, s, c, x, w) != OK:
                return CLOCKS
            t = next_due(p, x)
            if t < 0:
                return OK
        status = fire(p, s, c, out, x, w, t)
    return status


@inner
def forget(c, x, w):
    """Let the next cycle of copy `w` work out everything: this one ended in the middle."""
    c.valid[w] = False
    clear(x.stale)
    clear(x.unsure)


@kernel
def cycle(p, s, c, out, x, failed):
    """One cycle of every copy. Returns the first status that is not OK; ``failed`` is then the copy and the detail."""
    first = OK
    for w in range(s.row.shape[0]):
        status = advance(p, s, c, out, x, w)
        if status == OK:
            s.cycle[w] += 1
            continue
        forget(c, x, w)
        if status == FULL:
            return FULL
        if first == OK:
            first = status
            failed[0] = w
            failed[1] = x.counts[DETAIL]
    return first


@kernel
def fire_one(p, s, c, out, x, w, t):
    """Fire `t` of copy `w` by hand."""
    for u in range(p.transitions.shape[0]):
        enable(p, c, w, u, meets(p, s.row[w], u))
    x.counts[START] = 0
    status = fire(p, s, c, out, x, w, t)
    forget(c, x, w)
    return status


@kernel
def write(row, slots, columns, data, failed):
    """Copy columns of `data` into slots of every copy; False at the first number that is not finite, said in `failed`."""
    for w in range(row.shape[0]):
        for i in range(slots.shape[0]):
            value = data[w, columns[i]]
            if not np.isfinite(value):
                failed[0] = w
                failed[1] = i
                return False
            row[w, slots[i]] = value
    return True
