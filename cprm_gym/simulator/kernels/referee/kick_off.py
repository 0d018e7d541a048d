"""The kick-off procedure, automatic kick-offs and player types (specification/simulator.md 2.2 to 2.4, 7.3, 7.15)."""

from __future__ import annotations

from ...state import Announcement
from .. import event, kernel
from ..geometry import side_of
from ..stamina import recover
from .modes import BEFORE_KICK_OFF, KEPT_BY_SUBSTITUTION, KICK_OFF, LEFT, PLAY_ON, RIGHT, RULE_KEEPAWAY, announce, of_side, team_of
from .places import place_ball
from .set_mode import set_mode

SAY_TYPE = int(Announcement.CHANGE_PLAYER_TYPE)
NEVER = 18
"""Row of the tables of types for players who were never substituted."""


# --- player types


@kernel
def type_key(w, i):
    """Row of the tables of types that player `i` counts in."""
    return w.type[i] if w.substituted[i] else NEVER


@kernel
def substitute(w, p, i, new_type):
    """Player `i` becomes one of type `new_type`, rested and without cards; the place stays (specification/simulator.md 2.4)."""
    w.type[i] = new_type
    recover(w, p, i)
    w.bits[i] &= KEPT_BY_SUBSTITUTION
    w.card_count[i] = 0
    w.substituted[i] = 1
    announce(w, SAY_TYPE, side_of(i), i % 11 + 1, new_type)


@kernel
def book_substitution(w, i, new_type):
    """Keep the tables of types while player `i` becomes one of type `new_type`; call before `substitute`."""
    team, old = team_of(side_of(i)), type_key(w, i)
    if w.on_field[team, old] > 0:
        w.on_field[team, old] -= 1
        w.on_field[team, new_type] += 1
    if w.time > 0:
        w.substitutions[team] += 1
        w.used_types[team, new_type] += 1


@kernel
def count_types(w, team):
    """Fill both tables of `team` from its players."""
    for key in range(NEVER + 1):
        w.on_field[team, key], w.used_types[team, key] = 0, 0
    for i in range(11 * team, 11 * team + 11):
        if w.enabled[i]:
            key = type_key(w, i)
            w.on_field[team, key] += 1
            w.used_types[team, key] += 1


@kernel
def free_type(w, p, team):
    """The smallest type that may be given to one more player of `team`, -1 when there is none."""
    for t in range(p.player_types):
        if w.used_types[team, t] < p.pt_max:
            return t
    return -1


@kernel
def assign_type(w, p, i):
    """Give player `i` a type if his own is not chosen yet, or too often."""
    team, key = team_of(side_of(i)), type_key(w, i)
    if key != NEVER and w.used_types[team, key] <= p.pt_max:
        return
    new_type = free_type(w, p, team)
    if new_type < 0:
        return
    w.used_types[team, key] -= 1
    w.on_field[team, key] -= 1
    w.used_types[team, new_type] += 1
    w.on_field[team, new_type] += 1
    if w.type[i] != new_type:
        substitute(w, p, i, new_type)


@kernel
def assign_types(w, p):
    """Automatic player types before the first kick-off: the goalie first, then by uniform number."""
    for team in range(2):
        first = 11 * team
        count_types(w, team)
        if p.allow_mult_default_type or (p.nr_normal_halfs <= 0 and p.nr_extra_halfs <= 0):
            continue
        for goalies in (1, 0):
            for i in range(first, first + 11):
                if w.enabled[i] and (w.goalie[i] != 0) == (goalies == 1):
                    assign_type(w, p, i)


# --- kick-off


@kernel
def may_kick_off(w, p):
    """The kick-off procedure is heard: at the beginning of a half, or always in an endless match."""
    if p.half_time <= 0:
        return True
    if w.time <= p.normal_cycles:
        return w.time % p.half_cycles == 0
    return p.extra_half_cycles > 0 and (w.time - p.normal_cycles) % p.extra_half_cycles == 0


@kernel
def kicks_off(w, p):
    """The side that kicks off the half that begins now."""
    half, time = p.half_cycles, w.time
    if time > p.normal_cycles:
        half, time = p.extra_half_cycles, time - p.normal_cycles
    return LEFT if half <= 0 or (time // half) % 2 == 0 else RIGHT


@kernel
def kick_off(w, p):
    """The kick-off procedure of monitor, trainer and automatic mode (specification/simulator.md 7.3); nobody is put into formation."""
    if not may_kick_off(w, p):
        return
    if p.keepaway and p.rules & RULE_KEEPAWAY:
        set_mode(w, p, PLAY_ON)
        return
    side = kicks_off(w, p)
    if w.time < p.normal_cycles:
        for i in range(22):
            if w.enabled[i]:
                recover(w, p, i)
    place_ball(w, side, 0.0, 0.0)
    if w.time == 0:
        assign_types(w, p)
    set_mode(w, p, of_side(KICK_OFF, side))


@event
def automatic_kick_off(w, p, players_expected):
    """After each step with ``auto_mode``: count down the waits before a kick-off (specification/simulator.md 7.15)."""
    if w.mode != BEFORE_KICK_OFF or w.time >= p.total_cycles:
        w.auto_kick_off_wait, w.auto_connect_wait = p.kick_off_wait, p.connect_wait
        return
    players = 0
    for i in range(22):
        players += w.enabled[i]
    if players == players_expected or w.time > 0:
        w.auto_kick_off_wait -= 1
    else:
        w.auto_connect_wait -= 1
    if w.auto_kick_off_wait <= 0 or w.auto_connect_wait <= 0:
        kick_off(w, p)


@kernel
def automatic_kick_offs(worlds, parameters, players_expected):
    """`automatic_kick_off` of all worlds."""
    for n in range(worlds.shape[0]):
        automatic_kick_off(worlds[n], parameters[0], players_expected)
