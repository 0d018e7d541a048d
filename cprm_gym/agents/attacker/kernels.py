"""Kernels that judge shots, passes and ways by the room that opponents leave, world by world.

The one question behind all of them: the ball rolls from here with this velocity; when does a player reach it, and how far off are the
opponents all that time? An opponent may be anywhere within ``wander`` metres for each cycle since he was seen, is carried on by his own
motion, loses ``rival_start`` cycles, more where he runs another way and must turn, and then runs at ``rival_pace``: *room* is what is
left, the least over cycles and opponents, metres; below 0 he gets there.
Metres, cycles, radians in the frame of the own team.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compilation import kernel_group

kernel = kernel_group()

LONGEST = 40
"""Cycles that are looked ahead."""
EMPTY = 20.0
"""Room where no opponent is near, m."""
RUNNING, AHEAD = 0.3, 0.9
"""m / cycle beyond which an opponent runs, and the cosine within which what he runs to is ahead of him."""
AT_BALL = 3.0
"""Cycles for which an opponent at the ball is believed to be there."""
OLDEST = 12.0
"""Cycles after which the place where an opponent may be grows no more."""
FORGOTTEN = 60.0
"""Cycles after which an opponent is no longer reckoned with."""
WAYS, PUSHES = 16, 6
"""Directions and speeds of a push that are tried."""
BACK = 4.0
"""Metres aside to which he goes who is offside and has no place to wait."""
SWERVES, PASSES = 4, 6
"""Directions on each side of the team-mate, and speeds, of a pass that are tried."""
ASIDE = 1.3
"""Metres beside a team-mate who is offside at which the ball passes him."""
AIMS = 13
"""Points of the goal that are tried."""


class Terms(NamedTuple):
    """What everything is judged by: of the server, the players and the behaviour."""

    decay: float
    ball_speed: float
    reach: float
    keeper_reach: float
    pace: float
    start: float
    inertia: float
    rival_pace: float
    rival_start: float
    rival_reach: float
    rival_turn: float
    carried: float
    wander: float
    mate_start: float
    safe: float
    enough: float
    progress: float
    kick_speed: float
    goal_x: float
    goal_half: float
    low_x: float
    side_x: float
    side_y: float
    ahead: float
    apart: float
    soft: float
    corner: float
    closer: float
    hold: float
    lazy: float
    legs: float
    contact: float
    margin: float
    spread: float
    still: float
    keeper: int
    offside: int


@kernel
def rolled(v0, t, c):
    """Metres that a ball rolls in t cycles."""
    return v0 * (1.0 - c.decay**t) / (1.0 - c.decay)


@kernel
def gap_at(x, y, t, rivals, age, c):
    """Room at a place in t cycles."""
    least = EMPTY
    for k in range(rivals.shape[0]):
        if age[k] > FORGOTTEN:
            continue
        reach = c.keeper_reach if k == c.keeper else c.rival_reach
        mx, my = rivals[k, 2], rivals[k, 3]
        dx, dy = x - rivals[k, 0] - c.carried * mx, y - rivals[k, 1] - c.carried * my
        d, late = math.hypot(dx, dy), c.rival_start
        run = math.hypot(mx, my)
        if run > RUNNING and d > 0.1:
            along = (dx * mx + dy * my) / (d * run)
            if along < AHEAD:
                late += c.rival_turn * (1.0 + AHEAD - along)
        d -= reach + c.wander * min(age[k], OLDEST) + c.rival_pace * max(0.0, t - late)
        if d < least:
            least = d
    return least


@kernel
def turning(angle, speed, c):
    """Cycles that a turn by an angle costs somebody at a speed."""
    off = abs(angle - 2.0 * math.pi * round(angle / (2.0 * math.pi)))
    if off < 0.25:
        return 0.0
    return max(1.0, off * (1.0 + c.inertia * speed) / math.pi)


@kernel
def race(x, y, vx, vy, px, py, start, body, speed, c):
    """(cycles, x, y): when and where somebody at (px, py) meets the ball at (x, y); `speed` below 0 for one whose body is not known."""
    for t in range(LONGEST + 1):
        d = math.hypot(x - px, y - py) - c.reach
        if d <= 0.0:
            return float(t), x, y
        late = start
        if speed >= 0.0:
            late += turning(math.atan2(y - py, x - px) - body, speed, c)
        if d <= c.pace * max(0.0, t - late):
            return float(t), x, y
        x += vx
        y += vy
        vx *= c.decay
        vy *= c.decay
    return LONGEST + (math.hypot(x - px, y - py) - c.reach) / c.pace, x, y


@kernel
def strength(ball, me, c):
    """m / cycle by which a kick can change the ball's velocity."""
    dx, dy = ball[0] - me[0], ball[1] - me[1]
    away = math.atan2(dy, dx) - me[4]
    away = abs(away - 2.0 * math.pi * round(away / (2.0 * math.pi))) / math.pi
    gap = min(1.0, max(0.0, (math.hypot(dx, dy) - c.contact) / c.margin))
    return c.kick_speed * (1.0 - 0.25 * away - 0.25 * gap)


