"""An attacker before the goal as a behaviour tree: what is more urgent stands first and takes over."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.trees import Behaviour, Leaves


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    find = n.sequence(n.holds("lost"), n.keeps("sweep"), memory=False)
    shoot = n.sequence(n.holds("can_shoot"), n.does("shoot"))
    give = n.sequence(n.holds("can_pass"), n.does("give"))
    with_ball = n.sequence(n.holds("reach"), n.selector(shoot, give, n.does("push"), memory=True))
    meet = n.sequence(n.holds("chase"), n.does("meet"), memory=False)
    free = n.sequence(n.holds(f"off_place >= {OFF_PLACE}"), n.does("walk"))
    turn = n.sequence(n.holds(f"off_axis >= {OFF_AXIS}"), n.keeps("face"), memory=False)
    return n.parallel(n.keeps("look"), n.forever(n.selector(find, with_ball, meet, free, turn, n.keeps())))
