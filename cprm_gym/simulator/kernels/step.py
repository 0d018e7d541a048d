"""One cycle: the players' commands, then the step in the server's exact order (specification/simulator.md 1.5), for one world or many."""

from __future__ import annotations

import numpy as np

from ..state import PLAYERS, PlayerBit
from . import kernel
from .body import messages_due
from .collisions import carry_ball
from .commands import effect_of_dash, execute
from .contacts import resolve_collisions
from .motion import commit, move_ball, move_player
from .random import COMMAND_ORDER, PHYSICS, shuffle
from .referee.events import automatic_kick_off, on_step
from .referee.modes import BEFORE_KICK_OFF, TIME_OVER, is_stopped
from .senses import late_messages_due
from .stamina import update_stamina

_KEPT = np.uint32(PlayerBit.STAND | PlayerBit.GOALIE | PlayerBit.DISCARD | PlayerBit.YELLOW_CARD | PlayerBit.RED_CARD)
_KICKED = np.uint32(PlayerBit.KICK | PlayerBit.KICK_FAULT)
_TACKLED = np.uint32(PlayerBit.TACKLE | PlayerBit.TACKLE_FAULT)
_CHARGED = np.uint32(PlayerBit.FOUL_CHARGED)


@kernel
def execute_all(w, p, commands):
    """Every player's command in a random order."""
    shuffle(w, PHYSICS, -1, COMMAND_ORDER, w.order, PLAYERS)
    for k in range(PLAYERS):
        i = int(w.order[k])
        execute(w, p, i, commands[i])


@kernel
def advance(w, p):
    """The step: everything between the players' commands and the messages sent to them."""
    late_messages_due(w)
    if w.announced_done:  # nothing was announced during the commands
        w.announced, w.announced_done = 0, 0
    for i in range(PLAYERS):
        if w.enabled[i]:
            effect_of_dash(w, p, i)
        _reset_budget(w, i)
        w.arm_timer[i] += 1
    mode = w.mode
    if mode == BEFORE_KICK_OFF:
        for i in range(PLAYERS):
            if w.enabled[i]:
                commit(w, i)
                w.vel[i + 1] = 0.0
                w.acc[i + 1] = 0.0
        w.stoppage += 1
        on_step(w, p)
    elif is_stopped(mode):
        w.ball_catcher = 0
        _move_all(w, p)
        w.stoppage += 1
        on_step(w, p)
        if w.mode != mode:
            w.time += 1
            w.stoppage = 0
    elif mode == TIME_OVER:
        w.stoppage += 1
    else:
        _move_all(w, p)
        w.time += 1
        w.stoppage = 0
        on_step(w, p)
    for i in range(PLAYERS):
        if w.enabled[i]:
            update_stamina(w, p, i)
            for side in range(2):
                w.hear_capacity[i, side] = min(w.hear_capacity[i, side] + p.hear_inc, p.hear_max)
            if w.catch_ban[i] > 0:
                w.catch_ban[i] -= 1
        _reduce_bits(w, i)
    if p.auto_mode:
        automatic_kick_off(w, p, PLAYERS)
    w.announced_done = 1
    w.steps += 1
    messages_due(w, p)


@kernel
def _move_all(w, p):
    """Motion of every object, collisions, and the ball in a goalie's hands."""
    move_ball(w, p)
    for i in range(PLAYERS):
        if w.enabled[i]:
            move_player(w, p, i)
    resolve_collisions(w, p)
    carry_ball(w, p)


@kernel
def _reset_budget(w, i):
    """Free what the player may use again in the next cycle (specification/simulator.md 1.7)."""
    if w.kick_cycles[i] >= 0:
        w.kick_cycles[i] -= 1
    if w.dash_cycles[i] >= 0:
        w.dash_cycles[i] -= 1
    if w.tackle_cycles[i] > 0:
        w.tackle_cycles[i] -= 1
    if w.foul_cycles[i] > 0:
        w.foul_cycles[i] -= 1
    if w.kick_cycles[i] <= 0 and w.tackle_cycles[i] == 0 and w.foul_cycles[i] == 0:
        w.busy[i] = 0
    w.neck_busy[i] = 0
    for leg in range(2):
        w.leg_busy[i, leg] = 0
        w.leg_dashed[i, leg] = 0
        w.leg_power[i, leg] = 0.0
        w.leg_dir[i, leg] = 0.0


@kernel
def _reduce_bits(w, i):
    """Show the state bits to monitors and logs, then clear the transient ones (specification/simulator.md 0.5)."""
    w.bits_shown[i] = w.bits[i]
    kept = _KEPT
    if w.kick_cycles[i] > 0:
        kept |= _KICKED
    if w.tackle_cycles[i] > 0:
        kept |= _TACKLED
    if w.foul_cycles[i] > 0:
        kept |= _CHARGED
    w.bits[i] &= kept


@kernel
def command_world(worlds, parameters, k, i, commands, n):
    """Execute ``commands[n]`` of player `i` of world `k`, now."""
    execute(worlds[k], parameters[0], i, commands[n])


@kernel
def advance_worlds(worlds, parameters, start, stop):
    """The step of worlds `start` to `stop`, without commands."""
    p = parameters[0]
    for k in range(start, stop):
        advance(worlds[k], p)


@kernel
def step_worlds(worlds, parameters, commands, start, stop):
    """Commands and step of worlds `start` to `stop`."""
    p = parameters[0]
    for k in range(start, stop):
        w = worlds[k]
        execute_all(w, p, commands[k])
        advance(w, p)
