"""Graphs of inference: elimination orders and join trees over sets of variables.

Variables are any hashable labels with a number of states (`cards`); a scope is a set of variables that one factor links.

References
----------
Koller and Friedman, Probabilistic Graphical Models, 2009, chapters 9 and 10; dissertation section 2.3.2.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush
from math import prod
from typing import Any

Node = Any
"""A variable: any hashable that can be sorted among its kind."""


def neighbours(scopes: Iterable[Collection[Node]]) -> dict[Node, set[Node]]:
    """The graph in which the variables of each scope are linked pairwise."""
    graph: dict[Node, set[Node]] = {}
    for scope in scopes:
        for v in scope:
            graph.setdefault(v, set()).update(scope)
    for v, linked in graph.items():
        linked.discard(v)
    return graph


def connected(scopes: Sequence[Collection[Node]]) -> list[list[int]]:
    """Indices of the scopes of each connected component, in the order in which they first appear.

    Scopes without variables are components of their own.
    """
    owner: dict[Node, int] = {}
    parent = list(range(len(scopes)))

    def find(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, scope in enumerate(scopes):
        for v in scope:
            if v in owner:
                a, b = find(owner[v]), find(i)
                parent[max(a, b)] = min(a, b)
            else:
                owner[v] = i
    groups: dict[int, list[int]] = {}
    for i in range(len(scopes)):
        groups.setdefault(find(i), []).append(i)
    return list(groups.values())


def elimination_order(graph: Mapping[Node, set[Node]], cards: Mapping[Node, int], rule: str = "fill") -> tuple[list[Node], float]:
    """A greedy order in which to eliminate all variables, and the sum of the sizes of the cliques it makes.

    Parameters
    ----------
    graph : dict of variable to set of variables
        Symmetric; not changed.
    cards : dict of variable to int
    rule : {"fill", "weight"}
        Take the variable that adds fewest links, or the one that makes the smallest clique; ties by the other rule.
    """
    live = {v: set(n) for v, n in graph.items()}
    place = {v: i for i, v in enumerate(live)}

    def price(v: Node) -> tuple[float, float, int]:
        around = live[v]
        weight = float(cards[v]) * prod(cards[u] for u in around)
        missing = sum(len(around) - 1 - len(live[a] & around) for a in around) / 2
        return (missing, weight, place[v]) if rule == "fill" else (weight, missing, place[v])

    prices = {v: price(v) for v in live}
    heap = [_Entry(p, v) for v, p in prices.items()]
    heapify(heap)
    order: list[Node] = []
    total = 0.0
    while heap:
        entry = heappop(heap)
        best = entry.node
        if prices.get(best) != entry.price:
            continue
        around = live.pop(best)
        del prices[best]
        total += float(cards[best]) * prod(cards[u] for u in around)
        order.append(best)
        touched = set(around)
        for u in around:
            grown = around - live[u] - {u}
            live[u] |= around
            live[u] -= {u, best}
            if grown:
                touched |= live[u]
        for u in touched:
            new = price(u)
            if new != prices[u]:
                prices[u] = new
                heappush(heap, _Entry(new, u))
    return order, total


class _Entry:
    """A variable in the queue, compared by price alone."""

    __slots__ = ("node", "price")

    def __init__(self, price: tuple[float, float, int], node: Node) -> None:
        self.price, self.node = price, node

    def __lt__(self, other: _Entry) -> bool:
        return self.price < other.price


def best_order(graph: Mapping[Node, set[Node]], cards: Mapping[Node, int]) -> list[Node]:
    """The better of the two greedy elimination orders."""
    return min((elimination_order(graph, cards, rule) for rule in ("fill", "weight")), key=lambda pair: pair[1])[0]


@dataclass(frozen=True)
class JoinTree:
    """Cliques joined to a forest that keeps every variable's cliques together.

    Attributes
    ----------
    cliques : tuple of frozenset
        In an order in which every clique comes after its parent.
    parents : tuple of int
        Index of the parent clique; -1 for a root.
    """

    cliques: tuple[frozenset[Node], ...]
    parents: tuple[int, ...]

    @cached_property
    def holders(self) -> dict[Node, list[int]]:
        """The cliques that hold each variable."""
        found: dict[Node, list[int]] = {}
        for i, clique in enumerate(self.cliques):
            for v in clique:
                found.setdefault(v, []).append(i)
        return found

    def containing(self, scope: Collection[Node]) -> list[int]:
        """Indices of the cliques that hold all of `scope`."""
        rarest = min((self.holders.get(v, []) for v in scope), key=len)
        return [i for i in rarest if self.cliques[i].issuperset(scope)]

    def smallest(self, scope: Collection[Node], cards: Mapping[Node, int]) -> int:
        """Index of the smallest clique that holds all of `scope`."""
        return min(self.containing(scope), key=lambda i: prod(cards[v] for v in self.cliques[i]))


def join_tree(scopes: Sequence[Collection[Node]], cards: Mapping[Node, int]) -> JoinTree:
    """A join tree whose cliques hold every scope, each tree rooted at its largest clique.

    Parameters
    ----------
    scopes : sequence of collections of variables
    cards : dict of variable to int
    """
    graph = neighbours(scopes)
    cliques, edges = _clique_tree(graph, best_order(graph, cards))
    sizes = [prod(cards[v] for v in clique) for clique in cliques]
    order: list[int] = []
    parents: dict[int, int] = {}
    for start in sorted(range(len(cliques)), key=sizes.__getitem__, reverse=True):
        if start in parents:
            continue
        parents[start] = -1
        queue = deque([start])
        while queue:
            i = queue.popleft()
            order.append(i)
            for j in edges[i]:
                if j not in parents:
                    parents[j] = i
                    queue.append(j)
    place = {clique: k for k, clique in enumerate(order)}
    return JoinTree(tuple(cliques[i] for i in order), tuple(place[parents[i]] if parents[i] >= 0 else -1 for i in order))


def _clique_tree(graph: Mapping[Node, set[Node]], order: Sequence[Node]) -> tuple[list[frozenset[Node]], list[list[int]]]:
    """Maximal cliques that an elimination makes, and the links of their forest.

    A variable's clique is itself and its neighbours when it is eliminated; it hangs on the clique of the first of these to go.
    Where that clique is no more than those neighbours it is part of this one, and they are joined.
    """
    live = {v: set(n) for v, n in graph.items()}
    when = {v: i for i, v in enumerate(order)}
    cliques: list[frozenset[Node]] = []
    waiting: dict[Node, list[int]] = {}
    edges: list[list[int]] = []
    for v in order:
        around = live.pop(v)
        for u in around:
            live[u] |= around
            live[u] -= {u, v}
        clique = frozenset(around | {v})
        joined = next((i for i in waiting.get(v, ()) if clique <= cliques[i]), None)
        if joined is None:
            joined = len(cliques)
            cliques.append(clique)
            edges.append([])
        for i in waiting.pop(v, ()):
            if i != joined:
                edges[i].append(joined)
                edges[joined].append(i)
        if around:
            waiting.setdefault(min(around, key=when.__getitem__), []).append(joined)
    return cliques, edges
