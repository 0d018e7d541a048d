"""A taker in layers: cover, meet the ball, tackle, kick it out."""

from __future__ import annotations

from cprm_gym.agents.taker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.layers import Layer

LAYERS = (
    Layer("turn to it", f"off_axis >= {OFF_AXIS}", order="face"),
    Layer("cover", f"off_place >= {OFF_PLACE}", skill="walk"),
    Layer("meet it", "chase", skill="meet"),
    Layer("tackle", "tackles", order="tackle"),
    # two of one kind, of which the other speaks in the cycle in which the one has ended
    Layer("kick out again", "reach", skill="oust"),
    Layer("kick out", "reach", skill="oust"),
    Layer("look round", "lost", order="sweep"),
)
EYES = "look"
