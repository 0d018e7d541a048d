"""The firing of a transition, and what it changes: tokens, clocks, commands, which others are enabled."""

from __future__ import annotations

from .....compilation import kernel_group
from .arrays import CLOCKS, CONFLICTS, EVENTS, FULL, OFF, OK, UNDEFINED
from .bit_sets import drop, put
from .clocks import adjust_clocks, clocks_fit, degree, is_due, stop_clocks
from .held_objects import hold
from .renewal import enable, evaluate, meets

inner = kernel_group(_nrt=False, no_cpython_wrapper=True)  # called by other kernels only
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)  # too short for the cost of a call


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
def record(s, c, x, w, t, timed):
    """Add a firing to the trace; False when there is no room."""
    i = x.counts[EVENTS]
    if i >= x.event.shape[0]:
        return False
    x.event[i, 0] = w
    x.event[i, 1] = s.cycle[w]
    x.event[i, 2] = t
    x.event[i, 3] = timed
    for u in range(c.enabled.shape[1]):
        x.event_enabled[i, u] = c.enabled[w, u]
    x.counts[EVENTS] += 1
    return True


@inlined
def learn(c, w, slot):
    """Know a slot as it is now: what depends on it is brought up to date by the firing that has changed it."""
    c.known[w, slot] = c.now[w, slot]


@inner
def take(p, s, c, w, o, token):
    """Put object `token` (-1: none) into object place `o` in a firing."""
    hold(p, s, w, o, token)
    learn(c, w, p.objects[o].place)
    for i in range(p.objects[o].attr, p.objects[o].attr_end):
        learn(c, w, p.attributes[i].slot)


@inlined
def move(p, s, c, x, w, t, timed):
    """Consume, produce, then set; between the first two, see whose clocks the missing tokens stop."""
    row = s.row[w]
    tr = p.transitions[t]
    token = -1
    if tr.carrier >= 0:
        token = s.held[w, tr.carrier]
    for i in range(tr.pre, tr.pre_end):
        if p.arcs[i].object >= 0:
            take(p, s, c, w, p.arcs[i].object, -1)
        else:
            row[p.arcs[i].place] -= p.arcs[i].value
            learn(c, w, p.arcs[i].place)
    if p.options[0].intermediate == 1:
        for i in range(tr.touched, tr.touched_end):
            u = p.lists[i]
            rival = timed and u != t and p.transitions[u].priority == tr.priority and is_due(p, s, w, u)
            stop_clocks(p, s, w, u, degree(p, row, u, False))
            if rival and not is_due(p, s, w, u):
                note_conflict(x, t, u)
    for i in range(tr.post, tr.post_end):
        if p.arcs[i].object >= 0:
            take(p, s, c, w, p.arcs[i].object, token)
        else:
            row[p.arcs[i].place] += p.arcs[i].value
            learn(c, w, p.arcs[i].place)
    for i in range(tr.set, tr.set_end):
        if p.arcs[i].object >= 0:
            take(p, s, c, w, p.arcs[i].object, -1)
        else:
            row[p.arcs[i].place] = p.arcs[i].value
            learn(c, w, p.arcs[i].place)


@inlined
def due_again(p, s, x, w, t):
    """Note whether timed transition `t` of copy `w` is due."""
    if is_due(p, s, w, t):
        put(x.due, p.options[0].due_tops, p.transitions[t].rank)
    else:
        drop(x.due, p.options[0].due_tops, p.transitions[t].rank)


@inlined
def renew_after(p, s, c, x, w, t):
    """See which transitions the firing of `t` has enabled and disabled, and what their clocks do."""
    tr = p.transitions[t]
    timed = tr.delay > 0
    row = s.row[w]
    for i in range(tr.affected, tr.affected_end):
        u = p.lists[i]
        was, now = c.enabled[w, u] == 1, meets(p, row, u)
        if was != now:
            enable(p, c, w, u, now)
            rival = was and u != t and p.transitions[u].priority == tr.priority
            if rival and (p.transitions[u].delay > 0) == timed and (not timed or is_due(p, s, w, u)):
                note_conflict(x, t, u)
        if p.transitions[u].delay > 0 and (was or now):
            if not clocks_fit(p, s, x, w, u, now) and adjust_clocks(p, s, x, w, u, now) != OK:
                return CLOCKS
            due_again(p, s, x, w, u)
    for i in range(p.options[0].resampler, p.options[0].resampler_end):
        u = p.lists[i]
        for k in range(p.transitions[u].clock, p.transitions[u].clock_end):
            s.clock[w, k] = OFF
        if adjust_clocks(p, s, x, w, u, c.enabled[w, u] == 1) != OK:
            return CLOCKS
        due_again(p, s, x, w, u)
    return OK


@inlined
def fire(p, s, c, out, x, w, t):
    """Fire the enabled transition `t` of copy `w` and bring everything it may have changed up to date."""
    tr = p.transitions[t]
    timed = tr.delay > 0
    if x.event.shape[0] > 0 and not record(s, c, x, w, t, timed):
        return FULL
    if tr.command >= 0:
        emit(p, s, out, w, t)
    if timed:  # its oldest clock has done its work
        oldest = tr.clock
        for k in range(oldest + 1, tr.clock_end):
            if s.clock[w, k] > s.clock[w, oldest]:
                oldest = k
        s.clock[w, oldest] = OFF
    move(p, s, c, x, w, t, timed)
    if tr.remath < tr.remath_end and not evaluate(p, s, c, x, w, tr.remath, tr.remath_end):
        return UNDEFINED
    return renew_after(p, s, c, x, w, t)
