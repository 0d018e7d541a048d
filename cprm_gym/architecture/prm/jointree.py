"""Graphs of inference: elimination orders and join trees over sets of variables.

Variables are any hashable labels with a number of states (`cards`); a scope is a set of variables that one factor links.

References
----------
Koller and Friedman, Probabilistic Graphical Models, 2009, chapters 9 and 10; dissertation section 2.3.2.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
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

    def price(v: Node) -> tuple[float, float]:
        around = list(live[v])
        weight = float(cards[v]) * prod(cards[u] for u in around)
        missing = sum(1 for i, a in enumerate(around) for b in around[i + 1 :] if b not in live[a])
        return (missing, weight) if rule == "fill" else (weight, missing)

    prices = {v: price(v) for v in live}
    order: list[Node] = []
    total = 0.0
    while live:
        best = min(prices, key=lambda v: prices[v])
        around = live.pop(best)
        del prices[best]
        total += float(cards[best]) * prod(cards[u] for u in around)
        order.append(best)
        touched = set(around)
        for u in around:
            live[u] |= around
            live[u] -= {u, best}
            touched |= live[u]
        for u in touched:
            prices[u] = price(u)
    return order, total


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

    def smallest(self, scope: Collection[Node], cards: Mapping[Node, int]) -> int:
        """Index of the smallest clique that holds all of `scope`."""
        inside = [i for i, clique in enumerate(self.cliques) if clique.issuperset(scope)]
        return min(inside, key=lambda i: prod(cards[v] for v in self.cliques[i]))


def maximal_cliques(scopes: Sequence[Collection[Node]], cards: Mapping[Node, int]) -> list[frozenset[Node]]:
    """Maximal cliques of a triangulation of the graph of `scopes`, by the better of two greedy orders."""
    graph = neighbours(scopes)
    order = min((elimination_order(graph, cards, rule) for rule in ("fill", "weight")), key=lambda pair: pair[1])[0]
    live = {v: set(n) for v, n in graph.items()}
    found: list[frozenset[Node]] = []
    for v in order:
        around = live.pop(v)
        clique = frozenset(around | {v})
        if not any(clique <= other for other in found):
            found.append(clique)
        for u in around:
            live[u] |= around
            live[u] -= {u, v}
    return found


def join_tree(scopes: Sequence[Collection[Node]], cards: Mapping[Node, int], heavy: Collection[frozenset[Node]] = ()) -> JoinTree:
    """A join tree whose cliques hold every scope, each tree rooted at its largest clique.

    Parameters
    ----------
    scopes : sequence of collections of variables
    cards : dict of variable to int
    heavy : collection of frozensets
        Scopes of which the root must hold one, if given and possible.
    """
    cliques = maximal_cliques(scopes, cards)
    links = sorted(
        (
            (-len(a & b), prod(cards[v] for v in a | b), i, j)
            for i, a in enumerate(cliques)
            for j, b in enumerate(cliques[:i])
            if a & b
        ),
        key=lambda link: link[:2],
    )
    owner = list(range(len(cliques)))
    edges: dict[int, list[int]] = {i: [] for i in range(len(cliques))}

    def find(i: int) -> int:
        while owner[i] != i:
            i = owner[i]
        return i

    for _, _, i, j in links:
        a, b = find(i), find(j)
        if a != b:
            owner[a] = b
            edges[i].append(j)
            edges[j].append(i)

    def rank(i: int) -> tuple[bool, int]:
        return any(scope <= cliques[i] for scope in heavy), prod(cards[v] for v in cliques[i])

    order: list[int] = []
    parents: dict[int, int] = {}
    for start in sorted(range(len(cliques)), key=rank, reverse=True):
        if start in parents:
            continue
        parents[start] = -1
        queue = [start]
        while queue:
            i = queue.pop(0)
            order.append(i)
            for j in edges[i]:
                if j not in parents:
                    parents[j] = i
                    queue.append(j)
    place = {clique: k for k, clique in enumerate(order)}
    return JoinTree(tuple(cliques[i] for i in order), tuple(place[parents[i]] if parents[i] >= 0 else -1 for i in order))


def sorted_scope(scope: Iterable[Hashable]) -> tuple[Node, ...]:
    """The variables of a scope in a fixed order."""
    return tuple(sorted(scope, key=lambda v: (str(type(v)), v)))
