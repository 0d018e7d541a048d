"""Which cells several quantities can be in at once: samples find what is possible, interval refinement proves what is not.

Quantities are expression trees over common real names. A combination of cells is *possible* when some point was found that lies in all of
them, *impossible* when interval arithmetic excludes it on every box of a partition of the ranges, *undecided* when neither was achieved
within the effort granted. Boxes are split down to neighbouring floating-point numbers where it matters, so that thresholds on one name
are decided exactly.
"""

from __future__ import annotations

import itertools
import math
import struct
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...expressions import Node
from ...expressions.interpreter import interpret
from ...expressions.intervals import bound

LARGEST = 1.7976931348623157e308
MODERATE = 1e4
"""Points are looked for up to this size, or ten times the largest number written, whatever is more."""
MOST_SAMPLES, MOST_BOXES = 8192, 1000
MOST_COMBINATIONS = 1 << 12

Ranges = Mapping[str, tuple[float, float]]
Combination = tuple[int, ...]
Cells = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Question:
    """Which cells of `quantities` can be met at once.

    Attributes
    ----------
    ranges : tuple of (name, (low, high))
        Of every name that is free.
    steps : tuple of (name, tree)
        What is computed, each from the free names and the steps before it; all must be defined.
    quantities : tuple of (name, cells)
        Cells half-open, in order.
    limits : tuple of (name, (low, high))
        Ranges that steps must keep.
    """

    ranges: tuple[tuple[str, tuple[float, float]], ...]
    steps: tuple[tuple[str, Node], ...]
    quantities: tuple[tuple[str, tuple[tuple[float, float], ...]], ...]
    limits: tuple[tuple[str, tuple[float, float]], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The free names that move."""
        return tuple(name for name, (low, high) in self.ranges if low < high)

    def at(self, point: Mapping[str, float]) -> Combination | None:
        """The cells at a point, from 1; None where something is undefined or a limit is not kept."""
        values = dict(point)
        for name, tree in self.steps:
            values[name] = interpret(tree, values)
            if math.isnan(values[name]):
                return None
        if not all(low <= values[name] <= high for name, (low, high) in self.limits):
            return None
        found = tuple(next((k for k, (a, b) in enumerate(cells, 1) if a <= values[name] < b), 0) for name, cells in self.quantities)
        return found if all(found) else None

    def within(self, box: Ranges) -> list[list[int]] | None:
        """The cells that each quantity may be in on a box; None where something is undefined on all of it."""
        spans = dict(box)
        for name, tree in self.steps:
            span = bound(tree, spans)
            if span.empty:
                return None
            spans[name] = span.low, span.high
        for name, (low, high) in self.limits:
            if spans[name][0] > high or spans[name][1] < low:
                return None
            spans[name] = max(spans[name][0], low), min(spans[name][1], high)
        found = [[k for k, (a, b) in enumerate(cells, 1) if spans[name][0] < b and spans[name][1] >= a] for name, cells in self.quantities]
        return found if all(found) else None

    def numbers(self) -> list[float]:
        """Every number that is written."""
        found = [node.value for _, tree in self.steps for node in tree.walk() if node.op == "number"]
        found += [edge for _, cells in self.quantities for cell in cells for edge in cell if abs(edge) <= LARGEST]
        return found + [edge for _, span in self.limits for edge in span if abs(edge) < LARGEST]


@dataclass
class Answer:
    """What is known.

    Attributes
    ----------
    possible : dict from combination to point
        Combinations that can be met, with where.
    undecided : set of combinations
    complete : bool
        Whether every combination that is in neither is impossible; False where there are too many to ask for each.
    """

    possible: dict[Combination, dict[str, float]]
    undecided: set[Combination]
    complete: bool = True


_known: dict[Question, Answer] = {}


def combinations(question: Question, enough: Callable[[], bool] = lambda: False) -> Answer:
    """Every combination of cells that can be met, as far as it can be decided.

    Parameters
    ----------
    question : Question
    enough : callable
        Whether to stop early, with more left undecided.
    """
    if question in _known:
        return _known[question]
    answer = _combinations(question, enough)
    if not enough():
        if len(_known) >= 64:
            _known.clear()
        _known[question] = answer
    return answer


def _combinations(question: Question, enough: Callable[[], bool]) -> Answer:
    marks = _marks(question)
    most = math.prod(len(cells) for _, cells in question.quantities)
    answer = Answer({}, set(), most <= MOST_COMBINATIONS)
    _sample(question, marks, answer)
    if len(answer.possible) == most or not answer.complete:
        return answer
    may = _refine(question, marks, answer, enough, None)
    if may:
        abstract = _abstracted(question)
        if abstract is not None:
            may &= _refine(abstract, _marks(abstract), Answer(answer.possible, set()), enough, may)
    answer.undecided = may - answer.possible.keys()
    return answer


def _try(question: Question, far: float, point: dict[str, float], answer: Answer) -> None:
    if any(abs(point[name]) > far for name in question.names):
        return
    found = question.at(point)
    if found is not None:
        answer.possible.setdefault(found, point)


Marks = Mapping[str, list[float]]
"""Name -> numbers at which a threshold on it may lie."""


def _marks(question: Question) -> Marks:
    found: dict[str, set[float]] = {name: set() for name in question.names}
    tails: dict[str, set[str]] = {name: {name} for name, _ in question.ranges}

    def add(node: Node, numbers: Sequence[float]) -> None:
        for name in _tails(node, tails):
            if name in found:
                found[name].update(numbers)

    for step, tree in question.steps:
        tails[step] = _tails(tree, tails)
        for node in tree.walk():
            if node.op in ("<", "<=", ">", ">=", "==", "!=", "min", "max", "-", "+"):
                a, b = node.args
                for one, other in ((a, b), (b, a)):
                    if other.op == "number":
                        add(one, (other.value,))
            elif node.op == "clip":
                add(node.args[0], [arg.value for arg in node.args[1:] if arg.op == "number"])
            elif node.op in ("abs", "sqrt", "log", "if"):
                add(node.args[0], (0.0,))
    for name, cells in question.quantities:
        add(Node("name", name=name), [edge for cell in cells for edge in cell if abs(edge) <= LARGEST])
    both = {name: {sign * m for m in some for sign in (1.0, -1.0)} for name, some in found.items()}
    # a cut at m parts what is below m from m, one at the next number m from what is above: abs(x) < 3, x > 3
    return {name: sorted(some | {math.nextafter(m, math.inf) for m in some}) for name, some in both.items()}


def _tails(node: Node, known: Mapping[str, set[str]]) -> set[str]:
    """Free names of which the value of a tree may be, up to its sign."""
    if node.op == "name":
        return known.get(node.name, set())
    if node.op in ("abs", "neg"):
        return _tails(node.args[0], known)
    if node.op == "if":
        return _tails(node.args[1], known) | _tails(node.args[2], known)
    if node.op in ("min", "max"):
        return _tails(node.args[0], known) | _tails(node.args[1], known)
    return _tails(node.args[0], known) if node.op == "clip" else set()


def moderate(marks: Iterable[float]) -> float:
    """Up to where points are looked for."""
    return min(max(MODERATE, 10.0 * max(map(abs, marks), default=0.0)), LARGEST)


def _sample(question: Question, marks: Marks, answer: Answer) -> None:
    """Try points at the marks, beside and between them."""
    fixed = {name: low for name, (low, high) in question.ranges if low == high}
    far = moderate(question.numbers())
    values = {name: _values(marks[name], span, far) for name, span in question.ranges if span[0] < span[1]}
    if math.prod(map(len, values.values())) <= MOST_SAMPLES:
        points = np.array(list(itertools.product(*values.values())), np.float64).reshape(-1 if values else 1, len(values))
    else:
        draw = np.random.default_rng(0)
        scale = np.where(draw.random(MOST_SAMPLES) < 0.7, 1.0, 10.0)
        columns = []
        for name, some in values.items():
            low, high = dict(question.ranges)[name]
            widest = max(2.0, *(abs(v) for v in some if abs(v) < far))
            loose = np.clip(draw.normal(size=MOST_SAMPLES) * scale * draw.choice([1.0, widest], MOST_SAMPLES), low, high)
            columns.append(np.where(draw.random(MOST_SAMPLES) < 0.7, draw.choice(some, MOST_SAMPLES), loose))
        points = np.stack(columns, axis=1)
    arrays = {name: np.full(len(points), value) for name, value in fixed.items()}
    arrays |= {name: points[:, k] for k, name in enumerate(values)}
    fine = np.ones(len(points), bool)
    for name, tree in question.steps:
        arrays[name] = evaluate(tree, arrays, len(points))
        fine &= ~np.isnan(arrays[name])
    for name, (low, high) in question.limits:
        fine &= (arrays[name] >= low) & (arrays[name] <= high)
    codes = np.zeros((len(points), len(question.quantities)), np.int64)
    for k, (name, cells) in enumerate(question.quantities):
        for n, (a, b) in enumerate(cells, 1):
            codes[(arrays[name] >= a) & (arrays[name] < b), k] = n
    fine &= (codes > 0).all(axis=1)
    _, first = np.unique(codes[fine], axis=0, return_index=True)
    for i in np.flatnonzero(fine)[first][: MOST_COMBINATIONS if answer.complete else 200]:
        _try(question, far, {**fixed, **dict(zip(values, points[i].tolist()))}, answer)


def _values(marks: list[float], span: tuple[float, float], far: float) -> list[float]:
    """Values of one name worth trying: its marks, their neighbours, and some between and beyond."""
    some = {0.0, 1.0, -1.0, 30.0, *marks, *(math.nextafter(m, -math.inf) for m in marks)}
    some |= {(a + b) / 2 for a, b in itertools.pairwise(marks) if b > math.nextafter(a, math.inf)}
    if marks:
        some |= {marks[0] - 1.0, marks[-1] + 1.0}
    some |= {end for end in span if abs(end) <= far}
    return sorted(v for v in some if span[0] <= v <= span[1] and abs(v) <= far) or [_clip(0.0, span)]


def evaluate(node: Node, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """The values of a tree at many points; NaN where it is undefined. Points that matter are looked at again by the interpreter."""
    with np.errstate(all="ignore"):
        return _array(node, values, size)


def _array(node: Node, values: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    op = node.op
    if op == "number":
        return np.full(size, node.value)
    if op == "name":
        return values[node.name]
    a = [_array(arg, values, size) for arg in node.args]
    if op == "if":
        found = np.where(a[0] != 0.0, a[1], a[2])
        return np.where(np.isnan(a[0]), np.nan, found)
    if op == "and":
        return np.where(a[0] == 0.0, 0.0, np.where(np.isnan(a[0] + a[1]), np.nan, (a[1] != 0.0).astype(float)))
    if op == "or":
        return np.where(np.isnan(a[0]), np.nan, np.where(a[0] != 0.0, 1.0, np.where(np.isnan(a[1]), np.nan, (a[1] != 0.0).astype(float))))
    undefined = np.isnan(a[0])
    for other in a[1:]:
        undefined |= np.isnan(other)
    found = _ARRAYS[op](*a).astype(float)
    return np.where(undefined | ~np.isfinite(found), np.nan, found)


def _turn(x: np.ndarray, half: float) -> np.ndarray:
    turned = np.fmod(x, 2.0 * half)
    return np.where(turned > half, turned - 2.0 * half, np.where(turned <= -half, turned + 2.0 * half, turned))


_ARRAYS: Mapping[str, Callable[..., np.ndarray]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "%": np.mod, "**": np.power, "neg": np.negative,
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
    "not": lambda x: x == 0.0, "abs": np.abs, "sign": np.sign, "sqrt": np.sqrt, "exp": np.exp, "log": np.log,
    "floor": np.floor, "ceil": np.ceil, "round": np.round, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "degrees": lambda x: x * (180.0 / math.pi), "radians": lambda x: x * (math.pi / 180.0),
    "norm_angle": lambda x: _turn(x, math.pi), "norm_deg": lambda x: _turn(x, 180.0),
    "hypot": lambda x, y: np.sqrt(x * x + y * y),
    "clip": lambda x, low, high: np.minimum(np.maximum(x, low), high), "min": np.minimum, "max": np.maximum,
}  # fmt: skip


def _clip(value: float, span: tuple[float, float]) -> float:
    return min(max(value, span[0]), span[1])


def _refine(
    question: Question, marks: Marks, answer: Answer, enough: Callable[[], bool], open_: set[Combination] | None
) -> set[Combination]:
    """Split the ranges until every combination is found or excluded; those that are neither when the effort is spent.

    Parameters
    ----------
    open_ : set of combinations, optional
        Only these are still asked for; points are not tried.
    """
    far = moderate(question.numbers())
    queue: list[dict[str, tuple[float, float]]] = [dict(question.ranges)]
    spent = 0
    while queue:
        queue, boxes = [], queue
        for at, box in enumerate(boxes):
            spent += 1
            if spent >= MOST_BOXES or enough():
                queue += boxes[at:]
                break
            queue += _parts(question, marks, far, answer, open_, box)
        else:
            continue
        break
    asked = open_ if open_ is not None else set(itertools.product(*(range(1, len(cells) + 1) for _, cells in question.quantities)))
    asked = asked - answer.possible.keys()
    left: set[Combination] = set()
    for box in queue:
        if len(left) == len(asked):
            break
        cells = question.within(box)
        if cells is not None:
            left.update(asked.intersection(itertools.product(*cells)))
    return left


def _parts(
    question: Question,
    marks: Marks,
    far: float,
    answer: Answer,
    open_: set[Combination] | None,
    box: dict[str, tuple[float, float]],
) -> list[dict[str, tuple[float, float]]]:
    """A box in two, or nothing if it holds nothing that is still asked for."""
    cells = question.within(box)
    if cells is None:
        return []
    some = itertools.product(*cells)
    if open_ is None:
        if all(c in answer.possible for c in some):
            return []
    elif not any(c in open_ for c in some):
        return []
    name, middle = _split(marks, box)
    if name is None:
        if open_ is None:
            _try(question, far, {n: low for n, (low, _) in box.items()}, answer)
            return []
        return [box]
    low, high = box[name]
    below = math.nextafter(middle, -math.inf)
    if open_ is None:
        _try(question, far, {n: middle if n == name else _clip(0.0, span) for n, span in box.items()}, answer)
        _try(question, far, {n: below if n == name else _clip((a + b) / 2, (a, b)) for n, (a, b) in box.items()}, answer)
    return [{**box, name: (low, below)}, {**box, name: (middle, high)}]


def _split(marks: Marks, box: Mapping[str, tuple[float, float]]) -> tuple[str | None, float]:
    """Where to cut a box: at a mark inside it, else in the middle of what holds most numbers; no name if it is a point."""
    most, name, middle = 0, "", 0.0
    for other, some in marks.items():
        low, high = box[other]
        first = bisect_right(some, low)
        inside = bisect_right(some, high) - first
        if inside > most:
            most, name, middle = inside, other, some[first + inside // 2]
    if most:
        return name, middle
    widest = _widest(box)
    return (None, 0.0) if widest is None else (widest, _between(*box[widest]))


def _widest(box: Mapping[str, tuple[float, float]]) -> str | None:
    """The name whose range holds most floating-point numbers, None if the box is a point."""
    name = max(box, key=lambda n: _ordinal(box[n][1]) - _ordinal(box[n][0]), default=None)
    return None if name is None or box[name][0] == box[name][1] else name


def _ordinal(x: float) -> int:
    """The number of a floating-point number in their order."""
    bits = int(struct.unpack("<q", struct.pack("<d", x))[0])
    return bits if bits >= 0 else -(bits & 0x7FFFFFFFFFFFFFFF)


def _between(low: float, high: float) -> float:
    """A number above `low`, up to `high`, with as many floating-point numbers below as above."""
    middle = (_ordinal(low) + _ordinal(high) + 1) // 2
    bits = middle if middle >= 0 else (-middle) | 1 << 63
    value = float(struct.unpack("<d", struct.pack("<Q", bits))[0])
    return min(max(value, math.nextafter(low, math.inf)), high)


# -- common subexpressions as names of their own --------------------------------------------------------------------------------------


def _abstracted(question: Question) -> Question | None:
    """The question with what is computed as free names, where what it reads is read nowhere else; None if there is nothing such.

    It asks about more than there is: what is impossible in it is impossible.
    """
    steps = _shared(question.steps)
    moving = set(question.names)
    free: dict[str, frozenset[str]] = {name: frozenset({name} & moving) for name, _ in question.ranges}
    reads: dict[str, frozenset[str]] = {}
    for name, tree in steps:
        reads[name] = frozenset(node.name for node in tree.walk() if node.op == "name")
        free[name] = frozenset().union(*(free[read] for read in reads[name]))
    asked = {name for name, _ in question.quantities}
    chosen: dict[str, frozenset[str]] = {}
    for name, _ in reversed(steps):
        inner = _below(name, reads)
        outside = {read for other, some in reads.items() if other not in inner and other != name for read in some} | asked
        hidden = (inner | free[name]) - {name}
        if len(free[name]) > 1 and not hidden & outside and not any(free[name] & taken for taken in chosen.values()):
            chosen[name] = free[name]
    if not chosen:
        return None
    spans = dict(question.ranges)
    for name, tree in steps:
        span = bound(tree, spans)
        if span.empty:
            return None
        spans[name] = span.low, span.high
    dropped = set().union(*(_below(name, reads) | {name} for name in chosen))
    gone = set().union(*chosen.values())
    ranges = [(name, span) for name, span in question.ranges if name not in gone] + [(name, spans[name]) for name in chosen]
    limits = tuple((name, span) for name, span in question.limits if name not in dropped or name in chosen)
    return Question(tuple(ranges), tuple((n, t) for n, t in steps if n not in dropped), question.quantities, limits)


def _below(name: str, reads: Mapping[str, frozenset[str]]) -> set[str]:
    """The steps that a step rests on."""
    found: set[str] = set()
    todo = [name]
    while todo:
        fresh = {read for read in reads.get(todo.pop(), ()) if read in reads} - found
        found |= fresh
        todo += fresh
    return found


def _shared(steps: tuple[tuple[str, Node], ...]) -> list[tuple[str, Node]]:
    """The steps with every subexpression that occurs more than once as a step of its own."""
    count: dict[Node, int] = {}
    for _, tree in steps:
        for node in tree.walk():
            if node.args:
                count[node] = count.get(node, 0) + 1
    name_of: dict[Node, str] = {}
    out: list[tuple[str, Node]] = []

    def replaced(node: Node) -> Node:
        if not node.args:
            return node
        if node in name_of:
            return Node("name", name=name_of[node])
        made = Node(node.op, tuple(replaced(arg) for arg in node.args), node.value, node.name)
        if count[node] > 1:
            name_of[node] = f"~{len(name_of)}"
            out.append((name_of[node], made))
            return Node("name", name=name_of[node])
        return made

    for name, tree in steps:
        made = replaced(tree)
        out.append((name, made))
    return out
