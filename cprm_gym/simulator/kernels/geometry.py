"""Angles, vectors and the tests of specification/simulator.md 0.2 and 3.6, with the server's order of operations.

Every formula is written so that it rounds as the server's does: lengths are ``sqrt(x*x + y*y)``, never ``hypot``; degrees are
one multiplication away from radians; ties round to even.
"""

from __future__ import annotations

import math

import numpy as np

from ..pitch import HALF_LENGTH, PENALTY_X, PENALTY_Y
from ..player_types import T_KICKABLE_SQUARED
from . import kernel

EPS = 1e-10
D2R = math.pi / 180.0
R2D = 180.0 / math.pi
_TWO_PI = 2.0 * math.pi


@kernel
def clip(low, value, high):
    """`value` between `low` and `high`."""
    return min(max(low, value), high)


@kernel
def quantize(value, step):
    """`value` rounded (half to even) to a multiple of `step`; unchanged when `step` is below 1e-10."""
    if step < EPS:
        return value
    return np.rint(value / step) * step


@kernel
def norm(angle):
    """`angle` (radians) in [-pi, pi], with the server's branches."""
    if abs(angle) > _TWO_PI:
        angle = np.fmod(angle, _TWO_PI)
    if angle < -math.pi:
        angle += _TWO_PI
    if angle > math.pi:
        angle -= _TWO_PI
    return angle


@kernel
def length(x, y):
    """Length of a vector."""
    return math.sqrt(x * x + y * y)


@kernel
def direction(x, y):
    """Direction of a vector in radians; 0 for the zero vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    return math.atan2(y, x)


@kernel
def scale(x, y, size):
    """The vector with its length made `size`; the zero vector stays zero."""
    factor = size / max(math.sqrt(x * x + y * y), EPS)
    return x * factor, y * factor


@kernel
def rotate(x, y, angle):
    """The vector turned by `angle` radians."""
    c, s = math.cos(angle), math.sin(angle)
    return x * c - y * s, x * s + y * c


@kernel
def mirror_along(x, y, axis):
    """The vector with its component along direction `axis` (radians) negated."""
    u, v = rotate(x, y, -axis)
    return rotate(-u, v, axis)


@kernel
def squared_distance(w, a, b):
    """Squared distance (m^2) of the objects `a` and `b`."""
    x = w.pos[a, 0] - w.pos[b, 0]
    y = w.pos[a, 1] - w.pos[b, 1]
    return x * x + y * y


@kernel
def in_circle(x, y, cx, cy, radius):
    """Whether a point is in a circle round c: by its distance, whose square may round differently on the very edge."""
    return length(x - cx, y - cy) <= radius


@kernel
def segment_enters_circle(bx, by, ex, ey, cx, cy, radius):
    """(whether, x, y): where the segment from b to e first meets the circle round c (specification/simulator.md 3.3)."""
    if bx == ex and by == ey:
        return False, 0.0, 0.0
    dx, dy = ex - bx, ey - by
    if length(dx, dy) < length(bx - cx, by - cy) - radius:
        return False, 0.0, 0.0
    bx0, by0, ex0, ey0 = bx - cx, by - cy, ex - cx, ey - cy
    squared = dx * dx + dy * dy
    determinant = bx0 * ey0 - ex0 * by0
    discriminant = radius * radius * squared - determinant * determinant
    if discriminant <= 0.0:
        return False, 0.0, 0.0
    root = math.sqrt(discriminant)
    sign = -1.0 if dy < 0.0 else 1.0
    x1 = (determinant * dy + sign * dx * root) / squared
    y1 = (-determinant * dx + abs(dy) * root) / squared
    x2 = (determinant * dy - sign * dx * root) / squared
    y2 = (-determinant * dx - abs(dy) * root) / squared
    left, right, low, high = bx0, ex0, by0, ey0
    if bx0 > ex0:
        left, right, low, high = ex0, bx0, ey0, by0
    if low > high:
        low, high = high, low
    in1 = left <= x1 <= right and low <= y1 <= high
    in2 = left <= x2 <= right and low <= y2 <= high
    if in1 and in2:
        first = (x1 - bx0) ** 2 + (y1 - by0) ** 2 <= (x2 - bx0) ** 2 + (y2 - by0) ** 2
        return True, (x1 if first else x2) + cx, (y1 if first else y2) + cy
    if not in1 and not in2:
        return False, 0.0, 0.0
    x, y = (x1, y1) if in1 else (x2, y2)
    if x == bx0 and y == by0:
        return False, 0.0, 0.0
    return True, x + cx, y + cy


@kernel
def side_of(i):
    """+1 for players 0..10, -1 for players 11..21."""
    return 1 if i < 11 else -1


@kernel
def is_kickable(w, p, i):
    """Whether player `i` (0..21) can kick the ball."""
    return squared_distance(w, i + 1, 0) <= p.types[w.type[i], T_KICKABLE_SQUARED]


@kernel
def in_penalty_area(p, side, x, y):
    """Whether a point is in the penalty area of `side` (0: of either), enlarged by the ball's radius."""
    margin = p.ball_size
    if abs(y) > PENALTY_Y + margin or abs(x) > HALF_LENGTH + margin or abs(x) < PENALTY_X - margin:
        return False
    return side == 0 or (side > 0) == (x < 0.0)
