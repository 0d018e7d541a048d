"""meet_ball: run to where the ball can be met, as long as it is known well enough, and turn where the neck does not reach.

    begin --> [start] --> ongoing + ready
    ready --> [face | turn | dash | wait] --> acted --(one cycle)--> ready      one command per cycle
    ready & at the ball --> [arrive] --> at_ball
    abort ---------------> [stop] --> aborted

A rolling ball is not run after but met: the point is where ball and player are at the same time. He goes on running while he does not see
it, up to a trust in what he thinks; then he stands and turns with his gaze.
"""

from __future__ import annotations

import functools

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Ports, Transition
from ..body import DEFAULT, Body, number
from .constants import FinderConstants
from .parts import interface, interface_places, standard_transitions

AT_BALL = 0.5
"""Share of the kickable ring at which he has arrived."""
_PORTS: Ports = interface("at_ball", parameters=("ball_distance", "ball_age", "meet_distance", "meet_direction", "gaze"))


@functools.lru_cache(maxsize=256)
def meet_ball(body: Body = DEFAULT, constants: FinderConstants = FinderConstants()) -> PetriNet:  # noqa: B008
    """The skill of a player as a module; its outcomes are ``at_ball`` and ``aborted``."""
    c = constants
    return PetriNet(
        "meet_ball",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Continuous("ball_distance", 99.0), Continuous("ball_age", 99.0),  # metres; cycles since it was known where it is
            Continuous("meet_distance", 99.0), Continuous("meet_direction"),  # to where they meet: metres, degrees from the body
            Continuous("gaze"),  # where he looks, degrees from the body
            Input("speed", observes="body.speed"),
            Math("beyond", f"1 if ball_age >= {number(c.blind)} and (abs(gaze) > {number(c.reach)} or "
                           f"ball_age >= {number(c.trust)} and abs(gaze) > 30) else 0"),
            Math("off", "abs(meet_direction)"),
            # from near every degree counts less than a cycle
            Math("narrow", f"max({number(c.ahead)}, min(60, degrees(atan2({body.within(AT_BALL)}, max(meet_distance, 0.1)))))"),
            Math("turn_first", "1 if off > narrow else 0"),
            Math("face_moment", body.turn("gaze")), Math("turn_moment", body.turn("meet_direction")),
        ),
        transitions=(
            *standard_transitions(),
            Transition("arrive", ("ready", "ongoing"), ("at_ball",), inhibitors={"ball_distance": body.within(AT_BALL), "ball_age": 1.0},
                       priority=6),
            Transition("face", ("ready",), ("acted",), tests={"beyond": 1}, emits=Command("turn", moment="face_moment"), priority=4),
            Transition("wait", ("ready",), ("acted",), tests={"ball_age": c.trust}, priority=3),
            Transition("turn", ("ready",), ("acted",), tests={"turn_first": 1}, emits=Command("turn", moment="turn_moment"), priority=2),
            Transition("dash", ("ready",), ("acted",), emits=Command("dash", power=body.dash(1.0), direction=0.0), priority=1),
        ),
    )  # fmt: skip


MEET_BALL = meet_ball()
"""Of a default player."""
