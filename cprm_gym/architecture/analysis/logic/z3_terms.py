"""Expressions as terms of the solver z3, an optional dependency (the extra ``proofs``)."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ....errors import CprmError
from ...expressions import Node


class NotInZ3(CprmError):
    """An operation that z3 does not know, such as a sine."""


def has_z3() -> bool:
    """Whether z3 is installed."""
    return importlib.util.find_spec("z3") is not None


def variables(names: Mapping[str, str]) -> dict[str, Any]:
    """A z3 variable for each name, of the kind "real", "int" or "bool"."""
    import z3

    make = {"real": z3.Real, "int": z3.Int, "bool": z3.Bool}
    return {name: make[kind](name) for name, kind in names.items()}


def term(node: Node, names: Mapping[str, Any]) -> Any:
    """The tree as a z3 term; numbers are exact decimals.

    Raises
    ------
    NotInZ3
    """
    import z3

    if node.op == "number":
        exact = Fraction(repr(node.value))
        return z3.Q(exact.numerator, exact.denominator)
    if node.op == "name":
        return names[node.name]
    if node.op in ("and", "or", "not"):
        parts = [truth(a, names) for a in node.args]
        return {"and": z3.And, "or": z3.Or, "not": z3.Not}[node.op](*parts)
    if node.op == "if":
        return z3.If(truth(node.args[0], names), number(node.args[1], names), number(node.args[2], names))
    a = [number(arg, names) for arg in node.args]
    if node.op == "**":
        power = node.args[1]
        if power.op != "number" or power.value != round(power.value) or not 0 <= power.value <= 8:
            raise NotInZ3(f"the power {power.op} is no whole number from 0 to 8")
        out = z3.Q(1, 1)
        for _ in range(int(power.value)):
            out = out * a[0]
        return out
    plain = {
        "+": lambda: a[0] + a[1], "-": lambda: a[0] - a[1], "*": lambda: a[0] * a[1], "/": lambda: a[0] / a[1], "neg": lambda: -a[0],
        "<": lambda: a[0] < a[1], "<=": lambda: a[0] <= a[1], ">": lambda: a[0] > a[1], ">=": lambda: a[0] >= a[1],
        "==": lambda: a[0] == a[1], "!=": lambda: a[0] != a[1],
        "abs": lambda: z3.If(a[0] >= 0, a[0], -a[0]), "min": lambda: z3.If(a[0] <= a[1], a[0], a[1]),
        "max": lambda: z3.If(a[0] >= a[1], a[0], a[1]), "sign": lambda: z3.If(a[0] > 0, 1, z3.If(a[0] < 0, -1, 0)),
        "clip": lambda: z3.If(a[0] < a[1], a[1], z3.If(a[0] > a[2], a[2], a[0])),
    }  # fmt: skip
    if node.op not in plain:
        raise NotInZ3(f"z3 knows no {node.op!r}")
    return plain[node.op]()


def truth(node: Node, names: Mapping[str, Any]) -> Any:
    """The tree as a z3 condition: true where it is not 0."""
    import z3

    found = term(node, names)
    return found if z3.is_bool(found) else found != 0


def number(node: Node, names: Mapping[str, Any]) -> Any:
    """The tree as a z3 number: conditions are 1 or 0."""
    import z3

    found = term(node, names)
    if z3.is_bool(found):
        return z3.If(found, z3.Q(1, 1), z3.Q(0, 1))
    return z3.ToReal(found) if z3.is_int(found) else found


def value_of(model: Any, variable: Any) -> float:
    """What a model gives a variable, as a float."""
    import z3

    found = model.eval(variable, model_completion=True)
    if z3.is_bool(found):
        return float(z3.is_true(found))
    if z3.is_algebraic_value(found):
        found = found.approx(30)
    return float(Fraction(found.as_fraction())) if z3.is_rational_value(found) else float(found.as_long())
