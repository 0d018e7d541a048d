"""The cycle of a net, for many copies at once.

`cycle` runs the rule that stands in words at the top of this package. One copy is one row of every state array. Between calls
the state arrays are all there is; the scratch arrays hold nothing of worth.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...compilation import kernel_group
from ..expressions import kernels as expression_kernels

kernel = kernel_group(__file__, Path(expression_kernels.__file__))
run = expression_kernels.run

OK, LIVELOCK, UNDEFINED, CLOCKS, FULL = 0, 1, 2, 3, 4  # what a phase answers: FULL, no room left in the trace
OFF = -1  # a clock that is not running; -2 - c: an age clock paused at c
AGE = 1  # Memory.AGE
IMMEDIATE, TIMED = 0, 1  # why a transition fired
INTERMEDIATE, RANDOM, MOST, EARLY_MATH = 0, 1, 2, 3  # places in Program.options
LOOP = 512  # firings kept of a livelock
NO_PRIORITY = -(2**62)


class State(NamedTuple):
    """What a copy remembers from cycle to cycle; W copies."""

    row: np.ndarray  # (W, S) marking of the P places, then attributes of held objects, then of the candidate looked at
    held: np.ndarray  # (W, O) int32 index of the object in each object place, -1 for none
    clock: np.ndarray  # (W, K) int32
    random: np.ndarray  # (W,) uint64 state of the copy's random stream
    cycle: np.ndarray  # (W,) int64 cycles run
    data: np.ndarray  # (W, N) attributes of all objects


class Output(NamedTuple):
    """What a cycle sends out."""

    fired: np.ndarray  # (W, commands) bool
    source: np.ndarray  # (W, commands) int32 transition that emitted it
    value: np.ndarray  # (W, parameters)
    winner: np.ndarray  # (W, groups) int32 command that goes out, -1 for none
    overruled: np.ndarray  # (W, T) bool emitted a command that gave way to another of its group


class Scratch(NamedTuple):
    """Working memory and findings."""

    enabled: np.ndarray  # (T,) uint8 of the copy at work
    stack: np.ndarray  # of expressions
    score: np.ndarray  # (objects,)
    conflict: np.ndarray  # (n, 3) int64 transition fired, transition it disabled, how often
    counts: np.ndarray  # conflicts found; events in the trace; firings in the loop; undefined math; whether clocks start now
    loop: np.ndarray  # (LOOP,) int32 firings of a livelock
    event: np.ndarray  # (E, 4) int64 copy, cycle, transition, why; no rows: no trace
    event_enabled: np.ndarray  # (E, T) uint8 what was enabled


CONFLICTS, EVENTS, LOOPED, MATH, START = 0, 1, 2, 3, 4


@kernel
def splitmix(random, w):
    """A number in [0, 1) from the stream of copy `w`."""
    random[w] += np.uint64(0x9E3779B97F4A7C15)
    z = random[w]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.float64(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@kernel
def is_enabled(p, row, t):
    """Whether transition `t` may fire."""
    for i in range(p.cond_start[t], p.cond_start[t + 1]):
        m = row[p.cond_place[i]]
        if m < p.cond_low[i] or m >= p.cond_high[i]:
            return False
    return True


@kernel
def evaluate(p, s, x, w, m):
    """Set math place `m` of copy `w`; False when it is undefined."""
    row = s.row[w]
    for i in range(p.math_attr_start[m], p.math_attr_start[m + 1]):
        if row[p.math_attr[i]] != row[p.math_attr[i]]:
            row[p.math_slot[m]] = p.math_default[m]
            return True
    value = run(p.code, p.constants, p.code_start[m], p.code_start[m + 1], row, x.stack)
    if value != value:
        x.counts[MATH] = m
        return False
    row[p.math_slot[m]] = value
    return True


@kernel
def evaluate_all(p, s, x, w):
    """Set every math place of copy `w`, in order."""
    for m in range(p.math_slot.shape[0]):
        if not evaluate(p, s, x, w, m):
            return UNDEFINED
    return OK


@kernel
def hold(p, s, w, place, token):
    """Put object `token` (-1: none) into an object place, and refresh what is known of it."""
    o = p.object_of[place]
    s.held[w, o] = token
    s.row[w, place] = 1.0 if token >= 0 else 0.0
    for i in range(p.attr_start[o], p.attr_start[o + 1]):
        s.row[w, p.attr_slot[i]] = s.data[w, p.attr_column[i] + token] if token >= 0 else np.nan


@kernel
def select(p, s, x, w, z):
    """Set the object place of selection `z`: the candidate of its rank among those with a score."""
    c = p.select_class[z]
    row = s.row[w]
    best, where = p.select_best[z], p.select_where[z]
    size = p.class_size[c]
    count = 0
    for j in range(size):
        x.score[j] = np.nan
        if s.data[w, p.class_present[c] + j] == 0.0:
            continue
        for i in range(p.cand_start[c], p.cand_start[c + 1]):
            row[p.cand_slot[i]] = s.data[w, p.cand_column[i] + j]
        if where >= 0:
            holds = run(p.code, p.constants, p.code_start[where], p.code_start[where + 1], row, x.stack)
            if holds != holds or holds == 0.0:
                continue
        value = run(p.code, p.constants, p.code_start[best], p.code_start[best + 1], row, x.stack)
        if value == value:
            x.score[j] = p.select_sign[z] * value
            count += 1
    chosen = -1
    if count >= p.select_rank[z]:
        for _ in range(p.select_rank[z]):
            chosen = -1
            for j in range(size):
                if x.score[j] == x.score[j] and (chosen < 0 or x.score[j] > x.score[chosen]):
                    chosen = j
            x.score[chosen] = np.nan
    hold(p, s, w, p.select_place[z], chosen)


@kernel
def degree(p, row, t, full):
    """How often `t` is enabled at once; with `full` False only its need of tokens counts."""
    for i in range(p.cond_start[t], p.cond_start[t + 1]):
        place = p.cond_place[i]
        if full and row[place] >= p.cond_high[i]:
            return 0
        if (full or p.moved[place] == 1) and row[place] < p.cond_low[i]:
            return 0
    if p.pre_start[t] == p.pre_start[t + 1]:
        return 1
    least = np.inf
    for i in range(p.pre_start[t], p.pre_start[t + 1]):
        least = min(least, np.floor(row[p.pre_place[i]] / p.pre_weight[i]))
    return int(least)


@kernel
def stop_clocks(p, s, w, t, keep):
    """Stop the youngest clocks of `t` until at most `keep` run."""
    low, high = p.clock_start[t], p.clock_start[t + 1]
    running = 0
    for k in range(low, high):
        running += s.clock[w, k] >= 0
    while running > keep:
        youngest = -1
        for k in range(low, high):
            c = s.clock[w, k]
            if c >= 0 and (youngest < 0 or c < s.clock[w, youngest]):
                youngest = k
        c = s.clock[w, youngest]
        s.clock[w, youngest] = -2 - c if p.memory[t] == AGE else OFF
        running -= 1
    return running


@kernel
def adjust_clocks(p, s, x, w, t, enabled):
    """Stop the clocks of a timed transition that is no longer enabled; start those it lacks, once clocks may start."""
    low, high = p.clock_start[t], p.clock_start[t + 1]
    if high - low == 1 and p.servers[t] == 1:
        c = s.clock[w, low]
        if not enabled:
            if c >= 0:
                s.clock[w, low] = -2 - c if p.memory[t] == AGE else OFF
        elif c < 0 and x.counts[START] == 1:
            s.clock[w, low] = 0 if c == OFF else -2 - c
        return OK
    wanted = degree(p, s.row[w], t, True) if enabled else 0
    if wanted > high - low:
        if p.servers[t] < 0:
            return CLOCKS
        wanted = high - low
    running = stop_clocks(p, s, w, t, wanted)
    if x.counts[START] == 1:
        for k in range(low, high):
            if running < wanted and s.clock[w, k] < 0:
                s.clock[w, k] = 0
                running += 1
    return OK


@kernel
def note_conflict(x, t, u):
    """Count that firing `t` disabled `u` of the same priority."""
    for i in range(x.counts[CONFLICTS]):
        if x.conflict[i, 0] == t and x.conflict[i, 1] == u:
            x.conflict[i, 2] += 1
            return
    if x.counts[CONFLICTS] < x.conflict.shape[0]:
        i = x.counts[CONFLICTS]
        x.conflict[i, 0] = t
        x.conflict[i, 1] = u
        x.conflict[i, 2] = 1
        x.counts[CONFLICTS] += 1


@kernel
def emit(p, s, out, w, t):
    """Send out the command of `t`, unless one of its group with at least its priority is out already."""
    c = p.command_of[t]
    g = p.group_of[c]
    old = out.winner[w, g]
    if old >= 0:
        before = out.source[w, old]
        if p.priority[t] <= p.priority[before]:
            out.overruled[w, t] = True
            return
        out.overruled[w, before] = True
        out.fired[w, old] = False
    out.winner[w, g] = c
    out.fired[w, c] = True
    out.source[w, c] = t
    for i in range(p.param_start[t], p.param_start[t + 1]):
        source = p.param_source[i]
        if source >= 0:
            value = s.row[w, source]
        elif source == -1:
            value = p.param_value[i]
        else:
            value = s.held[w, -2 - source]
        out.value[w, p.param_target[i]] = value


@kernel
def record(s, x, w, t, why):
    """Add a firing to the trace; False when there is no room."""
    i = x.counts[EVENTS]
    if i >= x.event.shape[0]:
        return False
    x.event[i, 0] = w
    x.event[i, 1] = s.cycle[w]
    x.event[i, 2] = t
    x.event[i, 3] = why
    x.event_enabled[i] = x.enabled
    x.counts[EVENTS] += 1
    return True


@kernel
def is_due(p, s, w, t):
    """Whether a clock of `t` has reached its delay."""
    for k in range(p.clock_start[t], p.clock_start[t + 1]):
        if s.clock[w, k] >= p.delay[t]:
            return True
    return False


@kernel
def move(p, s, x, w, t, why):
    """Consume, produce, then set; between the first two, see whose clocks the missing tokens stop."""
    row = s.row[w]
    token = np.int32(-1)
    if p.carrier[t] >= 0:
        token = s.held[w, p.carrier[t]]
    for i in range(p.pre_start[t], p.pre_start[t + 1]):
        place = p.pre_place[i]
        if p.object_of[place] >= 0:
            hold(p, s, w, place, -1)
        else:
            row[place] -= p.pre_weight[i]
    if p.options[INTERMEDIATE] == 1:
        for i in range(p.touched_start[t], p.touched_start[t + 1]):
            u = p.touched[i]
            rival = why == TIMED and u != t and p.priority[u] == p.priority[t] and is_due(p, s, w, u)
            stop_clocks(p, s, w, u, degree(p, row, u, False))
            if rival and not is_due(p, s, w, u):
                note_conflict(x, t, u)
    for i in range(p.post_start[t], p.post_start[t + 1]):
        place = p.post_place[i]
        if p.object_of[place] >= 0:
            hold(p, s, w, place, token)
        else:
            row[place] += p.post_weight[i]
    for i in range(p.set_start[t], p.set_start[t + 1]):
        place = p.set_place[i]
        if p.object_of[place] >= 0:
            hold(p, s, w, place, -1)
        else:
            row[place] = p.set_value[i]


@kernel
def fire(p, s, out, x, w, t, why):
    """Fire the enabled transition `t` of copy `w` and bring everything it may have changed up to date."""
    if x.event.shape[0] > 0 and not record(s, x, w, t, why):
        return FULL
    if p.command_of[t] >= 0:
        emit(p, s, out, w, t)
    if p.delay[t] > 0:  # its oldest clock has done its work
        oldest = p.clock_start[t]
        for k in range(oldest + 1, p.clock_start[t + 1]):
            if s.clock[w, k] > s.clock[w, oldest]:
                oldest = k
        s.clock[w, oldest] = OFF
    move(p, s, x, w, t, why)
    for i in range(p.remath_start[t], p.remath_start[t + 1]):
        if not evaluate(p, s, x, w, p.remath[i]):
            return UNDEFINED
    row = s.row[w]
    for i in range(p.affected_start[t], p.affected_start[t + 1]):
        u = p.affected[i]
        now = is_enabled(p, row, u)
        rival = x.enabled[u] == 1 and not now and u != t and p.priority[u] == p.priority[t]
        x.enabled[u] = now
        if p.delay[u] > 0:
            if rival and why == TIMED and is_due(p, s, w, u):
                note_conflict(x, t, u)
            status = adjust_clocks(p, s, x, w, u, now)
            if status != OK:
                x.counts[MATH] = u
                return status
        elif rival and why == IMMEDIATE:
            note_conflict(x, t, u)
    for i in range(p.resamplers.shape[0]):
        u = p.resamplers[i]
        for k in range(p.clock_start[u], p.clock_start[u + 1]):
            s.clock[w, k] = OFF
        adjust_clocks(p, s, x, w, u, x.enabled[u] == 1)
    return OK


@kernel
def next_immediate(p, s, x, w):
    """The enabled immediate transition that fires next, -1 for none."""
    n = p.immediate.shape[0]
    for i in range(n):
        t = p.immediate[i]
        if x.enabled[t] == 1:
            if p.options[RANDOM] == 0:
                return t
            total = 0.0
            for j in range(i, n):
                u = p.immediate[j]
                if p.priority[u] == p.priority[t] and x.enabled[u] == 1:
                    total += p.weight[u]
            left = splitmix(s.random, w) * total
            for j in range(i, n):
                u = p.immediate[j]
                if p.priority[u] == p.priority[t] and x.enabled[u] == 1:
                    t = u
                    left -= p.weight[u]
                    if left < 0.0:
                        break
            return t
    return -1


@kernel
def settle(p, s, out, x, w):
    """Fire immediate transitions until none is enabled."""
    count = 0
    while True:
        t = next_immediate(p, s, x, w)
        if t < 0:
            return OK
        count += 1
        if count > p.options[MOST]:
            i = count - p.options[MOST] - 1
            if i >= LOOP:
                x.counts[LOOPED] = LOOP
                return LIVELOCK
            x.loop[i] = t
        status = fire(p, s, out, x, w, t, IMMEDIATE)
        if status != OK:
            return status


@kernel
def next_due(p, s, x, w):
    """The timed transition that is due next at this instant, -1 for none."""
    for i in range(p.timed.shape[0]):
        t = p.timed[i]
        if x.enabled[t] == 1 and is_due(p, s, w, t):
            return t
    return -1


@kernel
def cycle_of_one(p, s, out, x, w):
    """One cycle of copy `w`, after its inputs and beliefs have been written."""
    for k in range(s.clock.shape[1]):
        if s.clock[w, k] >= 0:
            s.clock[w, k] += 1
    out.fired[w] = False
    out.winner[w] = -1
    out.overruled[w] = False
    x.counts[START] = 0
    for place in range(p.object_of.shape[0]):
        o = p.object_of[place]
        if o >= 0 and p.attr_start[o] < p.attr_start[o + 1]:
            hold(p, s, w, place, s.held[w, o])
    if p.options[EARLY_MATH] == 1 and evaluate_all(p, s, x, w) != OK:
        return UNDEFINED
    for z in range(p.select_object.shape[0]):
        select(p, s, x, w, z)
    if evaluate_all(p, s, x, w) != OK:
        return UNDEFINED
    for t in range(x.enabled.shape[0]):
        x.enabled[t] = is_enabled(p, s.row[w], t)
    status = settle(p, s, out, x, w)
    if status != OK:
        return status
    x.counts[START] = 1
    for i in range(p.timed.shape[0]):
        t = p.timed[i]
        if adjust_clocks(p, s, x, w, t, x.enabled[t] == 1) != OK:
            x.counts[MATH] = t
            return CLOCKS
    while True:
        t = next_due(p, s, x, w)
        if t < 0:
            return OK
        status = fire(p, s, out, x, w, t, TIMED)
        if status == OK:
            status = settle(p, s, out, x, w)
        if status != OK:
            return status


@kernel
def cycle(p, s, out, x, failed):
    """One cycle of every copy. Returns the first status that is not OK; ``failed[0]`` is then the copy, ``failed[1]`` the detail."""
    first = OK
    for w in range(s.row.shape[0]):
        status = cycle_of_one(p, s, out, x, w)
        if status == OK:
            s.cycle[w] += 1
        elif first == OK:
            first = status
            failed[0] = w
            failed[1] = x.counts[MATH]
            if status == FULL:
                return FULL
    return first


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


@kernel
def refresh_math(p, s, x):
    """Set the math places of every copy where they are defined, keep the others."""
    for w in range(s.row.shape[0]):
        for m in range(p.math_slot.shape[0]):
            evaluate(p, s, x, w, m)
