"""Kernels that turn percepts into a picture of the pitch: where am I, where is the ball, where are the others.

Frame: that of the own team (x towards the opponent's goal, y to its right hand), metres and radians. Players are numbered own team
0..10, opponents 11..21.
"""

from __future__ import annotations

import math

import numpy as np

from ....simulator.kernels.landmark_sight import glance_at_landmarks, lines_in_view, told_line_direction
from ....simulator.kernels.senses import lowest_bit, message_of_arrays
from ....simulator.landmarks import LANDMARK_POSITIONS
from ....simulator.player_types import (
    T_DASH_POWER_RATE,
    T_INERTIA_MOMENT,
    T_KICK_POWER_RATE,
    T_KICKABLE_MARGIN,
    T_PLAYER_DECAY,
    T_PLAYER_SIZE,
    T_PLAYER_SPEED_MAX,
)
from ....simulator.senses import BodyColumn
from ....simulator.state import CommandKind
from ...kernels.bearings import bearing, turned
from . import kernel

PI = math.pi
NEVER = 1000
"""Age of what was never seen, cycles."""
MARKS = np.ascontiguousarray(LANDMARK_POSITIONS)
N_MARKS = len(MARKS)
PLAYERS = 22
STAMINA, EFFORT = int(BodyColumn.STAMINA), int(BodyColumn.EFFORT)
SPEED, SPEED_DIRECTION = int(BodyColumn.SPEED), int(BodyColumn.SPEED_DIRECTION)
HEAD, TACKLED, CHARGED = int(BodyColumn.HEAD_ANGLE), int(BodyColumn.TACKLE_EXPIRES), int(BodyColumn.FOUL_CHARGED)
TURN, KICK = int(CommandKind.TURN), int(CommandKind.KICK)
D2R = PI / 180.0
NOWHERE = 200.0
"""Distance that stands for that of somebody who was never seen, m: farther than two players can be apart."""
SURE = 0.85
"""Share of the kickable ring within which the ball is kickable however the eye errs."""
NEAR = 0.593
"""Share of it at which somebody who runs meets the ball."""
STRIDE = 0.95
"""Share of his top speed that a running player makes in a cycle."""
CATCH_SLACK = 0.05
"""Metres less than the catchable area is long at which a goalie catches."""
LINE_NORMAL = np.array([0.0, PI, 0.0, -0.5 * PI, 0.5 * PI])
"""Outward direction of no line, left, right, top, bottom, as seen from inside, in the server's frame."""


@kernel
def norm(a):
    """An angle in (-pi, pi]."""
    return a - 2.0 * PI * math.ceil((a - PI) / (2.0 * PI))


@kernel
def embody(m, p, kind):
    """What follows for a player of type `kind` from the parameters."""
    m.kind = kind + 1
    m.size, m.margin = p.types[kind, T_PLAYER_SIZE], p.types[kind, T_KICKABLE_MARGIN]
    m.contact = m.size + p.ball_size
    m.reach = m.contact + m.margin
    m.sure = m.contact + SURE * m.margin
    m.near = m.contact + NEAR * m.margin
    m.kick_rate, m.power = p.types[kind, T_KICK_POWER_RATE], p.maxpower
    m.decay, m.inertia = p.types[kind, T_PLAYER_DECAY], p.types[kind, T_INERTIA_MOMENT]
    m.dash_rate = p.types[kind, T_DASH_POWER_RATE]
    m.stride = STRIDE * min(p.types[kind, T_PLAYER_SPEED_MAX], p.max_dash_power * m.dash_rate / (1.0 - m.decay))
    m.stamina_max = p.stamina_max
    m.catch_reach = max(m.contact, p.catchable_area_l - CATCH_SLACK)
    m.ball_decay, m.ball_speed, m.ball_accel = p.ball_decay, p.ball_speed_max, p.ball_accel_max
    m.goal_half = 0.5 * p.goal_width
    m.moment_low, m.moment_high, m.neck_low, m.neck_high = p.minmoment, p.maxmoment, p.minneckang, p.maxneckang
    m.tackle_dist, m.tackle_width, m.tackle_exponent = p.tackle_dist, p.tackle_width, p.tackle_exponent


@kernel
def embody_all(memory, packed):
    """The same for the default type, for every player of every world."""
    for n in range(memory.shape[0]):
        for i in range(PLAYERS):
            embody(memory[n, i], packed[0], 0)


