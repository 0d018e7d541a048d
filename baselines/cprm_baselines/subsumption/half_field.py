"""An attacker before the goal in layers: run free, meet the ball, and what to do with it."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.layers import Layer

LAYERS = (
    Layer("turn to it", f"off_axis >= {OFF_AXIS}", order="face"),
    Layer("run free", f"off_place >= {OFF_PLACE}", skill="walk", stays="1"),
    Layer("meet it", "chase", skill="meet"),
    Layer("push", "reach", skill="push", stays="1"),
    Layer("pass", "reach and can_pass", skill="give", stays="1"),
    Layer("shoot", "reach and can_shoot", skill="shoot", stays="1"),
    Layer("look round", "lost", order="sweep"),
)
EYES = "look"
