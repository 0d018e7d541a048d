"""The finder as a state machine: the legs go to where the ball can be met, the eyes, a machine of their own, to where it is expected."""

from __future__ import annotations

from ..behaviour.machine import Move, State

STATES = {
    "meet": State("legs", on={"at_ball": "there"}),
    "there": State(moves=(Move("meet", after=1),)),
}
EYES = "eyes"
