"""setup: before a kick-off, take the place from which to play (dissertation §2.2.7).

begin --> [start] --> ongoing + ready
ready & play has begun ------------> [play] ---> set
ready & waiting & far from place --> [place] --> acted      move(x, y): a player may be put anywhere in his half
ready & waiting & at the place ----> [face] ---> acted      turns to the ball
ready ------------------------------> [wait] ---> acted
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Transition
from ..body import Body, of_body
from .parts import interface, interface_places, standard_transitions

PLACED = 0.6
"""Metres from the place within which he is there (he is not sure of his own place to a few decimetres)."""
FACING = 20.0
"""Degrees within which he faces the ball."""
BESIDE = 0.45
"""Share of the kickable ring at which he stands behind the ball, unless the net around him says where."""

_PORTS = interface("set", parameters=("place_x", "place_y"))


@of_body
def setup(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``set`` and ``aborted``."""
    return PetriNet(
        "setup",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Continuous("place_x", -body.within(BESIDE)), Continuous("place_y", 0.0),
            Input("waiting", observes="game.waiting"), Input("x", observes="me.x"), Input("y", observes="me.y"),
            Input("bearing", observes="ball.reckoned_direction_deg"), Input("ball_age", observes="ball.age"),
            Math("away", "hypot(x - place_x, y - place_y)"),
            Math("off_axis", "abs(bearing) if ball_age < 10 else 0"),
        ),
        transitions=(
            *standard_transitions(),
            Transition("play", ("ready", "ongoing"), ("set",), inhibitors={"waiting": 1}, priority=7),
            Transition("place", ("ready",), ("acted",), tests={"waiting": 1, "away": PLACED},
                       emits=Command("move", x="place_x", y="place_y"),
                       priority=3),
            Transition("face", ("ready",), ("acted",), tests={"waiting": 1, "off_axis": FACING}, inhibitors={"away": PLACED},
                       emits=Command("turn", moment="bearing"), priority=2),
            Transition("wait", ("ready",), ("acted",), priority=-1),
        ),
    )  # fmt: skip


SETUP = setup()
"""Of a default player."""
