"""Layered layout of a drawing: where everything stands and how the arcs run, top to bottom.

The usual four steps (Sugiyama, Tagawa and Toda 1981): turn arcs of circles round, give each node a layer, order the layers so that
few arcs cross (barycentres), and choose coordinates. The last step is exact for each layer: the positions nearest to the average of
the neighbours that keep their distances, by pooling adjacent violators.

The time is proportional to the size of the drawing: large ones get fewer sweeps, and when their edges would bend in more than `MAX_BENDS`
places, the longest run straight.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

Point = tuple[float, float]


@dataclass
class Node:
    """Something with a size: `left` and `right` of its axis, `height` in all."""

    key: str
    left: float
    right: float
    height: float
    top: bool = False  # wants the first layer
    bottom: bool = False  # wants the last layer
    layer: int = 0
    x: float = 0.0
    y: float = 0.0


@dataclass
class Edge:
    """From node `source` to node `target`; `points` are what it passes between them, set by `arrange`."""

    source: str
    target: str
    pull: float = 1.0  # how much it straightens
    points: list[Point] = field(default_factory=list)


GAP_X, GAP_Y = 26.0, 44.0
MAX_BENDS = 20_000
"""Most layers that edges pass through in all."""


def arrange(nodes: Sequence[Node], edges: Sequence[Edge]) -> tuple[float, float]:
    """Set x, y of every node and the points of every edge; returns width and height of the whole."""
    if not nodes:
        return 0.0, 0.0
    index = {node.key: i for i, node in enumerate(nodes)}
    ends = [(index[edge.source], index[edge.target]) for edge in edges]
    forward = _acyclic(len(nodes), ends, [node.top for node in nodes])
    _set_layers(nodes, forward)
    cells, chains = _with_dummies(nodes, forward)
    rows: list[list[int]] = [[] for _ in range(max(cell.layer for cell in cells) + 1)]
    for i, cell in enumerate(cells):
        rows[cell.layer].append(i)
    pulls: list[list[tuple[int, float]]] = [[] for _ in cells]
    for edge, chain in zip(edges, chains):
        for a, b in pairwise(chain):
            inner = sum(i >= len(nodes) for i in (a, b))
            for i, j in ((a, b), (b, a)):
                pulls[i].append((j, edge.pull * (1.0, 2.0, 10.0)[inner]))
    _order(rows, cells, pulls)
    _place(rows, cells, pulls)
    height = _set_y(rows, cells)
    shift = min(cell.x - cell.left for cell in cells)
    for cell in cells:
        cell.x -= shift
    tall = [max(cells[i].height for i in row) for row in rows]
    for edge, chain, (source, target) in zip(edges, chains, forward):
        points = []
        for i in chain:  # straight through the rows, bends between them
            cell, half = cells[i], tall[cells[i].layer] / 2
            if cell.height and half - cell.height / 2 < 5.0:
                continue
            if i != chain[0]:
                points.append((cell.x, cell.y - half))
            if i != chain[-1]:
                points.append((cell.x, cell.y + half))
        edge.points = points if nodes[source].key == edge.source or source == target else points[::-1]
    return max(cell.x + cell.right for cell in cells), height


def _acyclic(count: int, ends: Sequence[tuple[int, int]], first: Sequence[bool]) -> list[tuple[int, int]]:
    """The edges, those that close a circle turned round."""
    out: list[list[int]] = [[] for _ in range(count)]
    entered = [0] * count
    for source, target in ends:
        out[source].append(target)
        entered[target] += 1
    state = [0] * count
    finished: list[int] = []
    for root in sorted(range(count), key=lambda i: (not first[i], entered[i] > 0, i)):
        if state[root]:
            continue
        stack = [(root, iter(out[root]))]
        state[root] = 1
        while stack:
            node, rest = stack[-1]
            for target in rest:
                if not state[target]:
                    state[target] = 1
                    stack.append((target, iter(out[target])))
                    break
            else:
                finished.append(node)
                stack.pop()
    rank = {node: i for i, node in enumerate(reversed(finished))}
    return [(s, t) if rank[s] <= rank[t] else (t, s) for s, t in ends]


def _set_layers(nodes: Sequence[Node], forward: Sequence[tuple[int, int]]) -> None:
    """Longest path from the top; sources then sink towards what they feed, and what wants the bottom goes there."""
    above: list[list[int]] = [[] for _ in nodes]
    below: list[list[int]] = [[] for _ in nodes]
    for a, b in forward:
        if a != b:
            above[b].append(a)
            below[a].append(b)
    layer = [0] * len(nodes)
    for i in _topological(above, below):
        layer[i] = max((layer[a] + 1 for a in above[i]), default=0)
    last = max(layer)
    sinks = [node.bottom and not below[i] for i, node in enumerate(nodes)]
    if any(sinks) and any(layer[i] == last and not sinks[i] for i in range(len(nodes))):
        last += 1
    for i in reversed(_topological(above, below)):
        if sinks[i]:
            layer[i] = last
        elif below[i] and not nodes[i].top:
            lowest = min(layer[b] for b in below[i]) - 1
            if not above[i] or len(below[i]) > len(above[i]):
                layer[i] = lowest
    rank = {level: i for i, level in enumerate(sorted(set(layer)))}
    for node, level in zip(nodes, layer):
        node.layer = rank[level]


def _topological(above: Sequence[Sequence[int]], below: Sequence[Sequence[int]]) -> list[int]:
    waiting = [len(a) for a in above]
    order = [i for i, n in enumerate(waiting) if n == 0]
    for i in order:
        for b in below[i]:
            waiting[b] -= 1
            if waiting[b] == 0:
                order.append(b)
    return order


def _with_dummies(nodes: Sequence[Node], forward: Sequence[tuple[int, int]]) -> tuple[list[Node], list[list[int]]]:
    """The nodes and one narrow dummy per layer that an edge crosses; and per edge the cells it runs through, downwards."""
    cells = list(nodes)
    chains = []
    left, longest = MAX_BENDS, 0
    for span in sorted(nodes[b].layer - nodes[a].layer for a, b in forward):
        left -= max(0, span - 1)
        longest = span if left >= 0 else longest
    for a, b in forward:
        chain = [a]
        for layer in range(nodes[a].layer + 1, nodes[b].layer if nodes[b].layer - nodes[a].layer <= longest else 0):
            cells.append(Node("", 5.0, 5.0, 0.0, layer=layer))
            chain.append(len(cells) - 1)
        chains.append([*chain, b])
    return cells, chains


def _order(rows: list[list[int]], cells: Sequence[Node], pulls: Sequence[Sequence[tuple[int, float]]]) -> None:
    """Reorder each row by the barycentre of its neighbours, down and up; the order with the fewest crossings is kept."""
    best, kept = _crossings(rows, cells, pulls), [list(row) for row in rows]
    segments = sum(map(len, pulls)) // 2
    position = {i: k for row in rows for k, i in enumerate(row)}
    for sweep in range(max(4, min(24, 30_000 // max(segments, 1)))):
        down = sweep % 2 == 0
        for level in range(len(rows)) if down else reversed(range(len(rows))):
            near = level - 1 if down else level + 1
            keys = {}
            for i in rows[level]:
                there = [position[j] for j, _ in pulls[i] if cells[j].layer == near]
                keys[i] = math.fsum(there) / len(there) if there else position[i]
            rows[level].sort(key=lambda i: keys[i])
            position.update((i, k) for k, i in enumerate(rows[level]))
        if segments < 1500:
            _transpose(rows, cells, pulls, position)
        crossings = _crossings(rows, cells, pulls)
        if crossings < best:
            best, kept = crossings, [list(row) for row in rows]
    rows[:] = kept


def _transpose(
    rows: list[list[int]], cells: Sequence[Node], pulls: Sequence[Sequence[tuple[int, float]]], position: dict[int, int]
) -> None:
    """Swap neighbours in a row where that removes crossings; `position` in the rows is kept up to date."""
    for row in rows:
        for k in range(len(row) - 1):
            a, b = row[k], row[k + 1]
            if _pair_crossings(a, b, cells, pulls, position) > _pair_crossings(b, a, cells, pulls, position):
                row[k], row[k + 1] = b, a
                position[a], position[b] = k + 1, k


def _pair_crossings(a: int, b: int, cells: Sequence[Node], pulls: Sequence[Sequence[tuple[int, float]]], position: dict[int, int]) -> int:
    """Crossings among the edges of two neighbours, `a` standing left of `b`."""
    count = 0
    for i, _ in pulls[a]:
        for j, _ in pulls[b]:
            count += cells[i].layer == cells[j].layer and position[i] > position[j]
    return count


def _crossings(rows: Sequence[Sequence[int]], cells: Sequence[Node], pulls: Sequence[Sequence[tuple[int, float]]]) -> int:
    count = 0
    for row, lower in pairwise(rows):
        position = {i: k for k, i in enumerate(lower)}
        seen: list[int] = []
        for i in row:
            mine = [position[j] for j, _ in pulls[i] if j in position and cells[j].layer == cells[i].layer + 1]
            count += sum(len(seen) - bisect.bisect_right(seen, p) for p in mine)
            for p in mine:
                bisect.insort(seen, p)
    return count


def _place(rows: Sequence[Sequence[int]], cells: Sequence[Node], pulls: Sequence[Sequence[tuple[int, float]]]) -> None:
    for row in rows:
        x = 0.0
        for i in row:
            x += cells[i].left
            cells[i].x = x
            x += cells[i].right + GAP_X
    for sweep in range(max(6, min(60, 300_000 // len(cells)))):
        for row in rows if sweep % 2 == 0 else reversed(rows):
            wanted, weights = [], []
            for i in row:
                total = math.fsum(pull for _, pull in pulls[i])
                wanted.append(math.fsum(cells[j].x * pull for j, pull in pulls[i]) / total if total else cells[i].x)
                weights.append(total or 0.1)
            for i, x in zip(row, _spread(row, wanted, weights, cells)):
                cells[i].x = x


def _spread(row: Sequence[int], wanted: Sequence[float], weights: Sequence[float], cells: Sequence[Node]) -> list[float]:
    """The positions nearest to those wanted, by weighted least squares, that keep the order and the distances."""
    offset = [0.0]
    for a, b in pairwise(row):
        gap = GAP_X if cells[a].height and cells[b].height else GAP_X / 2
        offset.append(offset[-1] + cells[a].right + gap + cells[b].left)
    blocks: list[tuple[float, float, int]] = []  # mean, weight, members
    for x, weight, o in zip(wanted, weights, offset):
        blocks.append((x - o, weight, 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (m1, w1, n1), (m2, w2, n2) = blocks[-2:]
            blocks[-2:] = [((m1 * w1 + m2 * w2) / (w1 + w2), w1 + w2, n1 + n2)]
    means: Iterable[float] = (mean for mean, _, n in blocks for _ in range(n))
    return [mean + o for mean, o in zip(means, offset)]


def _set_y(rows: Sequence[Sequence[int]], cells: Sequence[Node]) -> float:
    y = 0.0
    for row in rows:
        tall = max(cells[i].height for i in row)
        for i in row:
            cells[i].y = y + tall / 2
        y += tall + GAP_Y
    return y - GAP_Y
