"""One of the passing pair as a behaviour tree."""

from __future__ import annotations

from cprm_gym.agents.passer import AFTER_SHOT, FORGOTTEN, IN_RANGE, ONSIDE, PATIENCE, UNCLAIMED, YIELD

from ..behaviour.trees import Behaviour, Leaves

LIES = "mine >= 0 and ball_speed < 0.3 and ball_age < 4 and not coming"
HAS = "at_ball and ball_age < 3 and his < 0.3"
BLIND = 2 * FORGOTTEN


def _find(n: Leaves) -> Behaviour:
    return n.selector(
        n.holds(f"ball_age < {FORGOTTEN} and off_axis < 60"),
        n.sequence(n.holds(f"ball_age >= {FORGOTTEN}"), n.keeps("sweep"), memory=False),
        n.keeps("face"),
    )


def _run_free(n: Leaves) -> Behaviour:
    """To the place where a pass can be taken, until it comes; then to take it. Fails when the ball lies about or is out of sight."""
    aside = n.sequence(n.holds("off_axis >= 60"), n.keeps("face"), memory=False)
    stand = n.sequence(n.holds(f"ball_age < {BLIND}"), n.selector(n.holds("off_place >= 1.8"), aside, n.keeps()), memory=False)
    free = n.forever(n.sequence(n.does("advance"), stand))
    wait = n.sequence(n.lacks(n.lasts(LIES, UNCLAIMED)), n.selector(n.holds("coming"), free), memory=False)
    return n.sequence(wait, n.does("receive"))


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    shoot = n.sequence(n.holds(f"goal_distance < {IN_RANGE}"), n.does("shoot"), n.waits(AFTER_SHOT))
    has_still = n.holds("not out_of_reach and his < 0.3")
    ready = n.sequence(has_still, n.selector(n.holds(f"onside >= {ONSIDE}"), n.waits(PATIENCE)), memory=False)
    give = n.sequence(ready, n.does("passing", "passing.ongoing"), _run_free(n))
    with_ball = n.sequence(n.holds(HAS), n.selector(shoot, give, memory=True))
    free = n.sequence(n.holds("mine < 0"), _run_free(n))
    fetch = n.sequence(_find(n), n.selector(n.lasts("his >= 3", YIELD), n.does("go")))
    legs = n.sequence(n.waits(4), n.forever(n.succeeds(n.selector(with_ball, free, fetch, memory=True))))
    return n.parallel(n.keeps("look"), legs)
