"""The striker (demonstration 1): kick-off, pass, run forward, receive the return pass, dribble, shoot (dissertation §2.2.7, Fig. 2.11).

    setup -> passing -> advance -> (ball comes) -> receive -> dribble -> shoot -> over
                |          `-> wait --^               |          |         |
                `----------------------> find <-------+----------+---------'
                                         find -> go -> dribble

Purely reflexive: no model. A primary sequence of modules, and one loop: whenever the ball is lost, back to finding and fetching it.
The neck is a concurrent activity: it keeps the face on the ball, or on the team-mate while a pass is prepared.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..architecture.cprm import CPRM
from ..architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Transition
from ..envs.tasks import Task
from ..lazy import made_on_use
from .attacker import agent as attacker
from .body import Body, number, of_body
from .percepts import field_percepts
from .play import SoccerAgent
from .skills.advance import advance
from .skills.dribble import dribble
from .skills.go_to_ball import go_to_ball_reflex
from .skills.pass_ball import pass_ball
from .skills.receive import receive
from .skills.setup import setup
from .skills.shoot import shoot

COMING = 0.3
"""m / cycle at which a ball that comes nearer counts as coming."""
FORGOTTEN = 4.0
"""Cycles without a sight of the ball after which it is looked for."""
WAIT = 80
"""Cycles for which he waits for the return pass."""
BESIDE = 0.215
"""Metres beyond his reach within which the ball is beside him: while he prepares a pass he looks at the team-mate."""
AFTER_SHOT = 20
"""Cycles after a shot in which the goal is expected."""


@of_body
def striker_net(body: Body) -> PetriNet:
    """High level: the sequence, the loop back, and the neck beside them."""
    return PetriNet(
        "striker",
        places=(
            Place("intend", capacity=1, tokens=1),
            *(Place(name, capacity=1) for name in ("waiting", "faced", "find", "searched", "over")),
            Place("looking", capacity=1, tokens=1),
            Input("ball_age", observes="ball.age"), Input("ball_direction", observes="ball.reckoned_direction_deg"),
            Input("ball_distance", observes="ball.reckoned_distance"), Input("approach", observes="ball.approach"),
            Input("mate_direction", observes="mate.direction_deg"), Input("mate_y", observes="mate.y"),
            Input("speed", observes="body.speed"),
            # as far forward as he may wait for the return pass without being offside, on the side away from the team-mate
            Continuous("forward", -3.0), Math("aside", "-6 if mate_y > 0 else 6"),
            Math("gaze", f"mate_direction if passing.ongoing >= 1 and ball_distance < {number(body.reach + BESIDE)} "
                         "else ball_direction if ball_age < 12 else 0"),
            Math("off_axis", "abs(ball_direction)"),
            Math("turn_moment", body.turn("60")),
            Math("face_moment", body.turn("ball_direction")),
        ),
        modules={"setup": setup(body), "passing": pass_ball(body), "advance": advance(body), "receive": receive(body),
                 "go": go_to_ball_reflex(body), "dribble": dribble(body), "shoot": shoot(body)},
        fuse={"advance.place_x": "forward", "advance.place_y": "aside"},
        transitions=(
            # the primary sequence
            Transition("set_up", ("intend",), ("setup.begin",)),
            Transition("kick_off", ("setup.set",), ("passing.begin",)),
            Transition("run_forward", ("passing.passed",), ("advance.begin",)),
            Transition("arrive", ("advance.arrived",), ("waiting",)),
            Transition("ball_comes", (), ("advance.abort",), tests={"advance.ongoing": 1, "approach": COMING},
                       inhibitors={"ball_age": FORGOTTEN, "advance.abort": 1}),
            Transition("be_ready", ("advance.aborted",), ("receive.begin",)),
            Transition("expect", ("waiting",), ("receive.begin",), tests={"approach": COMING}, inhibitors={"ball_age": FORGOTTEN}),
            Transition("keep_facing", ("waiting",), ("faced",), tests={"off_axis": 60.0}, emits=Command("turn", moment="face_moment"),
                       priority=-1),
            Transition("wait_on", ("faced",), ("waiting",), delay=1),
            Transition("drive", ("receive.received",), ("dribble.begin",)),
            Transition("aim", ("dribble.there",), ("shoot.begin",)),
            Transition("finish", ("shoot.shot",), ("over",)),
            # the loop back
            Transition("no_pass", ("passing.failed",), ("find",)),
            Transition("no_return", ("waiting",), ("find",), delay=WAIT),
            Transition("out_of_sight", ("waiting",), ("find",), tests={"ball_age": 2 * FORGOTTEN}),
            Transition("no_catch", ("receive.missed",), ("find",)),
            Transition("no_ball", ("dribble.lost_ball",), ("find",)),
            Transition("no_shot", ("shoot.failed",), ("find",)),
            Transition("no_way", ("go.lost_ball",), ("find",)),
            Transition("no_goal", ("over",), ("find",), delay=AFTER_SHOT),
            Transition("found", ("find",), ("go.begin",), inhibitors={"ball_age": FORGOTTEN, "off_axis": 60.0}, priority=1),
            Transition("search", ("find",), ("searched",), tests={"ball_age": FORGOTTEN}, emits=Command("turn", moment="turn_moment")),
            Transition("face", ("find",), ("searched",), tests={"off_axis": 60.0}, inhibitors={"ball_age": FORGOTTEN},
                       emits=Command("turn", moment="face_moment")),
            Transition("look_again", ("searched",), ("find",), delay=1),
            Transition("fetch", ("go.at_ball",), ("dribble.begin",)),
            # the neck
            Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="gaze")),
        ),
    )  # fmt: skip


STRIKER_NET = striker_net()
"""Of a default player."""


@of_body
def striker_cprm(body: Body) -> CPRM:
    """The net alone: this agent infers nothing."""
    return CPRM("striker", net=striker_net(body))


def make_controller(task: Task, agent: str) -> SoccerAgent:
    """The striker as a controller; against opponents an attacker who decides anew with every kick (`attacker`)."""
    if task.right if agent.startswith("left") else task.left:
        return attacker.make_controller(task, agent)
    body = Body.of(task)
    return SoccerAgent(striker_cprm(body), field_percepts, needs=("memory",), body=body)


if TYPE_CHECKING:
    STRIKER: CPRM
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"STRIKER": striker_cprm})
