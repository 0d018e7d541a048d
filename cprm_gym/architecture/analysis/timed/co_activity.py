"""Which modules may be active at the same time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...petri import CompiledNet, instances
from ..kernels import timed as kernels
from ..structure.invariants import never, semiflows
from ..verdicts import Verdict
from .state_space import UNDECIDED, TimedStateSpace


@dataclass(frozen=True)
class CoActivity:
    """Which module instances may be active (their `ongoing` marked) at the same time.

    Attributes
    ----------
    instances : tuple of str
    together : dict from (a, b) to verdict
        True with a run, False, or None.
    invariants : dict from (a, b) to str
        The P-invariant that proves exclusion, where there is one.
    sets : tuple of tuple of str
        Every set of instances found active at the end of an instant.
    """

    instances: tuple[str, ...]
    together: Mapping[tuple[str, str], Verdict]
    invariants: Mapping[tuple[str, str], str]
    sets: tuple[tuple[str, ...], ...]

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        pairs = [
            {"modules": list(pair), "together": v.holds, "why": self.invariants.get(pair, v.why), "run": [str(s) for s in v.run]}
            for pair, v in self.together.items()
        ]
        return {"instances": list(self.instances), "pairs": pairs, "sets": [list(s) for s in self.sets]}


def co_activity(compiled: CompiledNet, space: TimedStateSpace, enough: Callable[[], bool] = never) -> CoActivity | None:
    """Which module instances may be active together; None for a net without modules that have an `ongoing` port.

    Exclusion is proved by a P-invariant where one does it (§2.2.6, conservation analysis), by exploration otherwise. Invariants are those
    of the net together with its caller, their values those of the marking that the exploration starts from.
    """
    found = {
        path: instance.places[instance.net.ports.ongoing]
        for path, instance in instances(compiled.source).items()
        if path and instance.net.ports.ongoing
    }
    if not found:
        return None
    names = tuple(found)
    columns = [space.system.place(p) for p in found.values()]
    settled = np.flatnonzero((space.kinds == kernels.QUIET) & space.real)
    active = space.markings[settled][:, columns] > 0
    maybe = space.markings[space.kinds == kernels.QUIET][:, columns] > 0
    flows = semiflows(space.system.untimed, "P", enough=enough).vectors  # of the net with its caller, from the marking that was explored
    together: dict[tuple[str, str], Verdict] = {}
    proofs: dict[tuple[str, str], str] = {}
    for a in range(len(names)):
        for b in range(a + 1, len(names)):
            pair, p, q = (names[a], names[b]), found[names[a]], found[names[b]]
            proof = next((v for v in flows if v.weights.get(p, 0) + v.weights.get(q, 0) > v.value and {p, q} <= v.support), None)
            both = np.flatnonzero(active[:, a] & active[:, b])
            if p == q:
                together[pair] = Verdict(True, "they share the place ongoing")
            elif proof is not None:
                together[pair] = Verdict(False, "P-invariant")
                proofs[pair] = f"{proof} = {proof.value}"
            elif len(both):
                together[pair] = Verdict(True, "both are ongoing here", space.real_run(int(settled[both[0]])))
            elif (maybe[:, a] & maybe[:, b]).any():
                together[pair] = Verdict(None, UNDECIDED)
            elif space.complete:
                together[pair] = Verdict(False, "never seen together in the whole state space")
            else:
                together[pair] = Verdict(None, f"never seen together; the exploration stopped: {space.reason}")
    rows = np.unique(active, axis=0) if len(active) else np.zeros((0, len(names)), bool)
    sets = sorted((tuple(names[k] for k in np.flatnonzero(row)) for row in rows), key=lambda s: (len(s), s))
    return CoActivity(names, together, proofs, tuple(s for s in sets if s))
