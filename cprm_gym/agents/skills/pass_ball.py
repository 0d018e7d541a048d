"""pass_ball: seek the team-mate, face him, pass, and see the ball go (dissertation §2.2.7 Fig. 2.12; §4.3.1 Fig. 4.4).

begin --> [start] --> ongoing + ready
ready & ball drifted away ---> [drift] --> failed
ready & ball still rolling --> [stop] ---> trapping: trap.begin; trap.kicked, then a look -> ready    (a kick that stops it)
ready & just out of reach ---> [step] ---> acted          a step towards the ball, whichever way he faces
ready & mate not seen lately > [seek] ---> acted          turns the body, looking for him
ready & mate seen, aside ----> [face] ---> acted + turns  at most two turns: the second, smaller one is the more precise
ready & mate seen, faced ----> [pass] ---> kicking: kick.begin
kick.kicked --> [watch] --> watching
watching & ball seen to move off -----> [see_off] --> passed
watching & it does not, for a while --> [stuck] ----> failed

(me)o - - - - - - ->  (mate)       the power follows from the distance: the ball arrives with `arriving` m / cycle
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Transition
from ..body import Body, of_body
from .kick import SURE, kick
from .parts import interface, interface_places, standard_transitions, within_module

DRIFTED = 0.715
"""Metres beyond his reach at which the ball has drifted away."""
RECENT = 4.0
"""Cycles within which the team-mate must have been seen."""
FACING = 10.0
"""Degrees within which he faces him."""
TURNS = 2
"""Turns that he makes at most."""
ROLLING = 0.25
"""m / cycle at which the ball would roll away while he turns."""
SEEKS = 12
"""Looks around for a team-mate, beyond which there is none."""
MOVED = 0.515
"""Metres beyond his reach at which the ball has moved off after the kick."""
BESIDE = 0.45
"""Share of the kickable ring at which he wants the ball."""
WATCH = 8
"""Cycles within which it must have."""

_BALL = ("distance", "direction", "vx", "vy")
"""What he has to know of the ball: metres, degrees from the body, m / cycle along the body and to its right."""
_PORTS = interface("passed", "failed", parameters=("target_distance", "target_direction", "mate_age", "arriving", *_BALL))


@of_body
def pass_ball(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``passed``, ``failed`` and ``aborted``."""
    reach = body.within(SURE)
    return PetriNet(
        "pass_ball",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, "ready", "acted", "kicking", "watching", "trapping", "settling", "stopping_kick", "stopping_trap"),
            Place("turns", capacity=TURNS), Place("seeks", capacity=SEEKS),
            Input("target_distance", observes="mate.distance"), Input("target_direction", observes="mate.direction_deg"),
            Input("mate_age", observes="mate.age"), Input("distance", observes="ball.reckoned_distance"),
            Input("speed", observes="body.speed"),
            Continuous("arriving", 0.9), Continuous("sweep", 60.0),
            Continuous("no_speed", 0.0), Input("fresh", observes="body.fresh"),
            Input("vx", observes="ball.speed_ahead"), Input("vy", observes="ball.speed_aside"),
            Math("rolling", "hypot(vx, vy)"),
            Input("ball_age", observes="ball.age"), Input("direction", observes="ball.reckoned_direction_deg"),
            Math("step_power", f"clip({body.power(1.0)} * (distance - {body.within(BESIDE)} - speed), {body.dash(0.1)}, {body.dash(0.6)})"),
            Math("off_axis", "abs(target_direction)"),
            Math("moment", body.turn("target_direction")),
            Math("seek_moment", body.turn("sweep")),
        ),
        modules={"kick": kick(body), "trap": kick(body)},
        fuse={"kick.target_distance": "target_distance", "kick.target_direction": "target_direction", "kick.arriving": "arriving",
              "trap.at_most": "no_speed",
              **{f"{kick}.{inner}": own for kick in ("kick", "trap")
                 for inner, own in zip(("distance", "direction", "speed_ahead", "speed_aside"), _BALL)}},
        transitions=(
            *standard_transitions(("ready", "acted", "watching", "settling"), ("turns", "seeks")),
            *within_module("kick", ("kicked", "aborted"), "kicking"),
            *within_module("trap", ("kicked", "aborted"), "trapping", ("turns", "seeks")),  # in reach when they begin, so they do not fail
            Transition("drift", ("ready", "ongoing"), ("failed",), tests={"distance": round(body.reach + DRIFTED, 6)},
                       sets={"turns": 0, "seeks": 0}, priority=7),
            Transition("nobody", ("ready", "ongoing"), ("failed",), tests={"mate_age": RECENT, "seeks": SEEKS},
                       sets={"turns": 0, "seeks": 0},
                       priority=6),
            Transition("stop", ("ready",), ("trapping", "trap.begin"), tests={"rolling": ROLLING}, inhibitors={"distance": reach},
                       priority=5),
            Transition("trapped", ("trapping", "trap.kicked"), ("settling",), priority=5),
            Transition("see_it_lie", ("settling",), ("ready",), tests={"fresh": 1}, priority=5),
            Transition("step", ("ready",), ("acted",), tests={"distance": reach},
                       emits=Command("dash", power="step_power", direction="direction"), priority=5),
            Transition("seek", ("ready",), ("acted", "seeks"), tests={"mate_age": RECENT}, emits=Command("turn", moment="seek_moment"),
                       priority=4),
            Transition("face", ("ready",), ("acted", "turns"), tests={"off_axis": FACING}, inhibitors={"mate_age": RECENT},
                       emits=Command("turn", moment="moment"), priority=3),
            Transition("pass", ("ready",), ("kicking", "kick.begin"), inhibitors={"mate_age": RECENT},
                       sets={"turns": 0, "seeks": 0}, priority=2),
            Transition("watch", ("kicking", "kick.kicked"), ("watching",), priority=5),
            Transition("see_off", ("watching", "ongoing"), ("passed",), tests={"distance": round(body.reach + MOVED, 6)},
                       inhibitors={"ball_age": 1}, priority=5),
            Transition("stuck", ("watching", "ongoing"), ("failed",), delay=WATCH),
        ),
    )  # fmt: skip


PASS_BALL = pass_ball()
"""Of a default player."""
