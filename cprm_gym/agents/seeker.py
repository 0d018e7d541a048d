"""The seeker: goes to the ball, looks for it again when it is lost, and stays at it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..architecture.cprm import CPRM, Observe
from ..architecture.petri import PetriNet, Place, Transition
from ..envs.tasks import Task
from ..lazy import made_on_use
from .body import Body, of_body
from .models import ball_model
from .percepts import ball_percepts
from .play import SoccerAgent
from .skills.go_to_ball import go_to_ball


@of_body
def seeker_net(body: Body) -> PetriNet:
    """High level: one module, started again when it loses the ball, and a cycle after it has arrived."""
    return PetriNet(
        "seeker",
        places=(Place("intend", capacity=1, tokens=1), Place("arrived", capacity=1)),
        modules={"go": go_to_ball(body)},
        transitions=(
            Transition("set_out", ("intend",), ("go.begin",)),
            Transition("arrive", ("go.at_ball",), ("arrived",)),
            Transition("search_again", ("go.lost_ball",), ("intend",)),
            Transition("give_way", ("go.aborted",), ("intend",)),
            Transition("follow", ("arrived",), ("intend",), delay=1),
        ),
    )


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


def make_controller(task: Task, agent: str, **options: Any) -> SoccerAgent:
    """The seeker as a controller; options are those of `CPRMRunner`."""
    body = Body.of(task)
    return SoccerAgent(seeker_cprm(body), ball_percepts, body=body, **options)


if TYPE_CHECKING:
    SEEKER: CPRM
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"SEEKER": seeker_cprm})
