"""Questions about one net: is a predicate ever true, where does it stop, what can be covered, and the graph itself for other tools."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError, NetError, unknown_name
from ...files import write_atomically
from ..expressions import Expression
from ..petri import CompiledNet, PetriNet, compile_net
from .behaviour.coverability import CoverabilityGraph, karp_miller
from .behaviour.state_space import StateSpace, explore
from .budget import Budget
from .net_arrays import System
from .timed.environment import closed_system
from .timed.properties import needs_time, reached
from .timed.regions import evaluate
from .timed.state_space import TimedStateSpace, explore_timed
from .verdicts import Step, Verdict, untimed_run

BLOCK = 1 << 16
"""Markings that are unpacked at once."""
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Deadlocks:
    """The markings after which nothing fires.

    Attributes
    ----------
    markings : tuple of dict from place to tokens
    runs : tuple of tuple of Step
        A shortest run to each.
    complete : bool
        Whether these are all.
    reason : str
        Why not.
    """

    markings: tuple[Mapping[str, int], ...]
    runs: tuple[tuple[Step, ...], ...] = field(default=())
    complete: bool = True
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        found = [{"marking": dict(m), "run": [s.to_json() for s in run]} for m, run in zip(self.markings, self.runs)]
        return {"complete": self.complete, "reason": self.reason, "deadlocks": found}


def can_become(net: PetriNet | CompiledNet, predicate: str, *, budget: Budget | None = None, bounds: Bounds | None = None) -> Verdict:
    """Whether a predicate over tokens is ever true, and a shortest run to where it is.

    Nets with clocks, priorities, an environment or modules are followed cycle by cycle, others without time.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    predicate : str
        In the expression language over discrete and object places: ``"left >= 2 and not right"``.
    budget, bounds
        As for `analyze`.

    Raises
    ------
    ExpressionError, UnknownName
        For what is no expression, or names no discrete or object place.
    """
    expression = Expression(predicate)
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    if needs_time(c):
        space = explore_timed(closed_system(c, bounds), budget)
        return reached(space, _true(expression, space.system.places, space.markings))
    plain = explore(System.from_net(c), budget)
    for first in range(0, plain.n_states, BLOCK):
        found = np.flatnonzero(_true(expression, plain.system.places, plain.markings(first, first + BLOCK)))
        if len(found):
            node = first + int(found[0])
            return Verdict(True, run=untimed_run(plain.path(node) or ()), marking=plain.system.describe(plain.marking(node)))
    return Verdict(False) if plain.complete else Verdict(None, f"the exploration stopped: {plain.reason}")


def _true(expression: Expression, places: tuple[str, ...], markings: np.ndarray) -> np.ndarray:
    """Where an expression over places is true, (n,) bool."""
    for name in expression.names:
        if name not in places:
            raise unknown_name("discrete place", name, places)
    values = {name: markings[:, places.index(name)].astype(np.float64) for name in expression.names}
    found = evaluate(expression.tree, values, len(markings))
    return ~np.isnan(found) & (found != 0.0)


def deadlocks(net: PetriNet | CompiledNet, *, budget: Budget | None = None, bounds: Bounds | None = None, most: int = 1000) -> Deadlocks:
    """All markings after which nothing ever fires.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    budget, bounds
        As for `analyze`.
    most : int
        How many are listed.
    """
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    if needs_time(c):
        space = explore_timed(closed_system(c, bounds), budget)
        seen: dict[tuple[tuple[str, int], ...], int] = {}
        for node in np.flatnonzero(space.standstills()):
            seen.setdefault(tuple(space.marking(int(node)).items()), int(node))
        nodes = list(seen.values())
        listed = nodes[:most]
        runs = tuple(space.real_run(node) for node in listed)
        reason = space.reason or ("" if len(nodes) <= most else f"only {most} of {len(nodes)} are listed")
        whole = space.complete and len(nodes) <= most and space.unsure is None
        return Deadlocks(tuple(space.marking(node) for node in listed), runs, whole, reason)
    budget = budget or Budget()
    plain = explore(System.from_net(c), budget, edge_memory=budget.memory // 4)
    graph = plain.graph()
    dead = np.flatnonzero(np.diff(graph.offsets)[: plain.n_expanded] == 0)
    reason = plain.reason or ("" if len(dead) <= most else f"only {most} of {len(dead)} are listed")
    return Deadlocks(
        tuple(plain.system.describe(plain.marking(int(i))) for i in dead[:most]),
        tuple(untimed_run(plain.path(int(i)) or ()) for i in dead[:most]),
        plain.complete and len(dead) <= most,
        reason,
    )


def coverability(net: PetriNet | CompiledNet, *, budget: Budget | None = None) -> CoverabilityGraph:
    """The coverability graph of the untimed view: what can be reached or exceeded, and what is unbounded; of a module with its caller."""
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    ports = c.net.ports
    called = ports.begin and ports.ongoing and ports.outcomes
    return karp_miller(closed_system(c).untimed if called else System.from_net(c), budget)


def tokens(text: str) -> dict[str, int]:
    """``"left=2,right=1"`` as place -> tokens; a place alone means 1.

    Raises
    ------
    NetError
        For what does not have this form.
    """
    found: dict[str, int] = {}
    for part in text.split(","):
        name, equals, count = part.partition("=")
        if not name.strip() or (equals and not count.strip().isdecimal()):
            raise NetError(f"{text!r}: a marking is written place=tokens,place=tokens, got {part!r}")
        found[name.strip()] = int(count) if equals else 1
    return found


def save_graph(
    net: PetriNet | CompiledNet, path: str | os.PathLike[str], *, budget: Budget | None = None, bounds: Bounds | None = None
) -> int:
    """Write the reachability graph to a file; with clocks where the net has them.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    path : path
        ``*.json``: places, nodes as tokens, edges as (from, to, label); ``*.dot`` for Graphviz.
    budget, bounds
        As for `analyze`.

    Returns
    -------
    int
        Number of nodes.

    Raises
    ------
    FormatError
        For another suffix.
    NetError
        When the graph is not complete within the budget: half a graph would be taken for the whole.
    """
    kind = Path(path).suffix.lower()
    if kind not in (".json", ".dot"):
        raise FormatError(f"{os.fspath(path)}: a graph is written as .json or .dot, got {kind or 'no suffix'!r}")
    c = net if isinstance(net, CompiledNet) else compile_net(net)
    space: TimedStateSpace | StateSpace
    if needs_time(c):
        space = explore_timed(closed_system(c, bounds), budget)
        markings, places, labels, graph = space.markings, space.system.places, space.system.labels, space.graph
    else:
        budget = budget or Budget()
        space = explore(System.from_net(c), budget, edge_memory=budget.memory // 4)
        markings, places, labels = space.markings(), space.system.places, space.system.transitions
        graph = space.graph()
    if not space.complete:
        raise NetError(f"net {c.net.name!r}: its graph has more than {len(markings)} nodes; the exploration stopped: {space.reason}")
    edges = [(int(a), int(b), labels[int(t)]) for a, b, t in zip(graph.sources, graph.targets, graph.labels)]
    if kind == ".json":
        content = {"format": "cprm_gym graph", "version": 1, "net": c.net.name, "places": list(places)}
        write_atomically(path, json.dumps({**content, "nodes": markings.tolist(), "edges": edges}))
    else:
        write_atomically(path, _dot(c.net.name, places, markings, edges))
    return len(markings)


def _dot(name: str, places: tuple[str, ...], markings: np.ndarray, edges: list[tuple[int, int, str]]) -> str:
    lines = [f"digraph {json.dumps(name)} {{"]
    for i, row in enumerate(markings):
        shown = ", ".join(places[p] if row[p] == 1 else f"{row[p]} {places[p]}" for p in np.flatnonzero(row))
        lines.append(f"  {i} [label={json.dumps(shown or 'empty')}];")
    lines += [f"  {a} -> {b} [label={json.dumps(label)}];" for a, b, label in edges]
    return "\n".join([*lines, "}", ""])
