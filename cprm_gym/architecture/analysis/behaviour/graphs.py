"""Graphs of markings: components, liveness, what can be reached, shortest runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels import graph as kernels
from .state_space import Graph


@dataclass(frozen=True, eq=False)
class Components:
    """The strongly connected components of a graph.

    Attributes
    ----------
    component : (N,) int32
        Component of each node; edges lead to the same or a lower number.
    count : int
    bottom : (C,) bool
        No edge leaves the component.
    cyclic : (C,) bool
        It holds an edge.
    start, nodes : (C + 1,), (N,) int64
        The nodes of component c are ``nodes[start[c]:start[c + 1]]``.
    fires : (L,) bool
        Labels that occur.
    repeats : (L,) bool
        Labels that occur within a component: can happen again and again.
    live : (L,) bool
        Labels that occur in every bottom component: can happen again whatever happened.
    """

    component: np.ndarray
    count: int
    bottom: np.ndarray
    cyclic: np.ndarray
    start: np.ndarray
    nodes: np.ndarray
    fires: np.ndarray
    repeats: np.ndarray
    live: np.ndarray


def components(graph: Graph, n_labels: int) -> Components:
    """Strongly connected components and the liveness of `n_labels` edge labels."""
    n = graph.n_nodes
    component = np.empty(n, np.int32)
    scratch = [np.empty(n, np.int32) for _ in range(3)]
    count = int(kernels.strong_components(graph.offsets, graph.targets, component, *scratch, np.empty(n, np.int64)))
    bottom, cyclic = np.ones(count, bool), np.zeros(count, bool)
    fires, repeats = np.zeros(n_labels, bool), np.zeros(n_labels, bool)
    kernels.component_facts(graph.offsets, graph.targets, graph.labels, component, cyclic, bottom, fires, repeats)
    start, nodes = np.zeros(count + 1, np.int64), np.empty(n, np.int64)
    kernels.group_nodes(component, start, nodes)
    often = np.zeros(n_labels, np.int64)
    kernels.count_in_bottoms(graph.offsets, graph.labels, start, nodes, bottom, often)
    return Components(component, count, bottom, cyclic, start, nodes, fires, repeats, often == bottom.sum())


def can_reach(graph: Graph, parts: Components, goal: np.ndarray, unknown: bool = False) -> np.ndarray:
    """Whether each node can reach a node of `goal`, (N,) bool; `unknown`: edges out of what is known count as reaching it."""
    result = np.zeros(graph.n_nodes, bool)
    kernels.can_reach(graph.offsets, graph.targets, parts.component, parts.start, parts.nodes, goal, unknown, result)
    return result


def shortest_run(
    graph: Graph, starts: np.ndarray, goal: np.ndarray, allowed: np.ndarray | None = None
) -> tuple[list[int], list[int]] | None:
    """A shortest run from one of `starts` to a node of `goal`: its nodes and its edge numbers; None if there is none.

    Parameters
    ----------
    starts : (K,) int64
    goal : (N,) bool
    allowed : (E,) bool, optional
        Edges that may be taken.
    """
    n = graph.n_nodes
    came = np.full(n, -1, np.int64)
    allowed = np.ones(len(graph.targets), bool) if allowed is None else allowed
    end = int(kernels.search(graph.offsets, graph.targets, np.asarray(starts, np.int64), allowed, goal, came, np.empty(n, np.int64)))
    if end < 0:
        return None
    nodes, edges = [end], []
    while came[nodes[-1]] >= 0:
        edge = int(came[nodes[-1]])
        edges.append(edge)
        nodes.append(int(np.searchsorted(graph.offsets, edge, side="right")) - 1)
    return nodes[::-1], edges[::-1]


def closure(graph: Graph, starts: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """The nodes that can be reached from the nodes `starts` over `allowed` (E,) edges, (N,) bool."""
    n = graph.n_nodes
    came = np.full(n, -1, np.int64)
    kernels.search(graph.offsets, graph.targets, starts, allowed, np.zeros(n, bool), came, np.empty(n, np.int64))
    return np.asarray(came != -1)
