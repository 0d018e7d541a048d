"""What a net can do from its initial marking, time left out (§2.2.1, §3.1: PN-ANALYSIS).

Every answer is a `Verdict`: true, false or not known, with the reason and, where a run shows it, a firing sequence that was checked by
replay. The untimed view lets every transition fire whenever its tokens are there; it holds all that the timed net does, so that
what it excludes is excluded. The timed view (`analyze_timed`) follows clocks, priorities and the environment cycle by cycle.

Words (Murata, *Petri nets: properties, analysis and applications*, 1989): a transition is *dead* if it never fires, *live* if from every
reachable marking it can still fire; a *home* marking can be reached from every reachable one; a net is *reversible* if its
initial marking is one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...petri import CompiledNet, PetriNet
from ..budget import Budget, Clock
from ..net_arrays import System
from ..structure.invariants import finite_transitions
from ..verdicts import UNKNOWN, Verdict, untimed_run
from .coverability import karp_miller
from .graphs import Components, can_reach, components
from .state_space import Graph, Progress, StateSpace, explore


@dataclass(frozen=True)
class Proofs:
    """What is proved without exploration.

    Attributes
    ----------
    conservative, siphon_trap : Verdict
    most : mapping from place to tokens
        Most that P-invariants allow.
    """

    conservative: Verdict = UNKNOWN
    siphon_trap: Verdict = UNKNOWN
    most: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Soundness:
    """Soundness of a workflow net (van der Aalst): one source place, one sink place, from one token in the source.

    Attributes
    ----------
    source, sink : str
    option_to_complete : Verdict
        From every reachable marking, exactly one token in the sink can be reached.
    proper_completion : Verdict
        When the sink is marked, nothing else is.
    dead_transitions : tuple of str
    """

    source: str
    sink: str
    option_to_complete: Verdict
    proper_completion: Verdict
    dead_transitions: tuple[str, ...] | None

    @property
    def sound(self) -> bool | None:
        """All three."""
        parts = [self.option_to_complete.holds, self.proper_completion.holds]
        parts.append(None if self.dead_transitions is None else not self.dead_transitions)
        return False if False in parts else None if None in parts else True

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "source": self.source,
            "sink": self.sink,
            "sound": self.sound,
            "option_to_complete": self.option_to_complete.to_json(),
            "proper_completion": self.proper_completion.to_json(),
            "dead_transitions": None if self.dead_transitions is None else list(self.dead_transitions),
        }


@dataclass(frozen=True)
class Structure:
    """What the untimed state space says.

    Attributes
    ----------
    states, edges : int
        Found so far if not `complete`.
    complete, reason
        Whether the whole state space was explored, and why not.
    max_tokens_in_place, max_tokens_in_marking : int
        Seen so far if not `complete`.
    bounds : dict from place to int
        Most tokens seen.
    bounded, one_safe, deadlock_free, quasi_live, live, reversible : Verdict
    deadlocks : int
    dead_transitions : tuple of str
        Those that never fired; certain only if `complete`.
    liveness : dict from transition to level
        0 never fires, 1 can fire, 3 can fire for ever, 4 live; empty if not known.
    sccs, bottom_sccs : int
        Strongly connected components, and those that are never left; -1 if not known.
    home_markings : int
        Markings reachable from everywhere; -1 if not known.
    """

    states: int
    edges: int
    complete: bool
    reason: str
    seconds: float
    bytes_per_state: float
    max_tokens_in_place: int
    max_tokens_in_marking: int
    bounds: Mapping[str, int]
    bounded: Verdict
    one_safe: Verdict
    deadlock_free: Verdict
    quasi_live: Verdict
    live: Verdict
    reversible: Verdict
    deadlocks: int
    dead_transitions: tuple[str, ...]
    liveness: Mapping[str, int]
    sccs: int
    bottom_sccs: int
    home_markings: int
    soundness: Soundness | None = None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        out: dict[str, Any] = {}
        for key, value in self.__dict__.items():
            if isinstance(value, (Verdict, Soundness)):
                out[key] = value.to_json()
            elif isinstance(value, Mapping):
                out[key] = dict(value)
            else:
                out[key] = list(value) if isinstance(value, tuple) else value
        return out


def analyze_structure(
    net: System | PetriNet | CompiledNet,
    budget: Budget | None = None,
    progress: Progress | None = None,
    graph_memory: int | None = None,
    proofs: Proofs | None = None,
) -> Structure:
    """Reachability, boundedness, deadlocks, liveness, home markings, reversibility, soundness of the untimed view.

    Parameters
    ----------
    net : System, PetriNet or CompiledNet
    budget : Budget, optional
        The exploration stops with a partial answer when it is spent.
    progress : callable, optional
    graph_memory : int, optional
        Bytes for the edges; beyond, liveness and home markings stay unknown. By default as much as the markings may take.
    proofs : Proofs, optional
        What is proved without exploration: it decides what exploration leaves open.
    """
    system = net if isinstance(net, System) else System.from_net(net)
    budget, clock = (budget or Budget()).start()
    proofs = proofs or Proofs()
    graph_memory = budget.memory if graph_memory is None else graph_memory
    space = explore(system, budget.part(0.7), progress, edge_memory=graph_memory // 4)
    most, total = space.most_tokens()
    complete = space.complete
    graph, parts = _graph(space, graph_memory, clock)
    stopped = "" if complete else f"the exploration stopped: {space.reason}"
    dead = tuple(system.transitions[t] for t in np.flatnonzero(space.fired < 0))
    bounded = _bounded(space, stopped, proofs)
    if not complete and bounded.holds is False:
        cover = karp_miller(system, replace(budget.part(0.5), memory=min(budget.memory, 256 * 1024**2))) if not system.group.any() else None
        if cover is not None and cover.complete:
            dead = cover.dead_transitions
            stopped_dead = ""
        else:
            stopped_dead = stopped
    else:
        stopped_dead = stopped
    return Structure(
        states=space.n_states,
        edges=space.n_edges,
        complete=complete,
        reason=space.reason,
        seconds=space.seconds,
        bytes_per_state=space.bytes_per_state,
        max_tokens_in_place=int(most.max(initial=0)),
        max_tokens_in_marking=total,
        bounds={p: int(b) for p, b in zip(system.places, most)},
        bounded=bounded,
        one_safe=_one_safe(space, most, stopped, proofs, clock),
        deadlock_free=_deadlock_free(space, stopped, proofs, clock),
        quasi_live=_quasi_live(dead, stopped_dead),
        live=_live(space, graph, parts, stopped, bounded.holds is True, clock),
        reversible=_reversible(space, graph, parts, stopped, bounded.holds is True, clock),
        deadlocks=space.n_deadlocks,
        dead_transitions=dead,
        liveness=_levels(system, parts),
        sccs=parts.count if parts else -1,
        bottom_sccs=int(parts.bottom.sum()) if parts else -1,
        home_markings=_home(parts),
        soundness=_soundness_of(system, space, graph, parts, budget, clock),
    )


def _graph(space: StateSpace, memory: int, clock: Clock) -> tuple[Graph, Components] | tuple[None, None]:
    """The graph of a complete state space and its components; None where memory or the user's patience does not allow it."""
    if not space.complete or 8 * space.n_edges + 30 * space.n_states > memory or clock.spent():
        return None, None
    try:
        graph = space.graph()
        return graph, components(graph, len(space.system.transitions))
    except MemoryError:
        return None, None
    except KeyboardInterrupt:
        clock.interrupt()
        return None, None


