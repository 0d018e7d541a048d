"""Where a player of a match goes without the ball, and how likely a tackle is to hit it, world by world.

Metres, cycles, radians in the frame of the own team.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compilation import kernel_group
from ..attacker.kernels import race

kernel = kernel_group()

RECENT, KNOWN = 20.0, 40.0
"""Cycles within which an opponent must have been seen to be marked, and a team-mate to be reckoned with."""
DEEPEST, BACK, LOWEST = -46.0, -30.0, -38.0
"""x to which the back line goes back, x in the formation up to which somebody is of it, and x to which the others go, m."""
HIGHEST, WIDEST = 44.0, 32.0
"""Metres ahead and aside beyond which nobody waits."""
FORWARD = -12.0
"""x in the formation from which on a player is a forward, m."""
PRESSING = 4.0
"""Metres by which a team goes farther ahead while the ball is in the other half."""


class Places(NamedTuple):
    """By what his place is judged."""

    shift: float
    sway: float
    ahead: float
    margin: float
    marks: float
    cover: float
    supporters: float
    supports: float
    distance: float
    half_length: float
    rest: float
    near: float


@kernel
def tackle_chance(ball_x, ball_y, me, reach, width, exponent):
    """Probability that a tackle hits the ball (specification/simulator.md 4.4)."""
    dx, dy = ball_x - me[0], ball_y - me[1]
    along = dx * math.cos(me[4]) + dy * math.sin(me[4])
    across = abs(dy * math.cos(me[4]) - dx * math.sin(me[4]))
    if along <= 0.0:
        return 0.0
    return max(0.0, 1.0 - ((along / reach) ** exponent + (across / width) ** exponent))


@kernel
def their_time(ball, rivals, age, c):
    """Cycles until the first opponent is at the ball."""
    least = 99.0
    for k in range(rivals.shape[0]):
        if age[k] <= KNOWN:
            t, _, _ = race(ball[0], ball[1], ball[2], ball[3], rivals[k, 0], rivals[k, 1], c.rival_start, 0.0, -1.0, c)
            least = min(least, t)
    return least


@kernel
def rank(ball, me, mates, age):
    """How many team-mates are nearer to the ball."""
    own, nearer = math.hypot(ball[0] - me[0], ball[1] - me[1]), 0
    for m in range(mates.shape[0]):
        if age[m] <= KNOWN and math.hypot(ball[0] - mates[m, 0], ball[1] - mates[m, 1]) < own:
            nearer += 1
    return nearer


@kernel
def home(ball, place_x, place_y, line, p):
    """(x, y): his place in the formation, shifted with the ball, onside."""
    deepest = DEEPEST if place_x < BACK else LOWEST
    x = place_x + p.shift * (ball[0] + 10.0) + (PRESSING if ball[0] > 0.0 else 0.0)
    if place_x > FORWARD and ball[0] > -15.0:
        x = max(x, min(ball[0] + p.ahead, line - p.margin))
    x = min(x, max(line - p.margin, deepest))
    return min(HIGHEST, max(deepest, x)), min(WIDEST, max(-WIDEST, 0.85 * place_y + p.sway * ball[1]))


@kernel
def marking(x, y, rivals, age, p):
    """(x, y): between the opponent nearest to his place and the own goal; his place where there is none near."""
    best, gap = -1, p.marks
    for k in range(rivals.shape[0]):
        d = math.hypot(rivals[k, 0] - x, rivals[k, 1] - y)
        if age[k] <= RECENT and d < gap:
            best, gap = k, d
    if best < 0:
        return x, y
    dx, dy = -p.half_length - rivals[best, 0], -rivals[best, 1]
    d = max(0.5, math.hypot(dx, dy))
    return rivals[best, 0] + 1.5 * dx / d, rivals[best, 1] + 1.5 * dy / d


@kernel
def aside(ball, x, y, p):
    """(x, y) no nearer to the ball than a set play of the opponents allows, on the side of the own goal."""
    dx, dy = x - ball[0], y - ball[1]
    d = math.hypot(dx, dy)
    if d >= p.distance:
        return x, y
    if d < 0.1:
        dx, dy, d = -1.0, 0.0, 1.0
    x, y = ball[0] - p.distance * abs(dx) / d, ball[1] + p.distance * dy / d
    if x < DEEPEST:
        x, side = DEEPEST, -1.0 if y < ball[1] else 1.0
        y = ball[1] + side * math.sqrt(max(0.0, p.distance**2 - (ball[0] - x) ** 2))
    return x, y


@kernel
def place(ball, me, mates, mate_age, rivals, age, own_time, mate_time, line, home_at, support, mode, stamina, p, c, out):
    """Where he goes without the ball: x, y into out[0..1], the first opponent's time at the ball into out[2].

    mode : 1 while the ball is played, 2 at a set play of the own team, 3 at one of theirs, 0 else; stamina : share of the full one
    """
    out[2] = their_time(ball, rivals, age, c)
    ours = min(own_time, mate_time)
    x, y = home(ball, home_at[0], home_at[1], line, p)
    if mode == 3:
        x, y = aside(ball, x, y, p)
    elif mode == 1 or mode == 2:
        nearer = rank(ball, me, mates, mate_age)
        if mode == 2 or ours <= out[2]:
            if nearer <= p.supporters and math.hypot(ball[0] - me[0], ball[1] - me[1]) < p.supports:
                x, y = support[0], support[1]
            if stamina < p.rest and math.hypot(x - me[0], y - me[1]) < p.near and me[0] < line - p.margin:
                x, y = me[0], me[1]
        elif nearer <= 1:
            dx, dy = -p.half_length - ball[0], -ball[1]
            d = max(0.5, math.hypot(dx, dy))
            way = min(p.cover, 0.5 * d)
            x, y = ball[0] + way * dx / d, ball[1] + way * dy / d
        elif ball[0] < 0.0:
            x, y = marking(x, y, rivals, age, p)
    out[0], out[1] = x, y


@kernel
def places(ball, me, mates, mate_age, rivals, age, times, lines, homes, supports, modes, stamina, p, c, reach, width, exponent, out):
    """`place` in every world, and the chance of a tackle; out : (N, 4)."""
    for n in range(len(out)):
        place(
            ball[n], me[n], mates[n], mate_age[n], rivals[n], age[n], times[n, 0], times[n, 1], lines[n], homes[n], supports[n], modes[n],
            stamina[n], p, c, out[n],
        )  # fmt: skip
        out[n, 3] = tackle_chance(ball[n, 0], ball[n, 1], me[n], reach, width, exponent)
