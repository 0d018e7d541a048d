"""Joint samples from a product of factors, by elimination and a walk back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .factors import Factor, multiply
from .join_tree import best_order, neighbours


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