def _unknown(stopped: str) -> Verdict:
    return Verdict(None, stopped or "the graph of the state space is too large for the memory or the time granted, or was interrupted")


def _bounded(space: StateSpace, stopped: str, proofs: Proofs) -> Verdict:
    if space.complete:
        return Verdict(True)
    if space.pump is not None:
        prefix, repeat = space.pump
        space.system.run(prefix + repeat + repeat)
        return Verdict(
            False,
            "a sequence adds tokens and can be repeated",
            untimed_run(prefix),
            untimed_run(repeat),
            space.system.describe(space.system.run(prefix)[-1]),
        )
    if proofs.conservative.holds:
        return Verdict(True, f"conservation: {proofs.conservative.why}")
    if proofs.most and all(name in proofs.most for name in space.system.places):
        return Verdict(True, "P-invariants bound every place")
    return Verdict(None, stopped)


def _at(space: StateSpace, node: int, holds: bool, why: str, clock: Clock) -> Verdict:
    """The verdict with a run to a node, if the time allows to write it out."""
    path, marking = space.path(node, clock), space.system.describe(space.marking(node))
    if path is None:
        return Verdict(holds, f"{why}; no time was left to write out how to get there", marking=marking)
    return Verdict(holds, why, untimed_run(path), marking=marking)


