"""Whether a net uses the modules in it as their contracts assume.

A contract (`contracts.py`) is checked against a caller that begins a module only when it is idle and its last outcome was taken.
`check_composition` looks at the net around: does it ever call a module out of turn, does the module then start, is every outcome of
every instance handled, is none left lying for ever, and does the net leave alone what is the module's? Together with the contracts of
the modules this is the chaining of Algorithm 3.1 on the side of the net.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...petri import CompiledNet, Instance, PetriNet, Transition, compile_net, instances
from ..behaviour.graphs import closure
from ..budget import Budget
from ..kernels import timed as kernels
from ..timed.environment import closed_system
from ..timed.state_space import TimedStateSpace, explore_timed
from ..verdicts import Step


@dataclass(frozen=True)
class Misuse:
    """One way in which a net misuses an instance.

    Attributes
    ----------
    instance : str
    kind : {"unhandled", "never begun", "never starts", "out of turn", "left lying", "taken", "put"}
        taken, put: the net around takes from, or puts into, a port that is not its to touch so.
    why : str
    run : tuple of Step
        To where it happens, where a run shows it.
    """

    instance: str
    kind: str
    why: str
    run: tuple[Step, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {"instance": self.instance, "kind": self.kind, "why": self.why, "run": [str(s) for s in self.run]}

    def __str__(self) -> str:
        return f"instance {self.instance!r}, {self.kind}: {self.why}"


@dataclass(frozen=True)
class CompositionReport:
    """How a net uses its modules.

    Attributes
    ----------
    net : str
    misuses : tuple of Misuse
    complete : bool
        Whether everything was explored.
    undecided : tuple of Misuse
        Of which it is not decided whether what is observed can be so.
    """

    net: str
    misuses: tuple[Misuse, ...]
    complete: bool
    undecided: tuple[Misuse, ...] = ()

    @property
    def holds(self) -> bool | None:
        """True if nothing is misused, None if none was found but not everything was explored."""
        return False if self.misuses else True if self.complete and not self.undecided else None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "net": self.net,
            "holds": self.holds,
            "complete": self.complete,
            "misuses": [m.to_json() for m in self.misuses],
            "undecided": [m.to_json() for m in self.undecided],
        }

    def __str__(self) -> str:
        lines = [f"use of modules in {self.net!r}: " + {True: "as they assume", False: "WRONG", None: "unknown"}[self.holds]]
        for m in self.misuses:
            lines += [f"  {m}", *(f"             {step}" for step in m.run)]
        return "\n".join([*lines, *(f"  not decided: {m}" for m in self.undecided)])


def check_composition(
    net: PetriNet | CompiledNet,
    *,
    budget: Budget | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    space: TimedStateSpace | None = None,
) -> CompositionReport:
    """Whether `net` uses every behaviour module in it as the module's contract assumes, in every environment.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    budget, bounds
        As for `check_contract`.
    space : TimedStateSpace, optional
        The exploration of `closed_system(net)`, if it is there already.
    """
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    hierarchy = instances(compiled.source)
    behaviours = {path: i for path, i in hierarchy.items() if path and i.net.ports.begin and i.net.ports.ongoing and i.net.ports.outcomes}
    if not behaviours:
        return CompositionReport(compiled.net.name, (), True)
    space = space or explore_timed(closed_system(compiled, bounds), budget)
    found: list[Misuse] = []
    maybe: list[Misuse] = []
    for path, instance in behaviours.items():
        found += [*_by_arcs(compiled, space.real_part, path, instance), *_by_runs(space.real_part, path, instance)]
        lying, perhaps = _left_lying(space, path, instance)
        found += lying
        maybe += perhaps
        if space.unsure is not None:
            known = {(m.kind, m.why) for m in found}
            every = [*_by_arcs(compiled, space, path, instance), *_by_runs(space, path, instance)]
            maybe += [Misuse(m.instance, m.kind, m.why) for m in every if (m.kind, m.why) not in known]
    return CompositionReport(compiled.net.name, tuple(found), space.complete, tuple(maybe))


def _by_arcs(c: CompiledNet, space: TimedStateSpace, path: str, instance: Instance) -> list[Misuse]:
    """What the arcs of the flat net say. An outcome that comes in no run, of all runs, needs nobody to take it."""
    inside = {
        name for inner, i in instances(c.source).items() if inner == path or inner.startswith(f"{path}.") for name in i.transitions.values()
    }
    others = [t for t in c.net.transitions if t.name not in inside]
    ports = instance.net.ports
    exits = set(c.net.ports.exits)
    found = []
    for outcome in ports.outcomes:
        place = instance.places[outcome]
        taken = any(place in t.inputs or t.sets.get(place) == 0 for t in others)
        if not taken and place not in exits and (not space.complete or _marked(space, place).any()):
            found.append(Misuse(path, "unhandled", f"nothing takes its outcome {outcome!r}"))
    assert ports.begin
    begin = instance.places[ports.begin]
    fed = any(begin in t.outputs or t.sets.get(begin) for t in others)
    if not fed and begin not in c.net.ports.entries and not c.initial[c.place(begin)]:
        found.append(Misuse(path, "never begun", f"nothing puts a token into {begin!r}"))
    return found + [m for t in others for m in _touches(space, path, instance, t)]


def _touches(space: TimedStateSpace, path: str, instance: Instance, t: Transition) -> list[Misuse]:
    """What a transition of the net around does to ports that are not its to touch so, if some run fires it.

    A module relies on it that nobody but itself takes from its begin, its interrupts, its inputs and its ongoing, or puts into its
    ongoing, its outcomes and its outputs. Fusing a port with a place of the net around opens it to both.
    """
    ports = instance.net.ports
    assert ports.ongoing
    for port in (*ports.entries, *ports.exits):
        place = instance.places[port]
        takes = place in t.inputs or t.sets.get(place) == 0
        puts = place in t.outputs or bool(t.sets.get(place))
        theirs = takes and (port in ports.entries or port == ports.ongoing)
        wrong = "taken" if theirs else "put" if puts and port in ports.exits else ""
        if not wrong:
            continue
        edges = np.flatnonzero(space.graph.labels == space.system.labels.index(t.name))
        if len(edges):
            edge = int(edges[0])
            run = space.steps([*space.edges_to(int(space.graph.sources[edge])), edge])
            does = (
                f"takes from its {port!r}, which is the module's alone" if wrong == "taken" else f"puts into its {port!r}, as only it may"
            )
            return [Misuse(path, wrong, f"{t.name!r} {does}", run)]
    return []


def _by_runs(space: TimedStateSpace, path: str, instance: Instance) -> list[Misuse]:
    """What some run shows."""
    ports = instance.net.ports
    assert ports.begin
    assert ports.ongoing
    marked = {
        port: space.markings[:, space.system.place(instance.places[port])] > 0 for port in (ports.begin, ports.ongoing, *ports.outcomes)
    }
    settled = space.kinds == kernels.QUIET
    busy = marked[ports.ongoing] | np.array([marked[o] for o in ports.outcomes]).any(axis=0)
    found = []
    early = np.flatnonzero(settled & marked[ports.begin] & busy)
    if len(early):
        node = int(early[0])
        state = next(p for p in (ports.ongoing, *ports.outcomes) if marked[p][node])
        why = f"{ports.begin!r} is marked while {state!r} is"
        found.append(Misuse(path, "out of turn", why, space.run(node)))
    idle = np.flatnonzero(settled & marked[ports.begin] & ~busy)
    if len(idle):
        why = f"{ports.begin!r} is marked when the instant ends, and it has not started"
        found.append(Misuse(path, "never starts", why, space.run(int(idle[0]))))
    return found


def _left_lying(space: TimedStateSpace, path: str, instance: Instance) -> tuple[list[Misuse], list[Misuse]]:
    """Outcomes that are never taken once they lie, and those of which it is not decided."""
    found, maybe = [], []
    for outcome in instance.net.ports.outcomes:
        marked = _marked(space, instance.places[outcome])
        verdict = space.always_can(~marked, (space.kinds == kernels.QUIET) & marked, f"its outcome {outcome!r} is never taken after this")
        if verdict.holds is False:
            found.append(Misuse(path, "left lying", verdict.why, verdict.run))
        elif verdict.holds is None and space.complete:
            maybe.append(Misuse(path, "left lying", verdict.why))
    return found, maybe


def handovers(
    net: PetriNet | CompiledNet,
    *,
    budget: Budget | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    space: TimedStateSpace | None = None,
) -> dict[tuple[str, str], tuple[tuple[str, str], ...]]:
    """What each outcome of each instance may lead to: the question that Algorithm 3.1 puts to PN-ANALYSIS.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    budget, bounds, space
        As for `check_composition`.

    Returns
    -------
    dict from (instance, outcome) to ((instance, "begin"), ...)
        Where a token that the net takes from the outcome may lead next: the begin of an instance, or ``("", outcome)``, an
        outcome of the net itself. Where modules run at once, what another thread begins meanwhile is listed too.
    """
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    space = space or explore_timed(closed_system(compiled, bounds), budget)
    inner = {path: i for path, i in instances(compiled.source).items() if path and i.net.ports.begin}
    goals: dict[tuple[str, str], np.ndarray] = {}
    for path, instance in inner.items():
        assert instance.net.ports.begin
        goals[path, instance.net.ports.begin] = _marked(space, instance.places[instance.net.ports.begin])
    for outcome in compiled.net.ports.outcomes:
        goals["", outcome] = _marked(space, outcome)
    stop = np.zeros(space.n_nodes, bool)
    for marked in goals.values():
        stop |= marked
    sources, targets = space.graph.sources, space.graph.targets
    found: dict[tuple[str, str], tuple[tuple[str, str], ...]] = {}
    for path, instance in inner.items():
        for outcome in instance.net.ports.outcomes:
            held = _marked(space, instance.places[outcome])
            takes = np.flatnonzero(held[sources] & ~held[targets])
            reached = closure(space.graph, np.unique(targets[takes]).astype(np.int64), ~stop[sources])
            found[path, outcome] = tuple(goal for goal, marked in goals.items() if (reached & marked).any())
    return found


def _marked(space: TimedStateSpace, place: str) -> np.ndarray:
    """The nodes in which a place is marked, (N,) bool."""
    return np.asarray(space.markings[:, space.system.place(place)] > 0)
