"""The goalie as a behaviour tree: what is more urgent stands first and takes over; a save is seen through."""

from __future__ import annotations

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    save = n.sequence(n.holds("coming"), n.does("save"), n.does("away"))
    clear = n.sequence(n.holds("at_hand"), n.does("away"))
    guard = n.sequence(n.does("post"), n.selector(n.holds("displaced"), n.keeps()))
    return n.parallel(n.does("eyes"), n.selector(save, clear, guard))
