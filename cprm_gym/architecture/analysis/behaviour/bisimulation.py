"""Whether two nets behave alike: weak bisimulation of their state spaces, for bounded nets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ....errors import NetError
from ...petri.net.net import PetriNet
from ..budget import Budget
from ..net_arrays import System
from .state_space import StateSpace, explore

Marking = tuple[int, ...]
Steps = list[tuple[str, int]]


class Comparison(NamedTuple):
    """The answer of `weakly_bisimilar`."""

    alike: bool
    states: tuple[int, int]  # explored of each net
    reason: str  # empty when alike


def _explored(net: PetriNet, limit: int) -> StateSpace:
    """The state space under the firing rule: any timed transition may fire when no immediate one is enabled, priorities respected."""
    space = explore(System.from_net(net, timing=True, initial_values=True), Budget(states=limit + 1), chunk=max(1, limit // 4))
    if not space.complete or space.n_states > limit:
        raise NetError(f"net {net.name!r} has more than {limit} markings; they cannot be compared")
    return space


def weakly_bisimilar(a: PetriNet, b: PetriNet, *, hidden: Callable[[str], bool], limit: int = 100_000) -> Comparison:
    """Whether `a` and `b` behave alike, steps of hidden transitions left out.

    Two markings are alike when, after hidden steps, they show the same markings of the visible places, and each visible
    transition that one can fire (with hidden steps around it) the other can fire too, to markings that are alike again. A marking
    shows something only while no hidden place is marked. Input, belief and continuous places keep their initial values; math
    places are left out.

    Parameters
    ----------
    a, b : PetriNet
        Bounded.
    hidden : callable
        Name of a place or transition -> whether it is hidden.
    limit : int
        Markings of each beyond which the comparison is given up.

    Raises
    ------
    NetError
        When one has more than `limit` markings.
    """
    spaces = [_explored(net, limit) for net in (a, b)]
    names = [sorted(name for name in space.system.places if not hidden(name)) for space in spaces]
    if names[0] != names[1]:
        return Comparison(False, (0, 0), f"their visible places differ: {sorted(set(names[0]) ^ set(names[1]))}")
    shows: list[Marking | None] = []  # None: a hidden place is marked
    steps: list[Steps] = []
    for space in spaces:
        offset, graph, system = len(shows), space.graph(), space.system
        visible = [system.place(name) for name in names[0]]
        secret = [p for p, name in enumerate(system.places) if hidden(name)]
        for i, row in enumerate(space.markings()):
            shows.append(None if row[secret].any() else tuple(row[visible].tolist()))
            edges = np.arange(graph.offsets[i], graph.offsets[i + 1])
            fired = [system.transitions[t] for t in graph.labels[edges]]
            steps.append([("" if hidden(t) else t, offset + int(target)) for t, target in zip(fired, graph.targets[edges])])
    closure = [_closure(state, steps) for state in range(len(steps))]
    seen = [frozenset(shown for shown in (shows[s] for s in closure[state]) if shown is not None) for state in range(len(steps))]
    weak = [_weak_steps(closure[state], steps, closure) for state in range(len(steps))]
    block = _refine(seen, weak)
    start = spaces[0].n_states
    sizes = (start, spaces[1].n_states)
    if block[0] == block[start]:
        return Comparison(True, sizes, "")
    return Comparison(False, sizes, _difference(0, start, seen, weak, block))


def _closure(state: int, steps: Sequence[Steps]) -> frozenset[int]:
    """The states reached from `state` by hidden steps, itself among them."""
    found, todo = {state}, [state]
    while todo:
        for name, target in steps[todo.pop()]:
            if not name and target not in found:
                found.add(target)
                todo.append(target)
    return frozenset(found)


def _weak_steps(closure: frozenset[int], steps: Sequence[Steps], closures: Sequence[frozenset[int]]) -> frozenset[tuple[str, int]]:
    found: set[tuple[str, int]] = set()
    for state in closure:
        for name, target in steps[state]:
            if name:
                found |= {(name, after) for after in closures[target]}
    return frozenset(found)


def _refine(seen: Sequence[object], weak: Sequence[frozenset[tuple[str, int]]]) -> list[int]:
    """The coarsest blocks of states that see the same and step to the same blocks."""
    block = _numbers(list(seen))
    while True:
        finer = _numbers([(block[s], frozenset((name, block[t]) for name, t in weak[s])) for s in range(len(weak))])
        if max(finer) == max(block):
            return finer
        block = finer


def _numbers(keys: Sequence[object]) -> list[int]:
    known: dict[object, int] = {}
    return [known.setdefault(key, len(known)) for key in keys]


def _difference(
    a: int, b: int, seen: Sequence[frozenset[Marking]], weak: Sequence[frozenset[tuple[str, int]]], block: Sequence[int]
) -> str:
    """A firing sequence after which the two differ, in words."""
    path: list[str] = []
    visited: set[tuple[int, int]] = set()
    while (a, b) not in visited:
        visited.add((a, b))
        after = f"after {' '.join(path) or 'nothing'}"
        if seen[a] != seen[b]:
            return f"{after} they show {sorted(seen[a] - seen[b])} and {sorted(seen[b] - seen[a])}"
        for name in sorted({name for name, _ in weak[a] | weak[b]}):
            mine, theirs = ({t for n, t in weak[s] if n == name} for s in (a, b))
            if not mine or not theirs:
                return f"{after} only one of them can fire {name!r}"
            if {block[t] for t in mine} != {block[t] for t in theirs}:
                path.append(name)
                a, b = _apart(mine, theirs, block), _apart(theirs, mine, block)
                break
    return f"they differ after {' '.join(path)}"


def _apart(mine: set[int], theirs: set[int], block: Sequence[int]) -> int:
    """A state of `mine` that is like none of `theirs`, if there is one."""
    known = {block[t] for t in theirs}
    return min((t for t in mine if block[t] not in known), default=min(mine))
