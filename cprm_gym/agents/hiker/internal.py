"""The hiker by regions of belief alone, repaired as §5.3.2 proposes: what he is about is a variable of his model, inferred like any other.

``been`` has no reading: that he has been at the view follows from the places where he was, by a link in time. What a net keeps in a token
is an inference in every cycle here. The net only compares beliefs and sends (Fig. 5.3); its one token is the pace of the cycles.
"""

from __future__ import annotations

import functools

from ...architecture.cprm import CPRM, Observe
from ...architecture.petri import Belief, Command, Input, Math, PetriNet, Place, Transition
from ...architecture.prm.model.cpds import Chance, Noise, Uniform
from ...architecture.prm.model.domains import BOOL, Bins
from ...architecture.prm.model.model import Model
from ...architecture.prm.model.schema import Attribute, PRMClass, prev
from ...envs.tasks import Task
from ...errors import UnknownName
from ..body import DEFAULT, Body
from ..percepts import field_percepts
from ..play import SoccerAgent
from ..skills.advance import COURSE, FRESH
from .agent import WAY

CELLS = 24
"""Bins of the way."""
STEP = 0.6
"""Standard deviation of a cycle's way, m."""
NEAR = 1.15
"""Metres from the view at which he takes himself to be there."""


@functools.lru_cache(maxsize=64)
def hiker_model(way: float = WAY) -> Model:
    """Where he is along the way, and whether he has been at the view."""
    half = way / 2
    place = Bins(tuple(round(-half - 2 + (way + 4) * k / CELLS, 6) for k in range(CELLS + 1)), unit="m", clip=True)
    hiker = PRMClass(
        "Hiker",
        attributes=(
            Attribute("x", place, parents=(prev("x"),), initial=Uniform(), cpd=Noise("prev.x", sd=STEP)),
            # changes once and for good, at the view
            Attribute("been", BOOL, parents=(prev("been"), "x"), initial=Chance("0"),
                      cpd=Chance(f"1 if prev.been > 0.5 or x > {half - NEAR} else 0")),
            Attribute("seen_x", place, parents=("x",), cpd=Noise("x", sd=0.2, floor=1e-4)),
        ),
    )  # fmt: skip
    return Model("hiker", classes=(hiker,))


@functools.lru_cache(maxsize=64)
def internal_hiker(body: Body = DEFAULT, way: float = WAY) -> CPRM:
    """Regions of the belief in ``been`` and of where he is; the commands are those of the skill `advance`."""
    half = way / 2
    net = PetriNet(
        "hiker_regions",
        places=(
            Place("ready", capacity=1, tokens=1), Place("acted", capacity=1),
            Input("x", observes="me.x"), Input("y", observes="me.y"), Input("facing", observes="me.facing_deg"),
            Input("speed", observes="body.speed"), Input("stamina", observes="body.stamina"),
            Belief("been", variable="me.been", view="probability", state="yes"),
            Math("to_x", f"{half} if been < 0.5 else {-half}"),
            Math("distance", "hypot(to_x - x, y)"),
            Math("bearing", "norm_deg(degrees(atan2(-y, to_x - x)) - facing) if distance > 0.001 else 0"),
            Math("off_course", "abs(bearing)"),
            Math("moment", body.turn("bearing")),
            Math("power", f"clip({body.power(1.0)} * (distance - speed), {body.dash(0.2)}, "
                 f"{body.dash(1.0)} if stamina > {body.stamina(FRESH)} else {body.dash(0.5)})"),
        ),
        transitions=(
            Transition("turn", ("ready",), ("acted",), tests={"off_course": COURSE}, emits=Command("turn", moment="moment")),
            Transition("dash", ("ready",), ("acted",), inhibitors={"off_course": COURSE},
                       emits=Command("dash", power="power", direction=0.0)),
            Transition("tick", ("acted",), ("ready",), delay=1),
        ),
    )  # fmt: skip
    return CPRM("hiker_regions", net, hiker_model(way), {"me": "Hiker"}, (Observe("me.seen_x", "me.x", when="me.located"),))


def make_controller(task: Task, agent: str) -> SoccerAgent:
    """The hiker who infers what he is about; for the task Hike alone.

    Raises
    ------
    UnknownName
        For another task.
    """
    if task.name != "Hike":
        raise UnknownName(f"belief regions with internal variables: task {task.name!r}; the hiker plays Hike")
    body = Body.of(task)
    return SoccerAgent(internal_hiker(body, getattr(task, "way", WAY)), field_percepts, needs=("memory",), body=body)
