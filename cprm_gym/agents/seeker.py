"""The seeker: goes to the ball, looks for it again when it is lost, and stays at it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..architecture.cprm import CPRM, Observe
from ..architecture.petri import AnyPlace, Input, Math, PetriNet, Place, Transition
from ..envs.tasks import Task
from ..lazy import made_on_use
from .body import Body, number, of_body
from .models import ball_model
from .percepts import ball_percepts, field_percepts
from .play import SoccerAgent
from .skills.go_to_ball import go_to_ball, go_to_ball_reflex

OLD = 5.0
"""Cycles without a sight of the ball after which a reckoned direction tells nothing."""


def _net(name: str, go: PetriNet, known: tuple[AnyPlace, ...] = (), fuse: Mapping[str, str] | None = None) -> PetriNet:
    return PetriNet(
        name,
        places=(Place("intend", capacity=1, tokens=1), Place("arrived", capacity=1), *known),
        modules={"go": go},
        fuse=fuse or {},
        transitions=(
            Transition("set_out", ("intend",), ("go.begin",)),
            Transition("arrive", ("go.at_ball",), ("arrived",)),
            Transition("search_again", ("go.lost_ball",), ("intend",)),
            Transition("give_way", ("go.aborted",), ("intend",)),
            Transition("follow", ("arrived",), ("intend",), delay=1),
        ),
    )


@of_body
def seeker_net(body: Body) -> PetriNet:
    """High level: one module, started again when it loses the ball, and a cycle after it has arrived."""
    return _net("seeker", go_to_ball(body))


SEEKER_NET = seeker_net()
"""Of a default player."""


@of_body
def seeker_cprm(body: Body) -> CPRM:
    """Net, belief about the ball, and the links between them."""
    return CPRM(
        "seeker",
        net=seeker_net(body),
        model=ball_model(body),
        objects={"ball": "Ball"},
        observations=(
            Observe("ball.turned_deg", "body.turned_deg"),
            Observe("ball.advanced", "body.advanced"),
            Observe("ball.seen", "ball.seen", when="body.fresh"),
            Observe("ball.seen_dist", "ball.distance", when="ball.seen"),
            Observe("ball.seen_dir_deg", "ball.direction_deg", when="ball.seen"),
        ),
    )


@of_body
def reckoning_cprm(body: Body) -> CPRM:
    """The same net on what is reckoned instead of believed, whoever reckons it (`knowledge`); he looks round where that is `OLD`."""
    known = (
        Input("ball_age", observes="ball.age"), Input("distance", observes="ball.reckoned_distance"),
        Input("reckoned", observes="ball.reckoned_direction_deg"),
        Math("direction", f"reckoned if ball_age < {number(OLD)} else 90"),
    )  # fmt: skip
    fuse = {"go.believed_distance": "distance", "go.believed_direction": "direction"}
    return CPRM("seeker_reckoning", net=_net("seeker_reckoning", go_to_ball_reflex(body), known, fuse))


def make_reckoning(task: Task, agent: str) -> SoccerAgent:
    """The seeker without a model, on the observation's part ``memory``."""
    body = Body.of(task)
    return SoccerAgent(reckoning_cprm(body), field_percepts, needs=("memory",), body=body)


def make_controller(task: Task, agent: str, **options: Any) -> SoccerAgent:
    """The seeker as a controller; options are those of `CPRMRunner`."""
    body = Body.of(task)
    return SoccerAgent(seeker_cprm(body), ball_percepts, body=body, **options)


if TYPE_CHECKING:
    SEEKER: CPRM
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"SEEKER": seeker_cprm})
