"""catch_ball: get into the way of a shot and catch it (dissertation §2.3.5, Fig. 2.29).

    begin --> [start] --> ongoing + ready
    ready --> [turn | dash | hold] --> acted --(one cycle)--> ready     into the ball's way
    ready & within reach -> [catch] --> grasped                         the one chance
    grasped --> [caught] --> caught      or, a cycle later, [miss] --> missed
    ready & near, out of reach -> [tackle] --> grasped
    ready & no danger ----> [over] --> over
    ready & ball behind --> [past] --> past
    abort ----------------> [stop] --> aborted

What decides are quantities derived from the believed place and velocity of the ball: where its way comes closest, how far it is
from the hands now, and how far it will be a cycle later. The catch is timed to the cycle in which the ball lies in the area that
the hands cover, as deep in it as it will get. Short ways are run sideways or backwards, without turning.
"""

from __future__ import annotations

import functools

from ...architecture.petri import AnyPlace, Command, Continuous, Input, Math, PetriNet, Place, Ports, Transition
from ..body import DEFAULT, Body, number
from .constants import FIRST, GoalieConstants, HoldingConstants

LUNGE = 0.85
"""Share of ``tackle_dist`` up to which he tackles."""


def _grasp(body: Body, c: GoalieConstants) -> tuple[tuple[str, ...], tuple[AnyPlace, ...]]:
    """Parameters and places that say when he catches: by where the ball is, or by how likely he is to hold it."""
    if isinstance(c, HoldingConstants):
        return ("hold", "hold_next"), (
            Continuous("hold"), Continuous("hold_next"),  # probabilities that a catch takes the ball, now and a cycle later
            Math("reachable", f"1 if hold > {number(c.grip)} else 0"),
            Math("now_or_never", f"1 if hold_next < hold + {number(c.patience)} else 0"),
        )  # fmt: skip
    deep = number(round(body.hands - c.early, 10))  # as near as he waits for the ball to come
    return (), (
        # whatever its direction: the hands turn as far as they can, and what they cover is as broad as an arm is long
        Math("reachable", f"1 if ball_distance < {number(body.hands)} else 0"),
        Math("now_or_never", f"1 if ball_distance < {deep} or next_distance > ball_distance - {number(c.deepening)} else 0"),
    )  # fmt: skip


@functools.lru_cache(maxsize=256)
def catch_ball(body: Body = DEFAULT, constants: GoalieConstants = FIRST) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``caught``, ``over``, ``past``, ``missed`` and ``aborted``."""
    server, c = body.server, constants
    asked, grasp = _grasp(body, c)
    lunge = number(LUNGE * server.tackle_dist)
    power = number(server.tackle_exponent)
    return PetriNet(
        "catch_ball",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="caught", errors=("over", "past", "missed", "aborted"), interrupts=("abort",),
            answers={"abort": ("aborted", "caught", "missed")}, within=2,
            parameters=(
                "ball_distance", "ball_direction", "next_distance", "way_distance", "way_direction", "coming", "behind", "flank", *asked,
            ),
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("caught", capacity=1), Place("over", capacity=1),
            Place("past", capacity=1), Place("missed", capacity=1), Place("aborted", capacity=1), Place("abort", capacity=1),
            Place("ready", capacity=1), Place("acted", capacity=1), Place("grasped", capacity=1), Place("judged", capacity=1),
            Continuous("ball_distance", 99.0), Continuous("ball_direction"),  # now: metres, degrees from the body
            Continuous("next_distance", 99.0),  # from the ball, a cycle later
            Continuous("way_distance"), Continuous("way_direction"),  # to the point of closest approach
            Continuous("coming"), Continuous("behind"), Continuous("flank"),  # degrees from the body to the free flank
            Input("speed", observes="body.speed"), Input("stopped", observes="game.stopped"),
            *grasp,
            Math("ahead", "ball_distance * cos(radians(ball_direction))"), Math("aside", "ball_distance * sin(radians(ball_direction))"),
            Math("chance",
                 f"1 - min(1, (ahead / {number(server.tackle_dist)}) ** {power} + (aside / {number(server.tackle_width)}) ** {power})"
                 " if ahead > 0 else 0"),
            Math("last_chance", f"1 if chance > {number(c.worth)} and not reachable and ball_distance < {lunge} else 0"),
            Math("off", "abs(way_direction)"),
            Math("turn_first",
                 f"1 if way_distance > {number(c.strafe)} and off > {number(c.ahead)} and (off < 140 or way_distance > 3.5) else 0"),
            Math("moment", body.turn("way_direction")),
            Math("power", f"clip({body.power(1.02)} * way_distance - {body.power(0.24)} * speed, {body.dash(0.1)}, {body.dash(1.0)})"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "ready")),
            Transition("stop_ready", ("abort", "ongoing", "ready"), ("aborted",), priority=9),
            Transition("stop_acted", ("abort", "ongoing", "acted"), ("aborted",), priority=9),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            # outcomes
            Transition("caught_it", ("judged", "ongoing"), ("caught",), tests={"stopped": 1}, priority=7),
            Transition("stop_late", ("abort", "ongoing", "judged"), ("aborted",), inhibitors={"stopped": 1}, priority=9),
            Transition("miss", ("judged", "ongoing"), ("missed",), inhibitors={"stopped": 1}, priority=6),
            # the one chance
            Transition("catch", ("ready",), ("grasped",), tests={"reachable": 1, "now_or_never": 1},
                       emits=Command("catch", direction="ball_direction"), priority=5),
            Transition("tackle", ("ready",), ("grasped",), tests={"last_chance": 1, "coming": 1},
                       emits=Command("tackle", direction="flank", foul=0.0), priority=5),
            Transition("lose", ("ready", "ongoing"), ("past",), tests={"behind": 1}, priority=4),
            Transition("relax", ("ready", "ongoing"), ("over",), inhibitors={"coming": 1, "reachable": 1}, priority=3),
            # into the way
            Transition("turn", ("ready",), ("acted",), tests={"turn_first": 1}, emits=Command("turn", moment="moment"), priority=2),
            Transition("dash", ("ready",), ("acted",), tests={"way_distance": c.close},
                       emits=Command("dash", power="power", direction="way_direction"), priority=1),
            Transition("hold", ("ready",), ("acted",)),
            Transition("tick", ("acted",), ("ready",), delay=1),
            Transition("judge", ("grasped",), ("judged",), delay=1),
        ),
    )  # fmt: skip


CATCH_BALL = catch_ball()
"""Of a default player."""
