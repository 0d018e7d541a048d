"""Where ball and players are put by the referee (specification/simulator.md 7.2): positions of awards, relocations of players."""

from __future__ import annotations

import math

from ...pitch import CENTRE_RADIUS, GOAL_AREA_X, GOAL_AREA_Y, PENALTY_X, PENALTY_Y
from ...player_types import T_PLAYER_SIZE
from .. import kernel
from ..geometry import EPS, clip, in_circle, in_penalty_area, side_of
from ..random import REFEREE, RELOCATION, uniform_between
from .modes import (
    BACK_PASS,
    FOUL_CHARGE,
    FOUL_PUSH,
    ILLEGAL_DEFENSE,
    INDIRECT_FREE_KICK,
    KICK_OFF,
    LEFT,
    NEUTRAL,
    PAIR,
    RIGHT,
    SIDE,
)
from .touches import settle_overlaps

NEAR_RADIUS = 5.5
"""The distance kept from the ball after some offences."""
CLEAR_GAP = 1e-5


@kernel
def radius_of(w, p, i):
    """Body radius of player `i`, metres."""
    return p.types[w.type[i], T_PLAYER_SIZE]


@kernel
def sign_up(y):
    """+1 if y > 0, else -1."""
    return 1.0 if y > 0.0 else -1.0


@kernel
def clamp_pitch(p, x, y):
    """The nearest point of the pitch."""
    return clip(-p.goal_line, x, p.goal_line), clip(-p.touch_line, y, p.touch_line)


@kernel
def out_of_penalty_area(side, x, y):
    """A point in the penalty area of `side` (NEUTRAL: of either) moved to that area's corner."""
    if side != RIGHT and x <= -PENALTY_X and abs(y) <= PENALTY_Y:
        return -PENALTY_X + EPS, sign_up(y) * (PENALTY_Y + EPS)
    if side != LEFT and x >= PENALTY_X and abs(y) <= PENALTY_Y:
        return PENALTY_X - EPS, sign_up(y) * (PENALTY_Y + EPS)
    return x, y


@kernel
def out_of_goal_area(side, x, y):
    """A point in the goal area of `side` (NEUTRAL: of either) moved to that area's front."""
    if side != RIGHT and x <= -GOAL_AREA_X and abs(y) <= GOAL_AREA_Y:
        return -GOAL_AREA_X + EPS, y
    if side != LEFT and x >= GOAL_AREA_X and abs(y) <= GOAL_AREA_Y:
        return GOAL_AREA_X - EPS, y
    return x, y


@kernel
def nearest_edge(x, y, half_x, half_y):
    """The point of the edges of a rectangle round the centre that is nearest to (x, y), by the server's rule.

    A vertical edge when one is closer in x than a horizontal one is in y; the other coordinate is clipped.
    """
    if min(abs(x - half_x), abs(x + half_x)) < min(abs(y - half_y), abs(y + half_y)):
        return half_x if abs(x - half_x) < abs(x + half_x) else -half_x, clip(-half_y, y, half_y)
    return clip(-half_x, x, half_x), half_y if abs(y - half_y) < abs(y + half_y) else -half_y


@kernel
def nearest_on_circle(x, y, cx, cy, radius):
    """The point of a circle nearest to (x, y); from the very centre along the diagonal."""
    dx, dy = x - cx, y - cy
    if dx == 0.0 and dy == 0.0:
        dx, dy = EPS, EPS
    factor = radius / max(math.sqrt(dx * dx + dy * dy), EPS)
    return cx + dx * factor, cy + dy * factor


@kernel
def place_ball(w, side, x, y):
    """Put the ball at rest at (x, y) for `side`."""
    w.pos[0, 0], w.pos[0, 1] = x, y
    w.vel[0, 0], w.vel[0, 1] = 0.0, 0.0
    w.acc[0, 0], w.acc[0, 1] = 0.0, 0.0
    w.kick_off_side = side


@kernel
def field_clamp(w, p):
    """Bring back players who are more than the margin outside the pitch; velocities are kept."""
    for i in range(22):
        if w.enabled[i]:
            x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
            if abs(x) > p.limit_x or abs(y) > p.limit_y:
                w.pos[i + 1, 0], w.pos[i + 1, 1] = nearest_edge(x, y, p.limit_x, p.limit_y)