def _one_safe(space: StateSpace, most: np.ndarray, stopped: str, proofs: Proofs, clock: Clock) -> Verdict:
    if most.max(initial=0) <= 1:
        if not space.complete and proofs.most and all(proofs.most.get(name, 2) <= 1 for name in space.system.places):
            return Verdict(True, "P-invariants allow every place one token")
        return Verdict(True) if space.complete else Verdict(None, stopped)
    p = int(most.argmax())
    for first in range(0, space.n_states, 1 << 16):
        over = np.flatnonzero((space.markings(first, first + (1 << 16)) > 1).any(axis=1))
        if len(over):
            return _at(space, first + int(over[0]), False, f"{space.system.places[p]!r} holds up to {most[p]} tokens", clock)
    return Verdict(None, stopped)


def _deadlock_free(space: StateSpace, stopped: str, proofs: Proofs, clock: Clock) -> Verdict:
    if space.n_deadlocks:
        many = "" if space.n_deadlocks == 1 else f", and in {space.n_deadlocks - 1} others"
        return _at(space, space.first_deadlock, False, f"nothing is enabled in this marking{many}", clock)
    if space.complete:
        return Verdict(True)
    if proofs.siphon_trap.holds and len(space.system.transitions):
        return Verdict(True, proofs.siphon_trap.why)
    return Verdict(None, stopped)


def _quasi_live(dead: tuple[str, ...], stopped: str) -> Verdict:
    if not dead:
        return Verdict(True)
    names = ", ".join(map(repr, dead[:5])) + (f" and {len(dead) - 5} more" if len(dead) > 5 else "")
    return Verdict(None, f"{stopped}; not fired yet: {names}") if stopped else Verdict(False, f"never fire: {names}")


def _live(space: StateSpace, graph: Graph | None, parts: Components | None, stopped: str, bounded: bool, clock: Clock) -> Verdict:
    system = space.system
    if graph is None or parts is None:
        if space.n_deadlocks and len(system.transitions):
            return _at(space, space.first_deadlock, False, "nothing fires after this marking", clock)
        finite = finite_transitions(system, bounded)
        return Verdict(False, next(iter(finite.values()))) if finite else _unknown(stopped)
    if parts.live.all():
        return Verdict(True)
    t = int(np.flatnonzero(~parts.live)[0])
    able = np.zeros(graph.n_nodes, bool)
    able[graph.sources[graph.labels == t]] = True
    lost = np.flatnonzero(~can_reach(graph, parts, able))
    return _at(space, int(lost[0]), False, f"{system.transitions[t]!r} can never fire again after this marking", clock)


