"""One passes and the other receives: the pair's cycle, as two nets in one world.

The passer has the ball at his feet and plays `pass_ball`; his team-mate stands 8 to 18 m off, watches the ball, and plays `receive` as soon
as it comes. With the ball received the same begins with the parts exchanged.
"""

from __future__ import annotations

from ...architecture.cprm import CPRM
from ...architecture.petri import Command, Input, Math, PetriNet, Place, Transition
from ..body import Body
from ..finder.agent import finder_percepts
from ..passer import COMING
from ..play import SoccerAgent
from ..skills.receive import receive
from .stage import Cast, Change, spoken, stage_task
from .trials import TRIALS

CYCLES = 110
"""Cycles after which a pass that was neither received nor failed is cut off."""


def receiver(body: Body, change: Change | None = None) -> PetriNet:
    """Watches the ball and receives it when it comes."""
    skill = receive(body)
    return PetriNet(
        "receiver",
        places=(
            Place("waiting", capacity=1, tokens=1), Place("done", capacity=1), Place("looking", capacity=1, tokens=1),
            Input("direction", observes="ball.reckoned_direction_deg"), Input("age", observes="ball.age"),
            Input("approach", observes="ball.approach"), Math("gaze", "direction if age < 15 else 0"),
            Math("coming", "approach if age < 5 else 0"),
        ),
        modules={"skill": change(skill) if change is not None else skill},
        transitions=(
            Transition("get_ready", ("waiting",), ("skill.begin",), tests={"coming": COMING}),
            Transition("finish", ("skill.received",), ("done",)),
            Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="gaze")),
        ),
    )  # fmt: skip


def pair_on_stage(change: Change | None = None) -> Cast:
    """Passer and receiver; a change makes another receiver.

    Outcomes are ``received``, ``failed`` (the passer says that it did), ``missed`` (the receiver does).
    """
    tried = TRIALS["pass_ball"]
    task = stage_task(tried.start, controlled="left")
    body = Body.of(task)
    agents = {
        "passer.": tried.agent("pass_ball", body),
        "receiver.": SoccerAgent(CPRM("receiver", receiver(body, change)), finder_percepts, needs=("memory",), body=body),
    }
    net = PetriNet("pass and receive", modules={name[:-1]: spoken(agent.cprm.net, name) for name, agent in agents.items()})
    outcomes = {"received": "receiver.done", "failed": "passer.skill.failed", "missed": "receiver.skill.missed"}
    return Cast(task, agents, net, outcomes, CYCLES, lambda core: core.kickable(2))
