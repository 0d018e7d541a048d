"""go_to_ball as a behaviour tree without memory: the first condition that holds decides."""

from __future__ import annotations

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Run, turn, or look."""
    run = n.sequence(n.holds("known and not aside"), n.keeps("dash"), memory=False)
    turn = n.sequence(n.holds("seen"), n.keeps("turn"), memory=False)
    look = n.sequence(n.holds("fresh and not known"), n.keeps("search"), memory=False)
    return n.selector(run, turn, look, n.keeps())
