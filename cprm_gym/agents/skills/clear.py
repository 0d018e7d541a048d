"""clear: kick the ball away from the own goal (dissertation §2.3.5, Fig. 2.30).

    begin --> [start] --> ongoing + ready
    ready & ball at hand -> [kick] --> kicked --(one cycle)--> [away] --> cleared
    ready --> [wait] --> waited --(one cycle)--> ready                  at most `PATIENCE` times
    ready & waited enough -> [give_up] --> failed
    abort ----------------> [stop] --> aborted

After a catch the ball lies at the goalie's hands; he kicks it as hard as he can to the flank on which it is.
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, PetriNet, Place, Ports, Transition
from ..body import Body, of_body

AT_HAND = 0.85
"""Share of the kickable ring within which the ball can surely be kicked."""
PATIENCE = 4
"""Cycles that the goalie waits for the ball to be at hand."""


@of_body
def clear(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``cleared``, ``failed`` and ``aborted``."""
    return PetriNet(
        "clear",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="cleared", errors=("failed", "aborted"), interrupts=("abort",),
            answers={"abort": ("aborted", "cleared", "failed")}, within=2, parameters=("ball_distance", "flank"),
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("cleared", capacity=1), Place("failed", capacity=1),
            Place("aborted", capacity=1), Place("abort", capacity=1), Place("ready", capacity=1), Place("waited", capacity=1),
            Place("kicked", capacity=1), Place("patience", capacity=PATIENCE),
            Continuous("ball_distance", 99.0), Continuous("flank"),  # metres; degrees from the body to the free flank
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready"), sets={"patience": 0}),
            Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), sets={"patience": 0}, priority=9),
            Transition("stop_waited", ("abort", "ongoing", "waited"), ("aborted",), sets={"patience": 0}, priority=9),
            Transition("stop_kicked", ("abort", "ongoing", "kicked"), ("aborted",), sets={"patience": 0}, priority=9),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("kick", ("ready",), ("kicked",), inhibitors={"ball_distance": body.within(AT_HAND)},
                       emits=Command("kick", power=body.server.maxpower, direction="flank"), priority=5),
            Transition("give_up", ("ready", "ongoing"), ("failed",), tests={"patience": PATIENCE}, sets={"patience": 0}, priority=4),
            Transition("wait", ("ready",), ("waited", "patience"), priority=1),
            Transition("go_on", ("waited",), ("ready",), delay=1),
            Transition("away", ("kicked", "ongoing"), ("cleared",), sets={"patience": 0}, delay=1),
        ),
    )  # fmt: skip


CLEAR = clear()
"""Of a default player."""
