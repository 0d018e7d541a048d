"""intercept: run to where a rolling ball can be met, as fast as can be, until it can be kicked (dissertation §4.3).

begin --> [start] --> ongoing + ready
ready & ball in reach ------------> [arrive] --> at_ball
ready & off course & way to go ---> [turn] ----> acted
ready & else ---------------------> [dash] ----> acted      the last step goes whichever way it must, without a turn
abort ----------------------------> [stop] ----> aborted

(ball) . . . x . . >       the net around it says where x is, anew in every cycle
            /
        (me)
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Transition
from ..body import Body, number, of_body
from .kick import SURE
from .parts import interface, interface_places, standard_transitions

COURSE = 12.0
"""Degrees off course that are let pass."""
STEP = 1.1
"""Metres within which a step aside or back takes less time than a turn."""
SPARING = 0.32
"""Share of the full stamina below which he spares it, since effort would suffer."""
BESIDE = 0.3
"""Share of the kickable ring at which he wants the ball in the end."""
SEEN = 3.0
"""Cycles for which a ball in reach is trusted to be there."""

_PORTS = interface("at_ball", parameters=("way", "bearing", "distance"))


@of_body
def intercept(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``at_ball`` and ``aborted``."""
    return PetriNet(
        "intercept",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Input("way", observes="meet.distance"), Input("bearing", observes="meet.direction_deg"),
            Input("distance", observes="ball.reckoned_distance"), Input("age", observes="ball.age"),
            Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
            Math("off_course", "abs(bearing)"),
            Math("course", f"{number(COURSE)} if way > {number(STEP)} else 181"),
            Math("astray", "1 if off_course >= course else 0"),
            Math("moment", body.turn("bearing")),
            Math("heading", f"0 if way > {number(STEP)} else bearing"),
            Math("power", f"clip({body.power(1.0)} * (way - {body.within(BESIDE)} - 0.4 * speed), {body.dash(0.1)}, "
                 f"{body.dash(1.0)} if stamina > {body.stamina(SPARING)} else {body.dash(0.4)})"),
        ),
        transitions=(
            *standard_transitions(),
            Transition("arrive", ("ready", "ongoing"), ("at_ball",), inhibitors={"distance": body.within(SURE), "age": SEEN}, priority=7),
            Transition("turn", ("ready",), ("acted",), tests={"astray": 1}, emits=Command("turn", moment="moment"), priority=3),
            Transition("dash", ("ready",), ("acted",), inhibitors={"astray": 1},
                       emits=Command("dash", power="power", direction="heading"), priority=3),
        ),
    )  # fmt: skip


INTERCEPT = intercept()
"""Of a default player."""
