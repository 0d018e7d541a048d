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
from ..body import Body, number, of_body
from .parts import interface, interface_places, standard_transitions

SURE = 0.907
"""Share of the kickable ring up to which he trusts himself to kick; the rest is what the eye may err."""

_PORTS = interface(
    "kicked", "failed",
    parameters=("target_distance", "target_direction", "arriving", "at_most", "distance", "direction", "speed_ahead", "speed_aside"),
)  # fmt: skip


@of_body
def kick(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``kicked``, ``failed`` and ``aborted``."""
    return PetriNet(
        "kick",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Input("target_distance", observes="goal.distance"), Input("target_direction", observes="goal.direction_deg"),
            Continuous("arriving", 1.0),  # m / cycle that the ball should have left at the target
            Continuous("at_most", body.server.ball_speed_max),  # m / cycle that it may have at first
            Input("distance", observes="ball.reckoned_distance"), Input("direction", observes="ball.reckoned_direction_deg"),
            Input("speed_ahead", observes="ball.speed_ahead"), Input("speed_aside", observes="ball.speed_aside"),
            # from the ball to the target, along the body and to its right
            Math("to_x", "target_distance * cos(radians(target_direction)) - distance * cos(radians(direction))"),
            Math("to_y", "target_distance * sin(radians(target_direction)) - distance * sin(radians(direction))"),
            Math("way", "max(0.1, hypot(to_x, to_y))"),
            Math("speed", f"clip(arriving + {number(body.roll)} * way, 0, at_most)"),
            Math("push_x", "speed * to_x / way - speed_ahead"),
            Math("push_y", "speed * to_y / way - speed_aside"),
            Math("gap", f"clip((distance - {number(body.contact)}) / {number(body.kind.kickable_margin)}, 0, 1)"),
            Math("rate", f"{number(body.kind.kick_power_rate)} * (1 - 0.25 * abs(direction) / 180 - 0.25 * gap)"),
            Math("power", f"clip(hypot(push_x, push_y) / max(rate, 0.001), 0, {number(body.server.maxpower)})"),
            Math("kick_direction", "degrees(atan2(push_y, push_x)) if hypot(push_x, push_y) > 0.001 else 0"),
            # what the kick is to do, for a model of the ball: metres that it is further off in the next cycle, degrees by which it turns
            # aside, m / cycle at which it then goes away
            Math("next_x", "distance * cos(radians(direction)) + speed * to_x / way"),
            Math("next_y", "distance * sin(radians(direction)) + speed * to_y / way"),
            Math("next_distance", "max(0.1, hypot(next_x, next_y))"),
            Math("sends", "next_distance - distance"),
            Math("deflects", "norm_deg(degrees(atan2(next_y, next_x)) - direction) if hypot(next_x, next_y) > 0.01 else 0"),
            Math("leaves", "speed * (to_x * next_x + to_y * next_y) / (way * next_distance)"),
        ),
        transitions=(
            *standard_transitions(pace=False),
            Transition("miss", ("ready", "ongoing"), ("failed",), tests={"distance": body.within(SURE)}, priority=7),
            Transition("kick", ("ready",), ("acted",), inhibitors={"distance": body.within(SURE)},
                       emits=Command("kick", power="power", direction="kick_direction"), priority=3),
            Transition("finish", ("acted", "ongoing"), ("kicked",), delay=1),
        ),
    )  # fmt: skip


KICK = kick()
"""Of a default player."""
