"""The striker as a state machine: the states are those of the sequence, and every loss of the ball leads to one of them."""

from __future__ import annotations

from cprm_gym.agents.striker import AFTER_SHOT, COMING, FORGOTTEN, WAIT

from ..behaviour.machine import Move, State

_COMES = f"approach >= {COMING} and ball_age < {FORGOTTEN}"
STATES = {
    "set up": State("setup", on={"set": "pass"}),
    "pass": State("passing", on={"passed": "run forward", "failed": "find"}, raises=("passing.ongoing",)),
    "run forward": State("advance", moves=(Move("receive", _COMES),), on={"arrived": "wait"}),
    "wait": State(
        moves=(
            Move("receive", _COMES),
            Move("find", f"ball_age >= {2 * FORGOTTEN}"),
            Move("find", after=WAIT),
            Move("turn", "off_axis >= 60"),
        )
    ),
    "turn": State(order="face", moves=(Move("wait", after=1),)),
    "receive": State("receive", on={"received": "dribble", "missed": "find"}),
    "dribble": State("dribble", on={"there": "shoot", "lost_ball": "find"}),
    "shoot": State("shoot", on={"shot": "hope", "failed": "find"}),
    "hope": State(moves=(Move("find", after=AFTER_SHOT),)),
    "find": State(
        moves=(
            Move("search", f"ball_age >= {FORGOTTEN}"),
            Move("turn to it", "off_axis >= 60"),
            Move("fetch"),
        )
    ),
    "search": State(order="sweep", moves=(Move("find", after=1),)),
    "turn to it": State(order="face", moves=(Move("find", after=1),)),
    "fetch": State("go", on={"at_ball": "dribble", "lost_ball": "find"}),
}
EYES = "look"
