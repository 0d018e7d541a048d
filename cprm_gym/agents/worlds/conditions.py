"""What each behaviour is said to keep, as formulas over episodes on its stage (`runs.true_signals`).

A precondition is about how an episode begins, a postcondition about what an outcome promises, a property about the way there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple


class Condition(NamedTuple):
    """One of them."""

    name: str
    kind: Literal["precondition", "postcondition", "property"]
    formula: str
    """Of `architecture.analysis.sampling.properties`."""


def _begins(name: str, formula: str) -> Condition:
    return Condition(name, "precondition", formula)


def _ends(name: str, formula: str) -> Condition:
    return Condition(name, "postcondition", formula)


def _keeps(name: str, formula: str) -> Condition:
    return Condition(name, "property", formula)


CONDITIONS: Mapping[str, tuple[Condition, ...]] = {
    "approach": (
        _begins("the ball lies 8 to 25 m away", "true.distance > 7.9 & true.distance < 25.1 & true.ball_speed < 0.01"),
        _keeps("orient is over within 12 cycles", "G (works.orient -> F[0,12] !works.orient)"),
        _ends("after orient the ball is ahead", "F (works.accelerate & true.off_axis < 12)"),
        _ends("after cruise the ball is close", "F (works.slow & true.distance < 5)"),
        _ends("arrived: he stands at the ball", "F (ends.arrived & true.promised)"),
    ),
    "catch_ball": (
        _begins("the ball comes from 10 to 35 m", "true.distance > 10 & true.distance < 35 & true.ball_speed > 0.3"),
        _keeps("a ball within reach of his hands is grasped at", "G !true.promised | F catch"),
        _ends("caught: the ball is in his hands", "F (ends.caught & true.promised)"),
    ),
    "go_to_ball": (
        _begins("the ball lies 5 to 25 m away, within 45 degrees", "true.distance > 4.9 & true.distance < 25.1 & true.off_axis < 46"),
        _keeps("a turn brings a ball that is off axis nearer to it", "G (turn & true.off_axis > 25 -> N true.straighter > 0)"),
        _keeps("a dash comes nearer within two cycles", "G (dash & true.distance > 3 -> F[1,3] true.nearer > 0 | F[0,3] ends.at_ball)"),
        _ends("at_ball: the ball is in reach", "F (ends.at_ball & true.promised)"),
    ),
    "pass_ball": (
        _begins("the ball lies at his feet", "true.distance < 1.1 & true.ball_speed < 0.01"),
        _keeps("a turn faces the team-mate", "G (turn & mate.age < 1 & true.mate_off_axis > 30 -> N true.mate_off_axis < 30)"),
        _ends("passed: the ball flies to the team-mate", "F (ends.passed & true.off_mate < 25 & true.ball_speed > 0.5)"),
    ),
    "receive": (
        _begins("the ball rolls to him from 12 to 20 m", "true.distance > 11.9 & true.distance < 20.1 & true.ball_speed > 0.3"),
        _keeps("he stands by the ball's way when it is 3 m off", "G (true.distance < 3 & true.ball_speed > 0.3 -> true.aside < 1.5)"),
        _ends("received: the ball is in reach", "F (ends.received & true.promised)"),
    ),
    "pass_and_receive": (
        _begins("the ball lies at the passer's feet", "true.distance < 1.1 & true.ball_speed < 0.01"),
        _ends("the passer plays the ball to his team-mate", "F (true.off_mate < 15 & true.ball_speed > 0.5)"),
        _ends("received: the ball is in the receiver's reach", "F (ends.received & true.promised)"),
    ),
}
"""Behaviour -> what it is said to keep."""
