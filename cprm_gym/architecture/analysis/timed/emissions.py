"""Commands that may be sent in one cycle although only one of them can go out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..behaviour.graphs import closure, shortest_run
from ..structure.invariants import never
from ..verdicts import Step
from .state_space import TimedStateSpace


@dataclass(frozen=True)
class Emission:
    """Two transitions that may send exclusive commands in one cycle: one of the two is overruled.

    Attributes
    ----------
    first, second : str
        Transitions, in the order of `run`.
    commands : (str, str)
    run : tuple of Step
        To the second firing.
    decided : bool
        False where it is not decided whether what is observed can be so; without a run.
    """

    first: str
    second: str
    commands: tuple[str, str]
    run: tuple[Step, ...] = ()
    decided: bool = True

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        run = [s.to_json() for s in self.run]
        return {"first": self.first, "second": self.second, "commands": list(self.commands), "run": run, "decided": self.decided}

    def __str__(self) -> str:
        perhaps = "" if self.decided else ", perhaps"
        return f"{self.first!r} sends {self.commands[0]!r} and {self.second!r} {self.commands[1]!r} in one cycle{perhaps}"


def emissions(space: TimedStateSpace, exclusive: Sequence[Sequence[str]] = (), enough: Callable[[], bool] = never) -> tuple[Emission, ...]:
    """Every pair of transitions that some run lets send commands of one exclusive group in one cycle.

    Parameters
    ----------
    space : TimedStateSpace
    exclusive : sequence of sequences of command names
        As for the executor; two commands of one name are always exclusive.
    enough : callable
        Whether to stop early.
    """
    real = _emissions(space.real_part, exclusive, enough)
    if space.unsure is None:
        return real
    known = {frozenset((e.first, e.second)) for e in real}
    maybe = [e for e in _emissions(space, exclusive, enough) if frozenset((e.first, e.second)) not in known]
    return (*real, *(replace(e, run=(), decided=False) for e in maybe))


def _emissions(space: TimedStateSpace, exclusive: Sequence[Sequence[str]], enough: Callable[[], bool]) -> tuple[Emission, ...]:
    graph, tick = space.graph, space.system.tick_label
    inside = graph.labels != tick
    senders = {t: command.name for t, command in _senders(space)}
    found: list[Emission] = []
    for t, command in senders.items():
        if enough():
            break
        fires = np.flatnonzero(graph.labels == t)
        if not len(fires):
            continue
        rivals = [u for u, other in senders.items() if _exclusive(command, other, exclusive)]
        starts = np.unique(graph.targets[fires]).astype(np.int64)
        reached = closure(graph, starts, inside)
        for u in rivals:
            names = space.system.labels[t], space.system.labels[u]
            later = np.flatnonzero((graph.labels == u) & reached[graph.sources])
            if len(later) and not any({e.first, e.second} == set(names) for e in found):
                found.append(Emission(*names, (command, senders[u]), _run(space, t, u, starts, inside)))
    return tuple(found)


def _senders(space: TimedStateSpace) -> Iterator[tuple[int, Any]]:
    for t, transition in enumerate(space.system.transitions[: space.system.n_own]):
        if transition.emits is not None:
            yield t, transition.emits


def _exclusive(a: str, b: str, groups: Sequence[Sequence[str]]) -> bool:
    return a == b or any(a in group and b in group for group in groups)


def _run(space: TimedStateSpace, t: int, u: int, starts: np.ndarray, inside: np.ndarray) -> tuple[Step, ...]:
    """A run on which `t` fires and, in the same cycle, `u`."""
    graph = space.graph
    goal = np.zeros(graph.n_nodes, bool)
    goal[graph.sources[graph.labels == u]] = True
    between = shortest_run(graph, starts, goal, inside)
    assert between is not None
    nodes, edges = between
    first = int(np.flatnonzero((graph.labels == t) & (graph.targets == nodes[0]))[0])
    last = int(np.flatnonzero((graph.labels == u) & (graph.sources == nodes[-1]))[0])
    return space.steps([*space.edges_to(int(graph.sources[first])), first, *edges, last])
