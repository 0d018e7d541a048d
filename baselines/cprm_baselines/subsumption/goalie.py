"""The goalie in layers: keep his place; clear what lies at hand; save what comes."""

from __future__ import annotations

from ..behaviour.layers import Layer

LAYERS = (
    Layer("take place", "displaced", skill="post", stays="1"),
    Layer("clear", "at_hand or holding", skill="away", sets={"cleared": ("cleared", 1)}),
    Layer("save", "coming", skill="save", stays="1", sets={"caught": ("holding", 6)}),
)
EYES = "eyes"
