"""Overlapping objects are pushed apart (specification/simulator.md 3.4), and the caught ball is put before its goalie (3.5).

These kernels know no referee: `contacts.resolve_collisions` drives them and reports touches; the referee, who relocates objects
himself, drives them on his own (kernels cannot call each other in a circle).

One resolution is: up to ten rounds of [`clear_pushes`, for each player `touches_ball` (then the touch is reported) and
`push_from_ball`, `push_players`, `apply_pushes`], then `bounce`. Marks of who was involved (``w.hit``) stay until `bounce`.
"""

from __future__ import annotations

import math

from ..player_types import T_PLAYER_SIZE
from ..state import OBJECTS, PLAYERS, PlayerBit, PlayMode
from . import kernel
from .geometry import EPS, length, norm, scale, squared_distance
from .random import COLLISION_ANGLE, PHYSICS, uniform_between

ROUNDS = 10
"""Most rounds of one resolution."""
BALL_CONTACT = int(PlayerBit.BALL_TO_PLAYER | PlayerBit.BALL_COLLIDE)
PLAYER_COLLIDE = int(PlayerBit.PLAYER_COLLIDE)
PLAY_ON = int(PlayMode.play_on)


@kernel
def clear_pushes(w):
    """Begin a round: no position is registered."""
    for o in range(OBJECTS):
        w.push[o, 0] = 0.0
        w.push[o, 1] = 0.0
        w.pushes[o] = 0


@kernel
def touches_ball(w, p, i):
    """Whether player `i`, who is enabled and does not hold the ball, overlaps it; if so he is marked and flagged."""
    if not w.enabled[i] or w.ball_catcher == i + 1:
        return False
    reach = p.ball_size + p.types[w.type[i], T_PLAYER_SIZE]
    if squared_distance(w, 0, i + 1) >= reach * reach:
        return False
    w.hit[0] = 1
    w.hit[i + 1] = 1
    w.bits[i] |= BALL_CONTACT
    w.collided[i] |= 1
    return True


@kernel
def push_from_ball(w, p, i, round):
    """Register where ball and player `i` go: both apart in play_on, else only the player."""
    o = i + 1
    size = p.types[w.type[i], T_PLAYER_SIZE]
    if w.mode == PLAY_ON:
        _separate(w, 0, o, p.ball_size, size, round)
        return
    _register(w, 0, w.pos[0, 0], w.pos[0, 1])
    dx, dy = w.pos[o, 0] - w.pos[0, 0], w.pos[o, 1] - w.pos[0, 1]
    reach = p.ball_size + size + EPS
    if dx == 0.0 and dy == 0.0:
        angle = uniform_between(w, PHYSICS, 0, COLLISION_ANGLE, o + OBJECTS * round, -math.pi, math.pi)
        dx, dy = reach * math.cos(angle), reach * math.sin(angle)
    else:
        dx, dy = scale(dx, dy, reach)
    _register(w, o, w.pos[0, 0] + dx, w.pos[0, 1] + dy)


@kernel
def push_players(w, p, round):
    """Register where overlapping players go; True when there were some."""
    found = False
    for i in range(PLAYERS - 1):
        if not w.enabled[i]:
            continue
        x, y, size = w.pos[i + 1, 0], w.pos[i + 1, 1], p.types[w.type[i], T_PLAYER_SIZE]
        for j in range(i + 1, PLAYERS):
            dx, dy = w.pos[j + 1, 0] - x, w.pos[j + 1, 1] - y
            other = p.types[w.type[j], T_PLAYER_SIZE]
            if dx * dx + dy * dy < (size + other) * (size + other) and w.enabled[j]:
                found = True
                for k in (i, j):
                    w.hit[k + 1] = 1
                    w.bits[k] |= PLAYER_COLLIDE
                    w.collided[k] |= 2
                _separate(w, i + 1, j + 1, size, other, round)
    return found


@kernel
def apply_pushes(w):
    """End a round: every object with registered positions goes to their mean."""
    for o in range(OBJECTS):
        n = w.pushes[o]
        if n > 0:
            w.pos[o, 0] = w.push[o, 0] / n
            w.pos[o, 1] = w.push[o, 1] / n


@kernel
def bounce(w):
    """End a resolution: the velocity of everything that was involved is multiplied by -0.1, once."""
    for o in range(OBJECTS):
        if w.hit[o]:
            w.vel[o, 0] *= -0.1
            w.vel[o, 1] *= -0.1
            w.hit[o] = 0


@kernel
def carry_ball(w, p):
    """Put a caught ball before its goalie; its velocity stays."""
    o = w.ball_catcher
    if o > 0:
        reach = p.types[w.type[o - 1], T_PLAYER_SIZE] + p.ball_size
        w.pos[0, 0] = w.pos[o, 0] + reach * math.cos(w.body[o - 1])
        w.pos[0, 1] = w.pos[o, 1] + reach * math.sin(w.body[o - 1])


@kernel
def _register(w, o, x, y):
    """Count (x, y) among the positions that object `o` is pushed to."""
    w.push[o, 0] += x
    w.push[o, 1] += y
    w.pushes[o] += 1


@kernel
def _separate(w, a, b, size_a, size_b, round):
    """Register positions of `a` and `b` on both sides of their midpoint, just apart."""
    reach = (size_a + size_b) / 2.0 + EPS
    mx, my = (w.pos[a, 0] + w.pos[b, 0]) / 2.0, (w.pos[a, 1] + w.pos[b, 1]) / 2.0
    ax, ay = w.pos[a, 0] - mx, w.pos[a, 1] - my
    bx, by = w.pos[b, 0] - mx, w.pos[b, 1] - my
    if (w.pos[a, 0] == w.pos[b, 0] and w.pos[a, 1] == w.pos[b, 1]) or (length(ax, ay) < EPS and length(bx, by) < EPS):
        angle = uniform_between(w, PHYSICS, a, COLLISION_ANGLE, b + OBJECTS * round, -math.pi, math.pi)
        opposite = norm(angle + math.pi)
        ax, ay = reach * math.cos(angle), reach * math.sin(angle)
        bx, by = reach * math.cos(opposite), reach * math.sin(opposite)
    else:
        ax, ay = scale(ax, ay, reach)
        bx, by = scale(bx, by, reach)
    apart = (size_a + size_b) * (size_a + size_b)
    for _ in range(10):
        dx, dy = (mx + ax) - (mx + bx), (my + ay) - (my + by)
        if dx * dx + dy * dy >= apart:
            break
        ax, ay, bx, by = ax * 1.0001, ay * 1.0001, bx * 1.0001, by * 1.0001
    _register(w, a, mx + ax, my + ay)
    _register(w, b, mx + bx, my + by)
