"""Kernels of the scripted team: what each player does in each situation, from his own memory.

Strength 0 runs straight at the ball and kicks it forward; 1 meets the ball, passes and shoots; 2 also dribbles around opponents,
picks the corner of the goal and tackles. With more than five players 2 also moves its back line up, sends its forwards behind the
other one and passes into their runs; all of them judge the offside line from memory, and so are caught offside now and then.
"""

from __future__ import annotations

import math

from ....simulator.state import CommandKind, PlayMode
from . import kernel
from .memory import D2R, NEVER, PLAYERS, norm
from .motion import (
    GOAL_X,
    LONGEST,
    ball_distance,
    ball_pace,
    chase,
    clear,
    cycles_to,
    intercept,
    kick_to,
    kickable,
    lane,
    look_to,
    meets_by,
    nearest_opponent,
    offside_line,
    pass_speed,
    rolled,
    run_to,
    search,
    turn_to,
)

PI = math.pi
MOVE, CATCH, TACKLE = int(CommandKind.MOVE), int(CommandKind.CATCH), int(CommandKind.TACKLE)
BEFORE, PLAY_ON, TIME_OVER = int(PlayMode.before_kick_off), int(PlayMode.play_on), int(PlayMode.time_over)
GOAL_L, GOAL_R, DROP = int(PlayMode.goal_l), int(PlayMode.goal_r), int(PlayMode.drop_ball)
KICK_OFF_L, GOAL_KICK_R = int(PlayMode.kick_off_l), int(PlayMode.goal_kick_r)
INDIRECT_L, INDIRECT_R = int(PlayMode.indirect_free_kick_l), int(PlayMode.indirect_free_kick_r)
GOAL_KICK_L = int(PlayMode.goal_kick_l)
WAITING, PLAYING, OURS, THEIRS, DEAD = 0, 1, 2, 3, 4
BACK = -30.0
"""x in the formation up to which a player is one of the back line, m."""
HIGH_LINE, LINE_GAP = -4.0, 18.0
"""How far up the back line of a strong team goes, and how far behind the ball it stays, m."""
FORWARD = -12.0
"""x in the formation from which on a player is a forward, m."""
BENEFIT = 2.5
"""Metres beyond the remembered offside line up to which a team-mate is still thought to be onside."""
PATIENCE = 40
"""Cycles after a set play of a small team in which the ball may still come; then it is not the kicker's, however near he is."""
AT_BALL = 2.0
"""Metres from the ball at which somebody is about to take a set play."""
COMBINES = 5
"""More players than these make a strong team combine: runs, through passes, a back line that moves up."""
PERIOD, RUN = 45, 27
"""A forward whose team has the ball runs behind the defence for the first 27 of every 45 cycles, and waits before it for the others."""
FAR = 0.9
"""Share of the ball's top speed of a kick that clears."""
LOST = 6
"""Cycles without seeing the ball after which it is searched for."""


@kernel
def situation(mode, left):
    """Which of waiting, playing, our kick, their kick or a stoppage the play mode means for a side."""
    if mode == BEFORE or mode == GOAL_L or mode == GOAL_R:
        return WAITING
    if mode == PLAY_ON or mode == DROP:
        return PLAYING
    if KICK_OFF_L <= mode <= GOAL_KICK_R or mode == INDIRECT_L or mode == INDIRECT_R:
        return OURS if (mode % 2 == 0) == left else THEIRS
    return DEAD


