"""The lemmas behind the closed form, for all parameters at once, as claims for z3 (specification/appendix_a.md 4).

Each is written without division; a lemma holds when its negation cannot be satisfied.
"""

from __future__ import annotations

from typing import NamedTuple

from ..logic.implication import Implication


class Lemma(NamedTuple):
    """Wherever `given` is true, so is `claim`; all numbers real."""

    name: str
    given: str
    claim: str


_WORLD = "0 < g < 1 and 0 <= ds < 1 and 0 <= da < 1 and 0 < w and w * (1 + ds) == 1 - g and 0 < kappa and kappa * (1 - g) == g * (1 + ds)"
_BOUND = "d > 0 and s >= 0 and d >= kappa * s"

_MOVED = (
    "0 < w < 1 and 0 <= da < 1 and d > 0 and 0 <= u <= w * d and 0 <= r <= 1 and q >= 1 and b >= w * r * d - q * u and -da <= xi <= da "
    "and (1 + da) * v == (1 + da) * u + b * (1 + xi)"
)
"""u is g s, b is (1 + da) a, r and q are what the observer does to distance and speed."""

LEMMAS = (
    Lemma("L1: a turn does not overshoot", f"{_WORLD} and {_BOUND} and v == g * s", "(1 + ds) * v <= (1 - g) * d"),
    Lemma(
        "L1: an acceleration forward does not overshoot",
        f"{_WORLD} and {_BOUND} and c * (1 + ds) * (1 + da) == 1 - g and dc <= d and sc >= s and 0 <= a <= c * (dc - kappa * sc) "
        "and -da <= xi <= da and v == g * s + a * (1 + xi)",
        "(1 + ds) * v <= (1 - g) * d",
    ),
    Lemma(
        "L1: braking does not overshoot", f"{_WORLD} and {_BOUND} and a <= 0 and -da <= xi <= da and v == g * s + a * (1 + xi)",
        "(1 + ds) * v <= (1 - g) * d",
    ),
    Lemma("L1: the invariant stays", f"{_WORLD} and d > 0 and v >= 0 and (1 + ds) * v <= (1 - g) * d and e >= d - (1 + ds) * v",
          "e >= g * d and e >= kappa * v"),
    Lemma("L2: an acceleration goes forward", f"{_MOVED} and b >= 0", "(1 + da) * v >= w * (1 - da) * r * d or v >= w * (1 - q + r) * d"),
    Lemma("L2: braking still goes forward", f"{_MOVED} and b <= 0", "v >= w * (1 - q + r) * d"),
    Lemma(
        "L3: a disc in a cone",
        "0 < w < 1 and 0 <= ds < 1 and d > 0 and 0 <= v <= w * d and se * se + ce * ce == 1 and se >= 0 and x * x + y * y <= ds * ds "
        "and m >= w * (se + ds)",
        "d * m - v * (se * (1 + x) - ce * y) >= 0",
    ),
    Lemma(
        "L4: progress is convex in the speed",
        "0 < w < 1 and -1 <= k <= 1 and d > 0 and 0 <= v <= w * d and q >= 0 and q * q == d * d - 2 * d * v * k + v * v "
        "and z >= 0 and z * z == 1 - 2 * w * k + w * w",
        "w * q <= w * d - v + v * z",
    ),
    Lemma(
        "L5: what is off axis after a turn",
        "h >= 0 and dw >= 0 and -h <= e <= h and -dw <= xi <= dw and t >= 0 and off == -e - xi * (t + e)",
        "off <= h + dw * (t + h) and off >= -(h + dw * (t + h))",
    ),
)  # fmt: skip


def prove_lemmas(milliseconds: int = 120_000) -> dict[str, Implication]:
    """Every lemma by z3; those that it does not decide in time say so.

    Parameters
    ----------
    milliseconds : int
        For each.
    """
    import z3

    from ...expressions import Expression
    from ..logic.z3_terms import truth, value_of, variables

    found = {}
    for lemma in LEMMAS:
        given, claim = Expression(lemma.given), Expression(lemma.claim)
        names = variables(dict.fromkeys((*given.names, *claim.names), "real"))
        solver = z3.SolverFor("QF_NRA")
        solver.set("timeout", milliseconds)
        solver.add(truth(given.tree, names), z3.Not(truth(claim.tree, names)))
        answer = solver.check()
        if answer == z3.unsat:
            found[lemma.name] = Implication(True, "z3")
        elif answer == z3.sat:
            model = solver.model()
            found[lemma.name] = Implication(False, "z3", {k: value_of(model, v) for k, v in names.items()})
        else:
            found[lemma.name] = Implication(None, f"z3: {solver.reason_unknown()}")
    return found
