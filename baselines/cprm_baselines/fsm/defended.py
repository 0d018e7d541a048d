"""One of two who attack against a defence as a state machine."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.machine import Move, State

_URGENT = "waiting or barred or lost or seeks or (reach and not offside)"
STATES = {
    "decide": State(
        moves=(
            Move("set up", "waiting"),
            Move("hands off", "barred"),
            Move("look round", "lost or seeks"),
            Move("with the ball", "reach and not offside"),
            Move("meet it", "chase"),
            Move("run free", f"off_place >= {OFF_PLACE}"),
            Move("turn to it", f"off_axis >= {OFF_AXIS}"),
        )
    ),
    "set up": State("setup", on={"set": "rest"}),
    "rest": State(moves=(Move("decide", after=1),)),
    "hands off": State(order="stand", moves=(Move("decide", after=1),)),
    "look round": State(order="sweep", moves=(Move("decide", after=1),)),
    "turn to it": State(order="face", moves=(Move("decide", after=1),)),
    "meet it": State("meet", moves=(Move("decide", f"{_URGENT} or not chase"),), on={"at_ball": "with the ball"}),
    "run free": State("walk", moves=(Move("decide", f"{_URGENT} or chase"),), on={"arrived": "decide"}),
    "with the ball": State(
        moves=(Move("rest", "not may"), Move("take", "ours"), Move("shoot", "can_shoot"), Move("pass", "can_pass"), Move("push"))
    ),
    "take": State("give", on={"kicked": "rest", "failed": "rest"}),
    "shoot": State("shoot", on={"kicked": "decide", "failed": "decide"}),
    "pass": State("give", on={"kicked": "decide", "failed": "decide"}),
    "push": State("push", on={"kicked": "decide", "failed": "decide"}),
}
EYES = "look"
