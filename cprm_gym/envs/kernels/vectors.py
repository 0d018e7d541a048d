"""What the kernels of the feature vectors share: directions without angles, proximities, entries that stay in bounds.

The sine and cosine of the way (dx, dy) against a direction (cosine, sine) are a cross and a dot product over its length: one root and
two divisions where an arctangent, a sine and a cosine cost ten times as much. Places and ages come from the player's memory (`m`, a
`players.memory.MEMORY` record, own team 0..10, opponents 11..21).
"""

from __future__ import annotations

import math

from ...simulator.kernels.geometry import D2R
from ...simulator.kernels.rounding import rough_degrees
from ...simulator.player_types import T_KICKABLE_SQUARED
from ...simulator.state import CommandKind, Count
from . import kernel

RECENT = 30
"""Cycles for which a place in memory counts as known."""
KICK, KICKS = int(CommandKind.KICK), int(Count.KICK)


@kernel
def put(out, at, value):
    """Entry `at` of a vector: within -1 and 1, and 0 for what is no number."""
    out[at] = 0.0 if value != value else min(1.0, max(-1.0, value))


@kernel
def put_bounded(out, at, value):
    """The same for a value that is within bounds by itself, but for the last bit of a float64, or is no number."""
    out[at] = value if value == value else 0.0


@kernel
def flag(out, at, on):
    """Entry `at` of a vector: 1 or -1."""
    out[at] = 1.0 if on else -1.0


@kernel
def length(dx, dy):
    """Length of (dx, dy)."""
    return math.sqrt(dx * dx + dy * dy)


@kernel
def unit(dx, dy):
    """(x, y, length): the direction of (dx, dy), that of the x axis where it has none."""
    d = math.sqrt(dx * dx + dy * dy)
    if d == 0.0:
        return 1.0, 0.0, 0.0
    inverse = 1.0 / d  # one division, not two
    return dx * inverse, dy * inverse, d


@kernel
def near(distance, diagonal):
    """Proximity: 1 at 0 m, -1 at the diagonal and beyond."""
    return 1.0 - 2.0 * (diagonal if distance > diagonal else distance) / diagonal


@kernel
def within(distance):
    """Distance from a line, 0 beyond it."""
    return 0.0 if distance < 0.0 else distance


@kernel
def put_way(out, at, dx, dy, cosine, sine, diagonal):
    """Three entries: sine and cosine of the way (dx, dy) against the direction (cosine, sine), and the proximity of its end."""
    x, y, distance = unit(dx, dy)
    put_bounded(out, at, y * cosine - x * sine)
    put_bounded(out, at + 1, x * cosine + y * sine)
    put_bounded(out, at + 2, near(distance, diagonal))


@kernel
def ways_to(m, xs, ys, cosine, sine, diagonal, ways):
    """What `put_way` puts, for many places side by side: without branches, so that several are worked out at once.

    xs, ys : (n,); ways : (3, n) sines, cosines, proximities; 0 for what is no number
    """
    scale = 2.0 / diagonal
    for k in range(xs.shape[0]):
        dx, dy = xs[k] - m.x, ys[k] - m.y
        distance = math.sqrt(dx * dx + dy * dy)
        inverse = 1.0 / distance
        # at no distance the way is that of the x axis; what is no number fails every comparison
        x, y = (dx * inverse, dy * inverse) if distance > 0.0 else (1.0, 0.0)
        number = distance >= 0.0
        ways[0, k] = y * cosine - x * sine if number else 0.0
        ways[1, k] = x * cosine + y * sine if number else 0.0
        ways[2, k] = 1.0 - scale * min(distance, diagonal) if number else 0.0


@kernel
def put_course(out, at, vx, vy, cosine, sine):
    """Two entries: sine and cosine of a velocity against the direction (cosine, sine), zeros at rest; its length."""
    x, y, speed = unit(vx, vy)
    moves = speed > 0.0
    put_bounded(out, at, y * cosine - x * sine if moves else 0.0)
    put_bounded(out, at + 1, x * cosine + y * sine if moves else 0.0)
    return speed


@kernel
def clear(out, first, last):
    """Zeros from entry `first` to `last` - 1."""
    for at in range(first, last):
        out[at] = 0.0


@kernel
def angle_between(ax, ay, bx, by):
    """Angle between two directions, 0 to pi, to 5e-7: less than a vector's single precision shows after a division by pi."""
    return arc(abs(ax * by - ay * bx), ax * bx + ay * by)


@kernel
def arc(cross, dot):
    """Angle, 0 to pi, whose sine and cosine are as `cross`, at least 0, to `dot`; 0 where there is none."""
    if cross == 0.0 and dot == 0.0:
        return 0.0
    return rough_degrees(dot, cross) * D2R


@kernel
def kickable(w, p, m, i):
    """Whether player `i` remembers the ball within his reach."""
    dx, dy = m.ball_x - m.x, m.ball_y - m.y
    return m.ball_age <= 2 and dx * dx + dy * dy <= p.types[w.type[i], T_KICKABLE_SQUARED]


@kernel
def last_action_possible(w, i, sent, cycle, kicks, k):
    """False where the last command of player `i` was a kick without effect; ``kicks[k]`` counts those that had one."""
    before = kicks[k]
    kicks[k] = w.counts[i, KICKS]
    return not (sent.kind == KICK and before == kicks[k] and cycle > 0)
