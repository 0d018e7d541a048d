"""A tree of questions that sorts numbers into labelled leaves: the states of a quantity that CPDs have as a parent.

A CPD over the leaves is a tree-structured one: which of the numbers count depends on the answers before.

References
----------
Boutilier, Friedman, Goldszmidt and Koller 1996; Breiman, Friedman, Olshen and Stone 1984, chapter 4 (growing by the entropy).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import FormatError

CUTS = 32
"""Quantiles of a number at which a question may cut it."""


@dataclass(frozen=True)
class Tree:
    """Questions "is feature f below c", each with two followers.

    Attributes
    ----------
    feature : tuple of int
        Of each node; -1 for a leaf.
    cut : tuple of float
        Of each node; a leaf's is its number.
    below, above : tuple of int
        The nodes that follow; -1 for a leaf.
    """

    feature: tuple[int, ...]
    cut: tuple[float, ...]
    below: tuple[int, ...]
    above: tuple[int, ...]

    def __post_init__(self) -> None:
        sizes = {len(self.feature), len(self.cut), len(self.below), len(self.above)}
        ahead = all(f < 0 or (k < b < len(self.feature) and k < a < len(self.feature)) for k, (f, b, a) in enumerate(self._rows()))
        if len(sizes) != 1 or not self.feature or not ahead:
            raise FormatError("tree: the nodes of a tree are lists of one length, each after the one that leads to it")

    def _rows(self) -> zip[tuple[int, int, int]]:
        return zip(self.feature, self.below, self.above)

    @property
    def leaves(self) -> int:
        """How many there are."""
        return sum(f < 0 for f in self.feature)

    def leaf(self, numbers: np.ndarray) -> np.ndarray:
        """(N,) int64 leaves of (N, F) numbers."""
        feature, cut = np.array(self.feature), np.array(self.cut)
        followers = np.array([self.above, self.below])
        node, rows = np.zeros(len(numbers), np.int64), np.arange(len(numbers))
        asked = feature[node] >= 0
        while asked.any():
            less = (numbers[rows, np.maximum(feature[node], 0)] < cut[node]).astype(np.int64)
            node = np.where(asked, followers[less, node], node)
            asked = feature[node] >= 0
        return cut[node].astype(np.int64)

    def to_dict(self) -> dict[str, list[Any]]:
        """As it stands in a file."""
        return {"feature": list(self.feature), "cut": list(self.cut), "below": list(self.below), "above": list(self.above)}

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Tree:
        """The tree of `to_dict`.

        Raises
        ------
        FormatError
            For what is none.
        """
        try:
            feature, below, above = (tuple(int(v) for v in given[name]) for name in ("feature", "below", "above"))
            return cls(feature, tuple(float(v) for v in given["cut"]), below, above)
        except (KeyError, TypeError, ValueError) as error:
            raise FormatError(f"tree: not a tree: {error}") from None


def grow(numbers: np.ndarray, outcome: np.ndarray, leaves: int, least: int = 40) -> Tree:
    """The tree that tells the outcomes apart: the leaf whose best question gains most information is divided first.

    Parameters
    ----------
    numbers : (N, F) array
    outcome : (N,) int array
        Classes from 0.
    leaves : int
        At most.
    least : int
        Rows of a leaf.
    """
    classes = int(outcome.max()) + 1
    cuts = [np.unique(np.round(np.quantile(column, np.linspace(0, 1, CUTS + 1)[1:-1]), 3)) for column in numbers.T]
    nodes: list[list[Any]] = [[-1, 0.0, -1, -1]]
    open_leaves = [(0, np.arange(len(numbers)), _question(numbers, outcome, cuts, np.arange(len(numbers)), classes, least))]
    while len(open_leaves) < leaves:
        best = max(range(len(open_leaves)), key=lambda k: open_leaves[k][2][0])
        node, rows, (gain, feature, cut) = open_leaves[best]
        if gain <= 0:
            break
        less = numbers[rows, feature] < cut
        nodes[node] = [feature, float(cut), len(nodes), len(nodes) + 1]
        open_leaves.pop(best)
        for part in (rows[less], rows[~less]):
            open_leaves.append((len(nodes), part, _question(numbers, outcome, cuts, part, classes, least)))
            nodes.append([-1, 0.0, -1, -1])
    for number, k in enumerate(k for k, node in enumerate(nodes) if node[0] < 0):
        nodes[k][1] = float(number)
    questions, below, above = (tuple(int(node[k]) for node in nodes) for k in (0, 2, 3))
    return Tree(questions, tuple(float(node[1]) for node in nodes), below, above)


def _question(
    numbers: np.ndarray, outcome: np.ndarray, cuts: list[np.ndarray], rows: np.ndarray, classes: int, least: int
) -> tuple[float, int, float]:
    """(gain in nats of all rows together, feature, cut) of the best question for some rows; gain 0 if there is none."""
    best = (0.0, -1, 0.0)
    whole = _surprise(np.bincount(outcome[rows], minlength=classes)[None])[0]
    for feature, places in enumerate(cuts):
        if not len(places):
            continue
        part = np.searchsorted(places, numbers[rows, feature], side="right")
        table = np.zeros((len(places) + 1, classes))
        np.add.at(table, (part, outcome[rows]), 1.0)
        below = table.cumsum(axis=0)[:-1]
        above = table.sum(axis=0) - below
        gains = np.where(np.minimum(below.sum(axis=1), above.sum(axis=1)) >= least, whole - _surprise(below) - _surprise(above), 0.0)
        k = int(gains.argmax())
        if gains[k] > best[0]:
            best = (float(gains[k]), feature, float(places[k]))
    return best


def _surprise(counts: np.ndarray) -> np.ndarray:
    """Nats of outcomes counted in rows (n, C), each told by its share in its row."""
    total = counts.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.where(counts > 0, counts * np.log(counts / total), 0.0)
    return np.asarray(-parts.sum(axis=1))
