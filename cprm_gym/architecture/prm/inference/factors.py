"""Factors: non-negative tables over named variables, for one net or for many agents at once.

Every table has a leading axis for the agents, of length 1 where they share it. This is the plain, readable inference that the
static engine, smoothing and joint queries use; the filter's steps run on compiled plans instead (`plans.py`).

References
----------
Koller and Friedman 2009, chapter 9; dissertation section 2.3.2.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from .join_tree import best_order, neighbours


@dataclass(frozen=True, eq=False)
class Factor:
    """A table over `scope`, shape (agents or 1, card, ...)."""

    scope: tuple[Any, ...]
    table: np.ndarray

    @property
    def cards(self) -> dict[Any, int]:
        """Number of states of each variable."""
        return dict(zip(self.scope, self.table.shape[1:]))

    @property
    def size(self) -> int:
        """Entries for one agent."""
        return prod(self.table.shape[1:])

    def over(self, scope: Sequence[Any]) -> np.ndarray:
        """The table with its axes in the order of `scope`, of length 1 for the variables it lacks."""
        order = [self.scope.index(v) + 1 for v in scope if v in self.scope]
        moved = np.transpose(self.table, [0, *order])
        shape = [self.table.shape[0], *(self.cards.get(v, 1) for v in scope)]
        return moved.reshape(shape)

    def sum_onto(self, keep: Collection[Any]) -> Factor:
        """Sum over all variables that are not in `keep`."""
        drop = tuple(i + 1 for i, v in enumerate(self.scope) if v not in keep)
        return Factor(tuple(v for v in self.scope if v in keep), self.table.sum(axis=drop)) if drop else self

    def max_onto(self, keep: Collection[Any]) -> Factor:
        """Maximum over all variables that are not in `keep`."""
        drop = tuple(i + 1 for i, v in enumerate(self.scope) if v not in keep)
        return Factor(tuple(v for v in self.scope if v in keep), self.table.max(axis=drop)) if drop else self

    def scaled(self) -> tuple[Factor, np.ndarray]:
        """The table divided by each agent's largest entry, and the logarithm of that entry (-inf for a table of zeros)."""
        top = self.table.reshape(self.table.shape[0], -1).max(axis=1) if self.scope else self.table.reshape(-1)
        safe = np.where(top > 0, top, 1.0)
        with np.errstate(divide="ignore"):
            return Factor(self.scope, self.table / safe.reshape(-1, *[1] * len(self.scope))), np.log(top)


def union(scopes: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
    """The variables of several scopes, in the order in which they first appear."""
    return tuple(dict.fromkeys(v for scope in scopes for v in scope))


def multiply(a: Factor, b: Factor) -> Factor:
    """Product of two factors."""
    scope = union([a.scope, b.scope])
    return Factor(scope, a.over(scope) * b.over(scope))


def contract(a: Factor, b: Factor, drop: Collection[Any] = ()) -> Factor:
    """Product of two factors, summed over `drop`; by matrix multiplication where something is summed."""
    scope = union([a.scope, b.scope])
    if not any(v in drop for v in scope):
        return multiply(a, b)
    a, b = (
        a.sum_onto([v for v in a.scope if v not in drop or v in b.scope]),
        b.sum_onto([v for v in b.scope if v not in drop or v in a.scope]),
    )
    both = [v for v in a.scope if v in b.scope and v not in drop]
    left = [v for v in a.scope if v not in b.scope]
    right = [v for v in b.scope if v not in a.scope]
    summed = [v for v in a.scope if v in b.scope and v in drop]
    cards = {**a.cards, **b.cards}

    def shaped(f: Factor, order: list[list[Any]]) -> np.ndarray:
        table = f.over([v for part in order for v in part])
        return table.reshape(f.table.shape[0], *(prod(cards[v] for v in part) for part in order))

    product = shaped(a, [both, left, summed]) @ shaped(b, [both, summed, right])
    order = both + left + right
    return Factor(tuple(order), product.reshape(product.shape[0], *(cards[v] for v in order)))


def contract_all(factors: Sequence[Factor], keep: Sequence[Any]) -> Factor:
    """Product of all factors, summed onto `keep`: variable elimination.

    Parameters
    ----------
    factors : sequence of Factor
    keep : sequence of variables
        Axes of the result, in this order; each must be in some factor.

    Returns
    -------
    Factor
        Not normalised. Factors that have no link to `keep` are multiplied in as numbers.
    """
    pool = list(factors)
    cards: dict[Any, int] = {}
    for f in pool:
        cards.update(f.cards)
    graph = neighbours([f.scope for f in pool])
    for v in keep:
        graph.setdefault(v, set()).update(u for u in keep if u != v)
    hidden = [v for v in _order(graph, cards, keep) if v not in keep]
    for v in hidden:
        inside = sorted((f for f in pool if v in f.scope), key=lambda f: f.size)
        pool = [f for f in pool if v not in f.scope]
        while len(inside) > 2:
            inside = sorted([multiply(inside[0], inside[1]), *inside[2:]], key=lambda f: f.size)
        joined = contract(inside[0], inside[1], (v,)) if len(inside) == 2 else inside[0].sum_onto([u for u in inside[0].scope if u != v])
        pool.append(joined)
    result = Factor((), np.ones(1))
    for f in sorted(pool, key=lambda f: f.size):
        result = multiply(result, f)
    return Factor(tuple(keep), result.over(keep))


def _order(graph: dict[Any, set[Any]], cards: dict[Any, int], keep: Sequence[Any]) -> list[Any]:
    """A greedy order of elimination of the variables that are not kept."""
    if len(keep) <= 1:
        return best_order(graph, cards)
    return best_order({v: {u for u in around if u not in keep} for v, around in graph.items() if v not in keep}, cards)


def sample_factors(factors: Sequence[Factor], batch: int, count: int, rng: np.random.Generator) -> dict[Any, np.ndarray]:
    """Samples of all variables, in proportion to the product of the factors.

    Parameters
    ----------
    factors : sequence of Factor
    batch : int
        Number of agents.
    count : int
        Samples for each agent.
    rng : Generator

    Returns
    -------
    dict of node to (W, count) int array
    """
    pool = list(factors)
    cards: dict[Any, int] = {}
    for f in pool:
        cards.update(f.cards)
    graph = neighbours([f.scope for f in pool])
    order = best_order(graph, cards)
    trace: list[tuple[Any, Factor]] = []
    for v in order:
        inside = sorted((f for f in pool if v in f.scope), key=lambda f: f.size)
        pool = [f for f in pool if v not in f.scope]
        joined = inside[0]
        for f in inside[1:]:
            joined = multiply(joined, f)
        joined = joined.scaled()[0]
        trace.append((v, joined))
        pool.append(joined.sum_onto([u for u in joined.scope if u != v]))
    found: dict[Any, np.ndarray] = {}
    agents = np.arange(batch)[:, None]
    for v, joined in reversed(trace):
        others = [u for u in joined.scope if u != v]
        table = np.broadcast_to(joined.over([*others, v]), (batch, *(cards[u] for u in others), cards[v]))
        index = (np.broadcast_to(agents, (batch, count)), *(found[u] for u in others))
        rows = table[index]
        cumulative = np.cumsum(rows, axis=-1)
        draws = rng.random((batch, count, 1)) * cumulative[..., -1:]
        found[v] = (cumulative <= draws).sum(axis=-1).clip(max=cards[v] - 1)
    return found
