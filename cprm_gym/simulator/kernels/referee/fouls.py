"""Fouls and cards (specification/simulator.md 7.10)."""

from __future__ import annotations

import math

from ...player_types import T_FOUL_DETECT_PROBABILITY, T_PLAYER_SIZE
from ...state import Announcement
from .. import kernel
from ..geometry import direction, is_kickable, norm, rotate, side_of
from ..random import CARD, FOUL_DETECTION, REFEREE, decide
from .modes import BIT_DISCARD, BIT_FOUL_CHARGED, BIT_RED, BIT_STAND, BIT_YELLOW, announce

SAY_YELLOW = int(Announcement.YELLOW_CARD)
SAY_RED = int(Announcement.RED_CARD)
NO_FOUL, CHARGE, YELLOW, RED = 0, 1, 2, 3


@kernel
def charge_victim(w, p, v):
    """Player `v` was fouled on purpose: he cannot move for some cycles."""
    w.foul_cycles[v] = p.foul_cycles
    w.busy[v] = 1
    w.bits[v] |= BIT_FOUL_CHARGED


@kernel
def runs_into(w, p, i, v):
    """Tackler `i` goes through player `v`, who runs for the ball too, from behind."""
    if w.dash_cycles[v] < 0:
        return False
    dx, dy = w.pos[0, 0] - w.pos[i + 1, 0], w.pos[0, 1] - w.pos[i + 1, 1]
    to_ball = direction(dx, dy)
    x, y = rotate(w.pos[v + 1, 0] - w.pos[i + 1, 0], w.pos[v + 1, 1] - w.pos[i + 1, 1], -to_ball)
    if x * x + y * y > dx * dx + dy * dy or x < 0.0:
        return False
    if abs(y) > p.types[w.type[v], T_PLAYER_SIZE] + p.types[w.type[i], T_PLAYER_SIZE]:
        return False
    return abs(norm(w.body[v] - to_ball)) <= 0.5 * math.pi


@kernel
def judge_tackle(w, p, i, intentional):
    """What the tackle of player `i` is worth: NO_FOUL, CHARGE, YELLOW or RED."""
    charge, yellow, red = False, False, False
    probability = p.types[w.type[i], T_FOUL_DETECT_PROBABILITY]
    start = 11 if i < 11 else 0
    for v in range(start, start + 11):
        if not w.enabled[v] or not is_kickable(w, p, v):
            continue
        hit = False
        if intentional:
            charge_victim(w, p, v)
            hit = decide(w, w.forced_foul[i], REFEREE, i + 1, FOUL_DETECTION, v, probability)
            charge = charge or hit
        if not runs_into(w, p, i, v):
            continue
        if intentional:
            if hit and w.forced_card[i] >= 0:
                if decide(w, 0, REFEREE, i + 1, CARD, v, p.red_card_probability):
                    yellow, red = False, True
                else:
                    yellow = True
        elif decide(w, w.forced_foul[i], REFEREE, i + 1, FOUL_DETECTION, v, probability):
            charge = True
            if decide(w, w.forced_card[i], REFEREE, i + 1, CARD, v, p.red_card_probability):
                yellow = True
    return RED if red else (YELLOW if yellow else (CHARGE if charge else NO_FOUL))


@kernel
def send_off(w, i):
    """Player `i` leaves the match and his body the pitch."""
    unum, side = i % 11 + 1, side_of(i)
    w.bits[i] = (w.bits[i] & ~BIT_STAND) | BIT_RED | BIT_DISCARD
    w.enabled[i] = 0
    w.pos[i + 1, 0], w.pos[i + 1, 1] = -3.0 * unum * side, -37.0
    w.vel[i + 1, 0], w.vel[i + 1, 1] = 0.0, 0.0
    w.acc[i + 1, 0], w.acc[i + 1, 1] = 0.0, 0.0


@kernel
def show_card(w, i, outcome):
    """The card that goes with a foul of player `i`; a second yellow one sends him off as well."""
    unum, side = i % 11 + 1, side_of(i)
    if outcome == YELLOW:
        announce(w, SAY_YELLOW, side, unum, 0)
        w.card_count[i] += 1
        w.bits[i] |= BIT_YELLOW
        if w.card_count[i] < 2:
            return
    announce(w, SAY_RED, side, unum, 0)
    send_off(w, i)
