"""A belief as a product of factors: which variables stand where in which array, and how beliefs of agents are parted and joined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..factors import Factor, contract_all
from ..join_tree import connected
from .cache import Recent
from .slice_info import SliceInfo

Node = tuple[str, int]


class PieceFactor(NamedTuple):
    """Variables of a factor in the order of its axes, first column in the array, number of entries."""

    scope: tuple[Node, ...]
    column: int
    size: int


class Piece(NamedTuple):
    """A connected part of the belief: which array, which object in it, which factors."""

    group: int
    instance: int
    factors: tuple[PieceFactor, ...]

    @property
    def columns(self) -> slice:
        """The columns of the array that belong to the piece."""
        last = self.factors[-1]
        return slice(self.factors[0].column, last.column + last.size)


@dataclass(frozen=True, eq=False)
class Layout:
    """What stands where in a belief.

    Attributes
    ----------
    pieces : tuple of Piece
    widths : tuple of int
        Columns of each array.
    counts : tuple of int
        Objects in each array.
    held : dict of str to int
        Variables of the slice that were observed for every agent, and their row in its evidence.
    info : SliceInfo or None
        The slice; None before the first.
    """

    pieces: tuple[Piece, ...]
    widths: tuple[int, ...]
    counts: tuple[int, ...]
    held: dict[str, int]
    info: SliceInfo | None

    def variables(self) -> dict[Node, int]:
        """Piece of each variable in the belief."""
        return {node: i for i, piece in enumerate(self.pieces) for factor in piece.factors for node in factor.scope}


class Layouts(Recent[tuple[Any, ...], Layout]):
    """One object for equal layouts."""

    def one(
        self, pieces: tuple[Piece, ...], widths: tuple[int, ...], counts: tuple[int, ...], held: dict[str, int], info: SliceInfo
    ) -> Layout:
        """The layout of these parts."""
        key = (pieces, widths, counts, tuple(held.items()), info)
        return self.fetch(key, lambda: Layout(pieces, widths, counts, held, info))


EMPTY = Layout((), (), (), {}, None)


class Move(NamedTuple):
    """Copy columns of some objects' messages into the message of a group."""

    source: int
    instances: np.ndarray
    columns: slice
    to_instances: np.ndarray
    to_columns: slice


class FactoredBelief(NamedTuple):
    """All that is known after a slice, as a product of factors. Its arrays are never changed.

    Attributes
    ----------
    layout : Layout
    messages : tuple of (objects * W, columns) float arrays
    hard : (V, W) int array
        Readings of the slice.
    """

    layout: Layout
    messages: tuple[np.ndarray, ...]
    hard: np.ndarray


def nothing_yet(batch: int) -> FactoredBelief:
    """The belief before the first slice."""
    return FactoredBelief(EMPTY, (), np.zeros((0, batch), np.int64))


def belief_factors(belief: FactoredBelief) -> list[Factor]:
    """The factors of a belief, each with a leading axis for the agents; a variable is named (name, slice), slice `PRESENT` or `STATIC`."""
    info, batch = belief.layout.info, belief.hard.shape[1]
    factors = []
    for piece in belief.layout.pieces:
        message = belief.messages[piece.group]
        rows = message[piece.instance * batch : (piece.instance + 1) * batch]
        for f in piece.factors:
            assert info is not None
            shape = [int(info.cards[info.row[name]]) for name, _ in f.scope]
            factors.append(Factor(f.scope, rows[:, f.column : f.column + f.size].reshape(batch, *shape)))
    return factors


def select(belief: FactoredBelief, agents: np.ndarray) -> FactoredBelief:
    """The belief of some agents."""
    batch, objects = belief.hard.shape[1], belief.layout.counts
    blocks = (m.reshape(n, batch, m.shape[1])[:, agents] for m, n in zip(belief.messages, objects))
    messages = tuple(b.reshape(b.shape[0] * b.shape[1], b.shape[2]) for b in blocks)
    return FactoredBelief(belief.layout, messages, belief.hard[:, agents])


def join(beliefs: Sequence[FactoredBelief]) -> FactoredBelief:
    """The belief of the agents of several beliefs of one layout."""
    layout = beliefs[0].layout
    batches = [b.hard.shape[1] for b in beliefs]
    messages = []
    for g, columns in enumerate(layout.widths):
        blocks = [b.messages[g].reshape(layout.counts[g], w, columns) for b, w in zip(beliefs, batches)]
        messages.append(np.concatenate(blocks, axis=1).reshape(layout.counts[g] * sum(batches), columns))
    return FactoredBelief(layout, tuple(messages), np.concatenate([b.hard for b in beliefs], axis=1))


# ------------------------------------------------------------------------------------------------- other names


