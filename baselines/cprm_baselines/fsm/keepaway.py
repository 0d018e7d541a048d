"""A keeper as a state machine."""

from __future__ import annotations

from cprm_gym.agents.keeper.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.machine import Move, State

_AGAIN = {"kicked": "decide", "failed": "decide"}
STATES = {
    "decide": State(
        moves=(
            Move("look round", "lost"),
            Move("with the ball", "reach"),
            Move("meet it", "chase"),
            Move("get open", f"off_place >= {OFF_PLACE}"),
            Move("turn to it", f"off_axis >= {OFF_AXIS}"),
        )
    ),
    "look round": State(order="sweep", moves=(Move("decide", after=1),)),
    "turn to it": State(order="face", moves=(Move("decide", after=1),)),
    "meet it": State("meet", moves=(Move("decide", "lost or reach or not chase"),), on={"at_ball": "with the ball"}),
    "get open": State("walk", moves=(Move("decide", "lost or reach or chase"),), on={"arrived": "open"}),
    "open": State(moves=(Move("decide", after=1),)),
    "with the ball": State(moves=(Move("pass", "can_pass"), Move("shelter"))),
    "pass": State("give", on=_AGAIN),
    "shelter": State("shelter", on=_AGAIN),
}
EYES = "look"
