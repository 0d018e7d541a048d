"""kick: one kick that sends the ball towards a target, with a speed that suits the distance (dissertation §2.2.7).

begin --> [start] --> ongoing + ready
ready & ball out of reach --> [miss] --> failed
ready --> [kick] --> acted --(one cycle)--> [finish] --> kicked

       target                 power and direction by math: the acceleration wanted is the velocity that the ball should get,
      /  velocity wanted      less the one that it has; the leg gives less the further the ball is from the body and from
(ball)---- velocity it has    ahead (specification/simulator.md 4.3), so power makes up for it.
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Transition
from .parts import interface, interface_places, life

REACH = 1.02
"""Metres between the centres of player and ball up to which he trusts himself to kick (1.085 m less what the eye may err)."""
ROLL = 0.06
"""1 - ``ball_decay``: a ball of v m / cycle rolls v / ROLL metres."""

_PORTS = interface(
    "kicked", "failed",
    parameters=("target_distance", "target_direction", "arriving", "at_most", "distance", "direction", "speed_ahead", "speed_aside"),
)  # fmt: skip

KICK = PetriNet(
    "kick",
    ports=_PORTS,
    places=(
        *interface_places(_PORTS, "ready", "acted"),
        Input("target_distance", observes="goal.distance"), Input("target_direction", observes="goal.direction_deg"),
        Continuous("arriving", 1.0),  # m / cycle that the ball should have left at the target
        Continuous("at_most", 3.0),  # m / cycle that it may have at first
        Input("distance", observes="ball.reckoned_distance"), Input("direction", observes="ball.reckoned_direction_deg"),
        Input("speed_ahead", observes="ball.speed_ahead"), Input("speed_aside", observes="ball.speed_aside"),
        # from the ball to the target, along the body and to its right
        Math("to_x", "target_distance * cos(radians(target_direction)) - distance * cos(radians(direction))"),
        Math("to_y", "target_distance * sin(radians(target_direction)) - distance * sin(radians(direction))"),
        Math("way", "max(0.1, hypot(to_x, to_y))"),
        Math("speed", f"clip(arriving + {ROLL} * way, 0, at_most)"),
        Math("push_x", "speed * to_x / way - speed_ahead"),
        Math("push_y", "speed * to_y / way - speed_aside"),
        Math("gap", "clip((distance - 0.385) / 0.7, 0, 1)"),
        Math("rate", "0.027 * (1 - 0.25 * abs(direction) / 180 - 0.25 * gap)"),
        Math("power", "clip(hypot(push_x, push_y) / max(rate, 0.01), 0, 100)"),
        Math("kick_direction", "degrees(atan2(push_y, push_x)) if hypot(push_x, push_y) > 0.001 else 0"),
        # what the kick is to do, for a model of the ball: metres that it is further off in the next cycle, degrees by which it turns aside,
        # m / cycle at which it then goes away
        Math("next_x", "distance * cos(radians(direction)) + speed * to_x / way"),
        Math("next_y", "distance * sin(radians(direction)) + speed * to_y / way"),
        Math("next_distance", "max(0.1, hypot(next_x, next_y))"),
        Math("sends", "next_distance - distance"),
        Math("deflects", "norm_deg(degrees(atan2(next_y, next_x)) - direction) if hypot(next_x, next_y) > 0.01 else 0"),
        Math("leaves", "speed * (to_x * next_x + to_y * next_y) / (way * next_distance)"),
    ),
    transitions=(
        *life(pace=False),
        Transition("miss", ("ready", "ongoing"), ("failed",), tests={"distance": REACH}, priority=7),
        Transition("kick", ("ready",), ("acted",), inhibitors={"distance": REACH},
                   emits=Command("kick", power="power", direction="kick_direction"), priority=3),
        Transition("finish", ("acted", "ongoing"), ("kicked",), delay=1),
    ),
)  # fmt: skip
"""The skill as a module; its outcomes are ``kicked``, ``failed`` and ``aborted``."""
