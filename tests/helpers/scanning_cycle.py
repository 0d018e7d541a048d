"""The cycle as it was before it looked at changes only: every condition of every cycle, and lists from the start for every firing.

The executor is held against it (`ScanningExecutor`), and the benchmark of execution tells both times. Nothing of it is shared with the
cycle that runs, but the records of the program.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cprm_gym.architecture.expressions import kernels as expression_kernels
from cprm_gym.architecture.petri import Executor
from cprm_gym.compilation import kernel_group

kernel = kernel_group(_nrt=False)
inner = kernel_group(_nrt=False, no_cpython_wrapper=True)
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)
run, run_inlined = expression_kernels.run, expression_kernels.run_inlined

OK, LIVELOCK, UNDEFINED, CLOCKS, FULL = 0, 1, 2, 3, 4
OFF = -1
AGE = 1
CONFLICTS, EVENTS, DETAIL, START, LOOPED = 0, 1, 2, 3, 4
LOOP = 512


class Found(NamedTuple):
    """Working memory and findings."""

    enabled: np.ndarray
    stack: np.ndarray
    score: np.ndarray
    conflict: np.ndarray
    counts: np.ndarray
    loop: np.ndarray
    event: np.ndarray
    event_enabled: np.ndarray


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
def meets(p, row, t):
    """Whether the marking `row` enables transition `t`."""
    for i in range(p.transitions[t].cond, p.transitions[t].cond_end):
        m = row[p.conditions[i].place]
        if m < p.conditions[i].low or m >= p.conditions[i].high:
            return False
    return True


@inner
def evaluate(p, s, x, w, first, last):
    """Set the math places ``lists[first:last]`` of copy `w`; False at the first that is undefined."""
    row = s.row[w]
    for i in range(first, last):
        math = p.maths[p.lists[i]]
        absent = False
        for j in range(math.attr, math.attr_end):
            absent |= row[p.lists[j]] != row[p.lists[j]]
        value = math.default
        if not absent:
            value = run_inlined(p.code, p.constants, math.code, math.code_end, row, x.stack)
        if value != value:
            x.counts[DETAIL] = p.lists[i]
            return False
        row[math.slot] = value
    return True


@inner
def hold(p, s, w, o, token):
    """Put object `token` (-1: none) into object place `o`, and refresh what is known of it."""
    s.held[w, o] = token
    s.row[w, p.objects[o].place] = 1.0 if token >= 0 else 0.0
    for i in range(p.objects[o].attr, p.objects[o].attr_end):
        s.row[w, p.attributes[i].slot] = s.data[w, p.attributes[i].column + token] if token >= 0 else np.nan


@inner
def select(p, s, x, w, z):
    """The candidate that selection `z` chooses: the one of its rank among those with a score; -1 for none."""
    chooser = p.selections[z]
    row = s.row[w]
    count = 0
    for j in range(chooser.count):
        x.score[j] = np.nan
        if s.data[w, chooser.present + j] == 0.0:
            continue
        for i in range(chooser.cand, chooser.cand_end):
            row[p.attributes[i].slot] = s.data[w, p.attributes[i].column + j]
        holds = 1.0
        if chooser.where >= 0:
            holds = run(p.code, p.constants, chooser.where, chooser.where_end, row, x.stack)
        if holds != holds or holds == 0.0:
            continue
        value = run(p.code, p.constants, chooser.best, chooser.best_end, row, x.stack)
        if value == value:
            x.score[j] = chooser.sign * value
            count += 1
    chosen = -1
    if count >= chooser.rank:
        for _ in range(chooser.rank):
            if chosen >= 0:
                x.score[chosen] = np.nan
            chosen = -1
            for j in range(chooser.count):
                if x.score[j] == x.score[j] and (chosen < 0 or x.score[j] > x.score[chosen]):
                    chosen = j
    return chosen


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


@inner
def note_conflict(x, t, u):
    """Count that firing `t` disabled `u` of the same priority."""
    n = x.counts[CONFLICTS]
    for i in range(n):
        if x.conflict[i, 0] == t and x.conflict[i, 1] == u:
            x.conflict[i, 2] += 1
            return
    if n < x.conflict.shape[0]:
        x.conflict[n, 0] = t
        x.conflict[n, 1] = u
        x.conflict[n, 2] = 1
        x.counts[CONFLICTS] += 1


@inlined
def emit(p, s, out, w, t):
    """Send out the command of `t`, unless one of its group with at least its priority is out already."""
    tr = p.transitions[t]
    old = out.winner[w, tr.group]
    if old >= 0:
        before = out.source[w, old]
        if tr.priority <= p.transitions[before].priority:
            out.overruled[w, t] = True
            return
        out.overruled[w, before] = True
        out.fired[w, old] = False
    out.winner[w, tr.group] = tr.command
    out.fired[w, tr.command] = True
    out.source[w, tr.command] = t
    for i in range(tr.param, tr.param_end):
        source = p.parameters[i].source
        value = p.parameters[i].value
        if source >= 0:
            value = s.row[w, source]
        elif source < -1:
            value = s.held[w, -2 - source]
        out.value[w, p.parameters[i].target] = value


@inlined
def record(s, x, w, t, timed):
    """Add a firing to the trace; False when there is no room."""
    i = x.counts[EVENTS]
    if i >= x.event.shape[0]:
        return False
    x.event[i, 0] = w
    x.event[i, 1] = s.cycle[w]
    x.event[i, 2] = t
    x.event[i, 3] = timed
    for u in range(x.enabled.shape[0]):
        x.event_enabled[i, u] = x.enabled[u]
    x.counts[EVENTS] += 1
    return True


@inlined
def move(p, s, x, w, t, timed):
    """Consume, produce, then set; between the first two, see whose clocks the missing tokens stop."""
    row = s.row[w]
    tr = p.transitions[t]
    token = -1
    if tr.carrier >= 0:
        token = s.held[w, tr.carrier]
    for i in range(tr.pre, tr.pre_end):
        if p.arcs[i].object >= 0:
            hold(p, s, w, p.arcs[i].object, -1)
        else:
            row[p.arcs[i].place] -= p.arcs[i].value
    if p.options[0].intermediate == 1:
        for i in range(tr.touched, tr.touched_end):
            u = p.lists[i]
            rival = timed and u != t and p.transitions[u].priority == tr.priority and is_due(p, s, w, u)
            stop_clocks(p, s, w, u, degree(p, row, u, False))
            if rival and not is_due(p, s, w, u):
                note_conflict(x, t, u)
    for i in range(tr.post, tr.post_end):
        if p.arcs[i].object >= 0:
            hold(p, s, w, p.arcs[i].object, token)
        else:
            row[p.arcs[i].place] += p.arcs[i].value
    for i in range(tr.set, tr.set_end):
        if p.arcs[i].object >= 0:
            hold(p, s, w, p.arcs[i].object, -1)
        else:
            row[p.arcs[i].place] = p.arcs[i].value


@inlined
def fire(p, s, out, x, w, t):
    """Fire the enabled transition `t` of copy `w` and bring everything it may have changed up to date."""
    tr = p.transitions[t]
    timed = tr.delay > 0
    if x.event.shape[0] > 0 and not record(s, x, w, t, timed):
        return FULL
    if tr.command >= 0:
        emit(p, s, out, w, t)
    if timed:  # its oldest clock has done its work
        oldest = tr.clock
        for k in range(oldest + 1, tr.clock_end):
            if s.clock[w, k] > s.clock[w, oldest]:
                oldest = k
        s.clock[w, oldest] = OFF
    move(p, s, x, w, t, timed)
    if tr.remath < tr.remath_end and not evaluate(p, s, x, w, tr.remath, tr.remath_end):
        return UNDEFINED
    row = s.row[w]
    for i in range(tr.affected, tr.affected_end):
        u = p.lists[i]
        was, now = x.enabled[u] == 1, meets(p, row, u)
        rival = was and not now and u != t and p.transitions[u].priority == tr.priority
        x.enabled[u] = now
        if rival and (p.transitions[u].delay > 0) == timed and (not timed or is_due(p, s, w, u)):
            note_conflict(x, t, u)
        unfit = p.transitions[u].delay > 0 and (was or now) and not clocks_fit(p, s, x, w, u, now)
        if unfit and adjust_clocks(p, s, x, w, u, now) != OK:
            return CLOCKS
    for i in range(p.options[0].resampler, p.options[0].resampler_end):
        u = p.lists[i]
        for k in range(p.transitions[u].clock, p.transitions[u].clock_end):
            s.clock[w, k] = OFF
        if adjust_clocks(p, s, x, w, u, x.enabled[u] == 1) != OK:
            return CLOCKS
    return OK


@inlined
def next_immediate(p, s, x, w):
    """The enabled immediate transition that fires next, -1 for none."""
    first, last = p.options[0].immediate, p.options[0].immediate_end
    while first < last and x.enabled[p.lists[first]] == 0:
        first += 1
    if first == last:
        return -1
    chosen = p.lists[first]
    if p.options[0].random == 1:
        priority = p.transitions[chosen].priority
        total = 0.0
        for i in range(first, last):
            u = p.lists[i]
            if x.enabled[u] == 1 and p.transitions[u].priority == priority:
                total += p.transitions[u].weight
        left = draw(s.random, w) * total
        for i in range(first, last):
            u = p.lists[i]
            if x.enabled[u] == 1 and p.transitions[u].priority == priority and left >= 0.0:
                chosen = u
                left -= p.transitions[u].weight
    return chosen


@inlined
def next_due(p, s, x, w):
    """The timed transition that is due next at this instant, -1 for none."""
    for i in range(p.options[0].timed, p.options[0].timed_end):
        t = p.lists[i]
        if x.enabled[t] == 1 and is_due(p, s, w, t):
            return t
    return -1


@inlined
def prepare(p, s, out, x, w):
    """The part of a cycle before the first firing: clocks advance, objects are selected, math is evaluated."""
    for k in range(s.clock.shape[1]):
        if s.clock[w, k] >= 0:
            s.clock[w, k] += 1
    for c in range(out.fired.shape[1]):
        out.fired[w, c] = False
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
        if not evaluate(p, s, x, w, p.options[0].math, p.options[0].math_end):
            return UNDEFINED
    for t in range(x.enabled.shape[0]):
        x.enabled[t] = meets(p, s.row[w], t)
    return OK


@inlined
def advance(p, s, out, x, w):
    """One cycle of copy `w`, after its inputs and beliefs have been written."""
    status = prepare(p, s, out, x, w)
    x.counts[START] = 0
    count = 0  # immediate firings in a row
    while status == OK:
        t = next_immediate(p, s, x, w)
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
            if x.counts[START] == 0:  # quiet for the first time: clocks of what is enabled now start
                x.counts[START] = 1
                for i in range(p.options[0].timed, p.options[0].timed_end):
                    t = p.lists[i]
                    now = x.enabled[t] == 1
                    if not clocks_fit(p, s, x, w, t, now) and adjust_clocks(p, s, x, w, t, now) != OK:
                        return CLOCKS
            t = next_due(p, s, x, w)
            if t < 0:
                return OK
        status = fire(p, s, out, x, w, t)
    return status


@kernel
def cycle(p, s, out, x, failed):
    """One cycle of every copy. Returns the first status that is not OK; ``failed`` is then the copy and the detail."""
    first = OK
    for w in range(s.row.shape[0]):
        status = advance(p, s, out, x, w)
        if status == FULL:
            return FULL
        if status == OK:
            s.cycle[w] += 1
        elif first == OK:
            first = status
            failed[0] = w
            failed[1] = x.counts[DETAIL]
    return first


class ScanningExecutor(Executor):
    """An executor whose cycle scans."""

    def _cycle(self) -> int:
        rest = {name: getattr(self._scratch, name) for name in Found._fields[1:]}
        found = Found(np.zeros(self.net.n_transitions, np.uint8), **rest)
        return int(cycle(self._program, self._state, self._out, found, self._failed))
