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
REACH = 150.0  # from the middle of the last piece of the arc
SIDES = np.array([(1, 0), (-1, 0), (1, -1), (-1, 1), (1, 1), (-1, -1)])
"""Where a label may stand from a point of its arc: right and left of it, and half a height higher or lower."""


MAX_LOOKS = 200_000_000
"""Most pairs of a label and a point of an arc that are looked at; the labels of larger drawings just stand at their arcs."""


def curve_points(path: Sequence[Point]) -> NDArray[np.float64]:
    """Points along the curve that is drawn through `path`, upright at each of its points; (N, 2)."""
    parts = []
    for (x0, y0), (x1, y1) in pairwise(path):
        t = np.linspace(0.0, 1.0, max(2, int(math.hypot(x1 - x0, y1 - y0) / STEP)))
        bend = t * t * (3.0 - 2.0 * t)
        rise = (1.0 - t) ** 3 * y0 + 1.5 * t * (1.0 - t) * (y0 + y1) + t**3 * y1
        parts.append(np.column_stack((x0 + (x1 - x0) * bend, rise)))
    return np.concatenate(parts)


def place_labels(labels: Sequence[tuple[float, int]], height: float, texts: Sequence[Rect], paths: Sequence[Sequence[Point]]) -> list[Rect]:
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
    length = math.fsum(math.hypot(x1 - x0, y1 - y0) for path in paths for (x0, y0), (x1, y1) in pairwise(path))
    if len(labels) * (length / STEP + 2 * len(paths) + len(texts)) > MAX_LOOKS:
        return [_at_middle(width, height, paths[arc]) for width, arc in labels]
    curves = [curve_points(path) for path in paths]
    points = np.concatenate([np.zeros((0, 2)), *curves])
    owner = np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
    taken = np.array(texts, np.float64).reshape(-1, 4)
    found: list[Rect] = []
    for width, arc in labels:
        (x0, y0), (x1, y1) = paths[arc][-2:]
        far = np.hypot(curves[arc][:, 0] - (x0 + x1) / 2, curves[arc][:, 1] - (y0 + y1) / 2)
        reached = far <= max(REACH, far.min())
        corners = curves[arc][reached][:, None] - (width / 2, height / 2) + SIDES * (width / 2 + GAP, height / 2)
        rects = np.concatenate((corners, corners + (width, height)), axis=-1).reshape(-1, 4)
        around = np.concatenate((rects[:, :2].min(axis=0), rects[:, 2:].max(axis=0)))[None]
        near = _inside(around, points, GAP)[0]
        others = points[near & (owner != arc)]
        rivals = taken[_overlaps(around, taken)[0]]
        cost = 0.03 * np.repeat(far[reached], len(SIDES)) + 100.0 * _overlaps(rects, rivals).sum(axis=1)
        cost += _inside(rects, points[near], 1.5).sum(axis=1) + 0.5 * _inside(rects, others, GAP).sum(axis=1)
        best = rects[int(cost.argmin())]
        taken = np.concatenate((taken, best[None]))
        found.append((float(best[0]), float(best[1]), float(best[2]), float(best[3])))
    return found


def _at_middle(width: float, height: float, path: Sequence[Point]) -> Rect:
    """A label at the middle of the end of its arc, whatever stands there."""
    (x0, y0), (x1, y1) = path[-2:]
    left, top = (x0 + x1) / 2 + GAP, (y0 + y1 - height) / 2
    return (left, top, left + width, top + height)


def _overlaps(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rectangles of `a` (N, 4) and `b` (M, 4) share an area, (N, M)."""
    a = a[:, None]
    return (a[..., 0] < b[:, 2]) & (b[:, 0] < a[..., 2]) & (a[..., 1] < b[:, 3]) & (b[:, 1] < a[..., 3])


def _inside(rects: NDArray[np.float64], points: NDArray[np.float64], margin: float = 0.0) -> NDArray[np.bool_]:
    """Which of `points` (M, 2) lie in which of the rectangles (N, 4) or less than `margin` beside them, (N, M)."""
    rects, (x, y) = rects[:, None], points.T
    return (x > rects[..., 0] - margin) & (x < rects[..., 2] + margin) & (y > rects[..., 1] - margin) & (y < rects[..., 3] + margin)
