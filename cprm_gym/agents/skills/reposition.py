"""reposition: go to the guarding place and stand side-on to the ball (dissertation §2.3.5, Fig. 2.30).

    begin --> [start] --> ongoing + ready
    ready --> [turn | dash | face] --> acted --(one cycle)--> ready
    ready & there & side-on -> [settle] --> in_place
    abort -------------------> [stop] --> aborted

The place lies between ball and goal. Side-on, because a shot is met by running along the goal, forwards or backwards, and a turn
would cost one of the ten cycles that it takes; the neck keeps the ball in view.
"""

from __future__ import annotations

from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Ports, Transition
from ...simulator.pitch import HALF_LENGTH
from ..body import Body, number, of_body
from .constants import AttackedConstants, GoalieConstants

THERE = 0.4
"""Metres from the place that are good enough."""
SIDE_ON = 14.0
"""Degrees from side-on that are good enough."""

GOAL_X = -HALF_LENGTH
"""The own goal line."""


def attacked(body: Body, c: GoalieConstants) -> tuple[Math, ...]:
    """Places by which a goalie who faces several attackers decides; none for another one.

    ``carried``: an opponent is at the ball, or soon will be, and it rolls slowly: a dribble, whichever way it goes. ``threat``: from 0 to
    1, how near to the goal the one is to whom could be passed.
    """
    if not isinstance(c, AttackedConstants):
        return ()
    return (
        Math("carried", f"1 if rival_time < {number(c.carry)} and ball_speed < {number(c.touch)} else 0"),
        Math("second_gap", f"hypot(second_x - {GOAL_X}, second_y)"),
        Math("threat", f"clip(({number(c.feared)} - second_gap) / 8, 0, 1)"),
    )


def guarding_place(c: GoalieConstants) -> tuple[Math, ...]:
    """Places ``post_x``, ``post_y``: between ball and goal; with several attackers the ball as it will be, and a step to where it could go.

    The more who could get a pass threatens, the farther the place lies towards the way from him to the goal.
    """
    c_out = f"clip({number(c.out_share)} * goal_distance + {number(c.out_least)}, {number(c.out_least)}, {number(c.out_most)})"
    if not isinstance(c, AttackedConstants):
        return (
            Math("goal_distance", f"max(0.5, hypot(ball_x - {GOAL_X}, ball_y))"),
            Math("out", c_out),
            Math("post_x", f"{GOAL_X} + out * (ball_x - {GOAL_X}) / goal_distance"), Math("post_y", "out * ball_y / goal_distance"),
        )  # fmt: skip
    return (
        Math("soon_x", f"ball_x + {number(c.foresees)} * ball_vx"), Math("soon_y", f"ball_y + {number(c.foresees)} * ball_vy"),
        Math("goal_distance", f"max(0.5, hypot(soon_x - {GOAL_X}, soon_y))"),
        Math("out", c_out),
        Math("leaning", f"{number(c.lean)} * threat"),
        Math("post_x", f"{GOAL_X} + out * ((1 - leaning) * (soon_x - {GOAL_X}) / goal_distance + "
                       f"leaning * (second_x - {GOAL_X}) / max(second_gap, 0.5))"),
        Math("post_y", "out * ((1 - leaning) * soon_y / goal_distance + leaning * second_y / max(second_gap, 0.5))"),
    )  # fmt: skip


@of_body
def reposition(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``in_place`` and ``aborted``."""
    return PetriNet(
        "reposition",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="in_place", errors=("aborted",), interrupts=("abort",),
            parameters=("post_distance", "post_direction", "side_turn"),
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("in_place", capacity=1), Place("aborted", capacity=1),
            Place("abort", capacity=1), Place("ready", capacity=1), Place("acted", capacity=1),
            Continuous("post_distance"), Continuous("post_direction"),  # to the guarding place: metres, degrees from the body
            Continuous("side_turn"),  # degrees to the nearer of the two side-on directions
            Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
            Math("turn_first", "1 if post_distance > 3 and abs(post_direction) > 30 else 0"),
            Math("moment", body.turn("post_direction")),
            Math("face_moment", body.turn("side_turn")),
            Math("off_side", "abs(side_turn)"),
            Math("power", f"clip({body.power(0.72)} * post_distance - {body.power(0.36)} * speed, {body.dash(0.1)}, "
                 f"{body.dash(1.0)} if stamina > {body.stamina(0.5)} else {body.dash(0.5)})"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready")),
            Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), priority=9),
            Transition("stop_acted", ("abort", "ongoing", "acted"), ("aborted",), priority=9),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("settle", ("ready", "ongoing"), ("in_place",), inhibitors={"post_distance": THERE, "off_side": SIDE_ON}, priority=5),
            Transition("turn", ("ready",), ("acted",), tests={"turn_first": 1}, emits=Command("turn", moment="moment"), priority=3),
            Transition("face", ("ready",), ("acted",), inhibitors={"post_distance": 3.0}, tests={"off_side": SIDE_ON},
                       emits=Command("turn", moment="face_moment"), priority=2),
            Transition("dash", ("ready",), ("acted",), emits=Command("dash", power="power", direction="post_direction")),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip


REPOSITION = reposition()
"""Of a default player."""
