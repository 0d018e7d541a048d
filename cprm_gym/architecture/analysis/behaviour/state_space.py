"""State spaces: every marking a net can reach, with shortest firing sequences, within a budget.

`explore` drives the kernel of `kernels/packed.py`: it grows the arrays, widens the fields of places that hold more tokens than
thought, reports progress, and stops with a usable partial answer when the budget of memory, markings or time is spent or the user
interrupts. References: Schmidt, LoLA (2000) for the incremental view; Laarman et al., *Boosting multi-core reachability* (2010)
for the table.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ..budget import Budget, Clock
from ..kernels import packed, table
from ..net_arrays import System
from .packing import Layout, compile_words, first_bits

Progress = Callable[[int, int, float], None]
"""Called with markings found, markings expanded, seconds."""
CHUNK_WORK = 20_000_000
"""Transitions looked at in one call into compiled code, about: a budget of time is looked at in between."""


@dataclass(eq=False)
class StateSpace:
    """The reachable markings of a system, numbered in breadth-first order; 0 is the initial one.

    Attributes
    ----------
    system : System
    complete : bool
        Whether every reachable marking is there and was expanded.
    reason : str
        Why it is not: ``""``, ``"memory"``, ``"states"``, ``"seconds"``, ``"interrupted"`` or ``"unbounded"``.
    n_states, n_edges, n_deadlocks, first_deadlock : int
        Edges count every enabled transition of every expanded marking; -1 if there is no deadlock.
    n_expanded : int
        Markings whose successors are known.
    fired : (T,) int64
        The first marking in which each transition fires, -1 if it fires in none.
    pump : tuple of (tuple of str, tuple of str), optional
        For unbounded nets: a sequence, and one that can be repeated for ever after it and adds tokens.
    links : Graph, optional
        What `graph` gives, where the edges were kept.
    """

    system: System
    layout: Layout
    net: packed.PackedNet
    order: np.ndarray
    words: np.ndarray
    parents: np.ndarray
    table: np.ndarray
    bits: np.uint64
    n_states: int = 0
    n_expanded: int = 0
    n_edges: int = 0
    n_deadlocks: int = 0
    first_deadlock: int = -1
    complete: bool = False
    reason: str = ""
    seconds: float = 0.0
    fired: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    pump: tuple[tuple[str, ...], tuple[str, ...]] | None = None
    links: Graph | None = None

    @property
    def bytes_per_state(self) -> float:
        """Memory of markings, table and predecessors per marking."""
        held = self.words.nbytes + self.parents.nbytes + self.table.nbytes
        return held / max(self.n_states, 1)

    def markings(self, first: int = 0, last: int | None = None) -> np.ndarray:
        """The markings `first` to `last` - 1 as integers, shape (n, P)."""
        last = self.n_states if last is None else min(last, self.n_states)
        out = np.empty((max(last - first, 0), len(self.system.places)), np.int64)
        packed.unpack(self.words, first, self.layout.word, self.layout.shift, self.layout.mask, out)
        return out

    def marking(self, i: int) -> np.ndarray:
        """Marking number `i`, shape (P,)."""
        return self.markings(i, i + 1)[0]

    def number_of(self, marking: np.ndarray) -> int:
        """Number of a marking, -1 if it was not reached."""
        m = np.asarray(marking, np.int64)
        if (m < 0).any() or (m > self.layout.mask.astype(np.int64)).any():
            return -1
        row = self.layout.pack(m)[None]
        return max(int(table.find(self.words, self.table, self.bits, row, 0, np.uint64(table.hash_row(row, 0)))), -1)

    def path(self, i: int, clock: Clock | None = None) -> tuple[str, ...] | None:
        """A shortest firing sequence from the initial marking to marking `i`, checked by replay; None if the time is over before."""
        chain = [i]
        while chain[-1]:
            chain.append(int(self.parents[chain[-1]]))
        chain.reverse()
        names = []
        for a, b in pairwise(chain):
            if clock is not None and clock.spent():
                return None
            before, after = self.marking(a), self.marking(b)
            able = np.flatnonzero(self.system.enabled(before))
            names.append(next(self.system.transitions[t] for t in able if np.array_equal(self.system.fire(int(t), before), after)))
        return tuple(names)

    def most_tokens(self, counted: np.ndarray | None = None) -> tuple[np.ndarray, int]:
        """Most tokens seen in each place, shape (P,), and in one marking over the places `counted` (all if None)."""
        most = np.zeros(len(self.system.places), np.int64)
        mask = np.ones(len(most), bool) if counted is None else np.asarray(counted, bool)
        layout = self.layout
        total = packed.extremes(self.words, self.n_states, layout.word, layout.shift, layout.mask, mask, most)
        return most, int(total)

    def graph(self) -> Graph:
        """The edges of all expanded markings as a compressed graph: those kept, else found in a second pass."""
        if self.links is not None:
            return self.links
        offsets = np.zeros(self.n_states + 1, np.int64)
        targets = np.empty(self.n_edges, np.int32)
        labels = np.empty(self.n_edges, np.int32)
        t_count = len(self.system.transitions)
        out, which = np.empty((t_count + 1, self.layout.words), np.uint64), np.empty(t_count + 1, np.int64)
        at = 0
        for first in range(0, self.n_expanded, 1 << 18):
            last = min(first + (1 << 18), self.n_expanded)
            at = packed.edges(self.net, self.words, self.table, self.bits, first, last, offsets, targets, labels, out, which)
        offsets[self.n_expanded :] = at
        return Graph(offsets, targets, self.order.astype(np.int32)[labels])


@dataclass(frozen=True, eq=False)
class Graph:
    """Edges of a state space: those of node i are ``offsets[i]`` to ``offsets[i + 1]``.

    Attributes
    ----------
    offsets : (N + 1,) int64
    targets : (E,) int32
        -1 for a node that was not stored.
    labels : (E,) int32
        The transition of each edge.
    """

    offsets: np.ndarray
    targets: np.ndarray
    labels: np.ndarray

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.offsets) - 1

    @property
    def sources(self) -> np.ndarray:
        """Source of each edge, shape (E,) int32."""
        return np.repeat(np.arange(self.n_nodes, dtype=np.int32), np.diff(self.offsets))


def explore(
    system: System,
    budget: Budget | None = None,
    progress: Progress | None = None,
    bounds: np.ndarray | None = None,
    chunk: int = 50_000,
    edge_memory: int = 0,
) -> StateSpace:
    """Every reachable marking of `system`, breadth first.

    Parameters
    ----------
    system : System
    budget : Budget, optional
        Where to stop with a partial answer.
    progress : callable, optional
        Called about every `chunk` markings.
    bounds : (P,) int, optional
        Most tokens per place if known; they need not be right, only save the widening of fields.
    chunk : int
        Markings per call into compiled code; an interruption waits for one chunk.
    edge_memory : int
        Bytes that the edges may take besides: they are kept while they fit, so that `StateSpace.graph` need not find them again.

    Returns
    -------
    StateSpace
        Never raises for lack of memory: see `StateSpace.complete` and `reason`.
    """
    budget, clock = (budget or Budget()).start()
    chunk = max(1, min(chunk, budget.states // 4, max(100, CHUNK_WORK // (len(system.transitions) + 1))))
    bits = first_bits(system)
    if bounds is not None:
        bits = np.maximum(bits, np.ceil(np.log2(np.asarray(bounds, np.int64).clip(1) + 1)).astype(np.int64))
    space = _start(system, Layout.of(bits))
    _keep_edges(space, 0, edge_memory)
    t_count = len(system.transitions)
    state = np.array([0, 1, 0, 0, -1, -1, 0, 0], np.int64)
    fired = np.full(t_count, -1, np.int64)
    hashes, which = np.empty(t_count + 1, np.uint64), np.empty(t_count + 1, np.int64)
    out = np.empty((t_count + 1, space.layout.words), np.uint64)
    began = time.monotonic()
    code = packed.CHUNK
    try:
        while True:
            links = space.links or _NO_LINKS
            code = packed.expand(
                space.net, space.words, space.parents, space.table, space.bits, links.offsets, links.targets, links.labels,
                fired, out, which, hashes, state, chunk,
            )  # fmt: skip
            space.n_states = int(state[1])
            space.seconds = time.monotonic() - began
            if code == packed.DONE:
                space.complete = True
                break
            if clock.spent():
                space.reason = clock.reason
            elif space.n_states >= budget.states:
                space.reason = "states"
            elif code == packed.GROW:
                space.reason = "" if _grow(space, budget) else "memory"
                _keep_edges(space, int(state[2]), edge_memory)
            elif code == packed.OVERFLOW:
                space.reason = _widen(space, int(state[0]), int(state[5]), budget)
                out = np.empty((t_count + 1, space.layout.words), np.uint64)
            if space.reason:
                break
            if progress and code == packed.CHUNK:
                progress(space.n_states, int(state[0]), space.seconds)
    except (KeyboardInterrupt, MemoryError) as stop:
        space.reason = "memory" if isinstance(stop, MemoryError) else "interrupted"
        if isinstance(stop, KeyboardInterrupt):
            clock.interrupt()
        _mend(space, int(state[1]))
    space.n_expanded, space.n_edges, space.n_deadlocks, space.first_deadlock = (int(v) for v in (state[0], state[2], state[3], state[4]))
    space.n_states = int(state[1])
    if space.links is not None:
        offsets, n_edges = space.links.offsets[: space.n_states + 1], space.n_edges
        offsets[space.n_expanded :] = n_edges
        space.links = Graph(offsets, space.links.targets[:n_edges], space.order.astype(np.int32)[space.links.labels[:n_edges]])
    space.words.resize((space.n_states, space.layout.words), refcheck=False)  # give back the room that was not needed
    space.parents.resize(space.n_states, refcheck=False)
    space.seconds = time.monotonic() - began
    space.fired = np.full(t_count, -1, np.int64)
    space.fired[space.order] = fired
    return space


_NO_LINKS = Graph(np.zeros(1, np.int64), np.zeros(0, np.int32), np.zeros(0, np.int32))


def _keep_edges(space: StateSpace, n_edges: int, memory: int) -> None:
    """Make room for the edges of the next markings; those kept are given up where they would take more than `memory` bytes."""
    need = n_edges + len(space.system.transitions) + 1
    old = space.links or (_NO_LINKS if not n_edges else None)
    if old is None:
        return
    states, edges = len(space.words) + 1, len(old.targets)
    if need > edges:
        edges = max(2 * edges, 4 * need)
    try:
        fits = 8 * (states + edges) <= memory
        space.links = Graph(_longer(old.offsets, states), _longer(old.targets, edges), _longer(old.labels, edges)) if fits else None
    except MemoryError:
        space.links = None


def _longer(array: np.ndarray, size: int) -> np.ndarray:
    """The array with room for `size` entries; itself if it has it."""
    if size <= len(array):
        return array
    grown = np.zeros(size, array.dtype)
    grown[: len(array)] = array
    return grown


def _start(system: System, layout: Layout) -> StateSpace:
    """A state space that holds the initial marking."""
    order = np.argsort(system.group, kind="stable").astype(np.int64)
    capacity = max(4096, 4 * (len(system.transitions) + 1))
    bits = np.uint64(int(np.ceil(np.log2(capacity / 0.6))))
    words = np.zeros((capacity, layout.words), np.uint64)
    words[0] = layout.pack(system.marking)
    space = StateSpace(
        system,
        layout,
        compile_words(system, layout, order),
        order,
        words,
        np.zeros(capacity, np.uint32),
        np.zeros(1 << int(bits), np.uint32),
        bits,
        n_states=1,
    )
    table.rehash(space.words, 1, space.table, space.bits)
    return space


def _grow(space: StateSpace, budget: Budget) -> bool:
    """Make room for more markings; False if the budget forbids it."""
    t_count = len(space.system.transitions)
    capacity, slots = len(space.words), len(space.table)
    if space.n_states + t_count + 1 >= capacity:
        capacity = max(capacity * 3 // 2, capacity + 4 * (t_count + 1))
    if space.n_states + t_count + 1 >= slots * 7 // 10:
        slots *= 2
    row = 8 * space.layout.words + 4
    if slots > 2**32 or capacity * row + slots * 4 + (slots * 4 if slots > len(space.table) else 0) > budget.memory:
        return False
    if capacity > len(space.words):
        flat = space.words.reshape(-1)
        grown = np.empty((capacity, space.layout.words), np.uint64)
        grown.reshape(-1)[: space.n_states * space.layout.words] = flat[: space.n_states * space.layout.words]
        space.words = grown
        parents = np.empty(capacity, np.uint32)
        parents[: space.n_states] = space.parents[: space.n_states]
        space.parents = parents
    if slots > len(space.table):
        space.table = np.zeros(0, np.uint32)  # the old one goes before the new one comes
        space.table = np.zeros(slots, np.uint32)
        space.bits = np.uint64(int(space.bits) + 1)
        table.rehash(space.words, space.n_states, space.table, space.bits)
    return True


def _mend(space: StateSpace, n_states: int) -> None:
    """Make the table whole again after a growth that was cut short."""
    space.table = np.zeros(1 << int(space.bits), np.uint32)
    table.rehash(space.words, n_states, space.table, space.bits)


def _widen(space: StateSpace, i: int, k: int, budget: Budget) -> str:
    """Widen the fields that transition number `k` (in exploration order) overflows in marking `i`; a reason to stop or ``""``."""
    system, old = space.system, space.layout
    t = int(space.order[k])
    before = space.marking(i)
    after = system.fire(t, before)
    space.pump = _pump(space, i, t, after)
    if space.pump:
        return "unbounded"
    bits = np.maximum(old.bits, np.ceil(np.log2(after.clip(1) + 1)).astype(np.int64))
    if bits.max() > 40:
        return "unbounded"
    layout = Layout.of(bits)
    if len(space.words) * (8 * (layout.words + old.words) + 4) + space.table.nbytes > budget.memory:
        return "memory"
    words = np.empty((len(space.words), layout.words), np.uint64)
    packed.repack(space.words, space.n_states, old.word, old.shift, old.mask, words, layout.word, layout.shift)
    space.words, space.layout = words, layout
    space.net = compile_words(system, layout, space.order)
    space.table[:] = 0
    table.rehash(space.words, space.n_states, space.table, space.bits)
    return ""


def _pump(space: StateSpace, i: int, t: int, after: np.ndarray) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """If a predecessor of marking `i` is covered by the marking after `t`: the way to it and the sequence to repeat.

    The sequence can be repeated for ever where the places that grow are `System.pumpable`.
    """
    chain = [i]
    while chain[-1]:
        chain.append(int(space.parents[chain[-1]]))
    rows = np.array(chain, np.int64)
    out = np.empty((len(rows), len(after)), np.int64)
    packed.unpack_rows(space.words, rows, space.layout.word, space.layout.shift, space.layout.mask, out)
    grows = out < after
    covered = np.flatnonzero((out <= after).all(axis=1) & grows.any(axis=1) & ~grows[:, ~space.system.pumpable].any(axis=1))
    if not len(covered):
        return None
    whole = space.path(i) or ()
    prefix = len(chain) - 1 - int(covered[0])
    return whole[:prefix], (*whole[prefix:], space.system.transitions[t])
