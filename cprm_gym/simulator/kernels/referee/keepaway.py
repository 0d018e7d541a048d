"""Keepaway (specification/simulator.md 7.13): the left players keep the ball within a region, the right ones try to take it."""

from __future__ import annotations

from ...state import Announcement
from .. import kernel
from ..geometry import squared_distance
from ..random import KEEPAWAY, REFEREE, uniform, uniform_between
from ..stamina import recover
from .modes import BEFORE_KICK_OFF, PLAY_ON, RULING_MODE, announce, rule
from .places import place_ball

SAY_TRAINING = int(Announcement.TRAINING_KEEPAWAY)
TURNOVER = 4
"""Steps the takers must have had the ball before the one that ends the episode."""
CORNER_SPREAD = 3.0
BALL_INSET = 4.0


@kernel
def place_player(w, i, x, y):
    """Put player `i` at rest at (x, y)."""
    w.pos[i + 1, 0], w.pos[i + 1, 1] = x, y
    w.vel[i + 1, 0], w.vel[i + 1, 1] = 0.0, 0.0
    w.acc[i + 1, 0], w.acc[i + 1, 1] = 0.0, 0.0


@kernel
def place_keeper(w, p, i, corner):
    """Near one of three corners of the region (top left, top right, bottom right), further keepers in the middle."""
    a, b = uniform(w, REFEREE, i + 1, KEEPAWAY, 0), uniform(w, REFEREE, i + 1, KEEPAWAY, 1)
    half_x, half_y = 0.5 * p.keepaway_length, 0.5 * p.keepaway_width
    if corner == 0:
        place_player(w, i, -half_x + CORNER_SPREAD * a, -half_y + CORNER_SPREAD * b)
    elif corner == 1:
        place_player(w, i, half_x - CORNER_SPREAD * a, -half_y + CORNER_SPREAD * b)
    elif corner == 2:
        place_player(w, i, half_x - CORNER_SPREAD * a, half_y - CORNER_SPREAD * b)
    else:
        place_player(w, i, 2.0 * a - 1.0, 2.0 * b - 1.0)


@kernel
def place_taker(w, p, i):
    """Near the corner of the region that no keeper is put to (bottom left)."""
    a, b = uniform(w, REFEREE, i + 1, KEEPAWAY, 0), uniform(w, REFEREE, i + 1, KEEPAWAY, 1)
    x = -0.5 * p.keepaway_length + CORNER_SPREAD * a
    place_player(w, i, x, 0.5 * p.keepaway_width - CORNER_SPREAD * b)


@kernel
def begin_episode(w, p):
    """Keepers to the corners, from a random one on in turn; takers to the last corner; the ball to the first."""
    keepers = 0
    for i in range(11):
        keepers += w.enabled[i]
    first = int(uniform_between(w, REFEREE, -1, KEEPAWAY, 0, 0.0, 1.0) * keepers)
    w.keepaway_first = first
    w.keepaway_count = 0
    w.keepaway_begun = 1
    turn = 0
    for i in range(22):
        if not w.enabled[i]:
            continue
        if i < 11:
            place_keeper(w, p, i, (turn - first) % keepers)
            turn += 1
        else:
            place_taker(w, p, i)
        recover(w, p, i)
    place_ball(w, w.kick_off_side, -0.5 * p.keepaway_length + BALL_INSET, -0.5 * p.keepaway_width + BALL_INSET)
    w.ball_catcher = 0


@kernel
def keepaway_step(w, p):
    """End the episode when the ball is out of the region or the takers had it for four steps before this one.

    Before the first one: begin to play ``keepaway_start`` seconds after the start, if that is set.
    """
    if w.mode == BEFORE_KICK_OFF and 0 <= 1000 * p.keepaway_start <= w.stoppage * p.simulator_step:
        rule(w, RULING_MODE, PLAY_ON, 0.0, 0.0)
    if w.mode != PLAY_ON:
        return
    out = abs(w.pos[0, 0]) >= 0.5 * p.keepaway_length or abs(w.pos[0, 1]) >= 0.5 * p.keepaway_width
    if out or w.keepaway_count >= TURNOVER:
        announce(w, SAY_TRAINING, 1, 0, 0)
        begin_episode(w, p)
        return
    area = p.player_size + p.kickable_margin + p.ball_size
    keepers, takers = False, False
    for i in range(22):
        if w.enabled[i] and squared_distance(w, 0, i + 1) < area * area:
            if i < 11:
                keepers = True
            else:
                takers = True
    if takers:
        w.keepaway_count += 1
    elif keepers:
        w.keepaway_count = 0
