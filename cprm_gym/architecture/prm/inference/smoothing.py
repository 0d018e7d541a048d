"""Looking back: posteriors, best path and expected counts of a window of slices, given all its readings.

The window is unrolled to one net, with the belief before its first slice in front, and solved by junction tree. A node is
(variable, slice) with slice -1 before the window; a static one is (variable, None, slice that drew it).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ....errors import ModelError, did_you_mean
from ..grounding.slices import PREVIOUS, SAME, STATIC
from ..model.domains import Index
from .bayes_net import JunctionTree, by_chance, maximise, sliced
from .compiled.belief import FactoredBelief, belief_factors
from .compiled.slice_info import SliceInfo
from .evidence import Readings, one_hot
from .factors import Factor, sample_factors


class Slice(NamedTuple):
    """One slice of the window: belief before it, its variables, its readings."""

    before: Any
    info: SliceInfo
    readings: Readings


class Family(NamedTuple):
    """A CPD of the unrolled net: its slice, key, nodes (parents then child) and the values of those that are observed."""

    slice: int
    key: Hashable
    nodes: tuple[Any, ...]
    shape: tuple[int, ...]
    observed: dict[Any, np.ndarray]


def unroll(window: Sequence[Slice], batch: int, barren: bool = True) -> tuple[list[Factor], list[Family], set[Any]]:
    """Factors of the unrolled window.

    Parameters
    ----------
    window : sequence of Slice
    batch : int
    barren : bool
        Whether to keep unobserved variables without children that have two parents or more.

    Returns
    -------
    factors : list of Factor
    families : list of Family
    left_out : set of nodes
    """
    before = window[0].before
    out = [Factor(tuple((n, -1) if lag != STATIC else (n, None, -1) for n, lag in f.scope), f.table) for f in belief_factors(before)]
    known: dict[Any, np.ndarray] = {(n, -1): before.hard[row] for n, row in before.layout.held.items()}
    families: list[Family] = []
    tables: list[np.ndarray] = []
    drawn = origins(window)
    for t, (_, info, readings) in enumerate(window):
        for name, row in info.row.items():
            values = readings.hard[row]
            if (values >= 0).all() and not info.static[row]:
                known[name, t] = values
            elif (values >= 0).any():
                out.append(Factor((_node(drawn, name, SAME, t),), one_hot(values, int(info.cards[row]))))
        for name, likelihood in readings.soft.items():
            node = _node(drawn, name, SAME, t)
            if node in known:
                out.append(Factor((), likelihood[np.arange(batch), known[node]]))
            else:
                out.append(Factor((node,), likelihood))
        for cpd in info.slice.cpds:
            nodes = [_node(drawn, parent, lag, t) for parent, lag in cpd.parents] + [_node(drawn, cpd.child, SAME, t)]
            observed = {v: known[v] for v in nodes if v in known}
            families.append(Family(t, cpd.key, tuple(nodes), cpd.table.shape, observed))
            tables.append(cpd.table)
    left_out = set() if barren else _childless(families, out)
    out += [sliced(f.nodes, table, f.observed) for f, table in zip(families, tables) if f.nodes[-1] not in left_out]
    return out, families, left_out


def origins(window: Sequence[Slice]) -> list[dict[str, int]]:
    """For each slice, the slice in which each static variable was drawn; -1 for before the window.

    The variable of an object that left and came back is another one.
    """
    found: list[dict[str, int]] = []
    for t, (_, info, _) in enumerate(window):
        last = found[-1] if found else {}
        fixed = [n for n, row in info.row.items() if info.static[row]]
        found.append({n: t if n in info.slice.variables else last.get(n, -1) for n in fixed})
    return found


def _node(drawn: Sequence[Mapping[str, int]], name: str, lag: int, t: int) -> Any:
    """The node of a variable as slice t names it."""
    if lag == PREVIOUS:
        return name, t - 1
    return (name, None, drawn[t][name]) if name in drawn[t] else (name, t)


def _childless(families: Sequence[Family], weights: Sequence[Factor]) -> set[Any]:
    """Unobserved nodes without children that would link two or more hidden parents; repeated until none is left."""
    weighted = {v for f in weights for v in f.scope}
    out: set[Any] = set()
    while True:
        used = {v for f in families if f.nodes[-1] not in out for v in f.nodes[:-1]}
        new = {
            f.nodes[-1]
            for f in families
            if f.nodes[-1] not in used | out | weighted
            and f.nodes[-1] not in f.observed
            and sum(v not in f.observed for v in f.nodes[:-1]) > 1
        }
        if not new:
            return out
        out |= new


class Smoothed(Mapping[str, np.ndarray]):
    """Posteriors of one slice given the whole window: a mapping from variable to (W, card) array."""

    def __init__(self, tree: JunctionTree, extended: list[JunctionTree], window: Sequence[Slice], t: int, batch: int) -> None:
        self._tree, self._extended, self._window, self._t, self._batch = tree, extended, window, t, batch

    def __getitem__(self, name: str) -> np.ndarray:
        info, readings = self._window[self._t].info, self._window[self._t].readings
        if name not in info.row:
            raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, info.names)}")
        row = info.row[name]
        node = _node(origins(self._window), name, SAME, self._t)
        if node in self._tree.cards:
            return self._tree.marginal(node)
        if (readings.hard[row] >= 0).all():
            return one_hot(readings.hard[row], int(info.cards[row]))
        if not self._extended:
            self._extended.append(JunctionTree(unroll(self._window, self._batch)[0], self._batch))
        return self._extended[0].marginal(node)

    def __contains__(self, name: object) -> bool:
        return name in self._window[self._t].info.row

    def __iter__(self) -> Iterator[str]:
        return iter(self._window[self._t].info.names)

    def __len__(self) -> int:
        return len(self._window[self._t].info.names)


def smooth(window: Sequence[Slice]) -> list[Smoothed]:
    """Posteriors of every slice given all readings of the window."""
    batch = window[0].readings.hard.shape[1]
    tree = JunctionTree(unroll(window, batch, barren=False)[0], batch)
    extended: list[JunctionTree] = []
    return [Smoothed(tree, extended, window, t, batch) for t in range(len(window))]


def most_probable_path(window: Sequence[Slice]) -> list[dict[str, Index]]:
    """The most probable joint values of all declared variables of the window; what is before it, and auxiliary, is summed out."""
    batch = window[0].readings.hard.shape[1]
    factors, _, _ = unroll(window, batch)
    drawn = origins(window)
    summed = {v for f in factors for v in f.scope if v[1] == -1}
    summed |= {_node(drawn, name, SAME, t) for t, s in enumerate(window) for name in by_chance(s.info, t == 0)}
    found, _ = maximise(factors, batch, summed)
    path = []
    for t, (_, info, readings) in enumerate(window):
        values = {}
        for name, row in info.row.items():
            if not info.variables[name].auxiliary:
                node = _node(drawn, name, SAME, t)
                values[name] = Index(np.broadcast_to(found[node], (batch,)) if node in found else readings.hard[row])
        path.append(values)
    return path


def expected_counts(window: Sequence[Slice]) -> dict[Hashable, np.ndarray]:
    """Expected counts of every row and state of each class-level CPD, summed over slices, objects and agents."""
    batch = window[0].readings.hard.shape[1]
    factors, families, _ = unroll(window, batch)
    tree = JunctionTree(factors, batch)
    counts: dict[Hashable, np.ndarray] = {}
    for family in families:
        hidden = [v for v in family.nodes if v not in family.observed]
        joint = tree.joint(hidden) if hidden else np.ones(batch)
        axes = [k for k, v in enumerate(family.nodes) if v in family.observed]
        rest = [k for k in range(len(family.nodes)) if k not in axes]
        total = counts.setdefault(family.key, np.zeros(family.shape))
        moved = np.transpose(total, axes + rest)
        if axes:
            np.add.at(moved, tuple(family.observed[family.nodes[k]] for k in axes), joint)
        else:
            moved += joint.sum(axis=0)
    return counts


def sample_belief(belief: FactoredBelief, count: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Joint samples of the hidden variables of a belief, dict of name to (W, count) int array."""
    info, batch = belief.layout.info, belief.hard.shape[1]
    found: dict[str, np.ndarray] = {}
    factors = belief_factors(belief)
    for node, values in sample_factors(factors, batch, count, rng).items():
        found[node[0]] = values
    if info is not None:
        for name, row in belief.layout.held.items():
            found[name] = np.repeat(belief.hard[row][:, None], count, axis=1)
    return found
