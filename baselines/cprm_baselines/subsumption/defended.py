"""One of two who attack against a defence in layers."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.layers import Layer

_HAS = "reach and not offside"
LAYERS = (
    Layer("turn to it", f"off_axis >= {OFF_AXIS}", order="face"),
    Layer("run free", f"off_place >= {OFF_PLACE}", skill="walk", stays="1"),
    Layer("meet it", "chase", skill="meet"),
    Layer("push", _HAS, skill="push", stays="1"),
    Layer("pass", f"{_HAS} and can_pass", skill="give", stays="1"),
    Layer("shoot", f"{_HAS} and can_shoot", skill="shoot", stays="1"),
    Layer("take", f"{_HAS} and ours", skill="give", stays="1"),
    Layer("look round", "lost or seeks", order="sweep"),
    Layer("hands off", "barred", order="stand"),
    Layer("set up", "waiting", skill="setup"),
)
EYES = "look"
