"""How markings lie in words, and transitions as operations on words (for `kernels/packed.py`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.packed import PackedNet
from ..net_arrays import FREE, KEEP, System


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the field of each place lies.

    Attributes
    ----------
    bits : (P,) int64
        Value bits of each field; a field of more than one bit is followed by a guard bit.
    word, shift : (P,) int64, uint64
        The word a field is in and its lowest bit there.
    mask : (P,) uint64
        Its value bits, shifted down.
    words : int
        Words per marking.
    """

    bits: np.ndarray
    word: np.ndarray
    shift: np.ndarray
    mask: np.ndarray
    words: int

    @classmethod
    def of(cls, bits: np.ndarray) -> Layout:
        """Fields laid out in the order of the places, none across two words."""
        word = np.zeros(len(bits), np.int64)
        shift = np.zeros(len(bits), np.uint64)
        w = used = 0
        for p, b in enumerate(bits):
            width = int(b) + (b > 1)
            if used + width > 64:
                w, used = w + 1, 0
            word[p], shift[p] = w, used
            used += width
        mask = np.array([(1 << int(b)) - 1 for b in bits], np.uint64)
        return cls(np.asarray(bits, np.int64), word, shift, mask, w + 1)

    def pack(self, marking: np.ndarray) -> np.ndarray:
        """One marking as words, shape (W,)."""
        words = [0] * self.words
        for p in np.flatnonzero(marking):
            words[self.word[p]] |= int(marking[p]) << int(self.shift[p])
        return np.array(words, np.uint64)


def first_bits(system: System) -> np.ndarray:
    """Value bits per place that hold the initial marking and every weight at the place, shape (P,)."""
    most = system.marking.copy()
    for weights in (system.need, system.post, system.sets):
        most = np.maximum(most, weights.max(axis=0, initial=1))
    return np.maximum(1, np.ceil(np.log2(most + 1)).astype(np.int64))


def compile_words(system: System, layout: Layout, order: np.ndarray) -> PackedNet:
    """The transitions of `system`, in the given order, as word operations for `layout`.

    Parameters
    ----------
    system : System
    layout : Layout
    order : (T,) int64
        Transitions sorted by priority group.
    """
    t_count, p_count = system.pre.shape
    tests: list[dict[int, list[int]]] = [{} for _ in range(t_count)]
    effects: list[dict[int, list[int]]] = [{} for _ in range(t_count)]
    possible = np.ones(t_count, bool)
    net_effect = system.incidence
    full = (1 << 64) - 1
    changed = (net_effect != 0) | (system.sets != KEEP)
    touched = (system.need > 0) | (system.inhibit != FREE) | changed
    for k, t in enumerate(order):
        for p in np.flatnonzero(touched[t]):
            w, shift, mask = int(layout.word[p]), int(layout.shift[p]), int(layout.mask[p])
            wide = layout.bits[p] > 1
            high = 1 << (shift + int(layout.bits[p]))
            need, below = int(system.need[t, p]), int(system.inhibit[t, p])
            possible[k] &= need <= mask and below >= 0
            if need > mask or below < 0:
                continue
            if need or 0 < below <= mask:
                row = tests[k].setdefault(w, [0] * 6)
                if need and wide:
                    row[1] |= need << shift
                    row[2] |= high
                elif need:
                    row[0] |= 1 << shift
                if 0 < below <= mask and wide:
                    row[4] |= below << shift
                    row[5] |= high
                elif 0 < below <= mask:
                    row[3] |= 1 << shift
            if changed[t, p]:
                effect = effects[k].setdefault(w, [0, 0, 0, full, 0])
                if system.sets[t, p] != KEEP:
                    effect[3] &= full ^ (mask << shift)
                    effect[4] |= int(system.sets[t, p]) << shift
                else:
                    effect[0] += int(net_effect[t, p]) << shift
                    effect[1] |= high if wide else 0
                    effect[2] |= (1 << shift) if not wide and net_effect[t, p] > 0 else 0
    group = system.group[order]
    trigger_start, trigger = _triggers(system, order)
    field_of_bit = np.zeros(layout.words * 64, np.int64)
    for place in range(p_count):
        p = np.int64(place)
        begin = int(layout.word[p]) * 64 + int(layout.shift[p])
        field_of_bit[begin : begin + int(layout.bits[p]) + 1] = p
        if layout.bits[p] == 1 and begin + 1 < len(field_of_bit):
            field_of_bit[begin + 1] = 0
    return PackedNet(
        *_rows(tests, 6),
        *_rows(effects, 5),
        np.append(np.flatnonzero(np.diff(group)) + 1, t_count).astype(np.int64),
        system.preempts[order],
        possible,
        trigger_start,
        trigger,
        field_of_bit,
        layout.mask << layout.shift,
        bool(t_count > 48 and not group.any()),
    )


def _rows(tables: list[dict[int, list[int]]], width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Start, word and operand rows of per-transition tables word -> operands."""
    start = np.zeros(len(tables) + 1, np.int64)
    start[1:] = np.cumsum([len(table) for table in tables])
    word = np.array([w for table in tables for w in sorted(table)], np.int64)
    rows = [[value % (1 << 64) for value in table[w]] for table in tables for w in sorted(table)]
    return start, word, np.array(rows, np.uint64).reshape(len(rows), width)


def _triggers(system: System, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transitions listed under one of their required places each, the one that fewest others are listed under.

    Returns
    -------
    start : (P + 2,) int64
        Row P holds the transitions that require no place.
    trigger : (T,) int64
    """
    t_count, p_count = system.pre.shape
    load = np.zeros(p_count + 1, np.int64)
    chosen = np.full(t_count, p_count, np.int64)
    popularity = (system.need > 0).sum(axis=0)
    for k, t in enumerate(order):
        required = np.flatnonzero(system.need[t] > 0)
        if len(required):
            chosen[k] = required[np.lexsort((popularity[required], load[required]))[0]]
        load[chosen[k]] += 1
    by_place = np.argsort(chosen, kind="stable").astype(np.int64)
    return np.concatenate(([0], np.cumsum(load))).astype(np.int64), by_place
