"""The hiker as a state machine: where he is going is the state."""

from __future__ import annotations

from ..behaviour.machine import State

STATES = {
    "out": State("out", on={"arrived": "home"}),
    "home": State("home", on={"arrived": "there"}),
    "there": State(),
}
EYES = ""
