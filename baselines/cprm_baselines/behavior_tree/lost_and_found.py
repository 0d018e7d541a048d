"""The finder as a behaviour tree: eyes and legs in parallel."""

from __future__ import annotations

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    return n.parallel(n.does("eyes"), n.forever(n.sequence(n.does("legs"), n.waits(1))))
