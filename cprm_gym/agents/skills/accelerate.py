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
from ..body import Body, of_body
from .parts import interface, interface_places, standard_transitions

FAST = 0.75
"""Share of the top speed at which he is fast; what he feels of it is what the decay has left."""
CLOSE = 3.0
"""Metres at which the ball is close."""
OFF_COURSE = 25.0
"""Degrees off the ball at which the run leads nowhere."""

_PORTS = interface("distant", "close", "strayed")


@of_body
def accelerate(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``distant`` (done), ``close``, ``strayed`` and ``aborted``."""
    return PetriNet(
        "accelerate",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Input("distance", observes="ball.reckoned_distance"), Input("bearing", observes="ball.reckoned_direction_deg"),
            Input("speed", observes="body.speed"), Math("off_course", "abs(bearing)"),
        ),
        transitions=(
            *standard_transitions(),
            Transition("come_close", ("ready", "ongoing"), ("close",), inhibitors={"distance": CLOSE}, priority=7),
            Transition("stray", ("ready", "ongoing"), ("strayed",), tests={"off_course": OFF_COURSE, "distance": CLOSE}, priority=6),
            Transition("reach_speed", ("ready", "ongoing"), ("distant",),
                       tests={"speed": body.pace(FAST * body.kind.player_decay), "distance": CLOSE}, priority=5),
            Transition("dash", ("ready",), ("acted",), tests={"distance": CLOSE},
                       emits=Command("dash", power=body.dash(1.0), direction=0.0),
                       priority=3),
        ),
    )  # fmt: skip


ACCELERATE = accelerate()
"""Of a default player."""
