"""go_to_ball: find the ball, face it, run to it (dissertation §2.2.7, Fig. 2.13).

    begin --> [start] --> ongoing + ready
    ready --> [turn | dash | look | wait] --> acted --(one cycle)--> ready      one command per cycle
    ready & close ----> [arrive] --> at_ball
    ready & missed 2 -> [lose]   --> lost_ball
    abort ------------> [stop]   --> aborted

Facing the ball within `AHEAD` degrees, the player dashes, with a power from distance, ball speed and stamina; else he turns by the
damped angle. While the eye is closed (it opens every second cycle) direction and distance are those he believes in. Two looks in
a row without the ball and without a firm belief end in `lost_ball`.
"""

from __future__ import annotations

from dataclasses import replace

from ...architecture.petri import Belief, Command, Input, Math, PetriNet, Place, Ports, Transition
from ..body import Body, of_body

AHEAD = 12.0
"""Degrees within which the ball counts as ahead."""
CLOSE = 0.807
"""Share of the kickable ring at which the ball can surely be kicked (readings come in steps)."""
TIRED = 0.375
"""Share of the full stamina below which he spares it."""
DAMPING = 0.9
"""Share of the angle that is turned, against oscillation in the face of noise."""
LOOKS = 2
"""Looks in a row without the ball after which it is lost."""


@of_body
def go_to_ball(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``at_ball``, ``lost_ball`` and ``aborted``."""
    return PetriNet(
        "go_to_ball",
        ports=Ports(begin="begin", ongoing="ongoing", done="at_ball", errors=("lost_ball", "aborted"), interrupts=("abort",)),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("at_ball", capacity=1),
            Place("lost_ball", capacity=1), Place("aborted", capacity=1), Place("abort", capacity=1),
            Place("ready", capacity=1), Place("acted", capacity=1),
            Place("missed", capacity=LOOKS),  # looks in a row without the ball
            Input("seen", observes="ball.seen"), Input("fresh", observes="body.fresh"), Input("speed", observes="body.speed"),
            Input("stamina", observes="body.stamina"), Input("seen_distance", observes="ball.distance"),
            Input("seen_direction", observes="ball.direction_deg"), Input("closing", observes="ball.distance_change"),
            Belief("believed_distance", variable="ball.dist", view="expectation"),
            Belief("believed_direction", variable="ball.dir_deg", view="expectation"),
            Math("distance", "seen_distance if seen >= 1 else believed_distance"),
            Math("bearing", "seen_direction if seen >= 1 else believed_direction"),
            Math("off_axis", "abs(bearing)"),
            Math("moment", body.turn(f"{DAMPING} * bearing")),
            Math("look_moment", body.turn("(90 if believed_direction >= 0 else -90)")),
            Math("hurry", f"{body.hold(0.4)} + {body.hold(0.12)} * distance + {body.hold(0.4)} * max(closing + speed, 0)"),
            Math("power", f"clip(hurry, {body.dash(0.3)}, {body.dash(1.0)} if stamina > {body.stamina(TIRED)} else {body.dash(0.55)})"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready")),
            # outcomes come before actions
            Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), sets={"missed": 0}, priority=9),
            Transition("stop_acted", ("abort", "ongoing", "acted"), ("aborted",), sets={"missed": 0}, priority=9),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("arrive", ("ready", "ongoing"), ("at_ball",), tests={"seen": 1}, inhibitors={"distance": body.within(CLOSE)},
                       sets={"missed": 0},
                       priority=7),
            Transition("lose", ("ready", "ongoing"), ("lost_ball",), tests={"missed": LOOKS}, sets={"missed": 0}, priority=6),
            # what the look told
            Transition("see", ("ready",), ("ready",), tests={"seen": 1, "missed": 1}, sets={"missed": 0}, priority=5),
            # one command each cycle
            Transition("look", ("ready",), ("acted", "missed"), tests={"fresh": 1}, inhibitors={"seen": 1, "missed": LOOKS},
                       emits=Command("turn", moment="look_moment"), priority=3),
            Transition("turn", ("ready",), ("acted",), tests={"off_axis": AHEAD, "seen": 1}, emits=Command("turn", moment="moment")),
            Transition("dash", ("ready",), ("acted",), inhibitors={"off_axis": AHEAD, "missed": 1},
                       emits=Command("dash", power="power", direction=0.0)),
            Transition("wait", ("ready",), ("acted",), priority=-1),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip


GO_TO_BALL = go_to_ball()
"""Of a default player."""

_RECKONED = {"believed_distance": "ball.reckoned_distance", "believed_direction": "ball.reckoned_direction_deg"}


@of_body
def go_to_ball_reflex(body: Body) -> PetriNet:
    """The same for an agent without a model: while the eye is closed, what was last seen is carried on (§2.2.7).

    Or for one whose model says otherwise than `go_to_ball` where the ball is, who gives what he believes as parameters.
    """
    net = go_to_ball(body)
    return replace(
        net,
        name="go_to_ball_reflex",
        ports=replace(net.ports, parameters=tuple(_RECKONED)),
        places=tuple(Input(p.name, observes=_RECKONED[p.name]) if isinstance(p, Belief) else p for p in net.places),
    )


GO_TO_BALL_REFLEX = go_to_ball_reflex()
"""Of a default player."""