@kernel
def attainable(ball, ux, uy, power):
    """(least, most) speed that a kick of that strength can give the ball in a direction; most below 0 where none."""
    along, aside = ball[2] * ux + ball[3] * uy, ball[3] * ux - ball[2] * uy
    rest = power * power - aside * aside
    if rest <= 0.0:
        return 0.0, -1.0
    return along - math.sqrt(rest), along + math.sqrt(rest)


@kernel
def shot(ball, power, rivals, age, c):
    """(y, speed, worth) of the best shot: its room, less a share of the way, and of what scatter may carry beside the goal."""
    best_y, best_speed, best = 0.0, 0.0, -1e9
    for k in range(AIMS):
        y = (2.0 * k / (AIMS - 1) - 1.0) * (c.goal_half - 0.5)
        dx, dy = c.goal_x + 0.3 - ball[0], y - ball[1]
        length = math.hypot(dx, dy)
        _, v0 = attainable(ball, dx / length, dy / length, power)
        v0 = min(v0, c.ball_speed)
        if dx < 0.5 or v0 < 1.0 or rolled(v0, LONGEST, c) < length:
            continue
        miss = max(0.0, c.spread * length - (c.goal_half - abs(y)) * dx / length)
        cost = c.closer * length + c.corner * miss + 0.01 * abs(y)
        room, s, v = EMPTY, 0.0, v0
        for t in range(1, LONGEST):
            s, v = s + v, v * c.decay
            if s > length:
                break
            room = min(room, gap_at(ball[0] + s * dx / length, ball[1] + s * dy / length, t, rivals, age, c))
            if min(room, c.enough) - cost <= best:
                break
        room = min(room, c.enough) - cost
        if room > best:
            best_y, best_speed, best = y, v0, room
    return best_y, best_speed, best


@kernel
def inside(x, y, c):
    """Whether a place is where is played, with a margin."""
    return c.low_x < x < c.side_x and abs(y) < c.side_y


@kernel
def goal_way(x, y, c):
    """Metres to the goal, more beside it, where the angle is narrow."""
    return math.hypot(c.goal_x - x, max(0.0, abs(y) - 4.0))


@kernel
def worth(gain, cycles, room, c):
    """What an action is worth: metres towards the goal in a cycle, less what is missing of the safe room, and a little for more."""
    value = c.progress * gain / (cycles + 3.0) + 0.15 * min(room, c.enough)
    if room < c.safe:
        value += room - c.safe
    return value


@kernel
def until_held(x, y, t, room, rivals, age, c):
    """Room, also for the ``hold`` cycles that whoever has met the ball at (x, y) after t cycles needs to play it on."""
    for more in range(1, int(c.hold) + 1):
        room = min(room, gap_at(x, y, t + more, rivals, age, c))
    return room


@kernel
def into_mate(ball, ux, uy, length, mates, mate_age, line, c):
    """Whether a ball that rolls so far meets a team-mate who is offside, and so may not touch it."""
    for m in range(mates.shape[0]):
        dx, dy = mates[m, 0] - ball[0], mates[m, 1] - ball[1]
        along = dx * ux + dy * uy
        if mate_age[m] <= OLDEST and mates[m, 0] > line and 0.0 < along < length + c.reach and abs(dx * uy - dy * ux) < ASIDE:
            return True
    return False


