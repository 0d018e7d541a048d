"""Boyen-Koller projection: a belief that is too large to carry on is replaced by the product of its clusters' marginals.

The belief is projected between two steps, when the relations of the next slice are known, and only the pieces that would make
that step too costly. Clusters are made by mutual information: starting from single variables, the two clusters that share most
information are joined, as long as the step fits the budget. So what a relation has linked stays together, whatever objects
the variables belong to: one cluster for each object is the obvious choice and the wrong one.

The loss of a projection is the Kullback-Leibler divergence from the belief to the product, computed before the belief is
discarded: sum of the clusters' entropies minus the entropy of the belief. Variables that the next slice does not need are
summed out first, which loses nothing.

References
----------
Boyen and Koller 1998 (the error stays bounded); Frogner and Pfeffer 2007 (clusters by mutual information).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations
from math import prod
from typing import ClassVar

import numpy as np

from cprm_gym.errors import ParameterError

from ..bayes_net import JunctionTree
from ..compiled.belief import FactoredBelief, Node, Piece, belief_factors
from ..compiled.cache import Recent
from ..compiled.operations import MessageFactor, PlanSpec, TableFactor
from ..compiled.plans import structure_cost
from ..compiled.slice_info import SliceInfo
from ..compiled.steps import SliceStep
from ..evidence import Readings
from ..factors import Factor
from .clusters import Choice, given_clusters, home_nodes, project
from .exact import ExactEngine, FactoredResult


class ProjectionEngine(ExactEngine):
    """Exact steps, and a projection of the belief before a step that would be too costly.

    Parameters
    ----------
    clusters : "auto" or sequence of sequences of str
        "auto" chooses by mutual information. Given clusters are used before every step, for every piece of the belief that has
        variables of two of them; variables that stand in none are clusters of their own.
    max_flops : float
        Operations that the step of one component may take for one agent; about 1e6 in a millisecond.
    memory_limit : float
        Bytes that one component may take.
    threads : int
        As for `ExactEngine`.
    least : float
        Clusters that share less information than this, in nats, are not joined.
    """

    name: ClassVar[str] = "projection"
    exact: ClassVar[bool] = False

    def __init__(
        self,
        clusters: str | Sequence[Sequence[str]] = "auto",
        max_flops: float = 4e6,
        memory_limit: float = 2.0**31,
        threads: int = 1,
        least: float = 1e-6,
    ) -> None:
        super().__init__(memory_limit, threads)
        if isinstance(clusters, str) and clusters != "auto":
            raise ParameterError(f"`clusters` is 'auto' or a sequence of tuples of variable names, got {clusters!r}")
        if max_flops <= 0:
            raise ParameterError(f"`max_flops` is positive, got {max_flops!r}")
        self.given = None if isinstance(clusters, str) else tuple(tuple(c) for c in clusters)
        named = [v for c in self.given or () for v in c]
        if len(named) != len(set(named)):
            raise ParameterError(f"clusters may not share variables: {sorted({v for v in named if named.count(v) > 1})}")
        self.max_flops, self.least = max_flops, least
        self._choices: Recent[tuple[object, ...], dict[int, Choice]] = Recent(256)

    def advance_as(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, status: np.ndarray | None) -> FactoredResult:
        """Project what has to be projected, then go on by one slice."""
        slice_step = self.slice_step(belief, info, readings, status)
        chosen = self.choice(belief, info, slice_step)
        if not chosen:
            self.check(slice_step, readings.hard.shape[1])
            return self.run(belief, info, readings, slice_step)
        projected, loss = project(self.compiler, self.memory_limit, belief, chosen)
        result = super().advance_as(projected, info, readings, slice_step.status)
        clusters = [tuple(name for name, _ in c) for choice in chosen.values() for c in choice.clusters]
        return replace(result, loss=result.loss + loss, exact=False, report={**result.report, "clusters": clusters})

    # ------------------------------------------------------------------------------------------------- choosing

    def choice(self, belief: FactoredBelief, info: SliceInfo, slice_step: SliceStep) -> dict[int, Choice]:
        """Pieces to project before a step and how; made once for a layout, a slice and a budget."""
        key = belief.layout, info, slice_step.status.tobytes(), self.max_flops
        return self._choices.fetch(key, lambda: self._choose(belief, info, slice_step))

    def _choose(self, belief: FactoredBelief, info: SliceInfo, slice_step: SliceStep) -> dict[int, Choice]:
        """Pieces to project before this step, and their clusters."""
        layout = belief.layout
        if self.given is not None:
            return given_clusters(belief, self.given)
        chosen: dict[int, Choice] = {}
        place = layout.variables()
        for group in slice_step.groups:
            if group.plan.cost.flops <= self.max_flops and group.plan.cost.bytes <= self.memory_limit:
                continue
            for nodes in group.members:
                past = [(name, 0 if lag == 1 else lag) for name, lag in nodes if lag != 0]
                inside = sorted({place[v] for v in past if v in place})
                if inside:
                    scopes = [tuple(nodes[v] for v in scope) for scope in _table_scopes(group.plan.spec)]
                    cards = dict(zip(nodes, group.plan.spec.cards))
                    chosen.update(self._by_information(belief, inside, scopes, cards, info))
        return chosen

    def _by_information(
        self, belief: FactoredBelief, inside: Iterable[int], scopes: Sequence[tuple[Node, ...]], cards: dict[Node, int], info: SliceInfo
    ) -> dict[int, Choice]:
        """Clusters of the pieces of one component, joined by mutual information while the step fits the budget."""
        needed = {(p, 0 if lag == 1 else lag) for cpd in info.slice.cpds for p, lag in cpd.parents if lag != 0}
        pieces = {i: lasting(belief.layout.pieces[i], needed, {v: cards[_past(v)] for v in home_nodes(belief, i)}) for i in inside}
        clusters = {v: frozenset([v]) for nodes in pieces.values() for v in nodes}
        home = {v: i for i, nodes in pieces.items() for v in nodes}
        shared = mutual_information(belief, pieces)
        for together in info.slice.clusters:
            for a, b in combinations([v for v in clusters if v[0] in together], 2):
                if home[a] == home[b]:
                    shared[a, b] = max(shared.get((a, b), 0.0), shared.get((b, a), 0.0)) + 1.0

        def price(parts: Iterable[frozenset[Node]]) -> float:
            shifted = [tuple(_past(v) for v in part) for part in parts]
            flops, largest = structure_cost([*shifted, *scopes], {v for part in shifted for v in part if v[1] == 1}, cards)
            return flops if 8.0 * largest * 8.0 < self.memory_limit else np.inf

        for (a, b), information in sorted(shared.items(), key=lambda item: -item[1]):
            if information < self.least or clusters[a] == clusters[b] or home[a] != home[b] or not {a, b} <= needed:
                continue
            joined = clusters[a] | clusters[b]
            if prod(cards[_past(v)] for v in joined) * 8.0 > self.max_flops:
                continue
            if price({*clusters.values()} - {clusters[a], clusters[b]} | {joined}) <= self.max_flops:
                for v in joined:
                    clusters[v] = joined
        result: dict[int, Choice] = {}
        for i, nodes in pieces.items():
            loose = tuple(v for v in nodes if v not in needed and v[1] == 0)
            parts = tuple(
                tuple(v for v in nodes if v in part) for part in dict.fromkeys(clusters[v] for v in nodes) if not part <= set(loose)
            )
            if len(parts) > 1:
                result[i] = Choice(parts, loose)
        return result


def lasting(piece: Piece, needed: set[Node], cards: dict[Node, int], limit: float = 1e5) -> tuple[Node, ...]:
    """Variables of a piece that cannot be summed out before it is projected.

    Those that the next slice needs, and those whose elimination would make a table of more than `limit` entries.
    """
    pool = [frozenset(f.scope) for f in piece.factors]
    nodes = tuple(dict.fromkeys(v for f in piece.factors for v in f.scope))
    gone: set[Node] = set()
    while True:
        price = {
            v: prod(cards[u] for s in [frozenset().union(*(s for s in pool if v in s))] for u in s) for v in nodes if v not in needed | gone
        }
        cheap = [v for v in price if price[v] <= limit and v[1] == 0]
        if not cheap:
            return tuple(v for v in nodes if v not in gone)
        best = min(cheap, key=lambda v: price[v])
        joined = frozenset().union(*(s for s in pool if best in s)) - {best}
        pool = [s for s in pool if best not in s] + [joined]
        gone.add(best)


def _past(node: Node) -> Node:
    """A variable of the belief as the next slice names it."""
    return (node[0], 1) if node[1] == 0 else node


def _table_scopes(spec: PlanSpec) -> list[tuple[int, ...]]:
    """Scopes of all factors of a step except the message."""
    scopes = []
    for f in spec.factors:
        if isinstance(f, MessageFactor):
            continue
        axes = f.axes if isinstance(f, TableFactor) else (f.node,)
        scopes.append(tuple(a for a in axes if a >= 0))
    return scopes


def mutual_information(belief: FactoredBelief, pieces: dict[int, tuple[Node, ...]], agents: int = 8) -> dict[tuple[Node, Node], float]:
    """Mutual information, in nats, of pairs of variables that share a clique of the belief; mean over the first agents.

    Variables that share no clique depend on each other only through those that do, and share no more information than these.

    Parameters
    ----------
    belief : FactoredBelief
    pieces : dict of piece to its variables
    agents : int
        How many agents to look at.
    """
    batch = belief.hard.shape[1]
    looked = min(batch, agents)
    shared: dict[tuple[Node, Node], float] = {}
    wanted = {v for nodes in pieces.values() for v in nodes}
    inside = {v for i in pieces for f in belief.layout.pieces[i].factors for v in f.scope}
    factors = [Factor(f.scope, f.table[:looked]) for f in belief_factors(belief) if set(f.scope) <= inside]
    if not factors:
        return shared
    tree = JunctionTree(factors, looked)
    for i, clique in enumerate(tree.tree.cliques):
        if len(clique & wanted) < 2:
            continue
        table = tree.belief(i)
        for a, b in combinations(sorted(clique & wanted), 2):
            if (a, b) in shared:
                continue
            pair = table.sum_onto({a, b}).over((a, b))
            product = pair.sum(axis=1, keepdims=True) * pair.sum(axis=2, keepdims=True)
            with np.errstate(divide="ignore", invalid="ignore"):
                terms = np.where(pair > 0, pair * np.log(pair / product), 0.0)
            shared[a, b] = float(max(terms.sum(axis=(1, 2)).mean(), 0.0))
    return shared
