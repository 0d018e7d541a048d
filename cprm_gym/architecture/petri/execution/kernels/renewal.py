"""What follows from a marking is worked out again where the marking has changed: math places, and which transitions are enabled.

Slots are compared with the bits that they had, so whoever writes to a state need not say so. The math places that read a changed slot are
evaluated, in their order; if their value is another one, what reads *them* follows. At last the conditions of those transitions are
looked at that read a slot which has changed.
"""

from __future__ import annotations

from .....compilation import kernel_group
from ....expressions.kernels import run_inlined
from .arrays import DETAIL
from .bit_sets import drop, lowest, note, put

inner = kernel_group(_nrt=False, no_cpython_wrapper=True)  # called by other kernels only
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)  # too short for the cost of a call

BLOCK = 16  # slots compared at a time: without a branch between them they are compared several at once


@inlined
def meets(p, row, t):
    """Whether the marking `row` enables transition `t`."""
    for i in range(p.transitions[t].cond, p.transitions[t].cond_end):
        m = row[p.conditions[i].place]
        if m < p.conditions[i].low or m >= p.conditions[i].high:
            return False
    return True


@inlined
def value_of(p, s, x, w, m):
    """The value of math place `m` of copy `w`: its default where an attribute that it reads is absent; NaN where it is undefined."""
    math = p.maths[m]
    row = s.row[w]
    for j in range(math.attr, math.attr_end):
        if row[p.lists[j]] != row[p.lists[j]]:
            return math.default
    return run_inlined(p.code, p.constants, math.code, math.code_end, row, x.stack)


@inner
def evaluate(p, s, c, x, w, first, last):
    """Set the math places ``lists[first:last]`` of copy `w`; False at the first that is undefined."""
    for i in range(first, last):
        value = value_of(p, s, x, w, p.lists[i])
        if value != value:
            x.counts[DETAIL] = p.lists[i]
            return False
        slot = p.maths[p.lists[i]].slot
        s.row[w, slot] = value
        c.known[w, slot] = c.now[w, slot]
    return True


@inlined
def mark(p, x, slot):
    """Note that what depends on a slot is to be worked out again: math places, and the conditions of transitions."""
    for i in range(p.slots[slot].math, p.slots[slot].math_end):
        note(x.stale, p.lists[i])
    for i in range(p.slots[slot].cond, p.slots[slot].cond_end):
        note(x.unsure, p.lists[i])


@inner
def compare(p, c, x, w):
    """Mark what depends on slots of copy `w` that are other than they were."""
    slots = c.now.shape[1]
    for low in range(0, slots, BLOCK):
        high = min(low + BLOCK, slots)
        differ = 0
        for k in range(low, high):
            differ += c.now[w, k] != c.known[w, k]
        if differ == 0:
            continue
        for k in range(low, high):
            if c.now[w, k] != c.known[w, k]:
                c.known[w, k] = c.now[w, k]
                mark(p, x, k)
                if p.slots[k].own >= 0:
                    note(x.stale, p.slots[k].own)


@inner
def mark_all(p, c, x, w):
    """Mark everything of copy `w`."""
    for k in range(c.now.shape[1]):
        c.known[w, k] = c.now[w, k]
    for m in range(p.maths.shape[0]):
        note(x.stale, m)
    for t in range(p.transitions.shape[0]):
        note(x.unsure, t)
    c.valid[w] = True


@inner
def renew_math(p, s, c, x, w):
    """Evaluate the marked math places of copy `w`, each after those that it reads, and mark what depends on them; False at the first
    that is undefined."""
    for k in range(x.stale.shape[0]):
        while x.stale[k] != 0:  # what a value marks comes later in the order: it is met on the way
            m = 32 * k + lowest(x.stale[k])
            x.stale[k] &= x.stale[k] - 1
            value = value_of(p, s, x, w, m)
            if value != value:
                x.counts[DETAIL] = m
                return False
            slot = p.maths[m].slot
            s.row[w, slot] = value
            if c.now[w, slot] != c.known[w, slot]:
                c.known[w, slot] = c.now[w, slot]
                mark(p, x, slot)
    return True


@inlined
def enable(p, c, w, t, now):
    """Note whether `t` of copy `w` is enabled."""
    c.enabled[w, t] = now
    if p.transitions[t].delay == 0:
        if now:
            put(c.ready[w], p.options[0].ready_tops, p.transitions[t].rank)
        else:
            drop(c.ready[w], p.options[0].ready_tops, p.transitions[t].rank)


@inlined
def renew_enabled(p, s, c, x, w):
    """Look at the conditions of the marked transitions of copy `w`."""
    for k in range(x.unsure.shape[0]):
        marked = x.unsure[k]
        x.unsure[k] = 0
        while marked != 0:
            t = 32 * k + lowest(marked)
            marked &= marked - 1
            now = meets(p, s.row[w], t)
            if now != (c.enabled[w, t] == 1):
                enable(p, c, w, t, now)
