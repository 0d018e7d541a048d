"""What the environment sets: variables, the cells of their values, and what transitions ask of them.

Continuous, input, belief and math places and selected objects are *variables*: the thresholds at which the net reads a variable cut its
values into cells, and in every cycle it may be in any of them. Places that show the same observation, or the same view of the same random
variable, are one variable.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from ....errors import NetError
from ...expressions import Expression
from ...petri import Belief, CompiledNet, Continuous, Input, ObjectPlace, Place, PlaceKind, Transition
from ...petri.net.net import resolve_name
from ..net_arrays import selected_places

INFINITY = float("inf")
LARGEST = 1.7976931348623157e308


@dataclass(frozen=True)
class Variable:
    """What the environment sets: a set of places that show the same thing, and the cells of its values.

    Attributes
    ----------
    name : str
    places : tuple of str
    cells : tuple of (float, float)
        Half-open intervals; of a selected object (0, 1) absent and (1, 2) present.
    is_object : bool
    fixed : int
        The cell of a constant, 0 if it may change.
    """

    name: str
    places: tuple[str, ...]
    cells: tuple[tuple[float, float], ...]
    is_object: bool = False
    fixed: int = 0

    def text(self, cell: int) -> str:
        """Cell number `cell` (from 1) in words: ``off_axis >= 3``."""
        low, high = self.cells[cell - 1]
        if self.is_object:
            return f"{self.name} {'present' if low else 'absent'}"
        if low == -INFINITY:
            return f"{self.name} < {high:g}" if high < INFINITY else f"{self.name} anything"
        return f"{low:g} <= {self.name} < {high:g}" if high < INFINITY else f"{self.name} >= {low:g}"

    def inside(self, cell: int) -> float:
        """A value in the cell."""
        low, high = self.cells[cell - 1]
        if low == -INFINITY:
            return 0.0 if high == INFINITY else high - 1.0
        return low


def _keys(c: CompiledNet) -> dict[str, tuple[str, ...]]:
    """What each place shows; places with equal keys are one variable. Math places with one expression of the same things are, too."""
    keys: dict[str, tuple[str, ...]] = {}
    for p in c.net.places:
        if isinstance(p, Input):
            keys[p.name] = ("input", p.observes, str(p.value))  # before the first observation they show their own value
        elif isinstance(p, Belief):
            keys[p.name] = ("belief", p.variable, p.view, p.state, str(p.value))
        else:
            keys[p.name] = ("place", p.name)
    scope = {p.name: p for p in c.net.places}
    number: dict[tuple[str, ...], int] = {}
    for m in c.math:

        def canonical(name: str) -> str:
            place, attribute = resolve_name(name, scope)
            which = number.setdefault(keys[place], len(number))
            return f"v{which}.{attribute}" if attribute else f"v{which}"

        keys[m.name] = ("math", Expression(m.expression).rename(canonical).text, str(m.default))
    return keys


def variables_of(c: CompiledNet, ranges: Mapping[str, tuple[float, float]]) -> tuple[tuple[Variable, ...], dict[str, int]]:
    """The variables that some transition reads, and the variable of each of their places."""
    keys = _keys(c)
    cuts: dict[tuple[str, ...], set[float]] = {}
    places: dict[tuple[str, ...], list[object]] = {}
    chosen = {p.name for p, s in zip(c.net.places, selected_places(c)) if s}
    for t in c.net.transitions:
        for arcs in (t.inputs, t.sets, t.tests, t.inhibitors):
            for name, value in arcs.items():
                if name in chosen or not c.moved[c.place_index[name]]:
                    cuts.setdefault(keys[name], set()).add(float(value))
    for p in c.net.places:
        if keys[p.name] in cuts:
            places.setdefault(keys[p.name], []).append(p)
    variables, of_place = [], {}
    for x, (key, members) in enumerate(places.items()):
        names = tuple(p.name for p in members)  # type: ignore[attr-defined]
        of_place.update(dict.fromkeys(names, x))
        first = members[0]
        if isinstance(first, ObjectPlace):
            variables.append(Variable(names[0], names, ((0.0, 1.0), (1.0, 2.0)), is_object=True))
            continue
        edges = [-INFINITY, *sorted(cuts[key]), INFINITY]
        low, high = max(ranges[n][0] for n in names), min(ranges[n][1] for n in names)
        if len(edges) > 60:
            raise NetError(f"place {names[0]!r}: read at {len(edges) - 2} thresholds; analysis follows at most 58 per variable")
        cells = tuple((a, b) for a, b in pairwise(edges) if b > low and a <= high)
        fixed = 0
        if isinstance(first, Continuous) and first.name not in c.net.ports.parameters:
            fixed = 1 + next(k for k, (a, b) in enumerate(cells) if a <= first.value < b)
        variables.append(Variable(names[0], names, cells, fixed=fixed))
    return tuple(variables), of_place


def ranges_of(c: CompiledNet, bounds: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Least and largest value of every place, as far as known; of math places as far as their expressions say."""
    for name in bounds:
        c.place(name)
    ranges: dict[str, tuple[float, float]] = {}
    for p in c.net.places:
        low, high = -LARGEST, LARGEST
        if isinstance(p, Place):
            low, high = 0.0, LARGEST if p.capacity is None else float(p.capacity)
        elif isinstance(p, Continuous) and p.name not in c.net.ports.parameters:
            low = high = p.value
        elif isinstance(p, Belief) and p.view in ("probability", "entropy", "variance"):
            low, high = 0.0, 1.0 if p.view == "probability" else LARGEST
        ranges[p.name] = _narrowed(p.name, low, high, bounds)
    scope = {p.name: p for p in c.net.places}
    for m in c.math:
        expression = Expression(m.expression)
        read = {name: resolve_name(name, scope) for name in expression.names}
        held = any(attribute for _, attribute in read.values())
        found = expression.bounds({n: (-LARGEST, LARGEST) if attribute else ranges[place] for n, (place, attribute) in read.items()})
        low, high = (-LARGEST, LARGEST) if found.empty else (found.low, found.high)
        if held:
            low, high = min(low, m.default), max(high, m.default)
        ranges[m.name] = _narrowed(m.name, low, high, bounds)
    return ranges


