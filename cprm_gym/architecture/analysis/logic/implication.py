"""Does one condition follow from another?"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field

from ....errors import ExpressionError, ModelError, did_you_mean
from ...expressions import Expression, Node
from .boxes import Claim, prove
from .z3_terms import NotInZ3, has_z3, truth, value_of, variables

KINDS = ("real", "int", "bool")
CELLS = 20_000
"""Points up to which conditions on single variables are decided by trying them all."""
MILLISECONDS = 2000
"""That z3 may take."""


@dataclass(frozen=True)
class Implication:
    """An answer.

    Attributes
    ----------
    holds : bool or None
        None: not decided.
    method : str
        "cells", "boxes", "z3", or why none could.
    counterexample : mapping of str to float
        Where the first is true and the second false.
    vacuous : bool
        Whether the first is never true, so that anything follows: hardly what was meant.
    """

    holds: bool | None
    method: str
    counterexample: Mapping[str, float] = field(default_factory=dict)
    vacuous: bool = False

    def __str__(self) -> str:
        if self.holds is None:
            return f"undecided ({self.method})"
        if self.holds:
            return f"follows ({self.method})" + (", but the condition before can never be true" if self.vacuous else "")
        return "does not follow: " + ", ".join(f"{k} = {v:g}" for k, v in self.counterexample.items())


def implies(
    first: str, second: str, kinds: Mapping[str, str] | None = None, ranges: Mapping[str, tuple[float, float]] | None = None
) -> Implication:
    """Whether the second condition is true wherever the first is.

    Conditions on single variables are decided exactly by one point of each cell that their thresholds cut; others by z3 where it is
    installed (linear and polynomial ones), else by cutting boxes, where `ranges` bound every variable.

    Parameters
    ----------
    first, second : str
        Expressions.
    kinds : mapping of str to {"real", "int", "bool"}, optional
        Of the variables; default real.
    ranges : mapping of str to (low, high), optional
        Within which it is asked.

    Raises
    ------
    ExpressionError, ModelError

    Examples
    --------
    >>> print(implies("0 <= x <= 2", "x < 1 or x > 1"))
    does not follow: x = 1
    >>> print(implies("dist < 0.7 and abs(dir) < 0.1", "dist < 1"))
    follows (cells)
    """
    a, b = Expression(first), Expression(second)
    names = tuple(dict.fromkeys((*a.names, *b.names)))
    types = {name: (kinds or {}).get(name, "real") for name in names}
    for name, kind in types.items():
        if kind not in KINDS:
            raise ModelError(f"variable {name!r}: kind {kind!r}; allowed are {', '.join(KINDS)}.{did_you_mean(kind, KINDS)}")
    inside = [f"{low!r} <= {name} <= {high!r}" for name, (low, high) in (ranges or {}).items() if name in types]
    assumed = Expression(" and ".join([f"({first})", *inside]))
    points = _cells((assumed.tree, b.tree), types)
    if points is not None:
        return _by_points(assumed, b, points)
    found = Implication(None, "z3 is not installed, and not every variable has a range")
    if has_z3():
        found = _by_z3(assumed, b, types)
    if found.holds is None and ranges is not None and set(names) <= set(ranges) and "int" not in types.values():
        verdict = prove(Claim("implication", (assumed.text,), second), {n: ranges[n] for n in names})
        if verdict.holds is not None:
            return Implication(verdict.holds, "boxes", verdict.point)
    return found


def _by_points(first: Expression, second: Expression, points: Mapping[str, list[float]]) -> Implication:
    vacuous = True
    for values in itertools.product(*points.values()):
        point = dict(zip(points, values))
        if first.evaluate(point):
            vacuous = False
            if not second.evaluate(point):
                return Implication(False, "cells", point)
    return Implication(True, "cells", vacuous=vacuous)


def _cells(trees: tuple[Node, ...], kinds: Mapping[str, str]) -> dict[str, list[float]] | None:
    """For each variable points that meet every cell of its thresholds; None where conditions are not on single variables."""
    cuts: dict[str, set[float]] = {name: set() for name in kinds}
    if not all(_thresholds(tree, cuts) for tree in trees):
        return None
    points: dict[str, list[float]] = {}
    total = 1
    for name, kind in kinds.items():
        marks = sorted(cuts[name])
        if kind == "bool":
            points[name] = [0.0, 1.0]
        elif kind == "int":
            points[name] = sorted({float(k) for m in marks for k in (int(m // 1) - 1, int(m // 1), int(m // 1) + 1)} or {0.0})
        else:
            between = [(x + y) / 2 for x, y in itertools.pairwise(marks)]
            ends = [marks[0] - 1.0, marks[-1] + 1.0] if marks else [0.0]
            points[name] = sorted({*marks, *between, *ends})
        total *= len(points[name])
    return points if total <= CELLS else None


def _thresholds(node: Node, cuts: dict[str, set[float]]) -> bool:
    """Collect what single variables are compared with; whether there is nothing else."""
    if node.op in ("and", "or", "not"):
        return all(_thresholds(a, cuts) for a in node.args)
    if node.op == "name":
        cuts[node.name].add(0.0)
        return True
    if node.op in ("<", "<=", ">", ">=", "==", "!="):
        left, right = node.args
        if _constant(left) is not None:
            left, right = right, left
        value = _constant(right)
        if value is None:
            return False
        if left.op == "name":
            cuts[left.name].add(value)
            return True
        if left.op == "abs" and left.args[0].op == "name":
            cuts[left.args[0].name] |= {value, -value, 0.0}
            return True
    return node.op == "number"


def _constant(node: Node) -> float | None:
    if any(n.op == "name" for n in node.walk()):
        return None
    from ...expressions.interpreter import interpret

    return interpret(node, {})


def _by_z3(first: Expression, second: Expression, kinds: Mapping[str, str]) -> Implication:
    import z3

    try:
        names = variables(kinds)
        a, b = truth(first.tree, names), truth(second.tree, names)
    except NotInZ3 as error:
        return Implication(None, str(error))
    solver = z3.Solver()
    solver.set("timeout", MILLISECONDS)
    solver.add(a, z3.Not(b))
    answer = solver.check()
    if answer == z3.unsat:
        empty = z3.Solver()
        empty.set("timeout", MILLISECONDS)
        empty.add(a)
        return Implication(True, "z3", vacuous=empty.check() == z3.unsat)
    if answer == z3.sat:
        model = solver.model()
        point = {name: value_of(model, variable) for name, variable in names.items()}
        try:
            if first.evaluate(point) and not second.evaluate(point):
                return Implication(False, "z3", point)
        except ExpressionError:
            return Implication(None, "z3 points to where the conditions have no value")
        return Implication(False, "z3, up to rounding of the point", point)
    return Implication(None, f"z3: {solver.reason_unknown()}")
