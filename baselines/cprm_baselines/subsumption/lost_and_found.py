"""The finder in layers: one for the legs; the eyes have a wire of their own."""

from __future__ import annotations

from ..behaviour.layers import Layer

LAYERS = (Layer("meet", "1", skill="legs"),)
EYES = "eyes"
