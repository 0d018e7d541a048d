"""Plans: an elimination and a join tree, lowered to a list of operations on one flat array.

A plan answers one question for any evidence: given the message of slice t - 1 (a product of factors), the CPDs of slice t and
the readings, what are the marginals of all hidden variables, the message of slice t and ln P(readings)? It is made once for a
connected component up to the names of its objects (`PlanSpec` is that signature) and then runs for every component of the
same signature and every agent (`kernels.run_plan`).

1. Variables of the past slice are eliminated, cheapest first. Nothing of the present is summed out: which variables the next
   slice needs is known only when the next set of relations is known.
2. The factors that are left are collected in the cliques of a join tree; their products are the new message.
3. Two passes over the tree (towards the root, and back with a division by what was sent, 0 / 0 = 0) give every marginal.
4. With clusters, the message is the product of the clusters' marginals instead (Boyen-Koller), and its loss is computed.

References
----------
Murphy, Dynamic Bayesian Networks, 2002 (interface algorithm); Jensen, Lauritzen and Olesen 1990 (two passes, division);
Boyen and Koller 1998 (projection); dissertation section 2.3.3.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np

from ..join_tree import JoinTree, join_tree
from . import kernels
from .lanes import kernels as lanes
from .operations import (
    Builder,
    Cost,
    MessageFactor,
    OutputFactor,
    PlanSpec,
    Tensor,
    allocate,
)

MAX_LOOPS = 64
WORTH_A_THREAD = 2e5
"""Operations from which on it pays to hand them to another thread."""


@dataclass
class Plan:
    """A compiled component. Made by `compile_plan`; arrays as `kernels.run_plan` takes them."""

    spec: PlanSpec
    ops: np.ndarray
    band_constants: np.ndarray
    band_rows: np.ndarray
    band_values: np.ndarray
    loops: np.ndarray
    shifts: np.ndarray
    outputs: np.ndarray
    constants: np.ndarray
    heap_size: int
    message_at: int
    soft_places: tuple[tuple[int, int], ...]
    pieces: tuple[tuple[OutputFactor, ...], ...]
    message_size: int
    marginals: dict[int, tuple[int, int]]
    marginal_size: int
    sums: int
    projects: bool
    cost: Cost
    in_lanes: bool  # whether eight rows are computed at a time: where eight heaps stay in the cache
    _scratch: list[tuple[Any, ...]] = field(default_factory=list, repr=False)

    def scratch(self, thread: int) -> tuple[Any, ...]:
        """What one thread needs for itself: counters, a heap with the constants in place or beside it, room for observed values."""
        while len(self._scratch) <= thread:
            counter, columns, constants = np.zeros(MAX_LOOPS, np.int64), max(self.spec.values, 1), len(self.constants)
            if self.in_lanes:
                room = np.zeros((self.heap_size - constants, lanes.LANES))
                values = np.zeros((lanes.LANES, columns), np.int64)
                self._scratch.append((counter, room, self.constants, values, np.zeros((lanes.LANES, 2), np.int64)))
                continue
            heap = np.zeros(self.heap_size)
            heap[:constants] = self.constants
            self._scratch.append((counter, heap, np.zeros(columns, np.int64)))
        return self._scratch[thread]

    def run(
        self,
        message: np.ndarray,
        columns: np.ndarray,
        evidence: np.ndarray,
        previous: np.ndarray,
        soft: np.ndarray,
        soft_at: np.ndarray,
        increment: np.ndarray | None = None,
        pool: ThreadPoolExecutor | None = None,
        threads: int = 1,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Run for all rows; see `kernels.run_plan` for the arguments. To `increment`, (W,), is added in place.

        With a `pool` the agents are divided among its `threads` where there is enough to do.

        Returns
        -------
        new_message : (rows, message_size) float array
        marginals : (rows, marginal_size) float array
        sums : (rows, sums) float array
        losses : (rows, 1 or 0) float array
            Kullback-Leibler divergence from the projected to the exact message, nats.
        """
        rows = len(columns) * evidence.shape[1]
        new_message = np.empty((rows, self.message_size))
        marginals = np.empty((rows, self.marginal_size))
        sums = np.empty((rows, self.sums))
        losses = np.empty((rows, int(self.projects)))
        total = np.zeros(evidence.shape[1]) if increment is None else increment
        wait = []
        run_plan = lanes.run_plan if self.in_lanes else kernels.run_plan
        for thread, (first, last) in enumerate(shares(evidence.shape[1], threads, self.cost.flops * len(columns))):
            arguments: tuple[Any, ...] = (
                self.ops,
                self.band_constants,
                self.band_rows,
                self.band_values,
                self.loops,
                self.shifts,
                *self.scratch(thread),
                self.message_at,
                message,
                columns,
                evidence,
                previous,
                soft,
                soft_at,
                self.outputs,
                new_message,
                marginals,
                sums,
                losses,
                total,
                first,
                last,
            )
            if pool is None or last - first == evidence.shape[1]:
                run_plan(*arguments)
            else:
                wait.append(pool.submit(run_plan, *arguments))
        for part in wait:
            part.result()
        return new_message, marginals, sums, losses


