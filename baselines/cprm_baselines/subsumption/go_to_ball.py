"""go_to_ball in layers: turn round; face what is seen; run to what is ahead."""

from __future__ import annotations

from ..behaviour.layers import Layer

LAYERS = (
    Layer("look round", "fresh", order="search"),
    Layer("be patient", "known", inhibits=("look round",)),
    Layer("face", "seen and aside", order="turn"),
    Layer("run", "known and not aside", order="dash"),
)
EYES = ""
