"""receive: meet a ball that is rolling towards the player (dissertation §4.3).

begin --> [start] --> ongoing + ready
ready & ball in reach -----------------> [take] -> received
ready & not seen, or no longer coming -> [miss] -> missed
ready & its way passes me by ----------> [turn | dash] -> acted
ready & it comes to me ----------------> [face | wait] -> acted

(ball) . . . . x . . .>       x: where its way comes nearest to him; where it will be, if he is later than the
               |              ball; or where it will lie. He runs there, then faces the ball and lets it come
              (me)
"""

from __future__ import annotations

from ...architecture.petri import Command, Input, Math, PetriNet, Place, Transition
from ..body import Body, number, of_body
from .go_to_ball import CLOSE
from .parts import interface, interface_places, standard_transitions

ASIDE = 0.307
"""Share of the kickable ring in which the ball may pass beside him."""
STALE = 12.0
"""Cycles without a sight of the ball after which it is missed."""
COMING = 0.12
"""m / cycle below which the ball does not come."""
PATIENCE = 4
"""Cycles in a row in which it does not come after which it is missed."""

RUN = 0.8
"""Share of the top speed that he makes on the way to the ball."""
BEHIND = 3.0
"""Metres up to which he runs after a ball that has passed him."""


def _further(body: Body, before: str, after: str) -> tuple[Math, Math]:
    """Where the ball is on its way (`after`, metres) when he has run to where he would meet it at `before`."""
    time = f"1 + hypot(ball_x + {before} * vx / ball_speed, ball_y + {before} * vy / ball_speed) / {body.pace(RUN)}"
    return Math(f"time_to_{before}", time), Math(
        after, f"max(nearest, ball_speed / {number(body.roll)} * (1 - exp(-{body.fade} * time_to_{before})))"
    )


_PORTS = interface("received", "missed", parameters=("distance", "direction", "approach", "vx", "vy"))


@of_body
def receive(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``received``, ``missed`` and ``aborted``."""
    aside = body.within(ASIDE)
    return PetriNet(
        "receive",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted"),
            Place("astray", capacity=PATIENCE),  # cycles in a row in which the ball did not come
            Input("distance", observes="ball.reckoned_distance"), Input("direction", observes="ball.reckoned_direction_deg"),
            Input("age", observes="ball.age"), Input("approach", observes="ball.approach"),
            Input("vx", observes="ball.speed_ahead"), Input("vy", observes="ball.speed_aside"), Input("speed", observes="body.speed"),
            Math("ball_x", "distance * cos(radians(direction))"), Math("ball_y", "distance * sin(radians(direction))"),
            Math("ball_speed", "max(0.001, hypot(vx, vy))"),
            # metres of its way to where it comes nearest; he may be there too late, then: to where it is when he meets it, in two steps
            Math("nearest", f"clip(-(ball_x * vx + ball_y * vy) / ball_speed, 0, ball_speed / {number(body.roll)})"),
            *_further(body, "nearest", "sooner"), *_further(body, "sooner", "along"),
            Math("x", "ball_x + along * vx / ball_speed"), Math("y", "ball_y + along * vy / ball_speed"),
            Math("coming", f"approach if distance > {BEHIND} else ball_speed"),
            Math("aside", "hypot(x, y)"),
            Math("bearing", "degrees(atan2(y, x)) if aside > 0.001 else 0"),
            Math("off_course", "abs(bearing)"),
            Math("moment", body.turn("bearing")),
            Math("power", f"clip({body.power(1.0)} * (aside - {number(aside / 2)} - speed), {body.dash(0.2)}, {body.dash(1.0)})"),
            Math("off_axis", "abs(direction)"),
            Math("face_moment", body.turn("direction")),
        ),
        transitions=(
            *standard_transitions(counters=("astray",)),
            Transition("take", ("ready", "ongoing"), ("received",), inhibitors={"distance": body.within(CLOSE), "age": 3},
                       sets={"astray": 0}, priority=7),
            Transition("miss", ("ready", "ongoing"), ("missed",), tests={"age": STALE}, sets={"astray": 0}, priority=6),
            Transition("give_up", ("ready", "ongoing"), ("missed",), tests={"astray": PATIENCE}, sets={"astray": 0}, priority=6),
            Transition("come", ("ready",), ("ready",), tests={"coming": COMING, "astray": 1}, sets={"astray": 0}, priority=5),
            Transition("idle", ("ready",), ("acted", "astray"), inhibitors={"coming": COMING}, priority=4),
            Transition("turn", ("ready",), ("acted",), tests={"aside": aside, "off_course": 20.0}, emits=Command("turn", moment="moment"),
                       priority=3),
            Transition("dash", ("ready",), ("acted",), tests={"aside": aside}, inhibitors={"off_course": 20.0},
                       emits=Command("dash", power="power", direction=0.0), priority=3),
            Transition("face", ("ready",), ("acted",), tests={"off_axis": 25.0}, emits=Command("turn", moment="face_moment"), priority=2),
            Transition("wait", ("ready",), ("acted",), priority=-1),
        ),
    )  # fmt: skip


RECEIVE = receive()
"""Of a default player."""