@kernel
def dribble(ball, me, mates, mate_age, line, power, rivals, age, c, out):
    """The best push: direction, speed, room, worth into out[0..3]."""
    out[3] = -1e9
    here, speed = goal_way(ball[0], ball[1], c), math.hypot(me[2], me[3])
    x0, y0 = me[0] + me[2], me[1] + me[3]
    for k in range(WAYS):
        angle = math.atan2(-0.6 * ball[1], c.goal_x - ball[0]) + 2.0 * math.pi * k / WAYS
        ux, uy = math.cos(angle), math.sin(angle)
        turn = turning(angle - me[4], speed * 0.4, c)
        low, high = attainable(ball, ux, uy, power)
        for j in range(PUSHES):
            v0 = 0.4 + 0.4 * j
            if not low <= v0 <= high:
                continue
            room, met, x, y, s, v = EMPTY, 0, 0.0, 0.0, 0.0, v0
            for t in range(1, LONGEST):
                s, v = s + v, v * c.decay
                x, y = ball[0] + s * ux, ball[1] + s * uy
                room = min(room, gap_at(x, y, t, rivals, age, c))
                if room - c.safe + c.progress + 0.15 * c.enough < out[3]:
                    break  # however much it gained, another push is worth more
                if math.hypot(x - x0, y - y0) - c.reach <= c.pace * max(0.0, t - 1.0 - turn - c.start):
                    met = t
                    break
            if met == 0 or not inside(x, y, c) or into_mate(ball, ux, uy, s, mates, mate_age, line, c):
                continue
            room = until_held(x, y, met, room, rivals, age, c)
            value = worth(here - goal_way(x, y, c), met, room, c) - (c.still if met <= 2 else 0.0)
            if value > out[3]:
                out[0], out[1], out[2], out[3] = angle, v0, room, value


@kernel
def give(ball, power, mates, mate_age, line, rivals, age, c, out):
    """The best pass: direction, speed, room, worth into out[0..3]; worth -1e9 where there is none."""
    out[0], out[1], out[2], out[3] = 0.0, 1.0, -EMPTY, -1e9
    here = goal_way(ball[0], ball[1], c)
    for m in range(mates.shape[0]):
        mx, my = mates[m, 0], mates[m, 1]
        away = math.hypot(mx - ball[0], my - ball[1])
        if mate_age[m] > FORGOTTEN or away < 4.0 or (mx > 0.0 and mx > line - 0.3):
            continue
        for k in range(-SWERVES, SWERVES + 1):
            angle = math.atan2(my - ball[1], mx - ball[0]) + 0.2 * k
            ux, uy = math.cos(angle), math.sin(angle)
            low, high = attainable(ball, ux, uy, power)
            for j in range(PASSES):
                v0 = 1.0 + 0.3 * j
                if not low <= v0 <= high:
                    continue
                room, met, x, y, s, v = EMPTY, 0, 0.0, 0.0, 0.0, v0
                for t in range(1, LONGEST):
                    s, v = s + v, v * c.decay
                    x, y = ball[0] + s * ux, ball[1] + s * uy
                    room = min(room, gap_at(x, y, t, rivals, age, c))
                    if room - c.safe + c.progress * v0 + 0.15 * c.enough < out[3]:
                        break
                    if math.hypot(x - mx, y - my) - c.reach <= c.pace * max(0.0, t - c.mate_start):
                        met = t
                        break
                if met == 0 or not inside(x, y, c):
                    continue
                room = until_held(x, y, met, room, rivals, age, c)
                value = worth(here - goal_way(x, y, c), met, room, c) - c.soft * v0 * c.decay**met
                if value > out[3]:
                    out[0], out[1], out[2], out[3] = angle, v0, room, value


