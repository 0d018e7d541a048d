"""Whether two nets behave alike: weak bisimulation of their state spaces, for bounded nets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ....errors import NetError
from ...petri.execution.compiled_net import UNBOUNDED, CompiledNet, compile_net
from ...petri.net.net import PetriNet

Marking = tuple[float, ...]
Steps = list[tuple[str, int]]


class StateSpace(NamedTuple):
    """Every marking a net can reach, time left out: any timed transition may fire when no immediate one is enabled."""

    markings: list[Marking]
    steps: list[Steps]  # per marking: (transition, next marking)


class Verdict(NamedTuple):
    """The answer of `weakly_bisimilar`."""

    alike: bool
    states: tuple[int, int]  # explored of each net
    reason: str  # empty when alike


def explore(net: CompiledNet, limit: int = 100_000) -> StateSpace:
    """The state space of a net under its firing rule, priorities respected, equal priorities in every order.

    Raises
    ------
    NetError
        When it has more than `limit` markings.
    """
    first: Marking = tuple(net.initial.tolist())
    index = {first: 0}
    markings, steps = [first], []
    immediate = [t for t in range(net.n_transitions) if net.delay[t] == 0]
    timed = [t for t in range(net.n_transitions) if net.delay[t] > 0]
    position = 0
    while position < len(markings):
        marking = markings[position]
        able = [t for t in immediate if is_enabled(net, marking, t)]
        if able:
            best = max(int(net.priority[t]) for t in able)
            able = [t for t in able if net.priority[t] == best]
        else:
            able = [t for t in timed if is_enabled(net, marking, t)]
        found: Steps = []
        for t in able:
            after = fire(net, marking, t)
            if after not in index:
                if len(markings) >= limit:
                    raise NetError(f"net {net.net.name!r} has more than {limit} markings; they cannot be compared")
                index[after] = len(markings)
                markings.append(after)
            found.append((net.transition_names[t], index[after]))
        steps.append(found)
        position += 1
    return StateSpace(markings, steps)


def is_enabled(net: CompiledNet, marking: Sequence[float], t: int) -> bool:
    """Whether `marking` enables transition `t`."""
    consumed, produced = dict(net.inputs.of(t)), dict(net.outputs.of(t))
    if any(marking[p] < w for p, w in consumed.items()) or any(marking[p] < w for p, w in net.tests.of(t)):
        return False
    if any(marking[p] >= w for p, w in net.inhibitors.of(t)):
        return False
    weak = net.net.semantics.capacity == "weak"
    for p, amount in produced.items():
        back = 0 if weak else consumed.get(p, 0)
        if net.capacity[p] != UNBOUNDED and amount > back and marking[p] + amount - back > net.capacity[p]:
            return False
    return True


def fire(net: CompiledNet, marking: Marking, t: int) -> Marking:
    """The marking after `t`; of object places only whether they hold an object."""
    after = list(marking)
    for p, w in net.inputs.of(t):
        after[p] -= w
    for p, w in net.outputs.of(t):
        after[p] += w
    for p, value in net.sets.of(t):
        after[p] = value
    return tuple(after)


def weakly_bisimilar(a: PetriNet, b: PetriNet, *, hidden: Callable[[str], bool], limit: int = 100_000) -> Verdict:
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
        Markings of each beyond which the comparison is given up with `NetError`.
    """
    nets = [compile_net(net) for net in (a, b)]
    spaces = [explore(net, limit) for net in nets]
    names = [[name for name in net.place_names if not hidden(name) and net.moved[net.place(name)]] for net in nets]
    if sorted(names[0]) != sorted(names[1]):
        return Verdict(False, (0, 0), f"their visible places differ: {sorted(set(names[0]) ^ set(names[1]))}")
    shows: list[Marking | None] = []  # None: a hidden place is marked
    steps: list[Steps] = []
    for net, space in zip(nets, spaces):
        offset = len(shows)
        visible = [net.place(name) for name in sorted(names[0])]
        secret = [p for p, name in enumerate(net.place_names) if hidden(name)]
        for marking, row in zip(space.markings, space.steps):
            shows.append(None if any(marking[p] for p in secret) else tuple(marking[p] for p in visible))
            steps.append([("" if hidden(t) else t, offset + target) for t, target in row])
    closure = [_closure(state, steps) for state in range(len(steps))]
    seen = [frozenset(shown for shown in (shows[s] for s in closure[state]) if shown is not None) for state in range(len(steps))]
    weak = [_weak_steps(closure[state], steps, closure) for state in range(len(steps))]
    block = _refine(seen, weak)
    start = len(spaces[0].markings)
    sizes = (start, len(spaces[1].markings))
    if block[0] == block[start]:
        return Verdict(True, sizes, "")
    return Verdict(False, sizes, _difference(0, start, seen, weak, block))


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
