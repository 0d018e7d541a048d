"""The hiker as a behaviour tree: the sequence remembers how far it has come."""

from __future__ import annotations

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Out, then home."""
    return n.sequence(n.does("out"), n.forever(n.sequence(n.does("home"), n.waits(1))))
