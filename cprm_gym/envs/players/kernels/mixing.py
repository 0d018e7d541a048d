"""Kernels of the players who mix: what they have in mind is hidden, lasts for a while, and leads to what comes next.

``t`` is an INTENT record (`players.mixing`): the mode, the cycles that it still lasts, the side of the last feint. With the ball the mode
decides; without it those of a small team get open for a pass; everything else is what the strong team does (`team.play`).
"""

from __future__ import annotations

import math

from . import kernel
from .keepers import openness
from .motion import GOAL_X, clear, kick_to, kickable, lane, look_to, nearest_opponent, pass_speed, run_to, turn_to
from .team import COMBINES, LOST, PLAYING, best_shot, dribble, play, rank_to_ball, situation

DRIBBLE, FEINT, PASS, SHOOT = 0, 1, 2, 3
ASIDE = 1.15
"""Radians from the way to the goal at which a feint moves the ball."""
STROLL = 0.75
"""Speed of the ball in a feint, and while a team-mate is looked for, m / cycle."""
CORNER = 0.9
"""Metres from the post at which a shot is aimed after a feint to the other side."""
ARRIVING = 0.9
"""Speed at which a pass should arrive, m / cycle."""
PRESSED = 2.5
"""Metres from the next opponent at which he passes, if he can and does not mean to shoot."""
NEAREST, FARTHEST = 5.0, 30.0
"""Metres of a pass."""
LONG_AGO, SIDEWAYS = 60, 1.4
"""Cycles after which nobody is where he was; radians from the body at which he is looked for."""
BEHIND = 0.5
"""What a metre behind the ball costs, against the room of a place."""
GOAL_LINE_GAP, TOUCH = 5.0, 22.0
"""Metres before the goal line, and from the middle, within which they get open."""
LUCK = 4
"""Numbers in [0, 1) that a player needs per cycle: link, mode, duration, side."""


@kernel
def following(mode):
    """What a mode leads to: a dribble to a feint, a feint to a shot, a pass or a shot to a dribble."""
    if mode == DRIBBLE:
        return FEINT
    if mode == FEINT:
        return SHOOT
    return DRIBBLE


@kernel
def intend(t, luck, bounds, shortest, longest, link):
    """One cycle of what a player has in mind; when its time is over another mode is drawn.

    luck : (LUCK,) in [0, 1); bounds : (4,) cumulated shares of the modes; shortest, longest : cycles; link : probability that the next
    mode is what the last one leads to
    """
    t.cycles -= 1
    if t.cycles > 0:
        return
    if t.begun and luck[0] < link:
        mode = following(t.mode)
    else:
        mode = 0
        while mode < SHOOT and luck[1] >= bounds[mode]:
            mode += 1
    if mode == FEINT:
        t.side = 1 if luck[3] < 0.5 else -1
    elif mode != SHOOT:
        t.side = 0
    t.mode, t.begun = mode, 1
    t.cycles = shortest + int(luck[2] * (longest - shortest + 1))


@kernel
def open_mate(m, me, count):
    """The team-mate with the clearest way for a pass, nearer to the goal rather; -1 if there is none."""
    best, best_value = -1, -1e9
    for k in range(count):
        if k == me or m.age[k] > 10:
            continue
        dx, dy = m.px[k] - m.ball_x, m.py[k] - m.ball_y
        distance = math.sqrt(dx * dx + dy * dy)
        if distance < NEAREST or distance > FARTHEST:
            continue
        room = lane(m, m.px[k], m.py[k], pass_speed(m, distance, ARRIVING))
        value = min(room, 4.0) + 0.1 * dx + 0.3 * min(nearest_opponent(m, m.px[k], m.py[k]), 6.0)
        if room > 0.0 and value > best_value:
            best, best_value = k, value
    return best


