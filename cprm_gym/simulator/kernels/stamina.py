"""Stamina, effort, recovery and capacity (specification/simulator.md 5)."""

from __future__ import annotations

from ..player_types import T_EFFORT_MAX, T_EFFORT_MIN, T_STAMINA_INC_MAX
from . import kernel


@kernel
def update_stamina(w, p, i):
    """What player `i` regains in one step, and how his effort and recovery change."""
    type_ = w.type[i]
    stamina = w.stamina[i]
    if stamina <= p.recover_dec_thr * p.stamina_max:
        if w.recovery[i] > p.recover_min:
            w.recovery[i] -= p.recover_dec
        if w.recovery[i] < p.recover_min:
            w.recovery[i] = p.recover_min
    if stamina <= p.effort_dec_thr * p.stamina_max:
        lowest = p.types[type_, T_EFFORT_MIN]
        if w.effort[i] > lowest:
            w.effort[i] -= p.effort_dec
        if w.effort[i] < lowest:
            w.effort[i] = lowest
    if stamina >= p.effort_inc_thr * p.stamina_max:
        highest = p.types[type_, T_EFFORT_MAX]
        if w.effort[i] < highest:
            w.effort[i] = min(w.effort[i] + p.effort_inc, highest)
    gain = min(w.recovery[i] * p.types[type_, T_STAMINA_INC_MAX], p.stamina_max - stamina)
    if p.stamina_capacity >= 0.0:
        gain = min(gain, w.capacity[i])
        w.capacity[i] = max(0.0, w.capacity[i] - gain)
    w.stamina[i] = min(stamina + gain, p.stamina_max)


@kernel
def recover(w, p, i):
    """Full reset of stamina, effort, recovery, capacity and hearing of player `i` (kick-offs, trainer, substitution)."""
    w.stamina[i] = p.stamina_max
    w.recovery[i] = 1.0
    w.effort[i] = p.types[w.type[i], T_EFFORT_MAX]
    w.capacity[i] = p.stamina_capacity
    w.hear_capacity[i, 0] = p.hear_max
    w.hear_capacity[i, 1] = p.hear_max
