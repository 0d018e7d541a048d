"""Sums over a flat static net, written as simply as can be: the slow, obviously right way to ask it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from cprm_gym.architecture.prm.grounding.grounding import GroundSlice

Table = tuple[tuple[str, ...], np.ndarray]


def _times(a: Table, b: Table) -> Table:
    scope = tuple(dict.fromkeys((*a[0], *b[0])))
    axes = {v: k for k, v in enumerate(scope)}
    return scope, np.einsum(a[1], [axes[v] for v in a[0]], b[1], [axes[v] for v in b[0]], list(range(len(scope))))


def joint(ground: GroundSlice, evidence: Mapping[str, int], keep: Iterable[str]) -> np.ndarray:
    """Unnormalised joint of `keep` with the evidence (state indices), axes as in `keep`: one variable summed out after another."""
    kept = tuple(keep)
    pool: list[Table] = []
    for cpd in ground.cpds:
        assert all(lag == 0 for _, lag in cpd.parents), "only static nets can be summed"
        scope = [*(p for p, _ in cpd.parents), cpd.child]
        table = cpd.table[tuple(evidence.get(v, slice(None)) for v in scope)]
        pool.append((tuple(v for v in scope if v not in evidence), table))
    rest = {v for scope, _ in pool for v in scope} - set(kept)
    while rest:
        joined = {v: {u for scope, _ in pool if v in scope for u in scope} for v in sorted(rest)}
        v = min(joined, key=lambda name: np.prod([float(ground.variables[u].card) for u in joined[name]]))
        product: Table = ((), np.ones(()))
        for part in [t for t in pool if v in t[0]]:
            product = _times(product, part)
        pool = [t for t in pool if v not in t[0]]
        pool.append((tuple(u for u in product[0] if u != v), product[1].sum(axis=product[0].index(v))))
        rest.remove(v)
    total: Table = ((), np.ones(()))
    for part in pool:
        total = _times(total, part)
    assert set(total[0]) == set(kept)
    return np.transpose(total[1], [total[0].index(v) for v in kept])


def marginal(ground: GroundSlice, name: str, evidence: Mapping[str, int] | None = None) -> np.ndarray:
    """Posterior of one variable."""
    table = joint(ground, evidence or {}, (name,))
    return np.asarray(table / table.sum())
