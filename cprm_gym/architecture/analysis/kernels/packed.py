"""State spaces of untimed nets on bit-packed markings.

A marking is a row of 64-bit words. A place that never held more than one token has a field of one bit; a place that held more
has a field of `b` value bits below one guard bit, so that all fields of a word are compared, added and subtracted at once:
``((m | high) - pre) & high == high`` says that every field of `pre` is covered, one addition fires a transition, and a set guard
bit afterwards is an overflow (the caller widens the field and goes on from the same marking).

Markings are numbered in the order of their discovery (breadth first).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....compilation import kernel_group
from .table import enter, find, hash_row

kernel = kernel_group()

DONE, CHUNK, GROW, OVERFLOW = 0, 1, 2, 3
"""What `expand` returns: every marking expanded; as many as asked expanded; the arrays are full; a field is too narrow."""

_DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)
_LOW_BIT = np.zeros(64, np.int64)
for _i in range(64):
    _LOW_BIT[((1 << _i) * 0x03F79D71B4CB0A89 & (1 << 64) - 1) >> 58] = _i

_ONE = np.uint64(1)
_ZERO = np.uint64(0)
_S58 = np.uint64(58)
_FULL = np.uint64(0xFFFFFFFFFFFFFFFF)


class PackedNet(NamedTuple):
    """Transitions as word operations. `tests` and `effects` are rows of words, one row per word a transition looks at or changes."""

    test_start: np.ndarray  # (T + 1,) rows of `tests` of transition t
    test_word: np.ndarray  # (X,) which word
    tests: np.ndarray  # (X, 6) uint64: need, pre, pre_high, inhibit, threshold, threshold_high
    effect_start: np.ndarray  # (T + 1,)
    effect_word: np.ndarray  # (Y,)
    effects: np.ndarray  # (Y, 5) uint64: delta, guard, over, keep, value
    group_end: np.ndarray  # (G,) end of each priority group in the order of transitions
    preempts: np.ndarray  # (T,) bool: if enabled, later groups are not
    possible: np.ndarray  # (T,) bool: False if a field is too narrow for it to be enabled at all
    trigger_start: np.ndarray  # (F + 2,) transitions by the field of one of their inputs; row F: those without input
    trigger: np.ndarray  # (T,)
    field_of_bit: np.ndarray  # (W * 64,) which field a bit belongs to
    field_mask: np.ndarray  # (F,) uint64
    indexed: bool  # use the triggers


@kernel
def is_enabled(test_start, test_word, tests, t, states, i):
    """Whether transition `t` is enabled in the packed marking of row `i`."""
    for k in range(test_start[t], test_start[t + 1]):
        m = states[i, test_word[k]]
        if m & tests[k, 0] != tests[k, 0]:
            return False
        if ((m | tests[k, 2]) - tests[k, 1]) & tests[k, 2] != tests[k, 2]:
            return False
        if (m & tests[k, 3]) | (((m | tests[k, 5]) - tests[k, 4]) & tests[k, 5]) != _ZERO:
            return False
    return True


@kernel
def fire(effect_start, effect_word, effects, t, states, i, out, n):
    """Write the marking after `t` to row `n` of `out`; False if a field is too narrow."""
    for w in range(states.shape[1]):
        out[n, w] = states[i, w]
    for k in range(effect_start[t], effect_start[t + 1]):
        w = effect_word[k]
        m = states[i, w]
        moved = m + effects[k, 0]
        if (m & effects[k, 2]) | (moved & effects[k, 1]) != _ZERO:
            return False
        out[n, w] = (moved & effects[k, 3]) | effects[k, 4]
    return True


@kernel
def successors(net, states, i, out, which):
    """Every marking one firing from row `i`: rows of `out`, transitions in `which`. Their number, or -1 - t if `t` overflows."""
    test_start, test_word, tests, effect_start, effect_word, effects, group_end, preempts, possible = net[:9]
    n = 0
    if net.indexed:
        trigger_start, trigger, field_of_bit, field_mask = net[9:13]
        fields = field_mask.shape[0]
        for w in range(-1, states.shape[1]):
            m = _ONE if w < 0 else states[i, w]
            while m != _ZERO:
                if w < 0:
                    field = fields
                    m = _ZERO
                else:
                    low = _LOW_BIT[((m & (~m + _ONE)) * _DE_BRUIJN) >> _S58]
                    field = field_of_bit[w * 64 + low]
                    m &= ~field_mask[field]
                for k in range(trigger_start[field], trigger_start[field + 1]):
                    t = trigger[k]
                    if possible[t] and is_enabled(test_start, test_word, tests, t, states, i):
                        if not fire(effect_start, effect_word, effects, t, states, i, out, n):
                            return -1 - t
                        which[n] = t
                        n += 1
        return n
    begin = 0
    for g in range(group_end.shape[0]):
        stop = False
        for t in range(begin, group_end[g]):
            if possible[t] and is_enabled(test_start, test_word, tests, t, states, i):
                if not fire(effect_start, effect_word, effects, t, states, i, out, n):
                    return -1 - t
                which[n] = t
                n += 1
                stop |= preempts[t]
        if stop:
            break
        begin = group_end[g]
    return n


@kernel
def expand(net, states, parents, table, bits, offsets, targets, labels, fired, out, which, hashes, progress, chunk):
    """Expand markings in order until nothing is left, `chunk` are done, the arrays are full or a field overflows.

    Parameters
    ----------
    states : (capacity, W) uint64; parents : (capacity,) uint32; table : (2 ** bits,) uint32
    offsets, targets, labels : (capacity + 1,) int64, (E,) int32, (E,) int32
        Edges of what is expanded, as in `edges`; not kept where there are no `targets`.
    fired : (T,) int64
        First marking in which each transition fired, -1 if none; updated.
    out, which, hashes : scratch for the successors of one marking, one row per transition.
    progress : (8,) int64
        0 next marking to expand, 1 number of markings, 2 edges, 3 deadlocks, 4 first deadlock (-1), 5 transition that overflowed.

    Returns
    -------
    int
        `DONE`, `CHUNK`, `GROW` or `OVERFLOW`.
    """
    mask = (_ONE << bits) - _ONE
    words = states.shape[1]
    room = min(np.int64(states.shape[0]), np.int64(table.shape[0] * 7 // 10)) - out.shape[0]
    i = progress[0]
    last = i + chunk
    n_states = progress[1]
    edges = progress[2]
    keeps = targets.shape[0] > 0
    code = DONE
    while i < n_states:
        if i >= last:
            code = CHUNK
            break
        if n_states > room or (keeps and edges + out.shape[0] > targets.shape[0]):
            code = GROW
            break
        n = successors(net, states, i, out, which)
        if n < 0:
            progress[5] = -1 - n
            code = OVERFLOW
            break
        touched = np.uint32(0)
        for k in range(n):  # the cache misses of all successors overlap here
            hashes[k] = hash_row(out, k)
            touched ^= table[hashes[k] & mask]
        progress[6] = touched
        for k in range(n):
            h = hashes[k]
            at = find(states, table, bits, out, k, h)
            if at < 0:
                enter(table, bits, -1 - at, h, n_states)
                for w in range(words):
                    states[n_states, w] = out[k, w]
                parents[n_states] = i
                at = n_states
                n_states += 1
            if fired[which[k]] < 0:
                fired[which[k]] = i
            if keeps:
                targets[edges + k] = at
                labels[edges + k] = which[k]
        edges += n
        if keeps:
            offsets[i + 1] = edges
        if n == 0:
            if progress[3] == 0:
                progress[4] = i
            progress[3] += 1
        i += 1
    progress[0] = i
    progress[1] = n_states
    progress[2] = edges
    return code


@kernel
def repack(old, n, old_word, old_shift, old_mask, new, new_word, new_shift):
    """Copy the first `n` markings from one layout to another."""
    for i in range(n):
        for w in range(new.shape[1]):
            new[i, w] = _ZERO
        for p in range(old_word.shape[0]):
            value = (old[i, old_word[p]] >> old_shift[p]) & old_mask[p]
            new[i, new_word[p]] |= value << new_shift[p]


@kernel
def unpack(states, first, word, shift, mask, out):
    """Markings `first`, `first` + 1, ... as integers, one row each, shape (n, P)."""
    for i in range(out.shape[0]):
        for p in range(word.shape[0]):
            out[i, p] = np.int64((states[first + i, word[p]] >> shift[p]) & mask[p])


@kernel
def unpack_rows(states, rows, word, shift, mask, out):
    """The markings numbered `rows` as integers, shape (n, P)."""
    for i in range(rows.shape[0]):
        for p in range(word.shape[0]):
            out[i, p] = np.int64((states[rows[i], word[p]] >> shift[p]) & mask[p])


@kernel
def extremes(states, n, word, shift, mask, counted, most):
    """Most tokens seen per place (into `most`, shape (P,)); returns the most in one marking over the places `counted`."""
    best = 0
    for i in range(n):
        total = 0
        for p in range(word.shape[0]):
            value = np.int64((states[i, word[p]] >> shift[p]) & mask[p])
            if value > most[p]:
                most[p] = value
            if counted[p]:
                total += value
        best = max(best, total)
    return best


@kernel
def edges(net, states, table, bits, first, last, offsets, targets, labels, out, which):
    """Successors of the markings `first` to `last` - 1 as a compressed graph; `offsets[first]` is given.

    A successor that was never stored (the exploration stopped early) gets target -1.
    """
    at = offsets[first]
    for i in range(first, last):
        n = successors(net, states, i, out, which)
        for k in range(n):
            targets[at] = max(find(states, table, bits, out, k, hash_row(out, k)), -1)
            labels[at] = which[k]
            at += 1
        offsets[i + 1] = at
    return at
