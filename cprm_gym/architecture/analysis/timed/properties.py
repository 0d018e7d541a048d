"""Structural analysis with clocks, priorities and the environment: what the running net can do, cycle by cycle.

The states are markings with the clocks of the timed transitions, at the ends of cycles; inputs, beliefs, continuous places and
selected objects may be anything in every cycle, a behaviour module is driven by the caller of `contracts.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import unknown_name
from ...petri import CompiledNet, PetriNet, compile_net, instances
from ..behaviour.graphs import can_reach, components
from ..behaviour.state_space import Budget, Progress
from ..kernels import cycles as kernels
from ..modules.contracts import caller, immediate_loop
from ..net_arrays import System
from ..structure.invariants import semiflows
from .state_space import CycleSpace, Step, TimedSystem, explore_cycles, timed_system


@dataclass(frozen=True)
class RunVerdict:
    """An answer, and the run that shows it.

    Attributes
    ----------
    holds : bool or None
        None: not known.
    why : str
    run, loop : tuple of Step
        A shortest run that shows it, and what may follow for ever.
    """

    holds: bool | None
    why: str = ""
    run: tuple[Step, ...] = ()
    loop: tuple[Step, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As plain values; empty parts are left out."""
        out: dict[str, Any] = {"holds": self.holds}
        if self.why:
            out["why"] = self.why
        for key in ("run", "loop"):
            steps: tuple[Step, ...] = getattr(self, key)
            if steps:
                out[key] = [[s.cycle, s.kind, s.what, dict(s.marking)] for s in steps]
        return out

    def __str__(self) -> str:
        return {True: "yes", False: "no", None: "unknown"}[self.holds] + (f" ({self.why})" if self.why else "")


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
class CoActivity:
    """Which module instances may be active (their `ongoing` marked) at the same time.

    Attributes
    ----------
    instances : tuple of str
    together : dict from (a, b) to verdict
        True with a run, False, or None.
    invariants : dict from (a, b) to str
        The P-invariant that proves exclusion, where there is one.
    sets : tuple of tuple of str
        Every set of instances found active at the end of an instant.
    """

    instances: tuple[str, ...]
    together: Mapping[tuple[str, str], RunVerdict]
    invariants: Mapping[tuple[str, str], str]
    sets: tuple[tuple[str, ...], ...]

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        pairs = [
            {"modules": list(pair), "together": v.holds, "why": self.invariants.get(pair, v.why), "run": [str(s) for s in v.run]}
            for pair, v in self.together.items()
        ]
        return {"instances": list(self.instances), "pairs": pairs, "sets": [list(s) for s in self.sets]}


@dataclass(frozen=True)
class TimedStructure:
    """What the state space with clocks says.

    Attributes
    ----------
    states, nodes : int
        Markings with clocks at the ends of cycles; steps explored.
    complete, reason
        Whether everything was explored, and why not.
    bounded, never_stops, reversible, becomes_quiet, deterministic : RunVerdict
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
    bounded: RunVerdict
    never_stops: RunVerdict
    reversible: RunVerdict
    becomes_quiet: RunVerdict
    deterministic: RunVerdict
    dead_transitions: tuple[str, ...]
    live_transitions: tuple[str, ...]
    conflicts: tuple[Conflict, ...]
    modules: CoActivity | None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        out: dict[str, Any] = {}
        for key, value in self.__dict__.items():
            if isinstance(value, (RunVerdict, CoActivity)):
                out[key] = value.to_json()
            elif key == "conflicts":
                out[key] = [c.to_json() for c in value]
            else:
                out[key] = list(value) if isinstance(value, tuple) else value
        return out


def closed_system(net: PetriNet | CompiledNet, bounds: Mapping[str, tuple[float, float]] | None = None, limit: int = 255) -> TimedSystem:
    """The net with what its surroundings may do: a caller if it is a behaviour module, nothing but observations otherwise."""
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    ports = compiled.net.ports
    if ports.begin and ports.ongoing and ports.outcomes:
        moves, extra = caller(compiled.net, ports.idle_interrupts == "consumed")
        return timed_system(compiled, moves, extra, bounds, limit)
    return timed_system(compiled, bounds=bounds, limit=limit)


def analyze_cycles(
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
        As for `explore_cycles`.
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places.
    limit : int
        Tokens in one place beyond which it counts as unbounded.
    """
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    return judge_cycles(compiled, explore_cycles(closed_system(compiled, bounds, limit), budget, progress))


