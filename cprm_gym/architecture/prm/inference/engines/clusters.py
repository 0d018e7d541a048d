"""A belief replaced by the product of the marginals of clusters of its variables, and what that loses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cprm_gym.errors import CostError

from ..compiled.belief import FactoredBelief, Node, Piece, PieceFactor
from ..compiled.operations import MessageFactor, PlanSpec
from ..compiled.steps import Compiler

Clusters = tuple[tuple[Node, ...], ...]


class Choice(NamedTuple):
    """How a piece is projected.

    Attributes
    ----------
    clusters : tuple of tuple of Node
    loose : tuple of Node
        Variables that the next slice does not need, but that would make a large table if they were summed out first.
    """

    clusters: Clusters
    loose: tuple[Node, ...] = ()


def project(
    compiler: Compiler, memory_limit: float, belief: FactoredBelief, chosen: dict[int, Choice]
) -> tuple[FactoredBelief, np.ndarray]:
    """A belief with some pieces replaced by products of clusters.

    Parameters
    ----------
    compiler : Compiler
    memory_limit : float
        Bytes.
    belief : FactoredBelief
    chosen : dict of int to Choice
        Pieces and the clusters that their variables are divided into; other variables are summed out first.

    Returns
    -------
    belief : FactoredBelief
    loss : (W,) float array
        Kullback-Leibler divergence, nats; an upper bound where there are loose variables.
    """
    layout, batch = belief.layout, belief.hard.shape[1]
    info = layout.info
    assert info is not None
    pieces: list[Piece] = []
    messages = list(belief.messages)
    widths, counts = list(layout.widths), list(layout.counts)
    loss = np.zeros(batch)
    none = np.zeros((1, 0, 3), np.int64)
    for i, piece in enumerate(layout.pieces):
        if i not in chosen:
            pieces.append(piece)
            continue
        nodes = tuple(dict.fromkeys(v for f in piece.factors for v in f.scope))
        number = {v: k for k, v in enumerate(nodes)}
        start = piece.columns.start
        kept = {v for c in chosen[i].clusters for v in c} | set(chosen[i].loose)
        spec = PlanSpec(
            tuple(int(info.cards[info.row[name]]) for name, _ in nodes),
            tuple(v not in kept for v in nodes),
            tuple(MessageFactor(tuple(number[v] for v in f.scope), f.column - start) for f in piece.factors),
            0,
            tuple(tuple(number[v] for v in c) for c in chosen[i].clusters),
        )
        plan = compiler.plan(spec)
        if plan.cost.bytes > memory_limit:
            names = ", ".join(sorted(n for n, _ in nodes)[:12])
            raise CostError(f"projecting the belief about {names} needs {plan.cost.bytes / 2**30:.2f} GiB")
        rows = messages[piece.group][piece.instance * batch : (piece.instance + 1) * batch, piece.columns]
        message, _, _, losses = plan.run(np.ascontiguousarray(rows), none, belief.hard, belief.hard, np.ones((batch, 0)), none)
        loss += np.maximum(losses[:, 0], 0.0)
        for factors in plan.pieces:
            named = tuple(PieceFactor(tuple(nodes[v] for v in f.scope), f.column, f.size) for f in factors)
            pieces.append(Piece(len(messages), 0, named))
        messages.append(message)
        widths.append(plan.message_size)
        counts.append(1)
    made = compiler.layouts.one(tuple(pieces), tuple(widths), tuple(counts), layout.held, info)
    return FactoredBelief(made, tuple(messages), belief.hard), loss


def given_clusters(belief: FactoredBelief, clusters: Sequence[Sequence[str]]) -> dict[int, Choice]:
    """How to project every piece with variables of two clusters or more; variables in no cluster are clusters of their own."""
    of = {name: k for k, cluster in enumerate(clusters) for name in cluster}
    chosen = {}
    for i in range(len(belief.layout.pieces)):
        parts: dict[object, list[Node]] = {}
        for v in home_nodes(belief, i):
            parts.setdefault(of.get(v[0], v), []).append(v)
        if len(parts) > 1 and any(v[0] in of for v in home_nodes(belief, i)):
            chosen[i] = Choice(tuple(tuple(c) for c in parts.values()))
    return chosen


def home_nodes(belief: FactoredBelief, i: int) -> tuple[Node, ...]:
    """Variables of a piece."""
    return tuple(dict.fromkeys(v for f in belief.layout.pieces[i].factors for v in f.scope))
