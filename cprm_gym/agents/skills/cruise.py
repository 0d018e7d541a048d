"""cruise: keep running, at a power that spares stamina, until the ball is close; third part of the approach (dissertation Fig. 3.1).

begin --> [start] --> ongoing + ready
ready & ball close -------> [come_close] -> close
ready & far off course ---> [stray] ------> strayed
ready & a little off -----> [correct] ----> acted      a small turn; the run rolls on
ready & on course --------> [dash] -------> acted

(me)=> => =>  '  => => =>       (ball)
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Transition
from .accelerate import CLOSE
from .parts import interface, interface_places, life

OFF_AXIS = 8.0
"""Degrees at which a small turn corrects the course."""
OFF_COURSE = 40.0
"""Degrees at which the ball must have moved."""
POWER = 85.0
"""Power that keeps the speed."""

_PORTS = interface("close", "strayed")

CRUISE = PetriNet(
    "cruise",
    ports=_PORTS,
    places=(
        *interface_places(_PORTS, "ready", "acted"),
        Input("distance", observes="ball.reckoned_distance"), Input("bearing", observes="ball.reckoned_direction_deg"),
        Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
        Math("off_axis", "abs(bearing)"), Math("moment", "clip(bearing * (1 + 5 * speed), -180, 180)"),
        Math("power", f"{POWER} if stamina > 3500 else 50"),
    ),
    transitions=(
        *life(),
        Transition("come_close", ("ready", "ongoing"), ("close",), inhibitors={"distance": CLOSE}, priority=7),
        Transition("stray", ("ready", "ongoing"), ("strayed",), tests={"off_axis": OFF_COURSE, "distance": CLOSE}, priority=6),
        Transition("correct", ("ready",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="moment"), priority=3),
        Transition("dash", ("ready",), ("acted",), inhibitors={"off_axis": OFF_AXIS}, emits=Command("dash", power="power", direction=0.0),
                   priority=3),
    ),
)  # fmt: skip
"""The skill as a module; its outcomes are ``close``, ``strayed`` and ``aborted``."""
