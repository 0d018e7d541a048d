"""accelerate: dash at full power until fast, or until the ball is close; second part of the approach (dissertation Fig. 3.1).

begin --> [start] --> ongoing + ready
ready & ball close ----> [come_close] -> close        then slow must follow
ready & fast ----------> [reach_speed] > distant      then cruise can follow
ready & off course ----> [stray] ------> strayed
ready -----------------> [dash] -------> acted

(me)=>=>=>      . . . . .     (ball)
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Transition
from .parts import interface, interface_places, life

FAST = 0.3
"""m / cycle that are felt (after decay) at nearly full speed: 0.4 of the way made in a cycle."""
CLOSE = 3.0
"""Metres at which the ball is close."""
OFF_COURSE = 25.0
"""Degrees off the ball at which the run leads nowhere."""

_PORTS = interface("distant", "close", "strayed")

ACCELERATE = PetriNet(
    "accelerate",
    ports=_PORTS,
    places=(
        *interface_places(_PORTS, "ready", "acted"),
        Input("distance", observes="ball.reckoned_distance"), Input("bearing", observes="ball.reckoned_direction_deg"),
        Input("speed", observes="body.speed"), Math("off_course", "abs(bearing)"),
    ),
    transitions=(
        *life(),
        Transition("come_close", ("ready", "ongoing"), ("close",), inhibitors={"distance": CLOSE}, priority=7),
        Transition("stray", ("ready", "ongoing"), ("strayed",), tests={"off_course": OFF_COURSE, "distance": CLOSE}, priority=6),
        Transition("reach_speed", ("ready", "ongoing"), ("distant",), tests={"speed": FAST, "distance": CLOSE}, priority=5),
        Transition("dash", ("ready",), ("acted",), tests={"distance": CLOSE}, emits=Command("dash", power=100.0, direction=0.0),
                   priority=3),
    ),
)  # fmt: skip
"""The skill as a module; its outcomes are ``distant`` (done), ``close``, ``strayed`` and ``aborted``."""