@kernel
def own_halves(w, p):
    """Players in the opponent's half go to their own, then those of the side that does not kick off leave the circle."""
    kicking_off = p.forbid_kick_off_offside != 0 and PAIR[w.mode] == KICK_OFF
    for i in range(22):
        if not w.enabled[i]:
            continue
        side = side_of(i)
        if w.pos[i + 1, 0] * side <= 0.0:
            continue
        if kicking_off:
            w.pos[i + 1, 0] = -side * radius_of(w, p, i)
        else:
            w.pos[i + 1, 0] = -side * uniform_between(w, REFEREE, i, RELOCATION, 0, 0.0, p.goal_line)
            w.pos[i + 1, 1] = uniform_between(w, REFEREE, i, RELOCATION, 1, -p.touch_line, p.touch_line)
    for i in range(22):
        if w.enabled[i] and side_of(i) != w.kick_off_side:
            x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
            radius = CENTRE_RADIUS + radius_of(w, p, i)
            if in_circle(x, y, 0.0, 0.0, radius):
                w.pos[i + 1, 0], w.pos[i + 1, 1] = nearest_on_circle(x, y, 0.0, 0.0, radius)


@kernel
def clear_radius(w, p):
    """Distance that is kept from the ball in the present mode."""
    pair, side = PAIR[w.mode], SIDE[w.mode]
    if pair == ILLEGAL_DEFENSE or pair == BACK_PASS:
        return NEAR_RADIUS
    if (pair == FOUL_CHARGE or pair == FOUL_PUSH) and in_penalty_area(p, side, w.pos[0, 0], w.pos[0, 1]):
        return NEAR_RADIUS
    return CENTRE_RADIUS


@kernel
def is_indirect(w):
    """In the present mode players may stay on the goal line however near the ball is."""
    pair = PAIR[w.mode]
    return pair == BACK_PASS or pair == FOUL_CHARGE or pair == FOUL_PUSH or pair == INDIRECT_FREE_KICK


@kernel
def beyond_limit(nx, ny, bx, by, reach, limit):
    """A cleared point beyond the limit in its first coordinate, moved along the clearing circle to that limit."""
    height = abs(reach * math.sin(math.acos(clip(-1.0, (limit - abs(bx)) / reach, 1.0)))) + CLEAR_GAP
    return limit if nx > 0.0 else -limit, by - height if ny < by else by + height


@kernel
def cleared_point(w, p, x, y, clear, reach):
    """Where clearing puts a player who stands at (x, y) too near the ball; `reach` is `clear` plus his radius."""
    bx, by = w.pos[0, 0], w.pos[0, 1]
    nx, ny = nearest_on_circle(x, y, bx, by, reach + CLEAR_GAP)
    in_corner = abs(bx) > p.limit_x - clear and abs(by) > p.limit_y - clear
    if in_corner and abs(nx) > p.goal_line and abs(ny) > p.touch_line:
        nx, ny = 2.0 * bx - nx, 2.0 * by - ny
    if is_indirect(w) and abs(nx) > p.goal_line and nx != bx:
        line = p.goal_line if nx > 0.0 else -p.goal_line
        ny = by + (ny - by) * (line - bx) / (nx - bx)
        nx = line
    if abs(nx) > p.limit_x:
        nx, ny = beyond_limit(nx, ny, bx, by, reach, p.limit_x)
    if abs(ny) > p.limit_y:
        ny, nx = beyond_limit(ny, nx, by, bx, reach, p.limit_y)
    if abs(nx) > p.limit_x or abs(ny) > p.limit_y:
        nx, ny = 2.0 * bx - nx, 2.0 * by - ny
    return nx, ny


@kernel
def clear_ball(w, p, side):
    """Push the players of `side` (NEUTRAL: everybody) away from the ball; who is moved comes to rest."""
    clear = clear_radius(w, p)
    indirect = is_indirect(w)
    for _ in range(10):
        moved = False
        for i in range(22):
            if not w.enabled[i] or (side != NEUTRAL and side_of(i) != side):
                continue
            x, y = w.pos[i + 1, 0], w.pos[i + 1, 1]
            reach = clear + radius_of(w, p, i)
            if not in_circle(x, y, w.pos[0, 0], w.pos[0, 1], reach) or (indirect and abs(x) >= p.goal_line):
                continue
            w.pos[i + 1, 0], w.pos[i + 1, 1] = cleared_point(w, p, x, y, clear, reach)
            w.vel[i + 1, 0], w.vel[i + 1, 1] = 0.0, 0.0
            w.acc[i + 1, 0], w.acc[i + 1, 1] = 0.0, 0.0
            moved = True
        if not moved:
            return
        settle_overlaps(w, p)
