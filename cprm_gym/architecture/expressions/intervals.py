"""The tree of an expression over ranges: an enclosure of every value it can take."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from .language import Node

_INF = math.inf


class Interval(NamedTuple):
    """All values of an expression lie in [low, high]; where `total` is False it may also be undefined.

    ``low > high`` (both NaN-free) says that it is undefined everywhere.
    """

    low: float
    high: float
    total: bool = True

    @property
    def empty(self) -> bool:
        """Whether the expression has no value at all."""
        return self.low > self.high


_NEVER = Interval(_INF, -_INF, False)
_TRUTH = Interval(0.0, 1.0)


def _wide(low: float, high: float, total: bool) -> Interval:
    """[low, high] rounded outwards by one unit in the last place, cut at the largest finite numbers; a zero stays: signs are exact."""
    largest = 1.7976931348623157e308
    if low < -largest or high > largest:
        total = False  # an overflow is undefined
    below = low if low == 0.0 else math.nextafter(low, -_INF)
    above = high if high == 0.0 else math.nextafter(high, _INF)
    return Interval(max(below, -largest), min(above, largest), total)


def _product(x: float, y: float) -> float:
    return 0.0 if x == 0.0 or y == 0.0 else x * y


def _mul(a: Interval, b: Interval) -> Interval:
    corners = [_product(x, y) for x in a[:2] for y in b[:2]]
    return _wide(min(corners), max(corners), True)


def _div(a: Interval, b: Interval) -> Interval:
    if b.low == b.high == 0.0:
        return _NEVER
    if b.low < 0.0 < b.high:
        return Interval(-1.7976931348623157e308, 1.7976931348623157e308, False) if a[:2] != (0.0, 0.0) else Interval(0.0, 0.0, False)
    touches = b.low == 0.0 or b.high == 0.0
    corners = []
    for y in b[:2]:
        for x in a[:2]:
            if y != 0.0:
                corners.append(x / y)
            elif x != 0.0:
                corners.append(math.copysign(_INF, x) * (1.0 if b.low == 0.0 else -1.0))
            else:
                corners.append(0.0)
    wide = _wide(min(corners), max(corners), True)
    return wide._replace(total=wide.total and not touches)


def _mod(a: Interval, b: Interval) -> Interval:
    if b.low == b.high == 0.0:
        return _NEVER
    total = not b.low <= 0.0 <= b.high
    if total and b.low == b.high:
        turns = a.low / b.low, a.high / b.low
        x, y = a.low % b.low, a.high % b.low
        if all(map(math.isfinite, turns)) and math.floor(turns[0]) == math.floor(turns[1]) and x <= y:
            return _wide(x, y, True)
    return Interval(min(0.0, b.low), max(0.0, b.high), total)


def _pow(a: Interval, b: Interval) -> Interval:
    y = b.low
    if y != int(y):
        if a.high < 0.0:
            return _NEVER
        clipped = Interval(max(a.low, 0.0), a.high, a.low >= 0.0)
        return _monotone_pow(clipped, y)
    if a.low < 0.0 < a.high:
        parts = [_monotone_pow(Interval(a.low, 0.0), y), _monotone_pow(Interval(0.0, a.high), y)]
        return _hull(*parts)
    return _monotone_pow(a, y)


def _monotone_pow(a: Interval, y: float) -> Interval:
    total = a.total
    ends = []
    for x in a[:2]:
        if x == 0.0 and y < 0.0:
            total = False
            negative = y % 2 == 1 and a.high <= 0.0
            ends.append(-_INF if negative else _INF)
        else:
            try:
                ends.append(math.pow(x, y))
            except OverflowError:
                ends.append(-_INF if x < 0.0 and y % 2 == 1 else _INF)
    if a.low == a.high == 0.0 and y < 0.0:
        return _NEVER
    wide = _wide(min(ends), max(ends), True)
    return wide._replace(total=wide.total and total)


def _monotone(f: Callable[[float], float], low: float = -_INF, high: float = _INF, *, open_low: bool = False, sign: int = 1):  # type: ignore[no-untyped-def]
    """Enclosure of a function monotone on [low, high] and undefined elsewhere."""

    def bound(a: Interval) -> Interval:
        if a.high < low or a.low > high or (open_low and a.high <= low):
            return _NEVER
        total = a.low >= low and a.high <= high and not (open_low and a.low <= low)
        ends = []
        for x in (max(a.low, low), min(a.high, high)):
            if open_low and x == low:
                ends.append(-_INF * sign)
                continue
            try:
                ends.append(f(x))
            except OverflowError:
                ends.append(_INF)
        wide = _wide(min(ends), max(ends), True)
        return wide._replace(total=total and (wide.total or open_low))

    return bound


def _periodic(f: Callable[[float], float], top: float) -> Callable[[Interval], Interval]:
    """Enclosure of sin or cos, whose maxima are at ``top + 2 k pi``."""

    def bound(a: Interval) -> Interval:
        if a.high - a.low >= 2 * math.pi or max(abs(a.low), abs(a.high)) > 1e6:
            return Interval(-1.0, 1.0)
        ends = (f(a.low), f(a.high))
        margin = 1e-9
        high = 1.0 if _contains(a, top, margin) else min(1.0, max(ends) + 1e-15)
        low = -1.0 if _contains(a, top + math.pi, margin) else max(-1.0, min(ends) - 1e-15)
        return Interval(low, high)

    return bound


def _contains(a: Interval, point: float, margin: float) -> bool:
    """Whether ``point + 2 k pi`` lies in `a` for some whole k."""
    k = math.ceil((a.low - margin - point) / (2 * math.pi))
    return point + 2 * math.pi * k <= a.high + margin


def _tan(a: Interval) -> Interval:
    if a.high - a.low < math.pi and not _contains(a, math.pi / 2, 1e-9) and not _contains(a, -math.pi / 2, 1e-9):
        x, y = math.tan(a.low), math.tan(a.high)
        if x <= y:
            return _wide(math.nextafter(x, -_INF), math.nextafter(y, _INF), True)
    return Interval(-1.633123935319537e16, 1.633123935319537e16)


def _turn(half: float) -> Callable[[Interval], Interval]:
    def bound(a: Interval) -> Interval:
        if max(abs(a.low), abs(a.high)) > 1e6:  # the rounding of the shift would be felt
            return Interval(-half, half)
        shift = round((a.low + a.high) / 2 / (2 * half)) * 2 * half
        low, high = a.low - shift, a.high - shift
        if -half < low - 1e-9 and high + 1e-9 < half:
            slack = 1e-9 if shift else 0.0
            return Interval(low - slack, high + slack)
        return Interval(-half, half)

    return bound


def _hypot(a: Interval, b: Interval) -> Interval:
    def square(x: Interval) -> tuple[float, float]:
        lows = 0.0 if x.low <= 0.0 <= x.high else min(abs(x.low), abs(x.high))
        return lows, max(abs(x.low), abs(x.high))

    (a_low, a_high), (b_low, b_high) = square(a), square(b)
    high = math.sqrt(a_high * a_high + b_high * b_high)
    wide = _wide(math.sqrt(a_low * a_low + b_low * b_low) * (1 - 1e-15), high * (1 + 1e-15), True)
    return wide._replace(low=max(wide.low, 0.0))


def _atan2(a: Interval, b: Interval) -> Interval:
    if b.low <= 0.0 and a.low <= 0.0 <= a.high:
        return Interval(-math.pi, math.pi)
    corners = [math.atan2(y, x) for y in a[:2] for x in b[:2]]
    return _wide(math.nextafter(min(corners), -_INF), math.nextafter(max(corners), _INF), True)


def _abs(a: Interval) -> Interval:
    low = 0.0 if a.low <= 0.0 <= a.high else min(abs(a.low), abs(a.high))
    return Interval(low, max(abs(a.low), abs(a.high)))


def _compare(op: str, a: Interval, b: Interval) -> Interval:
    if op in (">", ">="):
        return _compare("<" if op == ">" else "<=", b, a)
    if op == "<":
        yes, no = a.high < b.low, a.low >= b.high
    elif op == "<=":
        yes, no = a.high <= b.low, a.low > b.high
    else:
        same, apart = a.low == a.high == b.low == b.high, a.high < b.low or a.low > b.high
        yes, no = (same, apart) if op == "==" else (apart, same)
    return Interval(1.0, 1.0) if yes else Interval(0.0, 0.0) if no else _TRUTH


def _sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0))


def _exact(f: Callable[[float], float]) -> Callable[[Interval], Interval]:
    return lambda a: Interval(float(f(a.low)), float(f(a.high)))


_UNARY: Mapping[str, Callable[[Interval], Interval]] = {
    "neg": lambda a: Interval(-a.high, -a.low),
    "abs": _abs,
    "sign": _exact(_sign),
    "floor": _exact(math.floor),
    "ceil": _exact(math.ceil),
    "round": _exact(round),
    "sqrt": _monotone(math.sqrt, 0.0),
    "exp": _monotone(math.exp),
    "log": _monotone(math.log, 0.0, open_low=True),
    "asin": _monotone(math.asin, -1.0, 1.0),
    "acos": _monotone(math.acos, -1.0, 1.0),
    "atan": _monotone(math.atan),
    "sin": _periodic(math.sin, math.pi / 2),
    "cos": _periodic(math.cos, 0.0),
    "tan": _tan,
    "degrees": lambda a: _wide(a.low * (180.0 / math.pi), a.high * (180.0 / math.pi), True),
    "radians": lambda a: _wide(a.low * (math.pi / 180.0), a.high * (math.pi / 180.0), True),
    "norm_angle": _turn(math.pi),
    "norm_deg": _turn(180.0),
}

_BINARY: Mapping[str, Callable[[Interval, Interval], Interval]] = {
    "+": lambda a, b: _wide(a.low + b.low, a.high + b.high, True),
    "-": lambda a, b: _wide(a.low - b.high, a.high - b.low, True),
    "*": _mul,
    "/": _div,
    "%": _mod,
    "**": _pow,
    "min": lambda a, b: Interval(min(a.low, b.low), min(a.high, b.high)),
    "max": lambda a, b: Interval(max(a.low, b.low), max(a.high, b.high)),
    "atan2": _atan2,
    "hypot": _hypot,
}


def _hull(*parts: Interval) -> Interval:
    """The smallest interval around those that are not empty."""
    some = [part for part in parts if not part.empty]
    if not some:
        return _NEVER
    return Interval(min(p.low for p in some), max(p.high for p in some), all(p.total for p in parts))


def _truth(a: Interval) -> tuple[bool, bool]:
    """Whether `a` may be false, may be true."""
    return a.low <= 0.0 <= a.high, not (a.low == a.high == 0.0)


def bound(node: Node, ranges: Mapping[str, tuple[float, float]]) -> Interval:
    """An enclosure of the values of `node` while each name stays in its range.

    Parameters
    ----------
    node : Node
    ranges : mapping
        Name -> (low, high), finite.
    """
    op = node.op
    if op == "number":
        return Interval(node.value, node.value)
    if op == "name":
        low, high = ranges[node.name]
        return Interval(float(low), float(high))
    first = bound(node.args[0], ranges)
    if first.low > first.high:
        return _NEVER
    if op in ("and", "or", "if"):
        return _branches(op, node, first, ranges)
    if op == "not":
        false, true = _truth(first)
        return Interval(0.0 if true else 1.0, 1.0 if false else 0.0, first.total)
    total = first.total
    rest = []
    for arg in node.args[1:]:
        part = bound(arg, ranges)
        if part.low > part.high:
            return _NEVER
        total = total and part.total
        rest.append(part)
    if op == "clip":
        result = _BINARY["min"](_BINARY["max"](first, rest[0]), rest[1])
    elif op in ("<", "<=", ">", ">=", "==", "!="):
        result = _compare(op, first, rest[0])
    else:
        result = _BINARY[op](first, rest[0]) if rest else _UNARY[op](first)
    if result.low > result.high:
        return _NEVER
    return result if total else Interval(result.low, result.high, False)


def _branches(op: str, node: Node, first: Interval, ranges: Mapping[str, tuple[float, float]]) -> Interval:
    """``and``, ``or`` and ``if``: only the parts that can decide count."""
    false, true = _truth(first)
    if op == "if":
        parts = [bound(arg, ranges) for arg, possible in ((node.args[1], true), (node.args[2], false)) if possible]
    else:
        shortcut = Interval(1.0, 1.0) if op == "or" else Interval(0.0, 0.0)
        parts = [shortcut] if (true if op == "or" else false) else []
        if true if op == "and" else false:
            second = bound(node.args[1], ranges)
            if not second.empty:
                no, yes = _truth(second)
                second = Interval(0.0 if no else 1.0, 1.0 if yes else 0.0, second.total)
            parts.append(second)
    hull = _hull(*parts)
    return hull if hull.empty or first.total else Interval(hull.low, hull.high, False)
