"""One of two who attack against a defence as a behaviour tree: what is more urgent stands first and takes over."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    begin = n.sequence(n.holds("waiting"), n.does("setup"), memory=False)
    hands_off = n.sequence(n.holds("barred"), n.keeps("stand"), memory=False)
    find = n.sequence(n.holds("lost or seeks"), n.keeps("sweep"), memory=False)
    take = n.sequence(n.holds("ours"), n.does("give"))
    shoot = n.sequence(n.holds("can_shoot"), n.does("shoot"))
    give = n.sequence(n.holds("can_pass"), n.does("give"))
    with_ball = n.sequence(n.holds("reach and not offside"), n.selector(take, shoot, give, n.does("push"), memory=True))
    meet = n.sequence(n.holds("chase"), n.does("meet"), memory=False)
    free = n.sequence(n.holds(f"off_place >= {OFF_PLACE}"), n.does("walk"))
    turn = n.sequence(n.holds(f"off_axis >= {OFF_AXIS}"), n.keeps("face"), memory=False)
    return n.parallel(n.keeps("look"), n.forever(n.selector(begin, hands_off, find, with_ball, meet, free, turn, n.keeps())))
