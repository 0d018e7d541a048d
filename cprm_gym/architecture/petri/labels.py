"""Where the labels of arcs stand in a drawing: beside their arc, clear of other texts and, as far as there is room, of other arcs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .layout import Point

Rect = tuple[float, float, float, float]
"""Left, top, right, bottom."""
GAP = 4.0  # between an arc and its label
STEP = 3.0  # between two points at which an arc is looked at


def curve_points(path: Sequence[Point]) -> NDArray[np.float64]:
    """Points along the curve that is drawn through `path`, upright at each of its points; (N, 2)."""
    parts = []
    for (x0, y0), (x1, y1) in pairwise(path):
        t = np.linspace(0.0, 1.0, max(2, int(math.hypot(x1 - x0, y1 - y0) / STEP)))
        bend = t * t * (3.0 - 2.0 * t)
        rise = (1.0 - t) ** 3 * y0 + 1.5 * t * (1.0 - t) * (y0 + y1) + t**3 * y1
        parts.append(np.column_stack((x0 + (x1 - x0) * bend, rise)))
    return np.concatenate(parts)


def place_labels(
    labels: Sequence[tuple[float, int]], height: float, texts: Sequence[Rect], paths: Sequence[Sequence[Point]]
) -> list[Rect]:
    """A rectangle for each label.

    Parameters
    ----------
    labels : sequence of (width, number of its arc)
    height : float
        Of a label.
    texts : sequence of Rect
        What no label may cover.
    paths : sequence of paths
        All arcs.
    """
    curves = [curve_points(path) for path in paths]
    taken = list(texts)
    found = []
    for width, arc in labels:
        (x0, y0), (x1, y1) = paths[arc][-2:]
        others = np.concatenate([np.zeros((0, 2)), *curves[:arc], *curves[arc + 1 :]])
        wanted = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
        best: tuple[float, Rect] = (math.inf, (0.0, 0.0, 0.0, 0.0))
        for x, y in curves[arc]:
            far = 0.03 * float(np.hypot(x - wanted[0], y - wanted[1]))
            for right, down in ((1, 0), (-1, 0), (1, -1), (-1, 1), (1, 1), (-1, -1)):
                left, top = x - width / 2 + right * (width / 2 + GAP), y - height / 2 + down * height / 2
                rect = (left, top, left + width, top + height)
                cost = far + 100.0 * sum(_overlap(rect, other) for other in taken)
                cost += _inside(rect, curves[arc]) + _inside(rect, others) + 0.5 * _inside(rect, others, GAP)
                best = min(best, (cost, rect))
        found.append(best[1])
        taken.append(best[1])
    return found


def _overlap(a: Rect, b: Rect) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _inside(rect: Rect, points: NDArray[np.float64], margin: float = 0.0) -> int:
    """How many of `points` lie in the rectangle or less than `margin` beside it."""
    x, y = points[:, 0], points[:, 1]
    return int(((x > rect[0] - margin) & (x < rect[2] + margin) & (y > rect[1] - margin) & (y < rect[3] + margin)).sum())