def shares(batch: int, threads: int, flops: float) -> list[tuple[int, int]]:
    """Agents for each thread: (first, last) pairs; one share if there is less to do than a thread is worth.

    flops : float
        Operations for one agent.
    """
    if threads == 1:
        return [(0, batch)]
    threads = int(min(threads, batch, max(1.0, batch * flops / WORTH_A_THREAD)))
    edges = [round(k * batch / threads) for k in range(threads + 1)]
    return list(itertools.pairwise(edges))


@dataclass
class _Passes:
    """What the two passes over a join tree leave behind."""

    potentials: dict[int, Tensor]
    beliefs: dict[int, Tensor]
    separators: dict[int, Tensor]
    root_slot: dict[int, int]


def _towards_root(build: Builder, tree: JoinTree, pots: Mapping[int, Tensor]) -> tuple[dict[int, Tensor], dict[int, Tensor]]:
    """Products of potential and children's messages, and the message each clique sends to its parent."""
    products: dict[int, Tensor] = {}
    sent: dict[int, Tensor] = {}
    for i in reversed(range(len(tree.cliques))):
        parts = [pots[i]] if i in pots else []
        parts += [sent[j] for j, parent in enumerate(tree.parents) if parent == i and j in sent]
        joined = build.product(parts)
        if joined is None:
            continue
        products[i] = joined
        if tree.parents[i] >= 0:
            separator = tree.cliques[i] & tree.cliques[tree.parents[i]]
            keep = [v for v in joined.scope if v in separator]
            sent[i] = build.marginal(joined, keep)
    return products, sent


def _calibrate(build: Builder, tree: JoinTree, pots: dict[int, Tensor], needed: set[int]) -> _Passes:
    """Both passes; beliefs are computed only for the cliques in `needed` and on the way to them."""
    products, sent = _towards_root(build, tree, pots)
    wanted = set(needed)
    for i in reversed(range(len(tree.cliques))):
        if i in wanted and tree.parents[i] >= 0:
            wanted.add(tree.parents[i])
    beliefs: dict[int, Tensor] = {}
    separators: dict[int, Tensor] = {}
    slots: dict[int, int] = {}
    for i, parent in enumerate(tree.parents):
        if parent < 0:
            beliefs[i] = build.owned(products[i])
            if i in pots and pots[i].buffer == products[i].buffer and pots[i].base == products[i].base:
                pots[i] = beliefs[i]
            slots[i] = build.sums
            build.emit(kernels.NORMALISE, build.one, build.one, beliefs[i], extra=build.sums)
            build.sums += 1
        elif i in wanted:
            separator = [v for v in beliefs[parent].scope if v in tree.cliques[i]]
            up = sent.get(i)
            if up is not None and set(up.scope) == set(separator):
                separator = list(up.scope)
            down = build.marginal(beliefs[parent], separator)
            separators[i] = down
            if up is None:
                beliefs[i] = down
                continue
            if up.scope == down.scope:
                ratio = build.new(down.scope)
                build.emit(kernels.DIVIDE, down, build.owned(up), ratio)
            else:
                up = build.owned(up)
                inverse = build.new(up.scope)
                build.emit(kernels.DIVIDE, build.ones(build.size(up.scope)), up, inverse)
                ratio = build.contract(down, inverse)
            beliefs[i] = build.contract(products[i], ratio)
    return _Passes(pots, beliefs, separators, slots)


