"""advance: run to a place on the pitch until told to stop (dissertation §4.3.2, Fig. 4.5).

begin --> [start] --> ongoing + ready
ready & there ------> [arrive] --> arrived
ready & off course -> [turn] ----> acted
ready & on course --> [dash] ----> acted
abort --------------> [stop] ----> aborted           the safe state: he stands still; set arcs empty the inside (Fig. 4.5)

o--.            he turns back on course only when he is off it by more than a margin that grows near the place
    `--> x      and dashes as hard as the way that is left and his stamina allow
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Transition
from ..body import Body, of_body
from .parts import interface, interface_places, standard_transitions

THERE = 1.0
"""Metres within which he has arrived."""
COURSE = 15.0
"""Degrees off course that are let pass."""
FRESH = 0.4375
"""Share of the full stamina above which he runs as hard as he can."""

_PORTS = interface("arrived", parameters=("place_x", "place_y"))


@of_body
def advance(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``arrived`` and ``aborted``."""
    return PetriNet(
        "advance",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Continuous("place_x"), Continuous("place_y"), Input("x", observes="me.x"), Input("y", observes="me.y"),
            Input("facing", observes="me.facing_deg"),
            Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
            Math("distance", "hypot(place_x - x, place_y - y)"),
            Math("bearing", "norm_deg(degrees(atan2(place_y - y, place_x - x)) - facing) if distance > 0.001 else 0"),
            Math("off_course", "abs(bearing)"),
            Math("moment", body.turn("bearing")),
            Math("power", f"clip({body.power(1.0)} * (distance - speed), {body.dash(0.2)}, "
                 f"{body.dash(1.0)} if stamina > {body.stamina(FRESH)} else {body.dash(0.5)})"),
        ),
        transitions=(
            *(t for t in standard_transitions() if not t.name.startswith("stop_")),
            Transition("stop", ("abort", "ongoing"), ("aborted",), sets={"ready": 0, "acted": 0}, priority=9),
            Transition("arrive", ("ready", "ongoing"), ("arrived",), inhibitors={"distance": THERE}, priority=7),
            Transition("turn", ("ready",), ("acted",), tests={"off_course": COURSE}, emits=Command("turn", moment="moment"), priority=3),
            Transition("dash", ("ready",), ("acted",), inhibitors={"off_course": COURSE},
                       emits=Command("dash", power="power", direction=0.0),
                       priority=3),
        ),
    )  # fmt: skip


ADVANCE = advance()
"""Of a default player."""