@kernel
def with_ball(m, c, t, me, count, reach, close, pace):
    """The ball can be kicked: what he has in mind, as far as it can be done; near the goal he shoots whatever it was.

    reach, close : metres from the goal within which he shoots if he means to, and in any case; pace : share of the ball's top speed
    """
    to_goal = math.sqrt((GOAL_X - m.ball_x) ** 2 + m.ball_y**2)
    if to_goal < close or (t.mode == SHOOT and to_goal < reach):
        y, _ = best_shot(m)
        if t.side != 0:
            y = -t.side * (m.goal_half - CORNER)
        kick_to(m, c, GOAL_X + 1.0, y, pace * m.ball_speed)
        return
    pressed = t.mode != SHOOT and nearest_opponent(m, m.x, m.y) < PRESSED
    if t.mode == PASS or pressed:
        k = open_mate(m, me, count)
        if k >= 0:
            distance = math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2)
            kick_to(m, c, m.px[k], m.py[k], pass_speed(m, distance, ARRIVING))
            return
        if not pressed:
            # close at the feet until somebody is found to pass to
            kick_to(m, c, GOAL_X, 0.5 * m.ball_y, STROLL)
            return
    if t.mode == FEINT:
        # the ball goes aside, and the goalie with it; the shot that follows goes to the other corner
        angle = math.atan2(-m.ball_y, GOAL_X - m.ball_x) + t.side * ASIDE
        kick_to(m, c, m.ball_x + 10.0 * math.cos(angle), m.ball_y + 10.0 * math.sin(angle), STROLL)
        return
    dribble(m, c, 2)


@kernel
def glance(m, c, me, count):
    """Look to the team-mate who was not seen for longest, the ball being felt at the feet; to either side for one who never was."""
    oldest, age = -1, 2
    for k in range(count):
        if k != me and m.age[k] > age:
            oldest, age = k, m.age[k]
    if oldest < 0:
        look_to(m, c, m.ball_x, m.ball_y)
    elif age < LONG_AGO:
        look_to(m, c, m.px[oldest], m.py[oldest])
    else:
        side = m.body + (SIDEWAYS if m.clock % 8 < 4 else -SIDEWAYS)
        look_to(m, c, m.x + 10.0 * math.cos(side), m.y + 10.0 * math.sin(side))


@kernel
def get_open(m, c, me, count):
    """Without the ball: to the place beside or before it to which it could best be passed."""
    best_x, best_y, best = m.x, m.y, -1e9
    for k in range(9):
        x, y = m.x, m.y
        if k > 0:
            ahead, aside = 6.0 * ((k - 1) // 4), (7.0, 12.0, -7.0, -12.0)[(k - 1) % 4]
            x, y = m.ball_x + ahead, m.ball_y + aside
        x, y = min(GOAL_X - GOAL_LINE_GAP, x), min(TOUCH, max(-TOUCH, y))
        value = openness(m, me, count, x, y) - 0.15 * math.sqrt((x - m.x) ** 2 + (y - m.y) ** 2) - BEHIND * max(0.0, m.ball_x - x)
        if value > best:
            best_x, best_y, best = x, y, value
    if run_to(m, c, best_x, best_y, 80.0, 1.5):
        turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def act(
    worlds, memory, intents, players, counts, formation, luck, bounds, shortest, longest, link, reach, close, pace, fresh, commands,
):  # fmt: skip
    """Commands of the mixing players of every world.

    intents : (W, 22) INTENT; players : (P,) rows 0..21; luck : (W, P, LUCK) in [0, 1); commands : (W, 22) COMMAND; the rest as above
    """
    for n in range(worlds.shape[0]):
        w = worlds[n]
        for p in range(players.shape[0]):
            i = players[p]
            if not w.enabled[i]:
                continue
            m, t, c = memory[n, i], intents[n, i], commands[n, i]
            m.left = 1 if i < 11 else 0
            me, count = i % 11, counts[0] if i < 11 else counts[1]
            intend(t, luck[n, p], bounds, shortest, longest, link)
            play(w, m, c, me, count, 2, w.goalie[i] == 1, formation, fresh[n, i])
            if situation(w.mode, m.left == 1) != PLAYING or w.goalie[i] == 1 or not m.free or m.taker > 0 or m.ball_age > LOST:
                continue
            if kickable(m):
                clear(c)
                with_ball(m, c, t, me, count, reach, close, pace)
                if t.mode == PASS or t.mode == DRIBBLE:
                    glance(m, c, me, count)
                else:
                    look_to(m, c, m.ball_x, m.ball_y)
            elif count <= COMBINES and rank_to_ball(m, me, count) > 0:
                clear(c)
                get_open(m, c, me, count)
