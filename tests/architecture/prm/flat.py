"""Enumeration by one big sum: the slow, obviously right way to ask a small flat net."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from cprm_gym.architecture.prm.grounding import GroundSlice


def joint(ground: GroundSlice, evidence: Mapping[str, int], keep: Iterable[str]) -> np.ndarray:
    """Unnormalised joint of `keep` with the evidence (state indices), axes as in `keep`."""
    names = {name: k for k, name in enumerate(ground.variables)}
    operands: list[object] = []
    for cpd in ground.cpds:
        assert all(lag == 0 for _, lag in cpd.parents), "only static nets can be enumerated"
        scope = [*(p for p, _ in cpd.parents), cpd.child]
        index = tuple(evidence.get(v, slice(None)) for v in scope)
        operands += [cpd.table[index], [names[v] for v in scope if v not in evidence]]
    kept = [names[v] for v in keep]
    return np.einsum(*operands, kept, optimize="greedy")


def marginal(ground: GroundSlice, name: str, evidence: Mapping[str, int] | None = None) -> np.ndarray:
    """Posterior of one variable."""
    table = joint(ground, evidence or {}, (name,))
    return np.asarray(table / table.sum())
