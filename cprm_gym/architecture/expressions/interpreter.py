"""The tree of an expression, interpreted in plain Python: the reference for the compiled form."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from .language import Node

_NAN = math.nan


def _mod(x: float, y: float) -> float:
    return x % y if y != 0.0 else _NAN


def _norm(x: float, half: float) -> float:
    """`x` brought into the half-open turn (-half, half]."""
    turned = math.fmod(x, 2.0 * half)
    if turned > half:
        return turned - 2.0 * half
    return turned + 2.0 * half if turned <= -half else turned


_UNARY: Mapping[str, Callable[[float], float]] = {
    "neg": lambda x: -x,
    "not": lambda x: float(x == 0.0),
    "abs": abs,
    "sign": lambda x: float((x > 0.0) - (x < 0.0)),
    "sqrt": math.sqrt, "exp": math.exp, "log": math.log,
    "floor": lambda x: float(math.floor(x)),
    "ceil": lambda x: float(math.ceil(x)),
    "round": lambda x: float(round(x)),
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos, "atan": math.atan,
    "degrees": lambda x: x * (180.0 / math.pi),
    "radians": lambda x: x * (math.pi / 180.0),
    "norm_angle": lambda x: _norm(x, math.pi),
    "norm_deg": lambda x: _norm(x, 180.0),
}  # fmt: skip

_BINARY: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": lambda x, y: x / y,
    "%": _mod,
    "**": math.pow,
    "<": lambda x, y: float(x < y),
    "<=": lambda x, y: float(x <= y),
    ">": lambda x, y: float(x > y),
    ">=": lambda x, y: float(x >= y),
    "==": lambda x, y: float(x == y),
    "!=": lambda x, y: float(x != y),
    "min": min,
    "max": max,
    "atan2": math.atan2,
    "hypot": lambda x, y: math.sqrt(x * x + y * y),
}


def interpret(node: Node, values: Mapping[str, float]) -> float:
    """The value of `node`, or NaN where it is undefined.

    Parameters
    ----------
    node : Node
    values : mapping
        Name -> value, for every name of the tree.
    """
    op = node.op
    if op == "number":
        return node.value
    if op == "name":
        value = float(values[node.name])
        return value if math.isfinite(value) else _NAN
    first = interpret(node.args[0], values)
    if first != first:
        return _NAN
    if op in ("and", "or"):
        if (first != 0.0) == (op == "or"):
            return float(op == "or")
        second = interpret(node.args[1], values)
        return second if second != second else float(second != 0.0)
    if op == "if":
        return interpret(node.args[1] if first != 0.0 else node.args[2], values)
    rest = [interpret(arg, values) for arg in node.args[1:]]
    if any(x != x for x in rest):
        return _NAN
    try:
        if op == "clip":
            result = min(max(first, rest[0]), rest[1])
        else:
            result = _BINARY[op](first, rest[0]) if rest else _UNARY[op](first)
    except (ValueError, ZeroDivisionError, OverflowError):
        return _NAN
    return result if math.isfinite(result) else _NAN
