"""look_out: keep the eyes where the ball can be, beside whatever the body does.

    begin --> [start] --> ongoing + open
    open --> [miss | expect] --> judged --> [look] --> moved --(one cycle)--> open          one turn of the neck per cycle
    stop ---------------> [close] --> stopped

The face points where the ball is thought to be in the next cycle. Each look there that does not show it is counted, and moves the next
one on: a step to the side to which it was going, a step to the other side, two steps, and so on outwards, instead of round in a circle.
The count is an output: what is made of it (`gaze`) the body reads too, which turns where the neck does not reach.
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Ports, Transition
from ..body import Body, number, of_body
from .constants import FinderConstants

COVERED = 0.8
"""Share of half the view cone within which a direction has been looked at."""
LOOKS = 12
"""Looks in a row without the ball after which it is begun again from the middle."""


def gaze(missed: str, constants: FinderConstants) -> Math:
    """Place ``gaze``: where to look after so many looks without the ball, degrees from the body.

    It reads ``expected_direction``, degrees from the body in which the ball is expected in the next cycle, and ``swing``, degrees by which
    it moves in one.
    """
    outwards = f"{number(constants.step)} * ceil({missed} / 2) * (1 if {missed} - 2 * floor({missed} / 2) >= 1 else -1)"
    return Math("gaze", f"norm_deg(expected_direction + (1 if swing >= 0 else -1) * {outwards})")


@of_body
def look_out(body: Body) -> PetriNet:
    """The skill of a player as a module; it goes on until it is stopped."""
    return PetriNet(
        "look_out",
        ports=Ports(
            begin="begin", ongoing="ongoing", errors=("stopped",), interrupts=("stop",),
            parameters=("gaze", "ball_age"), outputs=("missed",),
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("stopped", capacity=1), Place("stop", capacity=1),
            Place("open", capacity=1), Place("judged", capacity=1), Place("moved", capacity=1),
            Place("missed", capacity=LOOKS),
            Continuous("gaze"),  # where to look, degrees from the body (`gaze`)
            Continuous("ball_age", 99.0),  # cycles since it was known where it is
            Input("fresh", observes="body.fresh"), Input("neck", observes="body.neck_deg"),
            Input("half_view", observes="body.half_view_deg"),
            # a look that was made elsewhere says nothing
            Math("covered", f"1 if fresh >= 1 and abs(norm_deg(gaze - neck)) < {number(COVERED)} * half_view else 0"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "open"), sets={"missed": 0}),
            Transition("close_open", ("stop", "ongoing", "open"), ("stopped",), sets={"missed": 0}, priority=9),
            Transition("close_judged", ("stop", "ongoing", "judged"), ("stopped",), sets={"missed": 0}, priority=9),
            Transition("close_moved", ("stop", "ongoing", "moved"), ("stopped",), sets={"missed": 0}, priority=9),
            Transition("ignore", ("stop",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("see", ("open",), ("open",), tests={"missed": 1}, inhibitors={"ball_age": 1.0}, sets={"missed": 0}, priority=7),
            # what the look told, before the next one
            Transition("again", ("open",), ("judged",), tests={"covered": 1, "ball_age": 1.0, "missed": LOOKS}, sets={"missed": 0},
                       priority=6),
            Transition("miss", ("open",), ("judged", "missed"), tests={"covered": 1, "ball_age": 1.0}, inhibitors={"missed": LOOKS},
                       priority=5),
            Transition("expect", ("open",), ("judged",), priority=4),
            Transition("look", ("judged",), ("moved",), emits=Command("look", direction="gaze"), priority=3),
            Transition("blink", ("moved",), ("open",), delay=1),
        ),
    )  # fmt: skip


LOOK_OUT = look_out()
"""Of a default player."""