@kernel
def support(ball_x, ball_y, me, line, rivals, age, c, out):
    """Where a pass from there could best be taken: x, y into out[0..1]; back and aside where all of it is offside."""
    best = -1e9
    out[0], out[1] = me[0], me[1]
    if me[0] > line:
        out[0], out[1] = line - 2.0, me[1] + (BACK if me[1] > ball_y else -BACK)
    for i in range(5):
        for k in range(-3, 4):
            x = ball_x + c.ahead + 4.0 * (i - 2)
            y = ball_y + c.apart * (1.0 if k > 0 else -1.0) * (0.5 + 0.25 * abs(k))
            if k == 0:
                x, y = me[0], me[1]
            if not inside(x, y, c) or (x > 0.0 and x > line - 1.0):
                continue
            length = max(0.1, math.hypot(x - ball_x, y - ball_y))
            if length < 5.0:
                continue
            cost = c.lazy * math.hypot(x - me[0], y - me[1]) + 0.04 * goal_way(x, y, c) + 0.03 * abs(length - c.apart)
            v0 = min(c.kick_speed, 0.8 + (1.0 - c.decay) * length)
            room, s, v = EMPTY, 0.0, v0
            for t in range(1, LONGEST):
                s, v = s + v, v * c.decay
                if s > length:
                    break
                room = min(room, gap_at(ball_x + s * (x - ball_x) / length, ball_y + s * (y - ball_y) / length, t, rivals, age, c))
                if min(room, c.enough) - cost <= best:
                    break
            value = min(room, c.enough) - cost
            if value > best:
                best = value
                out[0], out[1] = x, y


@kernel
def judge(ball, me, mates, mate_age, rivals, age, near, c, out):
    """Everything that an attacker decides by, for every world.

    ball : (N, 4) x, y, vx, vy; me : (N, 5) x, y, vx, vy, body; mates : (N, M, 2); mate_age : (N, M) cycles; rivals : (N, O, 4) x, y and
    how far he went in the last cycle; age : (N, O); near : metres from the ball within which shots, passes and pushes are judged;
    out : (N, 19), see `percepts.NAMES`
    """
    for n in range(ball.shape[0]):
        b, p, o = ball[n], me[n], out[n]
        first, second = 0.0, 0.0
        for k in range(rivals.shape[1]):
            if age[n, k] <= FORGOTTEN:
                x = rivals[n, k, 0]
                if x > first:
                    first, second = x, first
                elif x > second:
                    second = x
        line = max(second, max(0.0, b[0])) if c.offside else 2.0 * c.goal_x
        o[0], o[1], o[2] = race(b[0], b[1], b[2], b[3], p[0], p[1], c.start, p[4], math.hypot(p[2], p[3]), c)
        o[3], meet_x, meet_y = 99.0, b[0], b[1]
        for m in range(mates.shape[1]):
            if mate_age[n, m] <= FORGOTTEN:
                t, x, y = race(b[0], b[1], b[2], b[3], mates[n, m, 0], mates[n, m, 1], c.start, 0.0, -1.0, c)
                if t < o[3]:
                    o[3], meet_x, meet_y = t, x, y
        o[4], o[5] = p[0], p[1]
        if o[0] > o[3] or p[0] > line - 0.5:
            support(meet_x, meet_y, p, line, rivals[n], age[n], c, o[4:6])
        o[6], o[7], o[18] = 0.0, -EMPTY, 0.0
        o[8], o[9], o[10], o[11] = 0.0, 1.0, -EMPTY, -1e9
        o[12], o[13], o[14], o[15] = 0.0, 1.0, -EMPTY, -1e9
        o[16], o[17] = 0.0, line
        for k in range(rivals.shape[1]):
            if age[n, k] <= AT_BALL and math.hypot(b[0] - rivals[n, k, 0], b[1] - rivals[n, k, 1]) < c.legs:
                o[16] = 1.0
        if math.hypot(b[0] - p[0], b[1] - p[1]) < near:
            power = strength(b, p, c)
            o[6], o[18], o[7] = shot(b, power, rivals[n], age[n], c)
            dribble(b, p, mates[n], mate_age[n], line, power, rivals[n], age[n], c, o[8:12])
            give(b, power, mates[n], mate_age[n], line, rivals[n], age[n], c, o[12:16])