@kernel
def localise(m, side, marks, seen, line, direction):
    """Face and position from the line ahead and the landmarks in view; False when there is too little to see.

    marks : (55, 4) distance, direction; seen : which of them are in view, as bits; line : the only one in view, or 0; direction : its own

    The face comes from the direction of a line (half a degree), or else from the two most distant landmarks; the position is the
    mean of what each landmark says, weighted by the inverse square of its distance (the eye's error grows with it).
    """
    if line > 0:
        s = direction - 0.5 * PI if direction > 0.0 else direction + 0.5 * PI
        face = norm(LINE_NORMAL[line] - s + (PI if side < 0 else 0.0))
    else:
        known, face = face_from_marks(m, side, marks, seen)
        if not known:
            return False
    # summed in the frame of the eye and turned once, not landmark by landmark
    total, x, y, ahead, aside = 0.0, 0.0, 0.0, 0.0, 0.0
    while seen:
        k = lowest_bit(seen)
        seen &= seen - 1
        distance = marks[k, 0]
        weight = 1.0 / (0.05 + distance * distance)
        cosine, sine = bearing(marks[k, 1])
        x += weight * MARKS[k, 0]
        y += weight * MARKS[k, 1]
        ahead += weight * distance * cosine
        aside += weight * distance * sine
        total += weight
    m.face = face
    if total == 0.0:
        return False
    cosine, sine = bearing(face)
    m.x = (side * x - (ahead * cosine - aside * sine)) / total
    m.y = (side * y - (ahead * sine + aside * cosine)) / total
    return True


@kernel
def face_from_marks(m, side, marks, seen):
    """(found, face) from the pair of landmarks in view that subtends the largest angle."""
    first, last = -1, -1
    while seen:
        k = lowest_bit(seen)
        seen &= seen - 1
        if first < 0 or marks[k, 1] < marks[first, 1]:
            first = k
        if last < 0 or marks[k, 1] > marks[last, 1]:
            last = k
    if first < 0 or marks[last, 1] - marks[first, 1] < 0.1:
        return False, m.face
    # the vector from one to the other, in the frame of the eye and in that of the pitch
    last_x, last_y = bearing(marks[last, 1])
    first_x, first_y = bearing(marks[first, 1])
    ex = marks[last, 0] * last_x - marks[first, 0] * first_x
    ey = marks[last, 0] * last_y - marks[first, 0] * first_y
    px = side * (MARKS[last, 0] - MARKS[first, 0])
    py = side * (MARKS[last, 1] - MARKS[first, 1])
    return True, norm(math.atan2(py, px) - math.atan2(ey, ex))


@kernel
def own_kick(m, sent):
    """What the own kick did to the ball's velocity (specification/simulator.md 4.2, own type), if it was in reach as remembered."""
    dx, dy = m.ball_x - m.x, m.ball_y - m.y
    distance = math.sqrt(dx * dx + dy * dy)
    if m.ball_age > 2 or distance > m.reach:
        return
    aside = abs(norm(math.atan2(dy, dx) - m.body))
    rate = m.kick_rate * max(0.0, 1.0 - 0.25 * aside / PI - 0.25 * (distance - m.contact) / m.margin)
    angle = m.body + sent.b * D2R
    push = min(m.ball_accel, rate * min(m.power, max(0.0, sent.a)))
    m.ball_vx += push * math.cos(angle)
    m.ball_vy += push * math.sin(angle)


@kernel
def predict(m, body, sent):
    """Carry the picture on by one cycle: own turn and way, the ball's roll, everybody's age."""
    before = m.body
    if sent.kind == KICK and m.free:
        own_kick(m, sent)
    if sent.kind == TURN and m.free:
        moment = min(m.moment_high, max(m.moment_low, sent.a)) * D2R
        before = norm(before + moment / (1.0 + m.inertia * math.sqrt(m.vx * m.vx + m.vy * m.vy)))
    m.body = before
    m.neck = body[HEAD]
    m.face = norm(m.body + m.neck)
    m.stamina, m.effort = body[STAMINA], body[EFFORT]
    m.free = body[TACKLED] <= 0.0 and body[CHARGED] <= 0.0
    move(m, body)
    # the speed told is what is left after the decay; the way of the cycle was longer
    if m.decay > 0.0:
        m.x += m.vx / m.decay
        m.y += m.vy / m.decay
    m.ball_x += m.ball_vx
    m.ball_y += m.ball_vy
    m.ball_vx *= m.ball_decay
    m.ball_vy *= m.ball_decay
    m.ball_age = min(NEVER, m.ball_age + 1)
    for j in range(PLAYERS):
        m.age[j] = min(NEVER, m.age[j] + 1)


