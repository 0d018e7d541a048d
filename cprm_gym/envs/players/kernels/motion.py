"""Kernels that write one command: turn, run, look, kick, pass, shoot, catch; all from a player's own memory.

``m`` is a MEMORY record, ``c`` a COMMAND record that these functions fill. Formulas: specification/simulator.md 4, default player type.
"""

from __future__ import annotations

import math

from ....simulator.state import CommandKind
from . import kernel
from .memory import BALL_DECAY, D2R, norm

PI = math.pi
NONE, DASH, TURN, KICK = int(CommandKind.NONE), int(CommandKind.DASH), int(CommandKind.TURN), int(CommandKind.KICK)
TACKLE, CATCH, MOVE = int(CommandKind.TACKLE), int(CommandKind.CATCH), int(CommandKind.MOVE)
NAN = float("nan")
REACH = 1.085
"""Kickable distance between the centres of player and ball, m."""
SURE = 0.98
"""The same, less what the eye may err."""
MARGIN, PLAYER_SIZE, BALL_SIZE = 0.7, 0.3, 0.085
KICK_POWER_RATE = 0.027
BALL_SPEED_MAX = 3.0
CATCH_REACH = 1.15
GOAL_X, GOAL_HALF = 52.5, 7.01
NARROW, NORMAL = 1, 2
"""View widths: the narrow view comes every cycle, the normal one every second (specification/simulator.md 4.7)."""
STRIDE = 0.95
"""Metres that a running player makes in a cycle."""


@kernel
def clear(c):
    """No command."""
    c.kind = NONE
    c.a = c.b = c.c = c.d = NAN
    c.turn_neck = NAN
    c.focus[0] = c.focus[1] = NAN
    c.point[0] = c.point[1] = NAN
    c.view_width = NORMAL
    c.view_quality = 0
    c.attention_side = 0
    c.say_length = 0


@kernel
def speed_of(m):
    """Own speed, m / cycle."""
    return math.sqrt(m.vx * m.vx + m.vy * m.vy)


@kernel
def turn_to(m, c, angle):
    """Turn the body to a direction of the pitch, with the moment that the inertia asks for."""
    moment = norm(angle - m.body) / D2R * (1.0 + 5.0 * speed_of(m))
    c.kind = TURN
    c.a = min(180.0, max(-180.0, moment))


@kernel
def thrifty(m, power):
    """`power`, less when stamina is short: below the threshold effort and recovery would suffer (specification/simulator.md 5)."""
    if m.stamina < 2600.0:
        return min(power, 25.0)
    if m.stamina < 3600.0:
        return min(power, 60.0)
    return power


@kernel
def run_to(m, c, x, y, power, slack):
    """Turn towards (x, y) or dash; True when already within `slack` metres of it."""
    dx, dy = x - m.x, y - m.y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance <= slack:
        return True
    angle = math.atan2(dy, dx)
    off = norm(angle - m.body)
    allowed = max(0.2, math.atan2(slack, distance))
    if abs(off) > allowed:
        # a short step back or aside needs no turn
        if distance < 2.0 and abs(off) > 2.2:
            c.kind = DASH
            c.a = thrifty(m, power)
            c.b = off / D2R
            return False
        turn_to(m, c, angle)
        return False
    c.kind = DASH
    # the last metre is not overrun
    needed = (distance - speed_of(m) * 0.4) / 0.6 * 100.0
    c.a = thrifty(m, max(10.0, min(power, needed)))
    c.b = 0.0
    return False


@kernel
def look_to(m, c, x, y):
    """Turn the neck so that the face points to (x, y), as far as it goes, after the body command in `c`."""
    body = m.body
    if c.kind == TURN:
        body = norm(body + c.a * D2R / (1.0 + 5.0 * speed_of(m)))
    wanted = norm(math.atan2(y - m.y, x - m.x) - body) / D2R
    c.turn_neck = min(90.0, max(-90.0, wanted)) - m.neck / D2R


@kernel
def ball_distance(m):
    """Distance to the ball as remembered, m."""
    return math.sqrt((m.ball_x - m.x) ** 2 + (m.ball_y - m.y) ** 2)


@kernel
def kickable(m):
    """Whether the player believes that he can kick."""
    return m.ball_age <= 2 and ball_distance(m) <= SURE


