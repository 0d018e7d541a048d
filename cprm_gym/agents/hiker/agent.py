"""The hiker: out to the view and home again. That he has been there is a token, not something that he could see (dissertation §5.3.2).

intend --> out (advance) --arrived--> home (advance) --arrived--> there --> home ...
"""

from __future__ import annotations

import functools

from ...architecture.cprm import CPRM
from ...architecture.petri import Continuous, Input, PetriNet, Place, Transition
from ...envs.tasks import Task
from ..body import DEFAULT, Body
from ..percepts import field_percepts
from ..play import SoccerAgent
from ..skills.advance import advance

WAY = 30.0
"""Metres between home and the view, unless the task says otherwise."""


@functools.lru_cache(maxsize=64)
def hiker_net(body: Body = DEFAULT, way: float = WAY) -> PetriNet:
    """Two modules, one after the other; the second again if he is moved away."""
    return PetriNet(
        "hiker",
        places=(
            Place("intend", capacity=1, tokens=1), Place("there", capacity=1),
            Input("x", observes="me.x"),
            Continuous("view", way / 2), Continuous("house", -way / 2), Continuous("middle", 0.0),
        ),
        modules={"out": advance(body), "home": advance(body)},
        fuse={"out.place_x": "view", "out.place_y": "middle", "home.place_x": "house", "home.place_y": "middle"},
        transitions=(
            Transition("set_out", ("intend",), ("out.begin",)),
            Transition("turn_back", ("out.arrived",), ("home.begin",)),
            Transition("set_out_again", ("out.aborted",), ("intend",)),
            Transition("arrive", ("home.arrived",), ("there",)),
            Transition("give_way", ("home.aborted",), ("there",)),
            Transition("go_on", ("there",), ("home.begin",), delay=1),
        ),
    )  # fmt: skip


@functools.lru_cache(maxsize=64)
def hiker_cprm(body: Body = DEFAULT, way: float = WAY) -> CPRM:
    """The net alone: this agent infers nothing."""
    return CPRM("hiker", net=hiker_net(body, way))


HIKER_NET = hiker_net()
"""Of a default player."""


def make_controller(task: Task, agent: str) -> SoccerAgent:
    """The hiker as a controller."""
    body = Body.of(task)
    return SoccerAgent(hiker_cprm(body, getattr(task, "way", WAY)), field_percepts, needs=("memory",), body=body)
