"""orient: turn until the ball is ahead; first part of the approach to a ball that lies still (dissertation Fig. 3.1).

begin --> [start] --> ongoing + ready
ready & seen ahead -----> [face] ----> facing         seen now: a turn is noisy, so he looks before he is sure
ready & thought ahead --> [wait] ----> acted
ready & TURNS turned ---> [give_up] -> failed
ready & aside ----------> [turn] ----> acted + turns

(me)->        (ball)  the moment makes up for inertia: a body that moves turns by 1 / (1 + 5 speed) of it
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Place, Transition
from ..body import Body, of_body
from .parts import interface, interface_places, standard_transitions

AHEAD = 5.0
"""Degrees within which the ball counts as ahead."""
TURNS = 12
"""Turns after which he gives up."""

_PORTS = interface("facing", "failed")


@of_body
def orient(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``facing``, ``failed`` and ``aborted``."""
    return PetriNet(
        "orient",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"), Place("turns", capacity=TURNS),
            Input("bearing", observes="ball.reckoned_direction_deg"), Input("speed", observes="body.speed"),
            Input("age", observes="ball.age"),
            Math("off_axis", "abs(bearing) if age < 10 else 180"),
            Math("moment", body.turn("(bearing if age < 10 else 60)")),
        ),
        transitions=(
            *standard_transitions(counters=("turns",)),
            Transition("face", ("ready", "ongoing"), ("facing",), inhibitors={"off_axis": AHEAD, "age": 1}, sets={"turns": 0}, priority=7),
            Transition("give_up", ("ready", "ongoing"), ("failed",), tests={"turns": TURNS}, sets={"turns": 0}, priority=6),
            Transition("turn", ("ready",), ("acted", "turns"), tests={"off_axis": AHEAD}, emits=Command("turn", moment="moment"),
                       priority=3),
            Transition("wait", ("ready",), ("acted",), priority=-1),
        ),
    )  # fmt: skip


ORIENT = orient()
"""Of a default player."""