def _spread(build: Builder, belief: Tensor, nodes: Sequence[int], found: dict[int, Tensor]) -> None:
    """One-variable marginals of a belief, by halving the set of variables."""
    if len(nodes) == 1:
        found[nodes[0]] = build.marginal(belief, nodes)
        return
    if len(nodes) == 2 and len(belief.scope) == 2:
        halves = [nodes[:1], nodes[1:]]
    else:
        ordered = [v for v in belief.scope if v in nodes]
        halves = [ordered[: len(ordered) // 2], ordered[len(ordered) // 2 :]]
    for half in halves:
        _spread(build, build.marginal(belief, half), half, found)


def compile_plan(spec: PlanSpec, tables: Mapping[int, np.ndarray]) -> Plan:
    """Make the plan of a component.

    Parameters
    ----------
    spec : PlanSpec
    tables : dict of int to float array
        The CPDs by number.

    Returns
    -------
    Plan
        Its memory is taken when it first runs; its `cost` is known at once.
    """
    build = Builder(spec, tables)
    present = [v for v in range(len(spec.cards)) if not spec.past[v]]
    factors = build.eliminate([build.source(f) for f in spec.factors], {v for v in range(len(spec.cards)) if spec.past[v]})
    scalars = [f for f in factors if not f.scope]
    factors = [f for f in factors if f.scope]
    scalar = build.product(scalars)
    if scalar is not None:
        build.emit(kernels.NORMALISE, build.one, build.one, build.owned(scalar), extra=build.sums)
        build.sums += 1
    scopes = [frozenset(f.scope) for f in factors]
    tree = join_tree(scopes + [frozenset(c) for c in spec.clusters], build.cards)
    members: dict[int, list[Tensor]] = {}
    for f in factors:
        members.setdefault(tree.smallest(f.scope, build.cards), []).append(f)
    pots = {i: joined for i, fs in members.items() if (joined := build.product(fs)) is not None}
    homes = {v: tree.smallest((v,), build.cards) for v in present}
    cluster_homes = {c: tree.smallest(c, build.cards) for c in spec.clusters}
    needed = set(homes.values()) | set(cluster_homes.values())
    if spec.clusters:
        needed |= set(range(len(tree.cliques)))
    passes = _calibrate(build, tree, pots, needed)

    found: dict[int, Tensor] = {}
    for i in sorted(set(homes.values())):
        _spread(build, passes.beliefs[i], [v for v in passes.beliefs[i].scope if homes[v] == i], found)
    if spec.clusters:
        pieces = _projected(build, passes, cluster_homes)
        _loose(build, passes, {v: homes[v] for v in present if not any(v in c for c in spec.clusters)})
    else:
        pieces = _kept(build, tree, passes)
    return _finish(build, pieces, found)


def _kept(build: Builder, tree: JoinTree, passes: _Passes) -> list[list[tuple[Tensor, int]]]:
    """The potentials of every tree of the forest; one of each tree is divided by the tree's sum, whose slot stands with it."""
    root_of: dict[int, int] = {}
    members: dict[int, list[int]] = {}
    for i, parent in enumerate(tree.parents):
        root_of[i] = i if parent < 0 else root_of[parent]
        if i in passes.potentials:
            members.setdefault(root_of[i], []).append(i)
    pieces = []
    for root, cliques in members.items():
        pots = [build.owned(passes.potentials[i]) for i in cliques]
        scaled = any(pot.buffer == passes.beliefs[root].buffer for pot in pots)
        pieces.append([(pot, passes.root_slot[root] if k == 0 and not scaled else -1) for k, pot in enumerate(pots)])
    return pieces


def _projected(build: Builder, passes: _Passes, homes: Mapping[tuple[int, ...], int]) -> list[list[tuple[Tensor, int]]]:
    """The marginals of the clusters; operations that compute the loss."""
    pieces = []
    for cluster, home in homes.items():
        belief = passes.beliefs[home]
        kept = build.owned(build.marginal(belief, [v for v in belief.scope if v in cluster]))
        pieces.append([(kept, -1)])
        build.emit(kernels.ENTROPY, kept, build.one, kept, extra=1)
    for i, belief in passes.beliefs.items():
        build.emit(kernels.ENTROPY, belief, build.one, belief, extra=-1)
        if i in passes.separators:
            build.emit(kernels.ENTROPY, passes.separators[i], build.one, passes.separators[i], extra=1)
    return pieces


def _loose(build: Builder, passes: _Passes, homes: Mapping[int, int]) -> None:
    """Correct the loss for variables that are in no cluster.

    The loss concerns the others only, whose entropy is that of all minus H(loose | others); the latter is at most the entropy
    given the rest of a clique. So the loss becomes an upper bound.
    """
    for v, home in homes.items():
        belief = passes.beliefs[home]
        rest = build.owned(build.marginal(belief, [u for u in belief.scope if u != v]))
        build.emit(kernels.ENTROPY, belief, build.one, belief, extra=1)
        build.emit(kernels.ENTROPY, rest, build.one, rest, extra=-1)


def _finish(build: Builder, pieces: Sequence[Sequence[tuple[Tensor, int]]], found: Mapping[int, Tensor]) -> Plan:
    """Give buffers their places and turn the lists into arrays."""
    outputs: list[list[int]] = []
    kept: set[int] = set()
    layout, column = [], 0
    for piece in pieces:
        factors = []
        for tensor, slot in piece:
            size = build.size(tensor.scope)
            factors.append(OutputFactor(tensor.scope, column, size))
            outputs.append([0, tensor.buffer, size, column, slot])
            kept.add(tensor.buffer)
            column += size
        layout.append(tuple(factors))
    message_size, column = column, 0
    marginals = {}
    for v, tensor in found.items():
        marginals[v] = column, build.cards[v]
        outputs.append([1, tensor.buffer, build.cards[v], column, -1])
        kept.add(tensor.buffer)
        column += build.cards[v]

    message_at = build.constant_size
    soft_places, at = {}, message_at + build.message_size
    for slot, size in sorted(build.soft_sizes.items()):
        soft_places[slot] = at, size
        at += size
    places, end = allocate(build.ops, build.sizes, kept, at)

    def address(t: Tensor) -> int:
        if t.buffer == -2:
            return t.base
        if t.buffer == -3:
            return message_at + t.base
        if t.buffer == -4:
            return soft_places[t.base][0]
        return places[t.buffer]

    ops = np.array([[op[0], *(address(t) for t in op[1:4]), *op[4:]] for op in build.ops], np.int64).reshape(-1, 12)
    for row in outputs:
        row[1] = places[row[1]]
    largest = max([*build.sizes, *(build.size(f.scope) for f in build.spec.factors if isinstance(f, MessageFactor)), 1])
    return Plan(
        spec=build.spec,
        ops=ops,
        band_constants=np.array([build.band_constants.get(k, 0.0) for k in range(len(ops))]),
        band_rows=np.concatenate(build.band_rows),
        band_values=np.concatenate(build.band_values),
        loops=np.array(build.loops, np.int64).reshape(-1, 4),
        shifts=np.array(build.shifts, np.int64).reshape(-1, 2),
        outputs=np.array(outputs, np.int64).reshape(-1, 5),
        constants=np.concatenate(build.constants),
        heap_size=end,
        message_at=message_at,
        soft_places=tuple(soft_places[slot] for slot in sorted(soft_places)),
        pieces=tuple(layout),
        message_size=message_size,
        marginals=marginals,
        marginal_size=column,
        sums=build.sums,
        projects=bool(build.spec.clusters),
        cost=Cost(8 * end, build.flops, largest),
        in_lanes=end - build.constant_size <= lanes.LARGEST,
    )


def structure_cost(scopes: Iterable[Iterable[Any]], past: Iterable[Any], cards: Mapping[Any, int]) -> tuple[float, float]:
    """What a step with factors over these scopes would take, without making a plan.

    Parameters
    ----------
    scopes : iterable of collections of variables
    past : iterable of variables
        Those to be eliminated first.
    cards : dict of variable to int

    Returns
    -------
    flops : float
    largest : float
        Entries of the largest table.
    """
    pool = [frozenset(s) for s in scopes if s]
    left = {v for v in past if any(v in s for s in pool)}
    flops, largest = 0.0, 1.0
    while left:
        unions = {v: frozenset().union(*(s for s in pool if v in s)) for v in left}
        sizes = {v: float(prod(cards[u] for u in unions[v])) for v in left}
        best = min(left, key=lambda v: sizes[v])
        flops += 2.0 * sizes[best]
        pool = [s for s in pool if best not in s] + [unions[best] - {best}]
        left = {v for v in left - {best} if any(v in s for s in pool)}
        largest = max(largest, sizes[best] / cards[best])
    pool = [s for s in pool if s]
    if pool:
        for clique in join_tree(pool, cards).cliques:
            size = float(prod(cards[v] for v in clique))
            flops += 8.0 * size
            largest = max(largest, size)
    return flops, largest
