"""Kernels of keepaway: keepers that hold, pass at random or by hand-written rules, and takers (Stone, Sutton, Kuhlmann 2005)."""

from __future__ import annotations

import math

from . import kernel
from .memory import PLAYERS, norm
from .motion import (
    NARROW,
    chase,
    clear,
    kick_to,
    kick_velocity,
    kickable,
    lane,
    look_to,
    nearest_opponent,
    pass_speed,
    run_to,
    search,
    turn_to,
)
from .team import LOST, rank_to_ball

KEEP_RANDOM, KEEP_HOLD, KEEP_HAND, TAKE = 0, 1, 2, 3
PRESSED = 3.0
"""Metres within which a taker makes the hand-coded keeper think of passing."""
HOLD_NEAR, HOLD_FAR = 0.38, 0.52
"""Shares of the kickable ring at which a player keeps the ball."""
AWAY = 2.2
"""Metres from an opponent at which the ball is out of danger."""
COMING = 0.075
"""Weight of where an opponent would be after a stride, against where he is; holding lasts the longer, the larger it is: takers who run
straight at the ball turn and turn when it is always moved out of their way. This one makes it last as long as published."""
PI = math.pi
FREE = 1.3
"""Metres from the next keeper beyond which a taker stops the ball; nearer, staying at the ball is what wins it."""
ARRIVING = 0.6
"""Speed at which a pass should arrive, m / cycle."""


@kernel
def open_place(m, me, count, half_x, half_y):
    """(x, y) within the region, near him, at which he is most open for a pass."""
    best_x, best_y, best = m.x, m.y, -1e9
    for k in range(17):
        radius = 0.0 if k == 0 else (2.5 if k < 9 else 6.0)
        angle = 0.7853981634 * k
        x = min(half_x - 1.5, max(1.5 - half_x, m.x + radius * math.cos(angle)))
        y = min(half_y - 1.5, max(1.5 - half_y, m.y + radius * math.sin(angle)))
        value = openness(m, me, count, x, y) - 0.15 * radius
        if value > best:
            best_x, best_y, best = x, y, value
    return best_x, best_y


@kernel
def receive(m, c, me, count, half_x, half_y, fresh):
    """Without the ball: go to it if nobody of the team is faster, else get open for a pass within the region."""
    if m.ball_age > LOST:
        search(m, c, fresh)
        return
    if rank_to_ball(m, me, count) == 0:
        chase(m, c, 100.0)
        return
    best_x, best_y = open_place(m, me, count, half_x, half_y)
    if run_to(m, c, best_x, best_y, 90.0, 1.0):
        turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def openness(m, me, count, x, y):
    """How good (x, y) is to receive the ball: far from opponents and team-mates, with a clear way, neither near nor far."""
    distance = math.sqrt((x - m.ball_x) ** 2 + (y - m.ball_y) ** 2)
    value = min(nearest_opponent(m, x, y), 8.0) + 1.5 * min(lane(m, x, y, pass_speed(m, distance, ARRIVING)), 3.0)
    if distance < 7.0:
        value -= 1.5 * (7.0 - distance)
    for k in range(count):
        if k != me and m.age[k] <= 30:
            d = math.sqrt((m.px[k] - x) ** 2 + (m.py[k] - y) ** 2)
            if d < 9.0:
                value -= 0.6 * (9.0 - d)
    return value


@kernel
def pass_to(m, c, k):
    """Pass to player `k` of the own team."""
    d = math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2)
    kick_to(m, c, m.px[k], m.py[k], pass_speed(m, d, ARRIVING))


@kernel
def best_receiver(m, me, count):
    """(player, room in metres) of the team-mate with the clearest way; -1 if none is known."""
    best, room = -1, -1e9
    for k in range(count):
        if k != me and m.age[k] <= 10:
            d = math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2)
            value = lane(m, m.px[k], m.py[k], pass_speed(m, d, ARRIVING)) + 0.15 * min(nearest_opponent(m, m.px[k], m.py[k]), 10.0)
            if d < 3.0:
                value -= 3.0
            if value > room:
                best, room = k, value
    return best, room


@kernel
def scan(m, c, me, count):
    """Look to whom was not seen for longest, the ball being felt at the feet."""
    oldest, age = -1, 2
    for k in range(PLAYERS):
        if k != me and age < m.age[k] < 200 and (k < count or k >= 11):
            oldest, age = k, m.age[k]
    if oldest >= 0:
        look_to(m, c, m.px[oldest], m.py[oldest])


@kernel
def kick_limit(m, x, y, bx, by):
    """The largest change of the ball's velocity by one kick with the ball at (x, y) and the player at (bx, by), m / cycle."""
    dx, dy = x - bx, y - by
    gap = math.sqrt(dx * dx + dy * dy) - m.contact
    aside = abs(norm(math.atan2(dy, dx) - m.body))
    return m.power * m.kick_rate * (1.0 - 0.25 * aside / PI - 0.25 * gap / m.margin)


@kernel
def threat(m, j, x, y, bx, by, come):
    """How much opponent `j` threatens the ball at (x, y) when he has come on by `come` metres, the holder's body being at (bx, by)."""
    px, py = m.px[j], m.py[j]
    dx, dy = m.ball_x + m.ball_vx - px, m.ball_y + m.ball_vy - py
    d = math.sqrt(dx * dx + dy * dy)
    share = min(1.0, come / max(0.01, d))
    px += share * dx
    py += share * dy
    ox, oy = px - bx, py - by
    gap = math.sqrt(ox * ox + oy * oy)
    if 0.0 < gap < 2.0 * m.size:
        # the body keeps him off
        px, py = bx + 2.0 * m.size * ox / gap, by + 2.0 * m.size * oy / gap
    return max(0.0, AWAY - math.sqrt((x - px) ** 2 + (y - py) ** 2)) ** 2


