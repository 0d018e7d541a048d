"""Behaviour with clocks, priorities and the environment: what the running net can do, cycle by cycle.

The states are markings with the clocks of the timed transitions, at the ends of cycles; inputs, beliefs, continuous places and
selected objects may be anything in every cycle, a behaviour module is driven by the caller of `environment.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import unknown_name
from ...petri import CompiledNet, PetriNet, compile_net
from ..behaviour.graphs import components
from ..behaviour.state_space import Progress
from ..budget import Budget
from ..kernels import timed as kernels
from ..net_arrays import selected_places
from ..structure.invariants import never
from ..verdicts import Step, Verdict
from .co_activity import CoActivity, co_activity
from .emissions import Emission, emissions
from .environment import closed_system
from .state_space import UNDECIDED, TimedStateSpace, explore_timed, immediate_loop


@dataclass(frozen=True)
class Conflict:
    """Two transitions whose order decides what happens.

    Attributes
    ----------
    first, second : str
    kind : {"conflict", "confusion", "unclear", "tie"}
        conflict: immediate, of equal priority, firing `first` disables `second`. confusion: neither disables the other, but the
        two orders end differently. unclear: what is observed between the two firings was not followed. tie: timed, due at one
        instant; the declared order decides.
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
    emissions : tuple of Emission
        Pairs of exclusive commands that may be sent in one cycle.
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
    emissions: tuple[Emission, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        out: dict[str, Any] = {}
        for key, value in self.__dict__.items():
            if isinstance(value, (Verdict, CoActivity)):
                out[key] = value.to_json()
            elif key in ("conflicts", "emissions"):
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
    exclusive: Sequence[Sequence[str]] = (),
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
    exclusive : sequence of sequences of command names
        Of which one goes out per cycle, as for the executor.
    """
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    budget, clock = (budget or Budget()).start()
    space = explore_timed(closed_system(compiled, bounds, limit, clock.spent), budget.part(0.8), progress)
    return judge_timed(compiled, space, exclusive, clock.spent)


def needs_time(c: CompiledNet) -> bool:
    """Whether clocks, priorities, the environment or modules make the running net differ from its untimed view."""
    ports = c.net.ports
    priorities = bool(c.priority.any()) and len(set(c.priority.tolist())) > 1
    chosen = bool(selected_places(c).any()) or not c.moved.all()
    module = bool(ports.begin and ports.ongoing and ports.outcomes)
    return module or bool(c.delay.any()) or priorities or chosen or bool(c.source.modules)


def judge_timed(
    compiled: CompiledNet, space: TimedStateSpace, exclusive: Sequence[Sequence[str]] = (), enough: Callable[[], bool] = never
) -> TimedStructure:
    """What an exploration of `closed_system(compiled)` says."""
    system, graph = space.system, space.graph
    own = system.n_own
    fired = np.zeros(len(system.labels), bool)
    fired[graph.labels] = True
    names = [t.name for t in system.transitions[:own]]
    active = np.zeros(graph.n_nodes, bool)
    active[graph.sources[graph.labels < len(system.transitions)]] = True
    quiet = np.flatnonzero(space.kinds == kernels.OVER)
    home = np.arange(space.n_nodes) == (int(quiet[0]) if len(quiet) else 0)
    everywhere = np.ones(space.n_nodes, bool)
    conflicts = _conflicts(space.real_part, enough)
    return TimedStructure(
        states=space.n_states,
        nodes=space.n_nodes,
        complete=space.complete,
        reason=space.reason,
        seconds=space.seconds,
        bounded=space.judged(_bounded),
        never_stops=space.always_can(active, everywhere, "nothing ever fires after this"),
        reversible=space.always_can(home, everywhere, "there is no way back from here"),
        becomes_quiet=space.judged(_quiet),
        deterministic=_deterministic(space, conflicts),
        dead_transitions=tuple(name for name, f in zip(names, fired) if not f),
        live_transitions=_live(space, names),
        conflicts=conflicts,
        modules=co_activity(compiled, space, enough),
        emissions=emissions(space, exclusive, enough),
    )


def _live(space: TimedStateSpace, names: list[str]) -> tuple[str, ...]:
    """Transitions that some environment can always make fire again."""
    if not space.complete:
        return ()
    if space.unsure is None:
        return tuple(np.array(names)[components(space.graph, len(space.system.labels)).live[: len(names)]].tolist())
    graph = space.graph
    live = []
    for t, name in enumerate(names):
        goal = np.zeros(space.n_nodes, bool)
        goal[graph.sources[graph.labels == t]] = True
        if goal.any() and space.surely_leads(goal).all():
            live.append(name)
    return tuple(live)


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
    return reached(space, good)


def reached(space: TimedStateSpace, good: np.ndarray) -> Verdict:
    """Whether one of the nodes `good` (N,) bool is reached, and a shortest run there."""
    found = np.flatnonzero(good & space.real)
    if len(found):
        return Verdict(True, "", space.real_run(int(found[0])))
    if good.any():
        return Verdict(None, UNDECIDED)
    return Verdict(False) if space.complete else Verdict(None, f"the exploration stopped: {space.reason}")


def _bounded(space: TimedStateSpace) -> Verdict:
    if space.complete:
        return Verdict(True)
    if space.reason != "unbounded" or space.overflow < 0:
        return Verdict(None, f"the exploration stopped: {space.reason}")
    t = space.system.transitions[space.overflow].name
    return Verdict(False, f"{t!r} fills a place beyond {space.system.net.limit} tokens", space.run(space.n_expanded))


def _quiet(space: TimedStateSpace) -> Verdict:
    labels, system = space.graph.labels, space.system
    inner = (labels < system.n_own) | ((labels >= len(system.transitions)) & (labels < system.end_label))
    found = immediate_loop(space, inner)
    if found is None:
        return Verdict(True) if space.complete else Verdict(None, f"the exploration stopped: {space.reason}")
    loop = space.steps(found[1])
    names = " -> ".join(dict.fromkeys(s.what for s in loop if s.kind == "fires"))
    return Verdict(False, f"fires for ever in one instant: {names}", space.run(found[0]), loop)


def _deterministic(space: TimedStateSpace, conflicts: tuple[Conflict, ...]) -> Verdict:
    """`conflicts`: those that are real."""
    for found in (conflicts, () if space.unsure is None else _conflicts(space)):
        for c in found:
            if c.kind in ("conflict", "confusion"):
                why = f"{c.kind} of {c.first!r} and {c.second!r}: the order among equal priorities matters"
                return Verdict(False, why, c.run) if found is conflicts else Verdict(None, f"{UNDECIDED}: {why}")
    unclear = next((c for c in conflicts if c.kind == "unclear"), None)
    if unclear:
        return Verdict(None, f"{unclear.first!r} and {unclear.second!r}: what is observed in between may make the order matter")
    return Verdict(True) if space.complete else Verdict(None, f"the exploration stopped: {space.reason}")


def _conflicts(space: TimedStateSpace, enough: Callable[[], bool] = never) -> tuple[Conflict, ...]:
    """Conflicts and confusion of immediates, ties of timed transitions: of these as many as there is time for."""
    system, graph, n = space.system, space.graph, len(space.system.transitions)
    found, where = np.zeros((n, n), np.int8), np.zeros((n, n), np.int64)
    kernels.conflicts(
        system.net, space.rows, space.kinds, graph.offsets, graph.targets, graph.labels, system.n_own, space.n_expanded, found, where
    )
    names = [t.name for t in system.transitions]
    result = []
    for t, u in np.argwhere(found):
        if found[t, u] & 1 or not found[u, t] & 1:
            kind = "conflict" if found[t, u] & 1 else "confusion" if found[t, u] & 2 else "unclear"
            result.append(Conflict(names[t], names[u], kind, space.run(int(where[t, u]))))
    for k, (t, u) in enumerate(np.argwhere(space.ties)):
        if k % 1000 == 999 and enough():
            break
        result.append(Conflict(names[t], names[u], "tie"))
    return tuple(result)
