"""Expressions of the one small language, evaluated over whole arrays when a model is built.

The meaning is that of `expressions`: an operation without a finite result makes the whole undefined, unless ``and``, ``or`` or
``a if c else b`` passes over it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ....errors import ExpressionError, ModelError
from ...expressions import Node, parse, unparse


def _norm_angle(a: np.ndarray) -> np.ndarray:
    return a - 2.0 * np.pi * np.ceil((a - np.pi) / (2.0 * np.pi))


def _norm_deg(a: np.ndarray) -> np.ndarray:
    return a - 360.0 * np.ceil((a - 180.0) / 360.0)


def _compare(how: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A comparison that is undefined where one of its sides is."""
    return lambda x, y: np.where(np.isnan(x) | np.isnan(y), np.nan, how(x, y))


def _truth(x: np.ndarray) -> np.ndarray:
    return np.where(np.isnan(x), np.nan, np.not_equal(x, 0.0))


_OPERATIONS: Mapping[str, Callable[..., np.ndarray]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "%": np.mod, "**": np.power, "neg": np.negative,
    "<": _compare(np.less), "<=": _compare(np.less_equal), ">": _compare(np.greater), ">=": _compare(np.greater_equal),
    "==": _compare(np.equal), "!=": _compare(np.not_equal),
    "and": lambda x, y: np.where(x == 0.0, 0.0, np.where(np.isnan(x), np.nan, _truth(y))),
    "or": lambda x, y: np.where(np.isnan(x), np.nan, np.where(x != 0.0, 1.0, _truth(y))),
    "not": lambda x: np.where(np.isnan(x), np.nan, np.equal(x, 0.0)),
    "if": lambda c, x, y: np.where(np.isnan(c), np.nan, np.where(c != 0.0, x, y)),
    "abs": np.abs, "sign": np.sign, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "floor": np.floor, "ceil": np.ceil,
    "round": np.rint, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": np.arctan2, "hypot": np.hypot, "degrees": np.degrees, "radians": np.radians, "norm_angle": _norm_angle,
    "norm_deg": _norm_deg, "clip": lambda x, a, b: np.minimum(np.maximum(x, a), b), "min": np.minimum, "max": np.maximum,
}  # fmt: skip


class Formula:
    """An expression that is called with arrays.

    Parameters
    ----------
    text : str

    Raises
    ------
    ModelError
        If the text is not in the language.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        try:
            self.node: Node = parse(text)
        except ExpressionError as error:
            raise ModelError(f"formula {text!r}: {error}") from None
        self.names: tuple[str, ...] = tuple(dict.fromkeys(n.name for n in self.node.walk() if n.op == "name"))

    def __call__(self, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
        """Value at every point.

        Parameters
        ----------
        values : mapping of str to (size,) float array
        size : int

        Returns
        -------
        (size,) float array

        Raises
        ------
        ModelError
            If a value is not finite.
        """
        with np.errstate(all="ignore"):
            out: np.ndarray = np.array(np.broadcast_to(np.asarray(_evaluate(self.node, values), dtype=float), (size,)))
        if not np.isfinite(out).all():
            at = int(np.argmin(np.isfinite(out)))
            point = ", ".join(f"{n} = {float(v[at])!r}" for n, v in values.items())
            raise ModelError(f"formula {self.text!r} has no finite value at {point}")
        return out

    def renamed(self, names: Mapping[str, str]) -> str:
        """The text with other names, in one canonical way of writing it."""
        return unparse(self.node, lambda name: names.get(name, name))

    def is_affine_in(self, *names: str) -> bool:
        """The text shows that the value is a constant plus multiples of these names when everything else is fixed."""
        return _degree(self.node, names) <= 1


def _evaluate(node: Node, values: Mapping[str, np.ndarray]) -> np.ndarray | float:
    """Values of a tree, NaN where an operation has no finite result and nothing has passed over it."""
    if node.op == "number":
        return node.value
    if node.op == "name":
        return values[node.name]
    out = np.asarray(_OPERATIONS[node.op](*(_evaluate(a, values) for a in node.args)), dtype=float)
    return np.where(np.isfinite(out), out, np.nan)


def _degree(node: Node, names: tuple[str, ...]) -> int:
    """0 without the names, 1 when affine in them, 2 for anything else."""
    if node.op == "number":
        return 0
    if node.op == "name":
        return int(node.name in names)
    degrees = [_degree(a, names) for a in node.args]
    if max(degrees) == 0:
        return 0
    if node.op in ("+", "-", "neg"):
        return max(degrees)
    if node.op == "*":
        return min(2, sum(degrees))
    if node.op == "/" and degrees[1] == 0:
        return degrees[0]
    if node.op == "if" and degrees[0] == 0:
        return max(degrees[1:])
    return 2
