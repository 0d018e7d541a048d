"""Kernels that write one command: turn, run, look, kick, pass, shoot, catch; all from a player's own memory.

``m`` is a MEMORY record, ``c`` a COMMAND record that these functions fill. Formulas: specification/simulator.md 4; the numbers of
the player's type and of the server stand in ``m``.
"""

from __future__ import annotations

import math

from ....simulator.pitch import HALF_LENGTH
from ....simulator.state import CommandKind
from . import kernel
from .memory import D2R, norm

PI = math.pi
NONE, DASH, TURN, KICK = int(CommandKind.NONE), int(CommandKind.DASH), int(CommandKind.TURN), int(CommandKind.KICK)
TACKLE, CATCH, MOVE = int(CommandKind.TACKLE), int(CommandKind.CATCH), int(CommandKind.MOVE)
NAN = float("nan")
GOAL_X = HALF_LENGTH
LONGEST = 40
"""Cycles for which the roll of the ball is looked ahead."""
NARROW, NORMAL = 1, 2
"""View widths: the narrow view comes every cycle, the normal one every second (specification/simulator.md 4.7)."""


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
    moment = norm(angle - m.body) / D2R * (1.0 + m.inertia * speed_of(m))
    c.kind = TURN
    c.a = min(m.moment_high, max(m.moment_low, moment))


@kernel
def thrifty(m, power):
    """`power`, less when stamina is short: below the threshold effort and recovery would suffer (specification/simulator.md 5)."""
    if m.stamina < 0.325 * m.stamina_max:
        return min(power, 25.0)
    if m.stamina < 0.45 * m.stamina_max:
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
    needed = (distance - speed_of(m) * m.decay) / m.dash_rate
    c.a = thrifty(m, max(10.0, min(power, needed)))
    c.b = 0.0
    return False


@kernel
def look_to(m, c, x, y):
    """Turn the neck so that the face points to (x, y), as far as it goes, after the body command in `c`."""
    body = m.body
    if c.kind == TURN:
        body = norm(body + c.a * D2R / (1.0 + m.inertia * speed_of(m)))
    wanted = norm(math.atan2(y - m.y, x - m.x) - body) / D2R
    c.turn_neck = min(m.neck_high, max(m.neck_low, wanted)) - m.neck / D2R


@kernel
def ball_distance(m):
    """Distance to the ball as remembered, m."""
    return math.sqrt((m.ball_x - m.x) ** 2 + (m.ball_y - m.y) ** 2)


@kernel
def kickable(m):
    """Whether the player believes that he can kick."""
    return m.ball_age <= 2 and ball_distance(m) <= m.sure


@kernel
def kick_velocity(m, c, vx, vy):
    """Kick so that the ball leaves with velocity (vx, vy), as nearly as one kick can."""
    ax, ay = vx - m.ball_vx, vy - m.ball_vy
    wanted = math.sqrt(ax * ax + ay * ay)
    dx, dy = m.ball_x - m.x, m.ball_y - m.y
    gap = math.sqrt(dx * dx + dy * dy) - m.contact
    aside = abs(norm(math.atan2(dy, dx) - m.body))
    rate = m.kick_rate * max(0.25, 1.0 - 0.25 * aside / PI - 0.25 * gap / m.margin)
    c.kind = KICK
    c.a = min(m.power, wanted / rate)
    c.b = norm(math.atan2(ay, ax) - m.body) / D2R


@kernel
def kick_to(m, c, x, y, speed):
    """Kick the ball towards (x, y) with an initial speed."""
    angle = math.atan2(y - m.ball_y, x - m.ball_x)
    kick_velocity(m, c, speed * math.cos(angle), speed * math.sin(angle))


@kernel
def pass_speed(m, distance, arriving):
    """Initial speed of a ball that still rolls with `arriving` m / cycle after `distance` metres."""
    return min(m.ball_speed, arriving + (1.0 - m.ball_decay) * distance)


@kernel
def ball_pace(m):
    """Speed of the ball, m / cycle."""
    return math.sqrt(m.ball_vx * m.ball_vx + m.ball_vy * m.ball_vy)


@kernel
def rolled(m, cycles):
    """(x, y) of the ball after so many cycles."""
    bx, by, vx, vy = m.ball_x, m.ball_y, m.ball_vx, m.ball_vy
    for _ in range(cycles):
        bx += vx
        by += vy
        vx *= m.ball_decay
        vy *= m.ball_decay
    return bx, by


@kernel
def earliest_meeting(m, x, y):
    """Cycles before which nobody at (x, y) can meet the ball even if it rolls straight at him: until then no root need be drawn."""
    return (math.sqrt((m.ball_x - x) ** 2 + (m.ball_y - y) ** 2) - m.near) / (m.stride + ball_pace(m)) - 1e-6


@kernel
def meets_by(m, x, y, delay, limit, slow, bx, by):
    """Whether somebody at (x, y), who loses `delay` cycles at first, meets the ball within `limit` cycles (less than LONGEST).

    slow : the ball is no faster than a runner, so who meets it once meets it at `limit` too, when it is at (bx, by): one comparison of
    squares, unless that is too close to call
    """
    if slow:
        reach = m.near + m.stride * max(0.0, limit - delay)
        squared = (bx - x) ** 2 + (by - y) ** 2
        if abs(squared - reach * reach) > 1e-6 * (1.0 + squared):
            return squared < reach * reach
    earliest = earliest_meeting(m, x, y)
    if earliest > limit:
        return False
    bx, by, vx, vy = m.ball_x, m.ball_y, m.ball_vx, m.ball_vy
    for t in range(limit + 1):
        if t >= earliest and math.sqrt((bx - x) ** 2 + (by - y) ** 2) - m.near <= m.stride * max(0.0, t - delay):
            return True
        bx += vx
        by += vy
        vx *= m.ball_decay
        vy *= m.ball_decay
    return False


@kernel
def cycles_to(m, x, y, delay, bx, by):
    """Cycles of a run from (x, y) to (bx, by)."""
    return int(delay + math.sqrt((bx - x) ** 2 + (by - y) ** 2) / m.stride)


@kernel
def intercept(m, x, y, delay):
    """(cycles, x, y): when and where somebody at (x, y), who loses `delay` cycles at first, meets the rolling ball."""
    bx, by, vx, vy = m.ball_x, m.ball_y, m.ball_vx, m.ball_vy
    earliest = earliest_meeting(m, x, y)
    for t in range(LONGEST):
        if t >= earliest:
            d = math.sqrt((bx - x) ** 2 + (by - y) ** 2) - m.near
            if d <= m.stride * max(0.0, t - delay):
                return t, bx, by
        bx += vx
        by += vy
        vx *= m.ball_decay
        vy *= m.ball_decay
    return cycles_to(m, x, y, delay, bx, by), bx, by


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
        room = across - 0.55 * time - m.near
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