def _narrowed(name: str, low: float, high: float, bounds: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """The range (low, high) of a place together with what is given about it."""
    given = bounds.get(name, (low, high))
    both = max(low, given[0]), min(high, given[1])
    if both[0] > both[1]:
        raise NetError(f"bounds of place {name!r}: {given} and [{low:g}, {high:g}] have nothing in common")
    return both


def cell_arcs(
    t: Transition, variables: tuple[Variable, ...], of_place: Mapping[str, int]
) -> tuple[list[tuple[int, ...]], list[tuple[int, ...]]]:
    """Masks of the cells that let `t` be enabled, and the cells it writes."""
    masks: dict[int, int] = {}
    writes: dict[int, int] = {}
    for kind in ("inputs", "tests", "inhibitors"):
        for name, value in getattr(t, kind).items():
            if name not in of_place:
                continue
            x = of_place[name]
            v = variables[x]
            above = sum(2 << k for k, (low, _) in enumerate(v.cells) if low >= value)
            every = sum(2 << k for k in range(len(v.cells)))
            masks[x] = masks.get(x, every) & (every ^ above if kind == "inhibitors" else above)
            if kind == "inputs":
                writes[x] = 1
    writes.update({of_place[name]: 1 for name in t.sets if name in of_place})
    return list(masks.items()), list(writes.items())


def volatile_variables(c: CompiledNet, of_place: Mapping[str, int]) -> dict[str, list[int]]:
    """Moved place -> variables whose value hangs on it within a cycle (math places, attributes of held objects)."""
    scope = {p.name: p for p in c.net.places}
    reads: dict[str, set[str]] = {}
    for place in c.math:
        operands = {resolve_name(n, scope)[0] for n in Expression(place.expression).names}
        reads[place.name] = set().union(*({o} | reads.get(o, set()) for o in operands if o)) if operands else set()
    for p in c.net.places:
        if isinstance(p, Belief):
            owner = resolve_name(p.variable, scope)[0]
            if isinstance(scope.get(owner), ObjectPlace):
                reads[p.name] = {owner}
    result: dict[str, list[int]] = {}
    for name, operands in reads.items():
        for operand in operands:
            if name in of_place and c.kind[c.place_index[operand]] in (PlaceKind.DISCRETE, PlaceKind.OBJECT):
                result.setdefault(operand, []).append(of_place[name])
    return result
