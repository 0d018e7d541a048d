"""dribble: drive the ball before oneself until the goal is near (dissertation §2.2.7, Fig. 2.14).

begin --> [start] --> ongoing + ready
ready & goal near -----> [arrive] --> there
ready & ball in reach -> [push] ----> pushing:  kick.begin;  kick.kicked -> [follow] -> following: go.begin
ready & ball too far --> [lose] ----> lost_ball
go.at_ball ------------> [again] ---> ready
go.lost_ball ----------> [lose_it] -> lost_ball
following & ball too far for GRACE cycles --> [drift] --> go.abort --> lost_ball    (not checked just after a kick)

(me)o-> . . . . o   a light kick towards the goal, then go_to_ball, and again
"""

from __future__ import annotations

from ...architecture.petri import Continuous, Input, PetriNet, Transition
from ..body import Body, of_body
from .go_to_ball import go_to_ball_reflex
from .kick import SURE, kick
from .parts import interface, interface_places, within_module

NEAR = 17.0
"""Metres from the goal at which he has arrived."""
TOO_FAR = 8.0
"""Metres at which the ball is lost."""
GRACE = 8
"""Cycles for which it may be so far, since he himself kicks it ahead."""
PUSH = 15.0
"""Metres that the ball rolls after the light kick; it slows to his speed on the way."""

_PORTS = interface("there", "lost_ball")


@of_body
def dribble(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``there``, ``lost_ball`` and ``aborted``."""
    reach = body.within(SURE)
    return PetriNet(
        "dribble",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "pushing", "following", "drifting", "stopping_kick", "stopping_go"),
            Input("goal_distance", observes="goal.distance"), Input("distance", observes="ball.reckoned_distance"),
            Continuous("light", round(PUSH * body.roll, 6)),
        ),
        modules={"kick": kick(body), "go": go_to_ball_reflex(body)},
        fuse={"kick.at_most": "light"},
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready")),
            Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), priority=9),
            *within_module("kick", ("kicked", "aborted"), "pushing"),  # the ball is in reach when it begins, so it does not fail
            *within_module("go", ("at_ball", "lost_ball", "aborted"), "following"),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("arrive", ("ready", "ongoing"), ("there",), inhibitors={"goal_distance": NEAR, "distance": reach}, priority=7),
            Transition("lose", ("ready", "ongoing"), ("lost_ball",), tests={"distance": TOO_FAR}, priority=6),
            Transition("push", ("ready",), ("pushing", "kick.begin"), inhibitors={"distance": reach}, priority=4),
            Transition("fetch", ("ready",), ("following", "go.begin"), tests={"distance": reach}, delay=1),
            Transition("follow", ("pushing", "kick.kicked"), ("following", "go.begin"), priority=5),
            Transition("again", ("following", "go.at_ball"), ("ready",), priority=5),
            Transition("lose_it", ("following", "ongoing", "go.lost_ball"), ("lost_ball",), priority=5),
            Transition("drift", ("following",), ("drifting", "go.abort"), tests={"distance": TOO_FAR}, delay=GRACE),
            Transition("drifted", ("drifting", "ongoing", "go.aborted"), ("lost_ball",), priority=5),
        ),
    )  # fmt: skip


DRIBBLE = dribble()
"""Of a default player."""