def _reversible(space: StateSpace, graph: Graph | None, parts: Components | None, stopped: str, bounded: bool, clock: Clock) -> Verdict:
    if graph is None or parts is None:
        if space.n_deadlocks and space.first_deadlock > 0:
            return _at(space, space.first_deadlock, False, "there is no way back from this marking", clock)
        for t, why in finite_transitions(space.system, True).items():  # what leads back to the start can be repeated
            if space.fired[t] >= 0:
                found = _at(space, int(space.fired[t]), False, f"once it has fired there is no way back: {why}", clock)
                after = space.system.fire(t, space.marking(int(space.fired[t])))
                return replace(found, run=(*found.run, *untimed_run([space.system.transitions[t]])), marking=space.system.describe(after))
        return _unknown(stopped)
    if parts.count == 1:
        return Verdict(True)
    start = np.zeros(graph.n_nodes, bool)
    start[0] = True
    lost = np.flatnonzero(~can_reach(graph, parts, start))
    return _at(space, int(lost[0]), False, "there is no way back from this marking", clock)


def _levels(system: System, parts: Components | None) -> dict[str, int]:
    if parts is None:
        return {}
    levels = np.where(parts.live, 4, np.where(parts.repeats, 3, np.where(parts.fires, 1, 0)))
    levels[~parts.fires] = 0
    return {name: int(level) for name, level in zip(system.transitions, levels)}


def _home(parts: Components | None) -> int:
    """Markings that can be reached from everywhere: those of the only bottom component."""
    if parts is None:
        return -1
    bottoms = np.flatnonzero(parts.bottom)
    if len(bottoms) != 1:
        return 0
    return int(parts.start[bottoms[0] + 1] - parts.start[bottoms[0]])


def workflow_ends(system: System) -> tuple[int, int] | None:
    """Source and sink of a workflow net (no transition puts into the one, none takes from the other), or None."""
    fed = (system.post > 0).any(axis=0)
    used = (system.need > 0).any(axis=0)
    sources, sinks = np.flatnonzero(~fed & used), np.flatnonzero(fed & ~used)
    idle = (~fed & ~used).any()
    if len(sources) != 1 or len(sinks) != 1 or idle:
        return None
    return int(sources[0]), int(sinks[0])


def _soundness_of(
    system: System, space: StateSpace, graph: Graph | None, parts: Components | None, budget: Budget, clock: Clock
) -> Soundness | None:
    """Soundness if the net is a workflow net, from one token in its source."""
    ends = workflow_ends(system)
    if ends is None:
        return None
    source, sink = ends
    start = np.zeros(len(system.places), np.int64)
    start[source] = 1
    if not np.array_equal(start, system.marking):
        system = replace(system, marking=start)
        space = explore(system, budget)
        graph, parts = _graph(space, budget.memory, clock)
    return soundness(space, graph, parts, source, sink, clock)


def soundness(space: StateSpace, graph: Graph | None, parts: Components | None, source: int, sink: int, clock: Clock) -> Soundness:
    """Soundness of a workflow net whose state space from one token in `source` is `space`."""
    system = space.system
    final = np.zeros(len(system.places), np.int64)
    final[sink] = 1
    proper: Verdict | None = None
    for first in range(0, space.n_states, 1 << 16):
        m = space.markings(first, first + (1 << 16))
        bad = np.flatnonzero((m[:, sink] > 0) & (m.sum(axis=1) != 1))
        if len(bad):
            proper = _at(space, first + int(bad[0]), False, f"{system.places[sink]!r} is marked, and more", clock)
            break
    stopped = "" if space.complete else f"the exploration stopped: {space.reason}"
    proper = proper or (Verdict(True) if space.complete else Verdict(None, stopped))
    end = space.number_of(final)
    if graph is None or parts is None:
        option = Verdict(False, "a sound net is bounded") if space.pump is not None else _unknown(stopped)
    else:
        goal = np.zeros(graph.n_nodes, bool)
        if end >= 0:
            goal[end] = True
        lost = np.flatnonzero(~can_reach(graph, parts, goal))
        option = Verdict(True) if not len(lost) else _at(space, int(lost[0]), False, "from here the end cannot be reached", clock)
    dead = tuple(system.transitions[t] for t in np.flatnonzero(space.fired < 0)) if space.complete else None
    return Soundness(system.places[source], system.places[sink], option, proper, dead)
