"""shoot: kick the ball at the goal as hard as can be (dissertation §2.2.7).

begin --> [start] --> ongoing + kick.begin
kick.kicked --> [finish] --> shot
kick.failed --> [miss] ----> failed           the ball was out of reach

        |
(me)o ==|==>  the middle of the goal; the leg's scatter at 20 m is far less than the goal's half width of 7 m
        |
"""

from __future__ import annotations

from ...architecture.petri import Continuous, Input, PetriNet, Transition
from ..body import Body, of_body
from .kick import kick
from .parts import interface, interface_places, within_module

BALL = ("distance", "direction", "speed_ahead", "speed_aside")
"""What the kick has to know of the ball."""
_PORTS = interface("shot", "failed", parameters=BALL)


@of_body
def shoot(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``shot``, ``failed`` and ``aborted``."""
    return PetriNet(
        "shoot",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "kicking", "stopping_kick"), Continuous("arriving", body.server.ball_speed_max),
            Input("distance", observes="ball.reckoned_distance"), Input("direction", observes="ball.reckoned_direction_deg"),
            Input("speed_ahead", observes="ball.speed_ahead"), Input("speed_aside", observes="ball.speed_aside"),
        ),
        modules={"kick": kick(body)},
        fuse={"kick.arriving": "arriving", **{f"kick.{name}": name for name in BALL}},
        transitions=(
            Transition("start", ("begin",), ("ongoing", "kicking", "kick.begin")),
            *within_module("kick", ("kicked", "failed", "aborted"), "kicking"),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("finish", ("kicking", "ongoing", "kick.kicked"), ("shot",), priority=5),
            Transition("miss", ("kicking", "ongoing", "kick.failed"), ("failed",), priority=5),
        ),
    )  # fmt: skip


SHOOT = shoot()
"""Of a default player."""
