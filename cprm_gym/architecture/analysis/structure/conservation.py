"""Conservation: a positive weighting of all places that no transition changes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..net_arrays import System
from ..verdicts import Verdict


def conservative(system: System, seconds: float = float("inf")) -> Verdict:
    """Whether some positive weighting of all places never changes: then every place is bounded, whatever the initial marking.

    Parameters
    ----------
    system : System
    seconds : float
        After which to give up.
    """
    from scipy.optimize import linprog  # slow to import

    if (system.sets >= 0).any():
        return Verdict(None, "set arcs do not keep weighted sums")
    if not len(system.places) or not len(system.transitions):
        return Verdict(True)
    p = len(system.places)
    if seconds <= 0.0:
        return Verdict(None, "no time was left for it")
    found = linprog(
        np.ones(p),
        A_eq=system.incidence.astype(float),
        b_eq=np.zeros(len(system.transitions)),
        bounds=[(1, None)] * p,
        method="highs",
        options={"time_limit": seconds} if seconds < float("inf") else {},
    )
    if found.status == 2:
        return Verdict(False, "no positive weighting of all places is kept by every transition")
    if found.status != 0:
        return Verdict(None, found.message)
    return _exact_weights(system, found.x)


def _exact_weights(system: System, weights: Any) -> Verdict:
    """The weighting found in floating point, confirmed in whole numbers."""
    from fractions import Fraction
    from math import lcm

    parts = [Fraction(float(w)).limit_denominator(10_000) for w in weights]
    scale = lcm(*(f.denominator for f in parts))
    whole = [int(f * scale) for f in parts]
    kept = all(sum(int(row[q]) * whole[q] for q in row.nonzero()[0]) == 0 for row in system.incidence)
    if not kept or min(whole) < 1:
        return Verdict(None, "a weighting was found, but could not be confirmed in whole numbers")
    shown = [f"{name} {w}" for name, w in zip(system.places, whole)]
    return Verdict(True, "weights " + ", ".join(shown[:8]) + (" ..." if len(shown) > 8 else ""))