class Renaming(NamedTuple):
    """The layout of a renamed belief, and where its readings and, for each array, its objects stood before (None: as they are)."""

    layout: Layout
    rows: np.ndarray
    objects: tuple[np.ndarray | None, ...]

    def of(self, belief: FactoredBelief) -> FactoredBelief:
        """A belief in which objects have their new names."""
        batch = belief.hard.shape[1]
        messages = tuple(
            m if at is None else m.reshape(len(at), batch, m.shape[1])[at].reshape(m.shape) for m, at in zip(belief.messages, self.objects)
        )
        return FactoredBelief(self.layout, messages, belief.hard[self.rows])


def renaming(layouts: Layouts, old: Layout, info: SliceInfo, name_of: Mapping[str, str]) -> Renaming:
    """How to give the variables of a belief other names; like objects stand in the order of their new names.

    Parameters
    ----------
    layouts : Layouts
    old : Layout
    info : SliceInfo
        A slice with the new names.
    name_of : mapping of str to str
        New name of every variable of the belief's slice.
    """
    assert old.info is not None
    back = {new: old_name for old_name, new in name_of.items()}
    rows = np.array([old.info.row[back[name]] for name in info.names], np.int64)
    moved = [
        Piece(p.group, p.instance, tuple(f._replace(scope=tuple((name_of[name], time) for name, time in f.scope)) for f in p.factors))
        for p in old.pieces
    ]
    first: dict[tuple[int, int], Node] = {}
    for p in moved:
        node = min(v for f in p.factors for v in f.scope)
        first[p.group, p.instance] = min(node, first.get((p.group, p.instance), node))
    objects: list[np.ndarray | None] = []
    place: dict[tuple[int, int], int] = {}
    for group, count in enumerate(old.counts):
        order = sorted(range(count), key=lambda b: first.get((group, b), ("", b)))
        place.update({(group, b): k for k, b in enumerate(order)})
        objects.append(None if order == list(range(count)) else np.array(order))
    pieces = sorted((p._replace(instance=place[p.group, p.instance]) for p in moved), key=lambda p: (p.group, p.instance))
    held = {name_of[name]: info.row[name_of[name]] for name in old.held}
    return Renaming(layouts.one(tuple(pieces), old.widths, old.counts, held, info), rows, tuple(objects))


# ------------------------------------------------------------------------------------------------- some agents anew


def merge(layouts: Layouts, belief: FactoredBelief, anew: FactoredBelief, agents: np.ndarray) -> FactoredBelief:
    """A belief that is `anew` for some agents and `belief` for the others.

    Both are products of factors, over different scopes. In the merged one each agent has ones in the factors that only the others
    have; a factor whose scope lies inside another's is multiplied into it. What only the slice of `anew` has is summed out; what it
    lacks is in its first state. Nothing is approximated.
    """
    batch = belief.hard.shape[1]
    fresh = _over_the_variables_of(belief, anew)
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
    return _with_extra(layouts, belief, messages, extra, agents)


def _over_the_variables_of(belief: FactoredBelief, anew: FactoredBelief) -> list[Factor]:
    """The factors of `anew` with the variables of `belief`."""
    info, other = belief.layout.info, anew.layout.info
    assert info is not None
    assert other is not None
    fresh = belief_factors(anew)
    strange = {v for f in fresh for v in f.scope if v[0] not in info.row}
    if strange:
        touched = [f for f in fresh if not strange.isdisjoint(f.scope)]
        keep = [v for v in dict.fromkeys(v for f in touched for v in f.scope) if v not in strange]
        fresh = [f for f in fresh if strange.isdisjoint(f.scope)] + [contract_all(touched, keep)]
    for node in belief.layout.variables():
        if node[0] not in other.row:
            certain = np.zeros((anew.hard.shape[1], int(info.cards[info.row[node[0]]])))
            certain[:, 0] = 1.0
            fresh.append(Factor((node,), certain))
    return fresh


def _with_extra(
    layouts: Layouts, belief: FactoredBelief, messages: list[np.ndarray], extra: list[Factor], agents: np.ndarray
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
                block[agents] = f.table.reshape(len(f.table), -1)
                parts = [(f.scope, block)]
            for scope, block in parts:
                factors.append(PieceFactor(scope, column, block.shape[1]))
                blocks.append(block)
                column += block.shape[1]
        pieces.append(Piece(len(arrays), 0, tuple(factors)))
        arrays.append(np.concatenate(blocks, axis=1))
    assert layout.info is not None
    merged = layouts.one(tuple(pieces), tuple(a.shape[1] for a in arrays), (1,) * len(arrays), layout.held, layout.info)
    return belief._replace(layout=merged, messages=tuple(arrays))
