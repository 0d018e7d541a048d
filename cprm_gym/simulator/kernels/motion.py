"""Motion of one object in one step: acceleration, caps, noise, wind, goal posts, decay (specification/simulator.md 3.1-3.3)."""

from __future__ import annotations

import math

from ..player_types import T_PLAYER_DECAY, T_PLAYER_SIZE, T_PLAYER_SPEED_MAX
from ..state import PlayerBit
from . import kernel
from .geometry import EPS, direction, length, mirror_along, norm, scale, segment_enters_circle
from .random import MOTION_NOISE, PHYSICS, POST_ANGLE, WIND_NOISE, polar_noise, uniform_between

POST_COLLIDE = int(PlayerBit.POST_COLLIDE)
WIND_WEIGHT = 10000.0


@kernel
def move_ball(w, p):
    """One step of the ball."""
    _accelerate(w, 0, p.ball_accel_max, p.ball_speed_max)
    _disturb(w, p, 0, p.ball_rand, p.ball_weight)
    if _near_post(w, p, 0, p.ball_size):
        _pass_posts(w, p, 0, p.ball_size)
    else:
        w.pos[0, 0] += w.vel[0, 0]
        w.pos[0, 1] += w.vel[0, 1]
    _slow_down(w, 0, p.ball_decay)


@kernel
def move_player(w, p, i):
    """One step of player `i` (0..21), who commits his staged angles."""
    o = i + 1
    team = 0 if i < 11 else 1
    slowness = p.slowness_of[team] if w.pos[o, 1] < 0.0 else 1.0
    type_ = w.type[i]
    _accelerate(w, o, p.player_accel_max * slowness, p.types[type_, T_PLAYER_SPEED_MAX] * slowness)
    commit(w, i)
    _disturb(w, p, o, p.player_rand_of[team], p.player_weight)
    size = p.types[type_, T_PLAYER_SIZE]
    if _near_post(w, p, o, size):
        if _pass_posts(w, p, o, size):
            w.bits[i] |= POST_COLLIDE
            w.collided[i] |= 4
    else:
        w.pos[o, 0] += w.vel[o, 0]
        w.pos[o, 1] += w.vel[o, 1]
    _slow_down(w, o, p.types[type_, T_PLAYER_DECAY])


@kernel
def commit(w, i):
    """Make the staged body and neck angles of player `i` the real ones."""
    w.body[i] = w.body_staged[i]
    w.neck[i] = w.neck_staged[i]


@kernel
def _accelerate(w, o, accel_max, speed_max):
    """Add the acceleration to the velocity; both capped, the velocity only if there was an acceleration."""
    ax, ay = w.acc[o, 0], w.acc[o, 1]
    if ax == 0.0 and ay == 0.0:
        return
    if length(ax, ay) > accel_max:
        ax, ay = scale(ax, ay, accel_max)
    vx, vy = w.vel[o, 0] + ax, w.vel[o, 1] + ay
    if length(vx, vy) > speed_max:
        vx, vy = scale(vx, vy, speed_max)
    w.vel[o, 0], w.vel[o, 1] = vx, vy


@kernel
def _disturb(w, p, o, rand, weight):
    """Add noise and wind to the velocity."""
    if rand > 0.0:
        nx, ny = polar_noise(w, PHYSICS, o, MOTION_NOISE, 0, rand * length(w.vel[o, 0], w.vel[o, 1]))
        w.vel[o, 0] += nx
        w.vel[o, 1] += ny
    if w.wind_rand >= EPS:
        speed = length(w.vel[o, 0], w.vel[o, 1])
        for k in range(2):
            push = w.wind[k] + uniform_between(w, PHYSICS, o, WIND_NOISE, k, -w.wind_rand, w.wind_rand)
            w.vel[o, k] += speed * push / (weight * WIND_WEIGHT)
    w.vel[o, 0] += 0.0  # no wind is a wind of zero: it turns -0 into 0, which decides between the directions 180 and -180
    w.vel[o, 1] += 0.0


@kernel
def _slow_down(w, o, decay):
    """Decay of the velocity; the acceleration is used up."""
    w.vel[o, 0] *= decay
    w.vel[o, 1] *= decay
    w.acc[o, 0] = 0.0
    w.acc[o, 1] = 0.0


@kernel
def _near_post(w, p, o, size):
    """False when the path of this step certainly stays clear of all four posts."""
    radius = p.post_radius + size
    x0, x1 = w.pos[o, 0], w.pos[o, 0] + w.vel[o, 0]
    y0, y1 = w.pos[o, 1], w.pos[o, 1] + w.vel[o, 1]
    if max(abs(x0), abs(x1)) < p.post_x - radius or max(abs(y0), abs(y1)) < p.post_y - radius:
        return False
    if x0 * x1 > 0.0 and min(abs(x0), abs(x1)) > p.post_x + radius:
        return False
    return not (y0 * y1 > 0.0 and min(abs(y0), abs(y1)) > p.post_y + radius)


@kernel
def _post_near(p, x, y):
    """Centre of the goal post in the quadrant of (x, y); zero counts as negative."""
    return (p.post_x if x > 0.0 else -p.post_x), (p.post_y if y > 0.0 else -p.post_y)


@kernel
def _pass_posts(w, p, o, size):
    """Move object `o` of radius `size` by its velocity, reflected by the goal posts; True when it hit one."""
    radius = p.post_radius + size
    x, y = w.pos[o, 0], w.pos[o, 1]
    vx, vy = w.vel[o, 0], w.vel[o, 1]
    hit = False
    cx, cy = _post_near(p, x, y)
    if length(x - cx, y - cy) < radius:
        dx, dy = x - cx, y - cy
        if dx == 0.0 and dy == 0.0:
            angle = uniform_between(w, PHYSICS, o, POST_ANGLE, 0, -math.pi, math.pi)
            dx, dy = radius * math.cos(angle), radius * math.sin(angle)
        else:
            dx, dy = scale(dx, dy, radius)
        x, y = cx + dx, cy + dy
        while length(x - cx, y - cy) < radius:
            dx *= 1.01
            dy *= 1.01
            x, y = cx + dx, cy + dy
        if vx != 0.0 or vy != 0.0:
            vx, vy = mirror_along(vx, vy, direction(cx - x, cy - y))
        cx, cy = _post_near(p, x, y)
        hit = True
    tx, ty = x + vx, y + vy
    c2x, c2y = _post_near(p, tx, ty)
    for _ in range(100):  # the server has no limit; each reflection uses up some of a path shorter than 4 m
        if x == tx and y == ty:
            break
        found, ix, iy = segment_enters_circle(x, y, tx, ty, cx, cy, radius)
        mx, my = cx, cy
        if not found and (c2x != cx or c2y != cy):
            found, ix, iy = segment_enters_circle(x, y, tx, ty, c2x, c2y, radius)
            mx, my = c2x, c2y
        if not found:
            break
        axis = direction(mx - ix, my - iy)
        rx, ry = mirror_along(tx - ix, ty - iy, axis)
        away = norm(axis + 180.0)  # degrees taken for radians, as the server does
        x, y = ix + EPS * math.cos(away), iy + EPS * math.sin(away)
        tx, ty = x + rx, y + ry
        speed, heading = length(vx, vy), direction(rx, ry)
        vx, vy = speed * math.cos(heading), speed * math.sin(heading)
        cx, cy = _post_near(p, x, y)
        c2x, c2y = _post_near(p, tx, ty)
        hit = True
    w.pos[o, 0], w.pos[o, 1] = tx, ty
    w.vel[o, 0], w.vel[o, 1] = vx, vy
    return hit
