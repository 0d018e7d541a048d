"""The finder: sees the ball once, loses it from view, predicts where it is, looks for it there first, and meets it.

    eyes (look_out) runs beside legs (meet_ball); the legs begin again when they have arrived

He has no model: he reads what he knows in the observation's part ``memory``, whoever fills it, and so runs on every tier of knowledge
(`knowledge`). What he knows of the ball's motion decides where he looks first and where he runs; what he does not know, in what order he
looks elsewhere.
"""

from __future__ import annotations

import functools

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Input, Math, PetriNet, Place, Transition
from ...envs.controller import Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.tasks import Task
from ..body import DEFAULT, Body, number
from ..goalie import race
from ..percepts import Percepts, field_percepts
from ..play import SoccerAgent
from ..skills.constants import FinderConstants
from ..skills.look_out import gaze, look_out
from ..skills.meet_ball import meet_ball

HALF_VIEWS = (0.0, 30.0, 60.0, 90.0)
"""Half the view cone by its width, degrees, as in synchronous mode."""


@functools.lru_cache(maxsize=256)
def finder_net(body: Body = DEFAULT, constants: FinderConstants = FinderConstants()) -> PetriNet:  # noqa: B008
    """High level: eyes and legs at once, and the quantities that both read."""
    c = constants
    modules = {"eyes": look_out(body), "legs": meet_ball(body, c)}
    return PetriNet(
        "finder",
        places=(
            Place("shut", capacity=1, tokens=1), Place("intend", capacity=1, tokens=1), Place("arrived", capacity=1),
            *(Input(name, observes=f"ball.{name[5:]}") for name in ("ball_x", "ball_y", "ball_vx", "ball_vy", "ball_age")),
            Input("x", observes="me.x"), Input("y", observes="me.y"), Input("body", observes="me.facing_deg"),
            Input("own_vx", observes="me.vx"), Input("own_vy", observes="me.vy"),
            Math("dx", "ball_x - x"), Math("dy", "ball_y - y"), Math("ball_distance", "hypot(dx, dy)"),
            # where it will be seen from when the neck has turned
            Math("next_x", f"dx + {number(c.lead)} * ball_vx - own_vx"), Math("next_y", f"dy + {number(c.lead)} * ball_vy - own_vy"),
            Math("expected_direction", "norm_deg(degrees(atan2(next_y, next_x)) - body) if hypot(next_x, next_y) > 0.01 else 0"),
            Math("swing", "degrees((dx * ball_vy - dy * ball_vx) / max(dx * dx + dy * dy, 0.25))"),
            *race(body, "own", "x", "y", f"{number(c.start)} + {{way}} / {body.pace(c.run)}"),
            Math("meet_dx", "own_x - x - own_vx"), Math("meet_dy", "own_y - y - own_vy"),
            Math("meet_distance", "hypot(meet_dx, meet_dy)"),
            Math("meet_direction", "norm_deg(degrees(atan2(meet_dy, meet_dx)) - body) if meet_distance > 0.01 else 0"),
            gaze("eyes.missed", c),
        ),
        modules=modules,
        transitions=(
            Transition("open_eyes", ("shut",), ("eyes.begin",)),
            Transition("set_out", ("intend",), ("legs.begin",)),
            Transition("arrive", ("legs.at_ball",), ("arrived",)),
            Transition("give_way", ("legs.aborted",), ("intend",), delay=1),
            Transition("follow", ("arrived",), ("intend",), delay=1),
        ),
        fuse={f"{skill}.{name}": name for skill, module in modules.items() for name in module.ports.parameters},
    )  # fmt: skip


@functools.lru_cache(maxsize=256)
def finder_cprm(body: Body = DEFAULT, constants: FinderConstants = FinderConstants()) -> CPRM:  # noqa: B008
    """The net alone: this agent infers nothing."""
    return CPRM("finder", net=finder_net(body, constants))


def finder_percepts(observation: Observation) -> Percepts:
    """What he knows, with `field_percepts`.

    Returns
    -------
    dict of (N,) float64
        ``ball.vx``, ``ball.vy``, ``me.vx``, ``me.vy``, m / cycle in the frame of the own team's pitch; ``body.half_view_deg``.
    """
    percepts = field_percepts(observation)
    memory, me = (np.asarray(observation[part], np.float64) for part in ("memory", "self"))
    percepts["ball.vx"], percepts["ball.vy"] = memory[:, 0, 2], memory[:, 0, 3]
    percepts["me.vx"], percepts["me.vy"] = me[:, SelfFeature.VX], me[:, SelfFeature.VY]
    width = np.asarray(observation["body"])[:, BodyFeature.VIEW_WIDTH].astype(np.int64)
    percepts["body.half_view_deg"] = np.array(HALF_VIEWS)[width]
    return percepts


FINDER_NET = finder_net()
"""Of a default player."""


def make_controller(task: Task, agent: str, constants: FinderConstants | None = None) -> SoccerAgent:
    """The finder as a controller, with the numbers set by hand if no others are given."""
    body = Body.of(task)
    return SoccerAgent(finder_cprm(body, constants or FinderConstants()), finder_percepts, needs=("memory",), body=body)
