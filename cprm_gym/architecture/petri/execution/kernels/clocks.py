"""The clocks of timed transitions: when they start, stop and are due."""

from __future__ import annotations

import numpy as np

from .....compilation import kernel_group
from .arrays import AGE, CLOCKS, DETAIL, OFF, OK, START

inner = kernel_group(_nrt=False, no_cpython_wrapper=True)  # called by other kernels only
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)  # too short for the cost of a call


@inner
def degree(p, row, t, full):
    """How often `t` is enabled at once; with `full` False only its need of tokens counts."""
    for i in range(p.transitions[t].cond, p.transitions[t].cond_end):
        m = row[p.conditions[i].place]
        if full and m >= p.conditions[i].high:
            return 0
        if (full or p.conditions[i].moved == 1) and m < p.conditions[i].low:
            return 0
    if p.transitions[t].pre == p.transitions[t].pre_end:
        return 1
    least = np.inf
    for i in range(p.transitions[t].pre, p.transitions[t].pre_end):
        least = min(least, np.floor(row[p.arcs[i].place] / p.arcs[i].value))
    return int(least)


@inner
def stop_clocks(p, s, w, t, keep):
    """Stop the youngest clocks of `t` until at most `keep` run; returns how many run."""
    low, high = p.transitions[t].clock, p.transitions[t].clock_end
    running = 0
    for k in range(low, high):
        running += s.clock[w, k] >= 0
    while running > keep:
        youngest = -1
        for k in range(low, high):
            c = s.clock[w, k]
            if c >= 0 and (youngest < 0 or c < s.clock[w, youngest]):
                youngest = k
        s.clock[w, youngest] = -2 - s.clock[w, youngest] if p.transitions[t].memory == AGE else OFF
        running -= 1
    return running


@inner
def adjust_clocks(p, s, x, w, t, enabled):
    """Stop the clocks of a timed transition that is no longer enabled; start those it lacks, once clocks may start."""
    low, high = p.transitions[t].clock, p.transitions[t].clock_end
    wanted = 0
    if enabled:
        wanted = 1 if p.transitions[t].servers == 1 else degree(p, s.row[w], t, True)
        if wanted > high - low:
            if p.transitions[t].servers < 0:
                x.counts[DETAIL] = t
                return CLOCKS
            wanted = high - low
    running = stop_clocks(p, s, w, t, wanted)
    if x.counts[START] == 1:
        while running < wanted:  # the oldest of those that stand goes on first; if none stands, one starts
            chosen = -1
            for k in range(low, high):
                if s.clock[w, k] < 0 and (chosen < 0 or s.clock[w, k] < s.clock[w, chosen]):
                    chosen = k
            s.clock[w, chosen] = 0 if s.clock[w, chosen] == OFF else -2 - s.clock[w, chosen]
            running += 1
    return OK


@inlined
def clocks_fit(p, s, x, w, t, enabled):
    """Whether the clock of a transition with one server is as `adjust_clocks` would leave it."""
    running = s.clock[w, p.transitions[t].clock] >= 0
    return p.transitions[t].servers == 1 and (running == enabled or (enabled and x.counts[START] == 0))


@inlined
def is_due(p, s, w, t):
    """Whether a clock of `t` has reached its delay."""
    due = False
    for k in range(p.transitions[t].clock, p.transitions[t].clock_end):
        due |= s.clock[w, k] >= p.transitions[t].delay
    return due
