"""One of the passing pair as a behaviour tree."""

from __future__ import annotations

from cprm_gym.agents.passer import AFTER_SHOT, FORGOTTEN, IN_RANGE, ONSIDE, PATIENCE, UNCLAIMED

from ..behaviour.trees import Behaviour, Leaves

LIES = "mine >= 0 and ball_speed < 0.3 and ball_age < 4 and not coming"
HAS = "not out_of_reach and ball_age < 4 and his < 0.3"
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
    stand = n.selector(n.holds("off_place >= 1.8"), aside, n.keeps())
    free = n.forever(n.sequence(n.does("advance"), stand))
    wait = n.sequence(
        n.holds(f"ball_age < {BLIND}"), n.lacks(n.lasts(LIES, UNCLAIMED)), n.selector(n.holds("coming"), free), memory=False
    )
    return n.sequence(wait, n.does("receive"))


def grow(n: Leaves) -> Behaviour:
    """Eyes and legs at once."""
    shoot = n.sequence(n.holds(f"goal_distance < {IN_RANGE}"), n.does("shoot"), n.waits(AFTER_SHOT))
    ready = n.selector(n.holds(f"onside >= {ONSIDE}"), n.waits(PATIENCE))
    give = n.sequence(ready, n.does("passing", "passing.ongoing"), _run_free(n))
    with_ball = n.sequence(n.holds(HAS), n.selector(shoot, give, memory=True))
    fetch = n.sequence(n.holds(f"mine >= 0 or ball_age >= {BLIND}"), n.sequence(_find(n), n.does("go")), memory=False)
    legs = n.sequence(n.waits(4), n.forever(n.succeeds(n.selector(with_ball, fetch, _run_free(n)))))
    return n.parallel(n.keeps("look"), legs)