@kernel
def note_kicker(m, me, count, state):
    """Remember who of a small team takes a set play: he may not touch the ball again before somebody else has.

    In a large one somebody else is at the ball within the time for which the kicker leaves it alone.
    """
    if count > COMBINES or m.ball_age > LOST:
        return
    if state == OURS:
        best, gap = -1, AT_BALL
        for k in range(count):
            d = math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2)
            if m.age[k] <= 20 and d < gap:
                best, gap = k, d
        if best < 0 and count == 2:
            # too far off to be seen, but who else
            best = 1 - me
        m.kicker, m.kicked = best + 1, m.clock
    elif state != PLAYING:
        m.kicker = 0
    elif m.kicker > 0:
        for k in range(PLAYERS):
            # rows of numbers that nobody has hold team-mates who were seen without theirs: the kicker, perhaps
            if count <= k < PLAYERS // 2:
                continue
            if k != m.kicker - 1 and m.age[k] <= 2 and (m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2 < m.reach**2:
                m.kicker = 0
                return


@kernel
def rank_to_ball(m, me, count):
    """How many team-mates are believed to meet the ball before the player does."""
    own, _, _ = intercept(m, m.x, m.y, 0.5)
    slow = ball_pace(m) <= m.stride
    last = min(own, LONGEST)
    sooner, later = rolled(m, last - 1), rolled(m, last)
    before = 0
    for k in range(count):
        if k != me and m.age[k] <= 20 and (k != m.kicker - 1 or m.clock - m.kicked <= PATIENCE):
            x, y = m.px[k], m.py[k]
            # at equal times the lower number goes
            if own < LONGEST and k < me:
                first = meets_by(m, x, y, 0.5, own, slow, later[0], later[1])
            else:
                first = last > 0 and meets_by(m, x, y, 0.5, last - 1, slow, sooner[0], sooner[1])
            if not first and own >= LONGEST:
                first = cycles_to(m, x, y, 0.5, later[0], later[1]) < own + (k < me)
            if first:
                before += 1
    return before


@kernel
def home(m, formation, me, attack, onside):
    """(x, y): the player's place in the formation, shifted with the ball, behind the offside line if `onside`."""
    fx, fy = formation[me, 0], formation[me, 1]
    bx, by = (m.ball_x, m.ball_y) if m.ball_age < NEVER else (0.0, 0.0)
    x = fx + 0.55 * (bx + 10.0) + attack
    y = fy * 0.85 + 0.35 * by
    deepest = -46.0 if fx < -30.0 else -38.0
    if onside:
        x = min(x, max(offside_line(m) - 1.0, deepest))
    return min(44.0, max(deepest, x)), min(32.0, max(-32.0, y))


@kernel
def best_pass(m, me, count, strength):
    """(player, score) of the best team-mate to pass to; player -1 if there is none worth it."""
    best, best_score = -1, 0.0
    line = offside_line(m)
    for k in range(count):
        if k == me or m.age[k] > 8:
            continue
        dx, dy = m.px[k] - m.ball_x, m.py[k] - m.ball_y
        distance = math.sqrt(dx * dx + dy * dy)
        if distance < 4.0 or distance > 30.0 or (strength >= 2 and m.px[k] > line and m.px[k] > 0.0):
            continue
        room = lane(m, m.px[k], m.py[k], pass_speed(m, distance, 1.0))
        if room < 0.3:
            continue
        score = 0.6 * dx + min(room, 4.0) + 0.7 * min(nearest_opponent(m, m.px[k], m.py[k]), 6.0) - 0.08 * distance
        if m.px[k] > 30.0:
            score += 4.0
        if best < 0 or score > best_score:
            best, best_score = k, score
    if best >= 0 and best_score < (2.0 if strength >= 2 else 3.5):
        return -1, best_score
    return best, best_score


@kernel
def through_pass(m, me, count):
    """(found, x, y, speed) of a pass behind the defence into the run of a team-mate who seems to be onside."""
    line = offside_line(m)
    found, best_x, best_y, best_speed, best = False, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        if k == me or m.age[k] > 8 or m.px[k] > line + BENEFIT or m.px[k] < line - 8.0:
            continue
        for step in range(3):
            x, y = m.px[k] + 5.0 + 4.0 * step, m.py[k] * (0.92 - 0.06 * step)
            dx, dy = x - m.ball_x, y - m.ball_y
            distance = math.sqrt(dx * dx + dy * dy)
            if distance < 8.0 or distance > 34.0 or x > 49.0 or x < line:
                continue
            speed = pass_speed(m, distance, 0.6)
            running = math.sqrt((x - m.px[k]) ** 2 + (y - m.py[k]) ** 2) / m.stride
            spare = nearest_opponent(m, x, y) / m.stride - running
            if spare < 0.0 or lane(m, x, y, speed) < 0.3:
                continue
            value = 0.5 * x + spare
            if not found or value > best:
                found, best_x, best_y, best_speed, best = True, x, y, speed, value
    return found, best_x, best_y, best_speed


@kernel
def have_ball(m, count):
    """Whether the own team is believed to have the ball."""
    ours = ball_distance(m)
    for k in range(count):
        if m.age[k] <= 20:
            ours = min(ours, math.sqrt((m.px[k] - m.ball_x) ** 2 + (m.py[k] - m.ball_y) ** 2))
    return ours < 3.0 and ours < nearest_opponent(m, m.ball_x, m.ball_y)


@kernel
def best_shot(m):
    """(y, room) of the point of the goal with the clearest way to it."""
    best_y, best_room = 0.0, -100.0
    for k in range(7):
        y = (k - 3) * (m.goal_half - 0.9) / 3.0
        room = lane(m, GOAL_X + 0.5, y, 2.6) + 0.04 * abs(y)
        if room > best_room:
            best_y, best_room = y, room
    return best_y, best_room


@kernel
def dribble(m, c, strength):
    """Push the ball a little ahead, towards the goal or past the opponent in the way."""
    goal = math.atan2(-m.ball_y * 0.7, GOAL_X - m.ball_x)
    best, best_value = goal, -1e9
    for k in range(9):
        angle = goal + (k - 4) * 0.35
        x, y = m.ball_x + 6.0 * math.cos(angle), m.ball_y + 6.0 * math.sin(angle)
        value = min(nearest_opponent(m, x, y), 6.0) + min(lane(m, x, y, 1.2), 3.0) - 1.6 * abs(k - 4)
        if abs(y) > 32.0 or x > 51.0:
            value -= 20.0
        if value > best_value:
            best, best_value = angle, value
    free = nearest_opponent(m, m.x, m.y)
    speed = 1.3 if free > 8.0 else 0.9 if free > 3.0 else 0.7
    off = abs(norm(best - m.body))
    if off > 0.5:
        speed = 0.45
    kick_to(m, c, m.ball_x + 10.0 * math.cos(best), m.ball_y + 10.0 * math.sin(best), speed + 0.35 * math.sqrt(m.vx**2 + m.vy**2))


@kernel
def with_ball(m, c, me, count, strength, set_play):
    """The ball can be kicked: shoot, pass, dribble or clear."""
    to_goal = math.sqrt((GOAL_X - m.ball_x) ** 2 + m.ball_y**2)
    if strength == 0:
        if to_goal < 14.0:
            kick_to(m, c, GOAL_X + 1.0, 0.0, 2.4)
        else:
            kick_to(m, c, GOAL_X, 0.3 * m.ball_y, 1.6)
        return
    y, room = best_shot(m)
    if to_goal < 11.0 or (to_goal < (24.0 if strength >= 2 else 18.0) and room > -0.6):
        if not set_play or to_goal < 24.0:
            kick_to(m, c, GOAL_X + 1.0, y if strength >= 2 else 0.0, m.ball_speed)
            return
    if strength >= 2 and count > COMBINES:
        found, x, y, speed = through_pass(m, me, count)
        if found:
            kick_to(m, c, x, y, speed)
            return
    target, score = best_pass(m, me, count, strength)
    pressed = nearest_opponent(m, m.x, m.y) < 3.0
    good = score > (5.0 if pressed else 9.0)
    if target >= 0 and (set_play or good or (pressed and strength == 1)):
        dx, dy = m.px[target] - m.ball_x, m.py[target] - m.ball_y
        distance = math.sqrt(dx * dx + dy * dy)
        ahead = 1.5 if strength >= 2 else 0.0
        kick_to(m, c, m.px[target] + ahead, m.py[target], pass_speed(m, distance, 1.1))
        return
    if set_play or (pressed and m.ball_x < -25.0):
        side = 1.0 if m.ball_y >= 0.0 else -1.0
        kick_to(m, c, min(45.0, m.ball_x + 30.0), side * 22.0, FAR * m.ball_speed)
        return
    dribble(m, c, strength)


@kernel
def tackle_chance(m):
    """Probability that a tackle hits the ball (specification/simulator.md 4.4)."""
    dx, dy = m.ball_x - m.x, m.ball_y - m.y
    along = dx * math.cos(m.body) + dy * math.sin(m.body)
    across = abs(dy * math.cos(m.body) - dx * math.sin(m.body))
    if along <= 0.0 or m.tackle_dist <= 0.0:
        return 0.0
    return max(0.0, 1.0 - ((along / m.tackle_dist) ** m.tackle_exponent + (across / m.tackle_width) ** m.tackle_exponent))


@kernel
def keep_goal(w, m, c, me, count, strength, fresh, state):
    """The goalie: catch what comes, meet what lies free, else stand between ball and goal."""
    near = ball_distance(m)
    inside = m.ball_x < -37.0 and abs(m.ball_y) < 19.0
    if state == PLAYING and inside and near < m.catch_reach and m.ball_age <= 1 and w.catch_ban[me if m.left else me + 11] == 0:
        c.kind = CATCH
        c.a = norm(math.atan2(m.ball_y - m.y, m.ball_x - m.x) - m.body) / D2R
        return
    if m.ball_age > LOST:
        search(m, c, fresh)
        return
    if kickable(m) and (state == PLAYING or state == OURS):
        target, _ = best_pass(m, me, count, strength)
        if target >= 0 and strength > 0:
            d = math.sqrt((m.px[target] - m.ball_x) ** 2 + (m.py[target] - m.ball_y) ** 2)
            kick_to(m, c, m.px[target], m.py[target], pass_speed(m, d, 1.2))
        else:
            kick_to(m, c, 0.0, 25.0 if m.ball_y >= 0.0 else -25.0, 2.8)
        if state == OURS:
            m.taker = 40
        look_to(m, c, m.ball_x, m.ball_y)
        return
    own, x, y = intercept(m, m.x, m.y, 1.0)
    theirs = 99
    for k in range(11, 22):
        if m.age[k] <= 15:
            t, _, _ = intercept(m, m.px[k], m.py[k], 0.0)
            theirs = min(theirs, t)
    speed = math.sqrt(m.ball_vx**2 + m.ball_vy**2)
    reaches = m.ball_vx < -0.5 and speed > 0.9
    if state == OURS and near < 12.0 and m.taker == 0 and inside:
        if run_to(m, c, m.ball_x, m.ball_y, 80.0, 0.6):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    elif state == PLAYING and m.taker == 0 and x < -38.0 and abs(y) < 18.0 and (own < theirs or (reaches and own < 20)):
        if run_to(m, c, x, y, 100.0, 0.3):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    else:
        # where the ball would cross the goal line if it is on its way, else on the line from ball to goal
        gx = -GOAL_X
        if reaches and m.ball_x > gx:
            target_y = m.ball_y + m.ball_vy * (m.ball_x - gx - 1.5) / max(0.2, -m.ball_vx)
            target_x = gx + 1.5
        else:
            dx, dy = m.ball_x - gx, m.ball_y
            d = max(0.5, math.sqrt(dx * dx + dy * dy))
            out = min(5.0, 1.2 + 0.07 * d)
            target_x, target_y = gx + out * dx / d, out * dy / d
        target_y = min(6.5, max(-6.5, target_y))
        if run_to(m, c, target_x, target_y, 100.0 if reaches else 70.0, 0.4):
            turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def play(w, m, c, me, count, strength, goalie, formation, fresh):
    """One player's command of one cycle."""
    clear(c)
    state = situation(w.mode, m.left == 1)
    note_kicker(m, me, count, state)
    m.taker = max(0, m.taker - 1)
    if m.kicker == me + 1 and state == PLAYING:
        m.taker = max(1, m.taker)
    m.clock += 1
    if state == WAITING:
        fx, fy = min(formation[me, 0], -1.0), formation[me, 1]
        if (m.x - fx) ** 2 + (m.y - fy) ** 2 > 1.0 or m.located == 0:
            c.kind = MOVE
            c.a, c.b = fx, fy
        else:
            turn_to(m, c, math.atan2(-m.y, -m.x))
            c.turn_neck = -m.neck / D2R
        return
    if not m.free:
        look_to(m, c, m.ball_x, m.ball_y)
        return
    if goalie:
        keep_goal(w, m, c, me, count, strength, fresh, state)
        return
    if m.ball_age > LOST:
        search(m, c, fresh)
        return
    m.search = 0
    if state == DEAD:
        x, y = home(m, formation, me, 0.0, True)
        run_to(m, c, x, y, 40.0, 2.0)
        look_to(m, c, m.ball_x, m.ball_y)
        return
    if kickable(m) and m.taker == 0 and state != THEIRS:
        with_ball(m, c, me, count, strength, state == OURS)
        if state == OURS:
            m.taker = 25
        look_to(m, c, m.ball_x, m.ball_y)
        return
    rank = rank_to_ball(m, me, count)
    chasing = rank == 0 and m.taker == 0
    if state == PLAYING and strength == 0 and rank <= 1 and m.taker == 0:
        chasing = True
    if state == PLAYING and strength == 2 and not kickable(m) and nearest_opponent(m, m.ball_x, m.ball_y) < 1.3 and tackle_chance(m) > 0.8:
        c.kind = TACKLE
        c.a = norm(-m.body) / D2R
        c.b = 0.0
        return
    if chasing and state != THEIRS:
        if strength == 0:
            if run_to(m, c, m.ball_x, m.ball_y, 70.0, 0.5):
                turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
            look_to(m, c, m.ball_x, m.ball_y)
        else:
            chase(m, c, 100.0)
        return
    position(m, c, me, count, strength, formation, state)


@kernel
def position(m, c, me, count, strength, formation, state):
    """Without the ball: go to the place in the formation, keep the distance at their kicks, mark in the own half."""
    attack = 4.0 if strength == 2 and m.ball_x > 0.0 else 0.0
    x, y = home(m, formation, me, attack, strength >= 2)
    combines = strength >= 2 and count > COMBINES
    back = combines and formation[me, 0] < BACK
    if back:
        # the back line moves up, so that forwards behind it are offside
        x = max(x, min(HIGH_LINE, m.ball_x - LINE_GAP))
    if strength >= 1 and formation[me, 0] > FORWARD and m.ball_x > -15.0:
        # forwards wait for the pass at the last defenders; only the strong team minds the offside line well
        x = max(x, min(m.ball_x + 22.0, offside_line(m) + (-0.7 if strength >= 2 else 1.0)))
    running = False
    if combines and formation[me, 0] > FORWARD and state == PLAYING and m.ball_x > -30.0 and have_ball(m, count):
        line = offside_line(m)
        running = (m.clock + 23 * me) % PERIOD < RUN
        x, y = (min(47.0, line + 6.0), 0.85 * m.y) if running else (line - 0.8, y)
    if state == THEIRS:
        dx, dy = x - m.ball_x, y - m.ball_y
        d = math.sqrt(dx * dx + dy * dy)
        if d < 10.5:
            x, y = m.ball_x - 10.5 * (0.9 if d < 0.1 else -dx / d), m.ball_y + 10.5 * (0.0 if d < 0.1 else dy / d)
            x = max(-46.0, min(x, 40.0))
    elif strength >= 1 and state == PLAYING and m.ball_x < 0.0:
        # mark: stand between the nearest opponent around the own place and the goal
        best, gap = -1, 9.0
        for k in range(11, PLAYERS):
            if m.age[k] <= 20:
                d = math.sqrt((m.px[k] - x) ** 2 + (m.py[k] - y) ** 2)
                if d < gap:
                    best, gap = k, d
        if best >= 0:
            dx, dy = -GOAL_X - m.px[best], -m.py[best]
            d = max(0.5, math.sqrt(dx * dx + dy * dy))
            lowest = x - 2.0 if back and m.ball_x > -30.0 else -GOAL_X
            x, y = max(lowest, m.px[best] + 1.5 * dx / d), m.py[best] + 1.5 * dy / d
    far = math.sqrt((x - m.x) ** 2 + (y - m.y) ** 2)
    power = 100.0 if running else 90.0 if far > 12.0 else 60.0
    if run_to(m, c, x, y, power, 1.5):
        turn_to(m, c, math.atan2(m.ball_y - m.y, m.ball_x - m.x))
    look_to(m, c, m.ball_x, m.ball_y)


@kernel
def act(worlds, memory, players, strengths, counts, formation, fresh, commands):
    """Commands of the scripted players of every world.

    players : (P,) rows 0..21; strengths : (P,) 0 to 2; counts : (2,) players per side; commands : (W, 22) COMMAND
    """
    for n in range(worlds.shape[0]):
        w = worlds[n]
        for k in range(players.shape[0]):
            i = players[k]
            if w.enabled[i]:
                m = memory[n, i]
                m.left = 1 if i < 11 else 0
                count = counts[0] if i < 11 else counts[1]
                play(w, m, commands[n, i], i % 11, count, strengths[k], w.goalie[i] == 1, formation, fresh[n, i])
