"""slow: close with the ball and come to rest beside it; last part of the approach (dissertation Fig. 3.1, Appendix A, Fig. A.2).

begin --> [start] --> ongoing + ready
ready & there, and slow --> [stop_there] -> there
ready & ball far again ---> [lose] -------> strayed
ready & off axis ---------> [turn] -------> acted       moment: the whole angle
ready & on axis ----------> [brake] ------> acted       power: the body rolls out where the way left ends

With decay g = 0.4 and a felt speed s (after decay) an acceleration a lets the body roll (s + a) / (1 - g) metres, so
a = (1 - g) d - s. It may be negative: he dashes backwards.
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Transition
from ..body import Body, number, of_body
from . import accelerate
from .go_to_ball import CLOSE
from .parts import interface, interface_places, standard_transitions

BESIDE = 0.521
"""Share of the kickable ring at which he wants to stand."""
NEAR = 0.879
"""Share of it below which he no longer turns."""
STILL = 0.1
"""m / cycle below which he counts as standing."""
OFF_AXIS = 15.0
"""Degrees at which he turns."""

_PORTS = interface("there", "strayed")


@of_body
def slow(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``there``, ``strayed`` and ``aborted``."""
    return PetriNet(
        "slow",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Input("distance", observes="ball.reckoned_distance"), Input("bearing", observes="ball.reckoned_direction_deg"),
            Input("speed", observes="body.speed"), Input("speed_direction", observes="body.speed_direction_deg"),
            Math("ahead_speed", "speed * cos(radians(speed_direction))"),
            Math("off_axis", f"abs(bearing) if distance > {body.within(NEAR)} else 0"), Math("moment", body.turn("bearing")),
            Math("power",
                 f"clip({body.power(1.0)} * ({number(1.0 - body.kind.player_decay)} * (distance - {body.within(BESIDE)}) - ahead_speed), "
                 f"{body.dash(-1.0)}, {body.dash(1.0)})"),
        ),
        transitions=(
            *standard_transitions(),
            Transition("stop_there", ("ready", "ongoing"), ("there",), inhibitors={"distance": body.within(CLOSE), "speed": STILL},
                       priority=7),
            Transition("lose", ("ready", "ongoing"), ("strayed",), tests={"distance": 2 * accelerate.CLOSE}, priority=6),
            Transition("turn", ("ready",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="moment"), priority=3),
            Transition("brake", ("ready",), ("acted",), inhibitors={"off_axis": OFF_AXIS},
                       emits=Command("dash", power="power", direction=0.0),
                       priority=3),
        ),
    )  # fmt: skip


SLOW = slow()
"""Of a default player."""