def judge_cycles(compiled: CompiledNet, space: CycleSpace) -> TimedStructure:
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
            RunVerdict(False, "nothing ever fires after this", space.run(int(idle[0])))
            if len(idle)
            else RunVerdict(True if space.complete else None, stopped)
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
) -> RunVerdict:
    """Whether some environment leads the running net to a marking with at least these tokens, and a shortest run there.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    tokens : mapping from place to tokens
    budget, bounds
        As for `analyze_cycles`.

    Raises
    ------
    UnknownName
        For a place that the net does not have.
    """
    space = explore_cycles(closed_system(net, bounds), budget)
    good = np.ones(space.n_nodes, bool)
    for name, least in tokens.items():
        if name not in space.system.places:
            raise unknown_name("place", name, space.system.places)
        good &= space.markings[:, space.system.place(name)] >= least
    found = np.flatnonzero(good)
    if len(found):
        return RunVerdict(True, "", space.run(int(found[0])))
    return RunVerdict(False) if space.complete else RunVerdict(None, f"the exploration stopped: {space.reason}")


def _bounded(space: CycleSpace, stopped: str) -> RunVerdict:
    if space.complete:
        return RunVerdict(True)
    if space.reason != "unbounded":
        return RunVerdict(None, stopped)
    t = space.system.transitions[space.overflow].name
    return RunVerdict(False, f"{t!r} fills a place beyond {space.system.net.limit} tokens", space.run(space.n_expanded))


def _reversible(space: CycleSpace, first: int, stopped: str) -> RunVerdict:
    if not space.complete:
        return RunVerdict(None, stopped)
    goal = np.zeros(space.n_nodes, bool)
    goal[first] = True
    parts = components(space.graph, len(space.system.labels))
    lost = np.flatnonzero(~can_reach(space.graph, parts, goal))
    return RunVerdict(False, "there is no way back from here", space.run(int(lost[0]))) if len(lost) else RunVerdict(True)


def _quiet(space: CycleSpace, stopped: str) -> RunVerdict:
    labels, system = space.graph.labels, space.system
    inner = (labels < system.n_own) | ((labels >= len(system.transitions)) & (labels < system.end_label))
    found = immediate_loop(space, inner)
    if found is None:
        return RunVerdict(True if space.complete else None, stopped)
    loop = space.steps(found[1])
    names = " -> ".join(dict.fromkeys(s.what for s in loop if s.kind == "fires"))
    return RunVerdict(False, f"fires for ever in one instant: {names}", space.run(found[0]), loop)


def _deterministic(conflicts: tuple[Conflict, ...], stopped: str) -> RunVerdict:
    real = [c for c in conflicts if c.kind != "tie"]
    if real:
        c = real[0]
        return RunVerdict(False, f"{c.kind} of {c.first!r} and {c.second!r}: the order among equal priorities matters", c.run)
    return RunVerdict(None, stopped) if stopped else RunVerdict(True)


def _conflicts(space: CycleSpace) -> tuple[Conflict, ...]:
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


def co_activity(compiled: CompiledNet, space: CycleSpace) -> CoActivity | None:
    """Which module instances may be active together; None for a net without modules that have an `ongoing` port.

    Exclusion is proved by a P-invariant where one does it (§2.2.6, conservation analysis), by exploration otherwise.
    """
    found = {
        path: instance.places[instance.net.ports.ongoing]
        for path, instance in instances(compiled.source).items()
        if path and instance.net.ports.ongoing
    }
    if not found:
        return None
    names = tuple(found)
    columns = [space.system.place(p) for p in found.values()]
    settled = np.flatnonzero(space.kinds == kernels.QUIET)
    active = space.markings[settled][:, columns] > 0
    flows = semiflows(System.from_net(compiled), "P").vectors
    together: dict[tuple[str, str], RunVerdict] = {}
    proofs: dict[tuple[str, str], str] = {}
    for a in range(len(names)):
        for b in range(a + 1, len(names)):
            pair, p, q = (names[a], names[b]), found[names[a]], found[names[b]]
            proof = next((v for v in flows if v.weights.get(p, 0) + v.weights.get(q, 0) > v.value and {p, q} <= v.support), None)
            both = np.flatnonzero(active[:, a] & active[:, b])
            if p == q:
                together[pair] = RunVerdict(True, "they share the place ongoing")
            elif proof is not None:
                together[pair] = RunVerdict(False, "P-invariant")
                proofs[pair] = f"{proof} = {proof.value}"
            elif len(both):
                together[pair] = RunVerdict(True, "both are ongoing here", space.run(int(settled[both[0]])))
            else:
                together[pair] = RunVerdict(False if space.complete else None, "never seen together in the whole state space")
    rows = np.unique(active, axis=0) if len(active) else np.zeros((0, len(names)), bool)
    sets = sorted((tuple(names[k] for k in np.flatnonzero(row)) for row in rows), key=lambda s: (len(s), s))
    return CoActivity(names, together, proofs, tuple(s for s in sets if s))
