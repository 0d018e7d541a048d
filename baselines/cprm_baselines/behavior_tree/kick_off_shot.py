"""The striker as a behaviour tree: the sequence once, with memory; afterwards fetch and finish, for good."""

from __future__ import annotations

from cprm_gym.agents.striker import AFTER_SHOT, COMING, FORGOTTEN, WAIT

from ..behaviour.trees import Behaviour, Leaves

COMES = f"approach >= {COMING} and ball_age < {FORGOTTEN}"


def _attack(n: Leaves) -> Behaviour:
    return n.sequence(n.does("dribble"), n.does("shoot"), n.waits(AFTER_SHOT))


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    stand = n.selector(n.sequence(n.holds("off_axis >= 60"), n.keeps("face"), memory=False), n.keeps())
    in_sight = n.sequence(n.holds(f"ball_age < {2 * FORGOTTEN}"), n.selector(n.lasts("1", WAIT), stand), memory=False)
    await_ball = n.selector(n.holds(COMES), n.sequence(n.does("advance"), in_sight, n.holds(COMES)))
    combination = n.sequence(n.does("passing", "passing.ongoing"), await_ball, n.does("receive"), _attack(n))
    find = n.selector(
        n.holds(f"ball_age < {FORGOTTEN} and off_axis < 60"),
        n.sequence(n.holds(f"ball_age >= {FORGOTTEN}"), n.keeps("sweep"), memory=False),
        n.keeps("face"),
    )
    fetch = n.sequence(find, n.does("go"))
    legs = n.sequence(n.does("setup"), n.succeeds(combination), n.forever(n.succeeds(n.sequence(fetch, _attack(n)))))
    return n.parallel(n.keeps("look"), legs)