@kernel
def move(m, body):
    """The own velocity as it was just told; (cosine, sine) of the face."""
    face_x, face_y = bearing(m.face)
    cosine, sine = turned(face_x, face_y, body[SPEED_DIRECTION])
    m.vx, m.vy = body[SPEED] * cosine, body[SPEED] * sine
    return face_x, face_y


@kernel
def take_ball(m, face_x, face_y, row, level):
    """The ball as it was just seen: its place, and its velocity from the changes or from the place before."""
    cosine, sine = turned(face_x, face_y, row[1])
    x, y = m.x + row[0] * cosine, m.y + row[0] * sine
    if level >= 3:
        along, across = row[2], row[3] * row[0]
        m.ball_vx = m.vx + along * cosine - across * sine
        m.ball_vy = m.vy + along * sine + across * cosine
    elif m.ball_age <= 3:
        # predicted place minus seen place corrects the velocity, carefully: both are noisy
        m.ball_vx += 0.3 * (x - m.ball_x)
        m.ball_vy += 0.3 * (y - m.ball_y)
    else:
        m.ball_vx, m.ball_vy = 0.0, 0.0
    speed = math.sqrt(m.ball_vx * m.ball_vx + m.ball_vy * m.ball_vy)
    if speed > m.ball_speed:
        m.ball_vx *= m.ball_speed / speed
        m.ball_vy *= m.ball_speed / speed
    m.ball_x, m.ball_y, m.ball_age = x, y, 0


@kernel
def own_number(j, side):
    """Index in memory (own team first) of the player that stands at index `j` of the see arrays."""
    return j if side > 0 else (j + 11) % PLAYERS


@kernel
def take_players(m, me, side, face_x, face_y, rows, levels):
    """The players as they were just seen; the unknown ones are matched with the nearest remembered one that they could be."""
    nameless = np.int64(0)
    for j in range(PLAYERS):
        if levels[j] == 3:
            x, y = place_of(m, face_x, face_y, rows[j])
            note_player(m, own_number(j, side), x, y)
        nameless |= np.int64(levels[j] == 1 or levels[j] == 2) << j
    while nameless:
        j = lowest_bit(nameless)
        nameless &= nameless - 1
        x, y = place_of(m, face_x, face_y, rows[j])
        low, high = 0, PLAYERS
        if levels[j] == 2:
            low = 0 if own_number(j, side) < 11 else 11
            high = low + 11
        best, gap = nearest_remembered(m, me, low, high, x, y)
        if best >= 0 and (levels[j] == 2 or gap < 100.0):
            note_player(m, best, x, y)


@kernel
def nearest_remembered(m, me, low, high, x, y):
    """(player, distance) of the player from `low` to `high` - 1 who could stand at (x, y) and was last seen nearest to it; -1: nobody.

    Squares are compared, without branches that depend on who stands where; of those never seen, who could be anywhere, the first one is
    taken when there is nobody else.
    """
    best, least, never = -1, 1e18, -1
    for k in range(low, high):
        age = m.age[k]
        dx, dy = m.px[k] - x, m.py[k] - y
        squared = dx * dx + dy * dy
        reach = 3.0 + 1.1 * age
        nearer = (age > 0) & (age < NEVER) & (k != me) & (squared <= reach * reach) & (squared < least)
        best, least = (k, squared) if nearer else (best, least)
        never = k if (never < 0) & (age >= NEVER) & (k != me) else never
    if best < 0:
        return never, NOWHERE
    return best, math.sqrt(least)


@kernel
def place_of(m, face_x, face_y, row):
    """(x, y) at the distance and direction of `row`."""
    cosine, sine = turned(face_x, face_y, row[1])
    return m.x + row[0] * cosine, m.y + row[0] * sine


@kernel
def note_player(m, k, x, y):
    """Player `k` was just seen at (x, y)."""
    m.px[k], m.py[k], m.age[k] = x, y, 0


@kernel
def in_view(levels):
    """The landmarks seen, as bits, from their levels (55,)."""
    seen = np.int64(0)
    for k in range(N_MARKS):
        seen |= np.int64(levels[k] >= 2) << k
    return seen


@kernel
def only_line(first, second):
    """The line by which the face can be told: the first in view, if it is the only one; 0 for none."""
    return first if second == 0 else 0


