"""Byte code of expressions, run on a small stack.

A program is an array of (operation, argument) pairs. Undefined is NaN: it passes through every operation, and only ``and``,
``or`` and ``if`` can pass over it, exactly as in the interpreter. Nothing is allocated, so numba's reference counts are off.
"""

from __future__ import annotations

import math

import numpy as np

from ...compilation import kernel_group

kernel = kernel_group(_nrt=False)
inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)

NUMBER, LOAD = 0, 1
NEG, NOT, ABS, SIGN, SQRT, EXP, LOG, FLOOR, CEIL, ROUND = 2, 3, 4, 5, 6, 7, 8, 9, 10, 11
SIN, COS, TAN, ASIN, ACOS, ATAN, DEGREES, RADIANS, NORM_ANGLE, NORM_DEG = 12, 13, 14, 15, 16, 17, 18, 19, 20, 21
FIRST_BINARY = 22
ADD, SUB, MUL, DIV, MOD, POW, LT, LE, GT, GE, EQ, NE = 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33
MIN, MAX, ATAN2, HYPOT, AND, OR = 34, 35, 36, 37, 38, 39
CLIP, IF = 40, 41

_EXP_MAX = 709.782712893384


@kernel
def turned(x, half):
    """`x` brought into the half-open turn (-half, half]."""
    rest = np.fmod(x, 2.0 * half)
    if rest > half:
        return rest - 2.0 * half
    if rest <= -half:
        return rest + 2.0 * half
    return rest


@kernel
def unary(op, x):
    """The value of a unary operation on a finite `x`; NaN or infinite where it is undefined."""
    if op == NEG:
        return -x
    if op == NOT:
        return 1.0 if x == 0.0 else 0.0
    if op == ABS:
        return abs(x)
    if op == SIGN:
        return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)
    if op == SQRT:
        return math.sqrt(x) if x >= 0.0 else np.nan
    if op == EXP:
        return math.exp(x) if x <= _EXP_MAX else np.nan
    if op == LOG:
        return math.log(x) if x > 0.0 else np.nan
    if op == FLOOR:
        return np.floor(x)
    if op == CEIL:
        return np.ceil(x)
    if op == ROUND:
        return np.rint(x)
    if op == SIN:
        return math.sin(x)
    if op == COS:
        return math.cos(x)
    if op == TAN:
        return math.tan(x)
    if op == ASIN:
        return math.asin(x) if abs(x) <= 1.0 else np.nan
    if op == ACOS:
        return math.acos(x) if abs(x) <= 1.0 else np.nan
    if op == ATAN:
        return math.atan(x)
    if op == DEGREES:
        return x * (180.0 / math.pi)
    if op == RADIANS:
        return x * (math.pi / 180.0)
    if op == NORM_ANGLE:
        return turned(x, math.pi)
    return turned(x, 180.0)


@kernel
def modulo(x, y):
    """Remainder with the sign of `y`, as Python's ``%``."""
    rest = np.fmod(x, y)
    if rest != 0.0:
        return rest + y if (rest < 0.0) != (y < 0.0) else rest
    return math.copysign(0.0, y)


@kernel
def power(x, y):
    """``x ** y``; NaN for a root of a negative number and for a division by zero."""
    if (x == 0.0 and y < 0.0) or (x < 0.0 and y != np.floor(y)):
        return np.nan
    if abs(x) > 1.0 and y * math.log(abs(x)) > 709.79:  # beyond the largest number
        return np.nan
    return math.pow(x, y)


@kernel
def binary(op, x, y):
    """The value of a binary operation on finite `x` and `y`; NaN or infinite where it is undefined."""
    if op == ADD:
        return x + y
    if op == SUB:
        return x - y
    if op == MUL:
        return x * y
    if op == DIV:
        return x / y if y != 0.0 else np.nan
    if op == LT:
        return 1.0 if x < y else 0.0
    if op == LE:
        return 1.0 if x <= y else 0.0
    if op == GT:
        return 1.0 if x > y else 0.0
    if op == GE:
        return 1.0 if x >= y else 0.0
    if op == EQ:
        return 1.0 if x == y else 0.0
    if op == NE:
        return 1.0 if x != y else 0.0
    if op == MIN:
        return y if y < x else x
    if op == MAX:
        return y if y > x else x
    if op == POW:
        return power(x, y)
    if op == MOD:
        return modulo(x, y) if y != 0.0 else np.nan
    if op == ATAN2:
        return math.atan2(x, y)
    return math.sqrt(x * x + y * y)


@kernel
def logical(op, x, y):
    """``and`` and ``or``: `x` alone decides where it can."""
    if x != x:
        return np.nan
    if (x != 0.0) == (op == OR):
        return 1.0 if op == OR else 0.0
    if y != y:
        return np.nan
    return 1.0 if y != 0.0 else 0.0


@inlined
def run_inlined(code, constants, begin, end, row, stack):
    """The value of ``code[begin:end]``; NaN where it is undefined.

    code : (N, 2) int32
    constants : (C,)
    row : (S,) values of the slots that the code loads
    stack : scratch, as deep as the deepest program
    """
    top = -1
    for i in range(begin, end):
        op = code[i, 0]
        if op == LOAD:
            top += 1
            stack[top] = row[code[i, 1]]
        elif op == NUMBER:
            top += 1
            stack[top] = constants[code[i, 1]]
        elif op < FIRST_BINARY:
            x = stack[top]
            stack[top] = unary(op, x) if x == x else np.nan
        elif op < AND:
            top -= 1
            x, y = stack[top], stack[top + 1]
            stack[top] = binary(op, x, y) if x == x and y == y else np.nan
        elif op < CLIP:
            top -= 1
            stack[top] = logical(op, stack[top], stack[top + 1])
        else:
            top -= 2
            x, y, z = stack[top], stack[top + 1], stack[top + 2]
            if op == IF:
                stack[top] = np.nan if x != x else (y if x != 0.0 else z)
            elif x == x and y == y and z == z:
                x = y if y > x else x
                stack[top] = z if z < x else x
            else:
                stack[top] = np.nan
        if not np.isfinite(stack[top]):
            stack[top] = np.nan
    return stack[top]


@kernel
def run(code, constants, begin, end, row, stack):
    """`run_inlined` as a call."""
    return run_inlined(code, constants, begin, end, row, stack)


@kernel
def run_rows(code, constants, begin, end, rows, stack, out):
    """`run` for every row of `rows` (W, S), into `out` (W,)."""
    for w in range(rows.shape[0]):
        out[w] = run(code, constants, begin, end, rows[w], stack)


@kernel
def run_columns(code, constants, start, targets, rows, stack):
    """`run` of expression e for every row of `rows` (W, S), into its column ``targets[e]``; each may read the columns before it."""
    for w in range(rows.shape[0]):
        for e in range(targets.shape[0]):
            rows[w, targets[e]] = run(code, constants, start[e], start[e + 1], rows[w], stack)