@kernel
def kick_velocity(m, c, vx, vy):
    """Kick so that the ball leaves with velocity (vx, vy), as nearly as one kick can."""
    ax, ay = vx - m.ball_vx, vy - m.ball_vy
    wanted = math.sqrt(ax * ax + ay * ay)
    dx, dy = m.ball_x - m.x, m.ball_y - m.y
    gap = math.sqrt(dx * dx + dy * dy) - PLAYER_SIZE - BALL_SIZE
    aside = abs(norm(math.atan2(dy, dx) - m.body))
    rate = KICK_POWER_RATE * max(0.25, 1.0 - 0.25 * aside / PI - 0.25 * gap / MARGIN)
    c.kind = KICK
    c.a = min(100.0, wanted / rate)
    c.b = norm(math.atan2(ay, ax) - m.body) / D2R


@kernel
def kick_to(m, c, x, y, speed):
    """Kick the ball towards (x, y) with an initial speed."""
    angle = math.atan2(y - m.ball_y, x - m.ball_x)
    kick_velocity(m, c, speed * math.cos(angle), speed * math.sin(angle))


@kernel
def pass_speed(distance, arriving):
    """Initial speed of a ball that still rolls with `arriving` m / cycle after `distance` metres."""
    return min(BALL_SPEED_MAX, arriving + (1.0 - BALL_DECAY) * distance)


@kernel
def intercept(m, x, y, delay):
    """(cycles, x, y): when and where somebody at (x, y), who loses `delay` cycles at first, meets the rolling ball."""
    bx, by, vx, vy = m.ball_x, m.ball_y, m.ball_vx, m.ball_vy
    for t in range(40):
        d = math.sqrt((bx - x) ** 2 + (by - y) ** 2) - 0.8
        if d <= STRIDE * max(0.0, t - delay):
            return t, bx, by
        bx += vx
        by += vy
        vx *= BALL_DECAY
        vy *= BALL_DECAY
    d = math.sqrt((bx - x) ** 2 + (by - y) ** 2)
    return int(delay + d / STRIDE), bx, by


@kernel
def chase(m, c, power):
    """Run to where the ball can be met."""
    angle = math.atan2(m.ball_y - m.y, m.ball_x - m.x)
    delay = 1.0 if abs(norm(angle - m.body)) > 0.3 else 0.0
    _, x, y = intercept(m, m.x, m.y, delay)
    if run_to(m, c, x, y, power, 0.5):
        turn_to(m, c, angle)
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def search(m, c, fresh):
    """Look for the ball: the neck first to one side, then the body turns; in blind cycles nothing would be gained."""
    m.search += 1
    if fresh:
        turn_to(m, c, m.body + (1.9 if m.search % 16 < 8 else -1.9))
        c.turn_neck = -m.neck / D2R


@kernel
def lane(m, x, y, speed):
    """How clear the way from the ball to (x, y) is of opponents: the least of (their distance to it - what they run meanwhile), m."""
    dx, dy = x - m.ball_x, y - m.ball_y
    length = math.sqrt(dx * dx + dy * dy)
    if length < 0.1:
        return 20.0
    dx /= length
    dy /= length
    least = 20.0
    for k in range(11, 22):
        if m.age[k] > 15:
            continue
        ox, oy = m.px[k] - m.ball_x, m.py[k] - m.ball_y
        along = ox * dx + oy * dy
        if along < -1.0 or along > length + 3.0:
            continue
        across = abs(ox * dy - oy * dx)
        time = max(0.0, along) / max(0.6, speed * 0.8)
        room = across - 0.55 * time - 0.8
        if room < least:
            least = room
    return least


@kernel
def nearest_opponent(m, x, y):
    """Distance from (x, y) to the nearest remembered opponent, m."""
    least = 50.0
    for k in range(11, 22):
        if m.age[k] <= 20:
            d = math.sqrt((m.px[k] - x) ** 2 + (m.py[k] - y) ** 2)
            if d < least:
                least = d
    return least


@kernel
def offside_line(m):
    """x beyond which a team-mate would be offside, as remembered: the second last opponent, the ball or the halfway line."""
    first, second = 0.0, 0.0
    for k in range(11, 22):
        if m.age[k] <= 40:
            x = m.px[k]
            if x > first:
                second = first
                first = x
            elif x > second:
                second = x
    return max(second, max(0.0, m.ball_x))