@kernel
def exposure(m, x, y, bx, by):
    """How exposed the ball is at (x, y) with the holder's body at (bx, by)."""
    total = 0.0
    for j in range(11, PLAYERS):
        if m.age[j] <= 20 and (m.px[j] - bx) ** 2 + (m.py[j] - by) ** 2 < 16.0:
            total += (1.0 - COMING) * threat(m, j, x, y, bx, by, 0.0) + COMING * threat(m, j, x, y, bx, by, 0.6)
    return total


@kernel
def sheltered(m):
    """(x, y): where to have the ball in the next cycle, the body between it and the opponents.

    Of the places around the body where the ball can be kicked, it is kicked to the one that lies away from the opponents, where they
    stand and, less so, where they would be after a stride towards it. There it is in the next cycle, and the kick after that stops it.
    """
    bx, by = m.x + m.vx, m.y + m.vy
    limit = kick_limit(m, m.ball_x, m.ball_y, m.x, m.y)
    best_x, best_y, best = m.ball_x, m.ball_y, -1e9
    for k in range(48):
        angle = (k % 24) * PI / 12.0
        radius = m.contact + (HOLD_NEAR if k < 24 else HOLD_FAR) * m.margin
        x, y = bx + radius * math.cos(angle), by + radius * math.sin(angle)
        vx, vy = x - m.ball_x, y - m.ball_y
        kick = math.sqrt((vx - m.ball_vx) ** 2 + (vy - m.ball_vy) ** 2)
        stop = m.ball_decay * math.sqrt(vx * vx + vy * vy)
        value = -0.1 * kick - 10.0 * (max(0.0, kick - limit) + max(0.0, stop - kick_limit(m, x, y, bx, by)))
        value -= exposure(m, x, y, bx, by)
        if value > best:
            best_x, best_y, best = x, y, value
    return best_x, best_y


@kernel
def hold(m, c):
    """Shield the ball."""
    x, y = sheltered(m)
    kick_velocity(m, c, x - m.ball_x, y - m.ball_y)
    # eyes that look every cycle; what is near is felt whichever way they look
    c.view_width = NARROW


@kernel
def keep(m, c, me, count, kind, luck, half_x, half_y, fresh):
    """A keeper's command: with the ball what his kind decides, without it `receive`."""
    clear(c)
    if not m.free:
        return
    if not kickable(m):
        receive(m, c, me, count, half_x, half_y, fresh)
        return
    receiver = -1
    if kind == KEEP_RANDOM:
        # hold or pass to one of the others, all equally likely
        choice = int(luck * count)
        if choice > 0:
            k = choice - 1 if choice - 1 < me else choice
            if m.age[k] <= 100:
                receiver = k
    elif kind == KEEP_HAND and nearest_opponent(m, m.x, m.y) < PRESSED:
        k, room = best_receiver(m, me, count)
        if room > 1.0:
            receiver = k
    if receiver >= 0:
        pass_to(m, c, receiver)
    else:
        hold(m, c)
    scan(m, c, me, count)


@kernel
def take(m, c, me, count, half_x, half_y, fresh):
    """A taker's command: the two fastest go to the ball and stop it when it is loose, the others stand before the most open keeper."""
    clear(c)
    if not m.free:
        return
    if m.ball_age > LOST:
        search(m, c, fresh)
        return
    if kickable(m) and nearest_opponent(m, m.ball_x, m.ball_y) > FREE:
        hold(m, c)
        return
    if rank_to_ball(m, me, count) <= 1:
        chase(m, c, 100.0)
        return
    best, gap = -1, -1.0
    for k in range(11, PLAYERS):
        if m.age[k] <= 30:
            d = math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2)
            nearest = 50.0
            for j in range(count):
                if m.age[j] <= 30:
                    nearest = min(nearest, math.sqrt((m.px[k] - m.px[j]) ** 2 + (m.py[k] - m.py[j]) ** 2))
            if d > 2.0 and nearest > gap:
                best, gap = k, nearest
    if best >= 0:
        x, y = 0.6 * m.px[best] + 0.4 * m.ball_x, 0.6 * m.py[best] + 0.4 * m.ball_y
        if run_to(m, c, x, y, 90.0, 0.5):
            turn_to(m, c, norm(math.atan2(m.ball_y - m.y, m.ball_x - m.x)))
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def act(worlds, memory, players, kinds, counts, half_x, half_y, luck, fresh, commands):
    """Commands of keepers and takers of every world.

    players : (P,) rows 0..21; kinds : (P,) KEEP_RANDOM ... TAKE; luck : (W, P) in [0, 1); commands : (W, 22) COMMAND
    """
    for n in range(worlds.shape[0]):
        w = worlds[n]
        for p in range(players.shape[0]):
            i = players[p]
            if w.enabled[i]:
                m = memory[n, i]
                m.left = 1 if i < 11 else 0
                count = counts[0] if i < 11 else counts[1]
                if kinds[p] == TAKE:
                    take(m, commands[n, i], i % 11, count, half_x, half_y, fresh[n, i])
                else:
                    keep(m, commands[n, i], i % 11, count, kinds[p], luck[n, p], half_x, half_y, fresh[n, i])
