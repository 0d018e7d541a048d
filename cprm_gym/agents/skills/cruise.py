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
from ..body import Body, of_body
from .accelerate import CLOSE
from .advance import FRESH
from .parts import interface, interface_places, standard_transitions

OFF_AXIS = 8.0
"""Degrees at which a small turn corrects the course."""
OFF_COURSE = 40.0
"""Degrees at which the ball must have moved."""
POWER = 0.85
"""Share of the power with which he keeps nearly his speed."""

_PORTS = interface("close", "strayed")


@of_body
def cruise(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``close``, ``strayed`` and ``aborted``."""
    return PetriNet(
        "cruise",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Input("distance", observes="ball.reckoned_distance"), Input("bearing", observes="ball.reckoned_direction_deg"),
            Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
            Math("off_axis", "abs(bearing)"), Math("moment", body.turn("bearing")),
            Math("power", f"{body.dash(POWER)} if stamina > {body.stamina(FRESH)} else {body.dash(0.5)}"),
        ),
        transitions=(
            *standard_transitions(),
            Transition("come_close", ("ready", "ongoing"), ("close",), inhibitors={"distance": CLOSE}, priority=7),
            Transition("stray", ("ready", "ongoing"), ("strayed",), tests={"off_axis": OFF_COURSE, "distance": CLOSE}, priority=6),
            Transition("correct", ("ready",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="moment"), priority=3),
            Transition("dash", ("ready",), ("acted",), inhibitors={"off_axis": OFF_AXIS},
                       emits=Command("dash", power="power", direction=0.0),
                       priority=3),
        ),
    )  # fmt: skip


CRUISE = cruise()
"""Of a default player."""
