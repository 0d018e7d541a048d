"""From the tree of an expression to the byte code of `kernels`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import kernels as k
from .language import Node

_OPERATIONS: Mapping[str, int] = {
    "neg": k.NEG, "not": k.NOT, "abs": k.ABS, "sign": k.SIGN, "sqrt": k.SQRT, "exp": k.EXP, "log": k.LOG, "floor": k.FLOOR,
    "ceil": k.CEIL, "round": k.ROUND, "sin": k.SIN, "cos": k.COS, "tan": k.TAN, "asin": k.ASIN, "acos": k.ACOS,
    "atan": k.ATAN, "degrees": k.DEGREES, "radians": k.RADIANS, "norm_angle": k.NORM_ANGLE, "norm_deg": k.NORM_DEG,
    "+": k.ADD, "-": k.SUB, "*": k.MUL, "/": k.DIV, "%": k.MOD, "**": k.POW, "<": k.LT, "<=": k.LE, ">": k.GT, ">=": k.GE,
    "==": k.EQ, "!=": k.NE, "min": k.MIN, "max": k.MAX, "atan2": k.ATAN2, "hypot": k.HYPOT, "and": k.AND, "or": k.OR,
    "clip": k.CLIP, "if": k.IF,
}  # fmt: skip


class Code(NamedTuple):
    """Byte code of several expressions."""

    code: NDArray[np.int32]  # (N, 2) operation, argument
    constants: NDArray[np.float64]  # (C,)
    start: NDArray[np.int32]  # (E + 1,) expression e is code[start[e]:start[e + 1]]
    depth: int  # of the stack


class Assembler:
    """Collects the byte code of expressions that share one row of slots.

    Parameters
    ----------
    slot : callable
        Name -> index in the row from which the code loads it.
    """

    def __init__(self, slot: Callable[[str], int]) -> None:
        self._slot = slot
        self._code: list[tuple[int, int]] = []
        self._constants: dict[float, int] = {}
        self._start = [0]
        self._depth = 1

    def add(self, tree: Node, slot: Callable[[str], int] | None = None) -> int:
        """Append an expression (with its own name -> slot, if given); returns its number."""
        self._depth = max(self._depth, self._emit(tree, slot or self._slot))
        self._start.append(len(self._code))
        return len(self._start) - 2

    def finish(self) -> Code:
        """All that was added."""
        code = np.array(self._code, np.int32).reshape(-1, 2)
        return Code(code, np.array(list(self._constants), np.float64), np.array(self._start, np.int32), self._depth)

    def _emit(self, node: Node, slot: Callable[[str], int]) -> int:
        """Append the code of `node`; returns how deep a stack it needs."""
        if node.op == "number":
            self._code.append((k.NUMBER, self._constants.setdefault(node.value, len(self._constants))))
            return 1
        if node.op == "name":
            self._code.append((k.LOAD, slot(node.name)))
            return 1
        depth = max(i + self._emit(arg, slot) for i, arg in enumerate(node.args))
        self._code.append((_OPERATIONS[node.op], 0))
        return depth
