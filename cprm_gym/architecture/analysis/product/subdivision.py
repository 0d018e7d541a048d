"""Independent groups of net and world (dissertation §3.2.1): found from the graph, analysed apart, recombined.

What depends on each other is one group: variables with their parents in any slice, places and transitions along arcs, percepts with the
variables that they show, and commands with the variables that they change. So what the agent couples is noticed, though the world keeps
it apart. Groups that are left are independent also in how they begin; only the end couples them, since the whole ends with the first
outcome of any. That is put together from how each ends over time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import unknown_name
from ...expressions import Expression
from ...petri import Belief, CompiledNet, Continuous, Input, Math, ObjectPlace, PetriNet, Ports, Transition, compile_net
from ..budget import Budget
from ..markov.absorption import Absorption, absorption
from ..markov.chain import NEVER, Certified
from ..markov.over_time import OverTime, outcomes_over_time
from .explore import STATES, Product, product
from .prm_world import PRMWorld

LONGEST = 100_000
"""Cycles that are looked ahead at most, to put together what was analysed apart."""
REST = 1e-13
"""Chance of going on at which looking ahead ends."""


class Part(NamedTuple):
    """A group: a net and a world of its own."""

    net: PetriNet
    world: PRMWorld
    outcomes: Mapping[str, str]


def subdivide(net: PetriNet | CompiledNet, world: PRMWorld, outcomes: Mapping[str, str]) -> tuple[Part, ...]:
    """The independent groups in which something ends; what has no part in any outcome is left out.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    world : PRMWorld
    outcomes : mapping of str to str
        Outcome -> place, as for `product`.
    """
    flat = (net if isinstance(net, CompiledNet) else compile_net(net)).net
    union = _Union()
    constants = {p.name for p in flat.places if isinstance(p, Continuous)}
    _join_world(union, world)
    _join_commands(union, flat, world)
    _join_net(union, flat, world, constants)
    if any(isinstance(p, ObjectPlace) for p in flat.places):  # objects are chosen among all there are
        union.join([*(("place", p.name) for p in flat.places), *(("variable", v) for v in world.names)])
    heads: dict[_Node, None] = {}
    for place in outcomes.values():
        heads[union.find(("place", place))] = None
    for text in world.ends.values():
        for name in Expression(text).names:
            heads[union.find(("variable", name))] = None
    return tuple(_part(union, head, flat, world, outcomes, constants) for head in heads)


def groups(world: PRMWorld, together: Sequence[Sequence[str]] = ()) -> list[tuple[str, ...]]:
    """Variables of a world that can be analysed apart: connected by parents in any slice, or by what the agent does.

    Parameters
    ----------
    world : PRMWorld
    together : sequence of sequences of str
        Variables that an agent couples; `coupled` says what one that is not known may couple, `subdivide` looks at the net itself.
    """
    union = _Union()
    _join_world(union, world)
    for link in together:
        union.join(("variable", v) for v in link)
    return sorted(tuple(sorted(name for _, name in group)) for group in union.classes(("variable", v) for v in world.names))


def coupled(world: PRMWorld) -> list[tuple[str, ...]]:
    """What some agent in this world may couple: all variables that it perceives, with all that its commands change."""
    read = {n for text in world.percepts_.values() for n in Expression(text).names}
    changed = {v for relation in world.relations for v in _changed(world, relation)}
    changed |= {v for given in world.given for v in _told(world, given)}
    joint = tuple(sorted(read | changed)) if changed else ()
    return [joint] if joint else []


@dataclass(frozen=True, eq=False)
class Apart:
    """What was found of each group, and of the whole.

    Attributes
    ----------
    outcomes : tuple of str
        In the order in which they count where several come at once.
    parts : tuple of Part
    products : tuple of Product
    solved : tuple of Absorption
    over : tuple of OverTime
        Of each group as long as all go on with a chance above `REST`.
    """

    outcomes: tuple[str, ...]
    parts: tuple[Part, ...]
    products: tuple[Product, ...]
    solved: tuple[Absorption, ...]
    over: tuple[OverTime, ...]

    @property
    def states(self) -> int:
        """States of all groups."""
        return sum(p.chain.n for p in self.products)

    @property
    def complete(self) -> bool:
        """Whether all reachable states are there."""
        return all(p.complete for p in self.products)

    def probability(self, outcome: str) -> Certified:
        """That the whole ends in an outcome, which is the first of any group.

        Raises
        ------
        UnknownName
        """
        if outcome not in (*self.outcomes, NEVER):
            raise unknown_name("outcome", outcome, (*self.outcomes, NEVER))
        never = float(np.prod([s.probability(NEVER).value for s in self.solved]))
        error = sum(s.probability(NEVER).error for s in self.solved)
        if outcome == NEVER:
            return Certified(never, error)
        rank = {name: k for k, name in enumerate(self.outcomes)}
        total = 0.0
        for j, over in enumerate(self.over):
            if outcome not in over.outcomes:
                continue
            share = _each(over)[:, over.outcomes.index(outcome)].copy()
            for other in (o for k, o in enumerate(self.over) if k != j):
                later = [k for k, name in enumerate(other.outcomes) if rank[name] > rank[outcome]]
                share *= other.remaining + _each(other)[:, later].sum(axis=1)
            total += float(share.sum())
        return Certified(total, max(0.0, float(self._going[-1]) - never) + error + self._rounding)

    @property
    def expected_time(self) -> Certified:
        """Expected cycles until the first outcome of any group; infinite where it may never come."""
        if all(s.may_diverge for s in self.solved):
            return Certified(float("inf"), 0.0)
        going = self._going
        tails = []
        for j, (solved, over) in enumerate(zip(self.solved, self.over)):
            if not solved.may_diverge:
                own = max(0.0, solved.expected_time.high - float(over.remaining[:-1].sum()))
                tails.append(own * float(np.prod([o.remaining[-1] for k, o in enumerate(self.over) if k != j])))
        return Certified(float(going[:-1].sum()), min(tails) + self._rounding * len(going))

    def jointly(self, ends: Sequence[str]) -> Certified:
        """That the groups, each for itself to its end, come to these outcomes, one for each; of all combinations these sum to one.

        Raises
        ------
        UnknownName
        """
        found = [s.probability(o) for s, o in zip(self.solved, ends, strict=True)]
        return Certified(float(np.prod([p.value for p in found])), sum(p.error for p in found))

    @property
    def _going(self) -> NDArray[np.float64]:
        return np.asarray(np.prod([o.remaining for o in self.over], axis=0))

    @property
    def _rounding(self) -> float:
        return sum(o.error for o in self.over) * len(self.over)


def analyze_apart(net: PetriNet | CompiledNet, world: PRMWorld, outcomes: Mapping[str, str], *, budget: Budget | None = None) -> Apart:
    """Find independent groups, analyse each for itself, and say what that makes of the whole.

    States are those of the groups together, where those of the whole are their product.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    world : PRMWorld
    outcomes : mapping of str to str
        Outcome -> place, as for `product`.
    budget : Budget, optional
        For each group.

    Raises
    ------
    NetError, ModelError
        As of `product`.
    """
    parts = subdivide(net, world, outcomes)
    limits, _ = (budget or Budget(states=STATES)).start()
    products = tuple(product(p.net, p.world, p.outcomes, budget=limits) for p in parts)
    solved = tuple(absorption(p.chain) for p in products)
    names = dict.fromkeys((*outcomes, *world.ends, *(o for p in products for o in p.chain.outcomes)))
    cycles = 64
    while True:
        over = tuple(outcomes_over_time(p.chain, cycles) for p in products)
        found = Apart(tuple(names), parts, products, solved, over)
        if cycles >= LONGEST or found._going[-1] - found.probability(NEVER).value <= REST:
            return found
        cycles = min(4 * cycles, LONGEST)


def _each(over: OverTime) -> NDArray[np.float64]:
    """(cycles + 1, outcomes) What ends in exactly each cycle."""
    return np.diff(over.ended, axis=0, prepend=0.0)


# ------------------------------------------------------------------------------------------------- the graph

_Node = tuple[str, str]


class _Union:
    """Nodes that are joined, by union and find."""

    def __init__(self) -> None:
        self.root: dict[_Node, _Node] = {}

    def find(self, node: _Node) -> _Node:
        self.root.setdefault(node, node)
        while self.root[node] != node:
            self.root[node] = node = self.root[self.root[node]]
        return node

    def join(self, nodes: Iterable[_Node]) -> None:
        first: _Node | None = None
        for node in nodes:
            if first is None:
                first = self.find(node)
            self.root[self.find(node)] = first = self.find(first)

    def classes(self, nodes: Iterable[_Node]) -> list[list[_Node]]:
        found: dict[_Node, list[_Node]] = {}
        for node in nodes:
            found.setdefault(self.find(node), []).append(node)
        return list(found.values())


def _join_world(union: _Union, world: PRMWorld) -> None:
    slices = [world.grounding.ground((), first=True), world.grounding.ground(())]
    slices += [world.grounding.ground([relation]) for relation in world.relations]
    for slice_ in slices:
        for cpd in slice_.cpds:
            union.join(("variable", n) for n in (cpd.child, *(p for p, _ in cpd.parents)) if n in world.names)
    for text in world.ends.values():
        union.join(("variable", n) for n in Expression(text).names)


def _changed(world: PRMWorld, relation: str) -> set[str]:
    """Variables whose chances a relation changes."""
    slice_, plain = world.grounding.ground([relation]), world.grounding.ground(())
    before = plain.by_child
    return {c.child for c in slice_.cpds if c.key != before[c.child].key or c.parents != before[c.child].parents}


def _told(world: PRMWorld, given: str) -> set[str]:
    """Variables whose chances depend on a given one."""
    return {c.child for c in world.grounding.ground(()).cpds if any(p == given for p, _ in c.parents)}


def _join_commands(union: _Union, flat: PetriNet, world: PRMWorld) -> None:
    """What commands change, with whoever gives them, and with what their effect depends on."""
    effects = [(text, _changed(world, relation)) for relation, text in world.relations.items()]
    effects += [(text, _told(world, given)) for given, text in world.given.items()]
    for text, changed in effects:
        names = Expression(text).names
        givers = [("transition", t.name) for t in flat.transitions if t.emits is not None and t.emits.name in names]
        read = [("variable", n) for n in names if n in world.names]
        union.join([*(("variable", n) for n in sorted(changed)), *read, *givers])


def _join_net(union: _Union, flat: PetriNet, world: PRMWorld, constants: set[str]) -> None:
    for t in flat.transitions:
        union.join([("transition", t.name), *(("place", p) for p in _around(t) if p not in constants)])
    for place in flat.places:
        own = ("place", place.name)
        if isinstance(place, Math):
            union.join([own, *(("place", n) for n in Expression(place.expression).names if n not in constants)])
        elif isinstance(place, (Input, Belief)):
            percept = place.observes if isinstance(place, Input) else place.name
            shown = Expression(world.percepts_[percept]).names if percept in world.percepts_ else ()
            union.join([own, *(("variable", n) for n in shown)])


def _around(t: Transition) -> list[str]:
    """Places that a transition touches, looks at, or tells of in its command."""
    arcs = [p for kind in (t.inputs, t.outputs, t.tests, t.inhibitors, t.sets) for p in kind]
    return arcs + [v for v in (t.emits.params.values() if t.emits is not None else ()) if isinstance(v, str)]


def _part(union: _Union, head: _Node, flat: PetriNet, world: PRMWorld, outcomes: Mapping[str, str], constants: set[str]) -> Part:
    def inside(kind: str, name: str) -> bool:
        return union.find((kind, name)) == head

    variables = tuple(v for v in world.names if inside("variable", v))
    places = tuple(p for p in flat.places if p.name in constants or inside("place", p.name))
    transitions = tuple(t for t in flat.transitions if inside("transition", t.name))
    net = replace(flat, places=places, transitions=transitions, ports=Ports())
    shown = {k: text for k, text in world.percepts_.items() if set(Expression(text).names) <= set(variables)}
    relations = {r: text for r, text in world.relations.items() if _changed(world, r) & set(variables)}
    ends = {k: text for k, text in world.ends.items() if set(Expression(text).names) <= set(variables)}
    own = replace(world, percepts_=shown, relations=relations, ends=ends, only=variables)
    return Part(net, own, {k: p for k, p in outcomes.items() if inside("place", p)})
