"""A taker as a state machine."""

from __future__ import annotations

from cprm_gym.agents.taker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.machine import Move, State

_AGAIN = {"kicked": "decide", "failed": "decide"}
STATES = {
    "decide": State(
        moves=(
            Move("look round", "lost"),
            Move("kick it out", "reach"),
            Move("tackle", "tackles"),
            Move("meet it", "chase"),
            Move("cover", f"off_place >= {OFF_PLACE}"),
            Move("turn to it", f"off_axis >= {OFF_AXIS}"),
        )
    ),
    "look round": State(order="sweep", moves=(Move("decide", after=1),)),
    "tackle": State(order="tackle", moves=(Move("decide", after=1),)),
    "turn to it": State(order="face", moves=(Move("decide", after=1),)),
    "meet it": State("meet", moves=(Move("decide", "lost or reach or tackles or not chase"),), on={"at_ball": "kick it out"}),
    "cover": State("walk", moves=(Move("decide", "lost or reach or tackles or chase"),), on={"arrived": "there"}),
    "there": State(moves=(Move("decide", after=1),)),
    "kick it out": State("oust", on=_AGAIN),
}
EYES = "look"
