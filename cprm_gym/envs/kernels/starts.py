"""Kernels of what happens when episodes begin: the engine's own arrays, and the start of a task that has one."""

from __future__ import annotations

import math

from ...simulator.kernels.powers import move_ball, move_player
from ...simulator.kernels.random import RESETS, START, uniform
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import PlayMode
from . import kernel

NAN = math.nan
PLAY_ON = int(PlayMode.play_on)
LENGTH, WIDTH = HALF_LENGTH - 1.0, HALF_WIDTH - 1.0
"""|x| and |y| up to which somebody is put onto the pitch, m."""
NUMBERS = 8
"""Numbers of a try: the player's place, the ball's distance and direction, whether it rolls, how fast and where to, the player's body."""


@kernel
def begin(worlds, chosen, cycle, late, previous_ball, counters, score, ages, oldest, commands, nothing, kicks, drawn):
    """Forget everything of earlier episodes of the chosen worlds; arrays as `SoccerCore` and `Preset` have them, the worlds first."""
    for n in chosen:
        w = worlds[n]
        cycle[n], late[n] = 0, False
        previous_ball[n, 0], previous_ball[n, 1] = w.pos[0, 0], w.pos[0, 1]
        counters[n, :] = 0
        score[n, 0], score[n, 1] = w.score[0], w.score[1]
        ages[n, :, :] = oldest
        for i in range(commands.shape[1]):
            commands[n, i] = nothing[0]
        kicks[n, :] = 0
        drawn[n, :] = -1


@kernel
def drawn_number(w, k):
    """Number `k` of those that a world draws at once from its stream of resets (`simulator.kernels.random.draw_uniforms`)."""
    return uniform(w, RESETS, -1, START, k)


@kernel
def on_pitch(value, limit):
    """A coordinate pulled onto the pitch."""
    return min(limit, max(-limit, value))


@kernel
def beside(x, y, near, far, share, turn):
    """(x, y) from `near` to `far` metres away in a direction, both from numbers in [0, 1)."""
    distance, angle = near + (far - near) * share, 2.0 * math.pi * turn
    return x + distance * math.cos(angle), y + distance * math.sin(angle)


@kernel
def ball_try(w, first, near, far, rolling, fastest, decay):
    """(fits, player's x and y, ball's x, y, vx and vy) of the try whose numbers begin with `first`."""
    x, y = (2.0 * drawn_number(w, first) - 1.0) * LENGTH, (2.0 * drawn_number(w, first + 1) - 1.0) * WIDTH
    ball_x, ball_y = beside(x, y, near, far, drawn_number(w, first + 2), drawn_number(w, first + 3))
    speed = fastest * drawn_number(w, first + 5) if drawn_number(w, first + 4) < rolling else 0.0
    heading = 2.0 * math.pi * drawn_number(w, first + 6)
    vx, vy = speed * math.cos(heading), speed * math.sin(heading)
    rest_x, rest_y = ball_x + vx / (1.0 - decay), ball_y + vy / (1.0 - decay)
    fits = abs(ball_x) <= LENGTH and abs(ball_y) <= WIDTH and abs(rest_x) <= LENGTH and abs(rest_y) <= WIDTH
    return fits, x, y, ball_x, ball_y, vx, vy


@kernel
def start_go_to_ball(worlds, packed, chosen, near, far, rolling, fastest, tries, left):
    """Ball and players of a race to the ball in the chosen worlds: the first try that fits, or the last one pulled onto the pitch."""
    p = packed[0]
    for n in chosen:
        w = worlds[n]
        w.mode = PLAY_ON
        first = 0
        for first in range(0, NUMBERS * tries, NUMBERS):
            fits, x, y, ball_x, ball_y, vx, vy = ball_try(w, first, near, far, rolling, fastest, p.ball_decay)
            if fits:
                break
        if not fits:
            ball_x, ball_y, vx, vy = on_pitch(ball_x, LENGTH), on_pitch(ball_y, WIDTH), 0.0, 0.0
        body = math.pi * (2.0 * drawn_number(w, first + 7) - 1.0)
        w.draws += 1
        move_ball(w, ball_x, ball_y, vx, vy)
        move_player(w, p, 0, x, y, body, NAN, NAN)
        for i in range(1, left):
            x, y = beside(ball_x, ball_y, near, far, drawn_number(w, 0), drawn_number(w, 1))
            body = math.pi * (2.0 * drawn_number(w, 2) - 1.0)
            w.draws += 1
            move_player(w, p, i, on_pitch(x, LENGTH), on_pitch(y, WIDTH), body, NAN, NAN)
