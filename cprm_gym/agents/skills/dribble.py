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
from .go_to_ball import GO_TO_BALL_REFLEX
from .kick import KICK, REACH
from .parts import interface, interface_places, within_module

NEAR = 17.0
"""Metres from the goal at which he has arrived."""
TOO_FAR = 8.0
"""Metres at which the ball is lost."""
GRACE = 8
"""Cycles for which it may be so far, since he himself kicks it ahead."""
PUSH = 0.9
"""m / cycle of the ball after the light kick; it rolls 15 m and slows to his speed on the way."""

_PORTS = interface("there", "lost_ball")

DRIBBLE = PetriNet(
    "dribble",
    ports=_PORTS,
    places=(
        *interface_places(_PORTS, "ready", "pushing", "following", "drifting", "stopping_kick", "stopping_go"),
        Input("goal_distance", observes="goal.distance"), Input("distance", observes="ball.reckoned_distance"),
        Continuous("light", PUSH),
    ),
    modules={"kick": KICK, "go": GO_TO_BALL_REFLEX},
    fuse={"kick.at_most": "light"},
    transitions=(
        Transition("start", ("begin",), ("ongoing", "ready")),
        Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), priority=9),
        *within_module("kick", ("kicked", "aborted"), "pushing"),  # the ball is in reach when it begins, so it does not fail
        *within_module("go", ("at_ball", "lost_ball", "aborted"), "following"),
        Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
        Transition("arrive", ("ready", "ongoing"), ("there",), inhibitors={"goal_distance": NEAR, "distance": REACH}, priority=7),
        Transition("lose", ("ready", "ongoing"), ("lost_ball",), tests={"distance": TOO_FAR}, priority=6),
        Transition("push", ("ready",), ("pushing", "kick.begin"), inhibitors={"distance": REACH}, priority=4),
        Transition("fetch", ("ready",), ("following", "go.begin"), tests={"distance": REACH}, delay=1),
        Transition("follow", ("pushing", "kick.kicked"), ("following", "go.begin"), priority=5),
        Transition("again", ("following", "go.at_ball"), ("ready",), priority=5),
        Transition("lose_it", ("following", "ongoing", "go.lost_ball"), ("lost_ball",), priority=5),
        Transition("drift", ("following",), ("drifting", "go.abort"), tests={"distance": TOO_FAR}, delay=GRACE),
        Transition("drifted", ("drifting", "ongoing", "go.aborted"), ("lost_ball",), priority=5),
    ),
)  # fmt: skip
"""The skill as a module; its outcomes are ``there``, ``lost_ball`` and ``aborted``."""
