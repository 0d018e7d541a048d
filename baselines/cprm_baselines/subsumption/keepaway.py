"""A keeper in layers: get open, meet the ball, keep it, pass it."""

from __future__ import annotations

from cprm_gym.agents.keeper.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.layers import Layer

LAYERS = (
    Layer("turn to it", f"off_axis >= {OFF_AXIS}", order="face"),
    Layer("get open", f"off_place >= {OFF_PLACE}", skill="walk"),
    Layer("meet it", "chase", skill="meet"),
    # two of one kind, of which the other speaks in the cycle in which the one has ended
    Layer("shelter again", "reach", skill="shelter"),
    Layer("shelter", "reach", skill="shelter"),
    Layer("pass", "reach and can_pass", skill="give", stays="1"),
    Layer("look round", "lost", order="sweep"),
)
EYES = "look"
