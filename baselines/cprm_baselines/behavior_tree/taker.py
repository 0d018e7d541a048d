"""A taker as a behaviour tree: what is more urgent stands first and takes over."""

from __future__ import annotations

from cprm_gym.agents.taker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    find = n.sequence(n.holds("lost"), n.keeps("sweep"), memory=False)
    oust = n.sequence(n.holds("reach"), n.does("oust"))
    tackle = n.sequence(n.holds("tackles"), n.keeps("tackle"), memory=False)
    meet = n.sequence(n.holds("chase"), n.does("meet"), memory=False)
    cover = n.sequence(n.holds(f"off_place >= {OFF_PLACE}"), n.does("walk"), n.waits(1))
    turn = n.sequence(n.holds(f"off_axis >= {OFF_AXIS}"), n.keeps("face"), memory=False)
    return n.parallel(n.keeps("look"), n.forever(n.selector(find, oust, tackle, meet, cover, turn, n.keeps())))
