"""One of the passing pair as a state machine: both run it, each on his own percepts."""

from __future__ import annotations

from cprm_gym.agents.passer import AFTER_SHOT, FORGOTTEN, IN_RANGE, ONSIDE, PATIENCE, UNCLAIMED, YIELD

from ..behaviour.machine import Move, State

_LIES = "mine >= 0 and ball_speed < 0.3 and ball_age < 4"
STATES = {
    "begin": State(moves=(Move("fetch", "mine >= 0", after=4), Move("run free", "mine < 0", after=4))),
    "fetch": State("go", moves=(Move("search", "his >= 3", after=YIELD),), on={"at_ball": "on the ball", "lost_ball": "search"}),
    "on the ball": State(
        moves=(
            Move("search", "out_of_reach"),
            Move("search", "his >= 0.3", after=3),
            Move("shoot", f"goal_distance < {IN_RANGE}"),
            Move("pass", f"onside >= {ONSIDE}"),
            Move("pass", after=PATIENCE),
        )
    ),
    "pass": State("passing", on={"passed": "run free", "failed": "search"}, raises=("passing.ongoing",)),
    "run free": State(
        "advance",
        moves=(Move("receive", "coming"), Move("search", f"{_LIES} and not coming", after=UNCLAIMED)),
        on={"arrived": "stand free"},
    ),
    "stand free": State(
        moves=(
            Move("receive", "coming"),
            Move("search", _LIES, after=UNCLAIMED),
            Move("search", f"ball_age >= {2 * FORGOTTEN}"),
            Move("run free", "off_place >= 1.8", after=1),
            Move("turn", "off_axis >= 60 and off_place < 1.8"),
        )
    ),
    "turn": State(order="face", moves=(Move("stand free", after=1),)),
    "receive": State("receive", on={"received": "on the ball", "missed": "search"}),
    "shoot": State("shoot", on={"shot": "hope", "failed": "search"}),
    "hope": State(moves=(Move("search", after=AFTER_SHOT),)),
    "search": State(
        moves=(
            Move("sweep", f"ball_age >= {FORGOTTEN}"),
            Move("turn to it", "off_axis >= 60"),
            Move("fetch", "mine >= 0"),
            Move("run free"),
        )
    ),
    "sweep": State(order="sweep", moves=(Move("search", after=1),)),
    "turn to it": State(order="face", moves=(Move("search", after=1),)),
}
EYES = "look"
