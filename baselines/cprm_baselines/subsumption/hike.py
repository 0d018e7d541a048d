"""The hiker in layers: go out; go home. That he has been there is a register."""

from __future__ import annotations

from ..behaviour.layers import Layer

FOREVER = 10_000
"""Cycles, more than an episode has."""
LAYERS = (
    Layer("out", "not been", skill="out", sets={"arrived": ("been", FOREVER)}),
    Layer("home", "been", skill="home"),
)
EYES = ""
