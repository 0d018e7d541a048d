"""Behaviour with clocks, priorities and the environment: what the running net can do, cycle by cycle.

The states are markings with the clocks of the timed transitions, at the ends of cycles; inputs, beliefs, continuous places and
selected objects may be anything in every cycle, a behaviour module is driven by the caller of `environment.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import unknown_name
from ...petri import CompiledNet, PetriNet, compile_net
from ..behaviour.graphs import can_reach, components
from ..behaviour.state_space import Budget, Progress
from ..kernels import timed as kernels
from ..verdicts import Step, Verdict
from .co_activity import CoActivity, co_activity
from .environment import closed_system
from .state_space import TimedStateSpace, explore_timed, immediate_loop


@dataclass(frozen=True)
class Conflict:
    """Two transitions whose order decides what happens.

    Attributes
    ----------
    first, second : str
    kind : {"conflict", "confusion", "tie"}
        conflict: immediate, of equal priority, firing `first` disables `second`. confusion: neither disables the other, but the
        two orders end differently. tie: timed, due at one instant; the declared order decides.
    run : tuple of Step
        To where it happens; empty for ties.
    """

    first: str
    second: str
    kind: str
    run: tuple[Step, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {"first": self.first, "second": self.second, "kind": self.kind, "run": [[s.cycle, s.kind, s.what] for s in self.run]}


@dataclass(frozen=True)
class TimedStructure:
    """What the state space with clocks says.

    Attributes
    ----------
    states, nodes : int
        Markings with clocks at the ends of cycles; steps explored.
    complete, reason
        Whether everything was explored, and why not.
    bounded, never_stops, reversible, becomes_quiet, deterministic : Verdict
        `never_stops`: from every state something can still fire; `reversible`: the first quiet state can always be reached again;
        `deterministic`: no order among equal priorities matters.
    dead_transitions, live_transitions : tuple of str
    conflicts : tuple of Conflict
    modules : CoActivity or None
    """

    states: int
    nodes: int
    complete: bool
    reason: str
    seconds: float
    bounded: Verdict
    never_stops: Verdict
    reversible: Verdict
    becomes_quiet: Verdict
    deterministic: Verdict
    dead_transitions: tuple[str, ...]
    live_transitions: tuple[str, ...]
    conflicts: tuple[Conflict, ...]
    modules: CoActivity | None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        out: dict[str, Any] = {}
        for key, value in self.__dict__.items():
            if isinstance(value, (Verdict, CoActivity)):
                out[key] = value.to_json()
            elif key == "conflicts":
                out[key] = [c.to_json() for c in value]
            else:
                out[key] = list(value) if isinstance(value, tuple) else value
        return out


def analyze_timed(
    net: PetriNet | CompiledNet,
    budget: Budget | None = None,
    progress: Progress | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limit: int = 255,
) -> TimedStructure:
    """Explore a net cycle by cycle in any environment and say what it can do.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    budget, progress
        As for `explore_timed`.
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places.
    limit : int
        Tokens in one place beyond which it counts as unbounded.
    """
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    return judge_timed(compiled, explore_timed(closed_system(compiled, bounds, limit), budget, progress))


def judge_timed(compiled: CompiledNet, space: TimedStateSpace) -> TimedStructure:
    """What an exploration of `closed_system(compiled)` says."""
    system = space.system
    graph, own = space.graph, system.n_own
    parts = components(graph, len(system.labels))
    stopped = "" if space.complete else f"the exploration stopped: {space.reason}"
    names = [t.name for t in system.transitions[:own]]
    fires = np.flatnonzero(~parts.fires[:own])
    live = [names[t] for t in np.flatnonzero(parts.live[:own])] if space.complete else []
    active = np.zeros(graph.n_nodes, bool)
    active[graph.sources[graph.labels < len(system.transitions)]] = True
    active[space.kinds < 0] = True
    idle = np.flatnonzero(~can_reach(graph, parts, active))
    quiet = np.flatnonzero(space.kinds == kernels.OVER)
    conflicts = _conflicts(space)
    return TimedStructure(
        states=space.n_states,
        nodes=space.n_nodes,
        complete=space.complete,
        reason=space.reason,
        seconds=space.seconds,
        bounded=_bounded(space, stopped),
        never_stops=(
            Verdict(False, "nothing ever fires after this", space.run(int(idle[0])))
            if len(idle)
            else Verdict(True if space.complete else None, stopped)
        ),
        reversible=_reversible(space, int(quiet[0]) if len(quiet) else 0, stopped),
        becomes_quiet=_quiet(space, stopped),
        deterministic=_deterministic(conflicts, stopped),
        dead_transitions=tuple(names[t] for t in fires),
        live_transitions=tuple(live),
        conflicts=conflicts,
        modules=co_activity(compiled, space),
    )


def may_reach(
    net: PetriNet | CompiledNet,
    tokens: Mapping[str, int],
    budget: Budget | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> Verdict:
    """Whether some environment leads the running net to a marking with at least these tokens, and a shortest run there.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    tokens : mapping from place to tokens
    budget, bounds
        As for `analyze_timed`.

    Raises
    ------
    UnknownName
        For a place that the net does not have.
    """
    space = explore_timed(closed_system(net, bounds), budget)
    good = np.ones(space.n_nodes, bool)
    for name, least in tokens.items():
        if name not in space.system.places:
            raise unknown_name("place", name, space.system.places)
        good &= space.markings[:, space.system.place(name)] >= least
    found = np.flatnonzero(good)
    if len(found):
        return Verdict(True, "", space.run(int(found[0])))
    return Verdict(False) if space.complete else Verdict(None, f"the exploration stopped: {space.reason}")


def _bounded(space: TimedStateSpace, stopped: str) -> Verdict:
    if space.complete:
        return Verdict(True)
    if space.reason != "unbounded":
        return Verdict(None, stopped)
    t = space.system.transitions[space.overflow].name
    return Verdict(False, f"{t!r} fills a place beyond {space.system.net.limit} tokens", space.run(space.n_expanded))


def _reversible(space: TimedStateSpace, first: int, stopped: str) -> Verdict:
    if not space.complete:
        return Verdict(None, stopped)
    goal = np.zeros(space.n_nodes, bool)
    goal[first] = True
    parts = components(space.graph, len(space.system.labels))
    lost = np.flatnonzero(~can_reach(space.graph, parts, goal))
    return Verdict(False, "there is no way back from here", space.run(int(lost[0]))) if len(lost) else Verdict(True)


def _quiet(space: TimedStateSpace, stopped: str) -> Verdict:
    labels, system = space.graph.labels, space.system
    inner = (labels < system.n_own) | ((labels >= len(system.transitions)) & (labels < system.end_label))
    found = immediate_loop(space, inner)
    if found is None:
        return Verdict(True if space.complete else None, stopped)
    loop = space.steps(found[1])
    names = " -> ".join(dict.fromkeys(s.what for s in loop if s.kind == "fires"))
    return Verdict(False, f"fires for ever in one instant: {names}", space.run(found[0]), loop)


def _deterministic(conflicts: tuple[Conflict, ...], stopped: str) -> Verdict:
    real = [c for c in conflicts if c.kind != "tie"]
    if real:
        c = real[0]
        return Verdict(False, f"{c.kind} of {c.first!r} and {c.second!r}: the order among equal priorities matters", c.run)
    return Verdict(None, stopped) if stopped else Verdict(True)


def _conflicts(space: TimedStateSpace) -> tuple[Conflict, ...]:
    """Conflicts and confusion of immediates, ties of timed transitions."""
    system, graph, n = space.system, space.graph, len(space.system.transitions)
    found, where = np.zeros((n, n), np.int8), np.zeros((n, n), np.int64)
    kernels.conflicts(
        system.net, space.rows, space.kinds, graph.offsets, graph.targets, graph.labels, system.n_own, space.n_expanded, found, where
    )
    names = [t.name for t in system.transitions]
    result = []
    for t, u in np.argwhere(found):
        if found[t, u] & 1 or not found[u, t] & 1:
            kind = "conflict" if found[t, u] & 1 else "confusion"
            result.append(Conflict(names[t], names[u], kind, space.run(int(where[t, u]))))
    ties = [Conflict(names[t], names[u], "tie") for t, u in np.argwhere(space.ties)]
    return tuple(result + ties)