@kernel
def glance(w, p, m, i, side, sight, marks):
    """`localise` from the world itself: only the landmarks of this one message, only what is needed of them.

    sight : (3, 55) and marks : (55, 4), to be overwritten
    """
    protocol, tick = message_of_arrays(w, i)
    seen = glance_at_landmarks(w, p, i, protocol, tick, sight, marks)
    first, second = lines_in_view(w, i)
    line = only_line(first, second)
    return localise(m, side, marks, seen, line, told_line_direction(w, i, line, protocol) if line > 0 else 0.0)


@kernel
def update(
    worlds, packed, chosen, memory, sent, active, fresh, ball, ball_level, players, players_level, body, told, sight, marks,
    mark_levels, lines, line_ids,
):  # fmt: skip
    """One cycle of everybody's memory in the chosen worlds; row c of the senses, `fresh` to `body`, is world ``chosen[c]``.

    memory : (W, 22) MEMORY; sent : (W, 22) COMMAND of the cycle before; active : (22,) whose memory is kept; told : the landmarks are
    those of the arrays, row c too, that messages filled; otherwise they are looked at here; sight : (3, 55) and the first row of `marks`
    are then overwritten
    """
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for i in range(PLAYERS):
            if not active[i] or not w.enabled[i]:
                continue
            m = memory[n, i]
            side = 1.0 if i < 11 else -1.0
            me = i % 11
            if m.kind != w.type[i] + 1:
                embody(m, packed[0], w.type[i])
            predict(m, body[c, i], sent[n, i])
            if fresh[c, i]:
                if told:
                    line = only_line(line_ids[c, i, 0], line_ids[c, i, 1])
                    found = localise(m, side, marks[c, i], in_view(mark_levels[c, i]), line, lines[c, i, 0, 1])
                else:
                    found = glance(w, packed[0], m, i, side, sight, marks[0, 0])
                if found:
                    m.located = 1
                m.body = norm(m.face - m.neck)
                face_x, face_y = move(m, body[c, i])
                if ball_level[c, i] > 0:
                    take_ball(m, face_x, face_y, ball[c, i], ball_level[c, i])
                take_players(m, me, side, face_x, face_y, players[c, i], players_level[c, i])
                m.looks += 1
            m.px[me], m.py[me], m.age[me] = m.x, m.y, 0


@kernel
def know(worlds, packed, chosen, memory, active):
    """The truth in everybody's memory, in the own team's frame."""
    for c in range(chosen.shape[0]):
        n = chosen[c]
        w = worlds[n]
        for i in range(PLAYERS):
            if not active[i] or not w.enabled[i]:
                continue
            m = memory[n, i]
            side = 1.0 if i < 11 else -1.0
            if m.kind != w.type[i] + 1:
                embody(m, packed[0], w.type[i])
            turned = 0.0 if side > 0 else PI
            m.x, m.y = side * w.pos[i + 1, 0], side * w.pos[i + 1, 1]
            m.vx, m.vy = side * w.vel[i + 1, 0], side * w.vel[i + 1, 1]
            m.body, m.neck = norm(w.body[i] + turned), w.neck[i]
            m.face = norm(m.body + m.neck)
            m.stamina, m.effort, m.located = w.stamina[i], w.effort[i], 1
            m.looks += 1
            m.free = w.tackle_cycles[i] <= 0 and w.foul_cycles[i] <= 0
            m.ball_x, m.ball_y = side * w.pos[0, 0], side * w.pos[0, 1]
            m.ball_vx, m.ball_vy, m.ball_age = side * w.vel[0, 0], side * w.vel[0, 1], 0
            for j in range(PLAYERS):
                k = own_number(j, side)
                if w.enabled[j]:
                    m.px[k], m.py[k], m.age[k] = side * w.pos[j + 1, 0], side * w.pos[j + 1, 1], 0
                else:
                    m.age[k] = NEVER


@kernel
def forget(memory, chosen):
    """The empty memory of the players of the chosen worlds."""
    for c in range(chosen.shape[0]):
        for i in range(PLAYERS):
            m = memory[chosen[c], i]
            m.located = 0
            m.free = 1
            m.x, m.y, m.vx, m.vy = -20.0, 0.0, 0.0, 0.0
            m.body, m.neck, m.face = 0.0, 0.0, 0.0
            m.stamina, m.effort = m.stamina_max, 1.0
            m.ball_x, m.ball_y, m.ball_vx, m.ball_vy = 0.0, 0.0, 0.0, 0.0
            m.ball_age = NEVER
            m.looks += 1
            m.search = 0
            m.taker = 0
            m.kicker, m.kicked = 0, 0
            m.clock = 0
            for j in range(PLAYERS):
                m.px[j], m.py[j] = 0.0, 0.0
                m.age[j] = NEVER
