"""Beliefs in which some agents began anew while the others went on.

Both beliefs are products of factors, over different scopes. In the merged one each agent has ones in the factors that only the
others have; a factor whose scope lies inside another's is multiplied into it. Nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..compiled.steps import Piece, PieceFactor, SliceInfo
from ..evidence import Readings
from ..factors import Factor
from ..join_tree import connected
from .exact import ExactEngine, FactoredBelief, Outcome, belief_factors


def replace_agents(
    engine: ExactEngine, outcome: Outcome, first: SliceInfo, readings: Readings, agents: np.ndarray, order: Sequence[int]
) -> Outcome:
    """The outcome of a step in which some agents begin anew.

    Parameters
    ----------
    engine : ExactEngine
    outcome : Outcome
        Of all agents, as if all went on.
    first : SliceInfo
        The first slice, with the same variables.
    readings : Readings
        Of the agents concerned, rows in the order of `first`.
    agents : int array
        Which agents.
    order : sequence of int
        Row in the outcome's slice of each variable of `first`.
    """
    anew = engine.advance(engine.start(len(agents)), first, readings, outcome.slice_step.status[np.asarray(order)])
    belief = merge(engine, outcome.belief, anew.belief, agents)
    increment, loss = outcome.increment.copy(), outcome.loss.copy()
    increment[agents], loss[agents] = anew.increment, anew.loss
    return replace(outcome, belief=belief, increment=increment, loss=loss, replaced=[*outcome.replaced, (agents, anew)])


def merge(engine: ExactEngine, belief: FactoredBelief, anew: FactoredBelief, agents: np.ndarray) -> FactoredBelief:
    """A belief that is `anew` for some agents and `belief` for the others."""
    batch = belief.hard.shape[1]
    fresh = belief_factors(anew, len(agents))
    homes: dict[tuple[int, int], list[Factor]] = {}
    extra: list[Factor] = []
    for f in fresh:
        for i, piece in enumerate(belief.layout.pieces):
            k = next((k for k, old in enumerate(piece.factors) if set(f.scope) <= set(old.scope)), None)
            if k is not None:
                homes.setdefault((i, k), []).append(f)
                break
        else:
            extra.append(f)
    messages = [m.copy() for m in belief.messages]
    info = belief.layout.info
    assert info is not None
    for i, piece in enumerate(belief.layout.pieces):
        rows = messages[piece.group][piece.instance * batch : (piece.instance + 1) * batch]
        for k, old in enumerate(piece.factors):
            shape = [int(info.cards[info.row[name]]) for name, _ in old.scope]
            table = np.ones((len(agents), *shape))
            for f in homes.get((i, k), ()):
                table = table * f.over(old.scope)
            rows[agents, old.column : old.column + old.size] = table.reshape(len(agents), -1)
    if not extra:
        return belief._replace(messages=tuple(messages))
    return _with_extra(engine, belief, messages, extra, agents)


def _with_extra(
    engine: ExactEngine, belief: FactoredBelief, messages: list[np.ndarray], extra: list[Factor], agents: np.ndarray
) -> FactoredBelief:
    """Pieces joined by factors that only the new agents have; such a factor is ones for the others."""
    batch = belief.hard.shape[1]
    layout = belief.layout
    scopes = [tuple(v for f in piece.factors for v in f.scope) for piece in layout.pieces] + [f.scope for f in extra]
    pieces: list[Piece] = []
    arrays: list[np.ndarray] = []
    for members in connected(scopes):
        factors, blocks, column = [], [], 0
        for m in members:
            if m < len(layout.pieces):
                piece = layout.pieces[m]
                rows = messages[piece.group][piece.instance * batch : (piece.instance + 1) * batch]
                parts = [(f.scope, rows[:, f.column : f.column + f.size]) for f in piece.factors]
            else:
                f = extra[m - len(layout.pieces)]
                block = np.ones((batch, f.size))
                block[agents] = f.table.reshape(len(agents), -1)
                parts = [(f.scope, block)]
            for scope, block in parts:
                factors.append(PieceFactor(scope, column, block.shape[1]))
                blocks.append(block)
                column += block.shape[1]
        pieces.append(Piece(len(arrays), 0, tuple(factors)))
        arrays.append(np.concatenate(blocks, axis=1))
    assert layout.info is not None
    merged = engine.compiler.layout(tuple(pieces), tuple(a.shape[1] for a in arrays), (1,) * len(arrays), layout.held, layout.info)
    return belief._replace(layout=merged, messages=tuple(arrays))
