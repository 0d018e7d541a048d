"""The keeper: one of three or more who keep the ball from takers inside a square (keepaway).

    decide --(ball out of sight)--> look round
    decide --(ball at his feet)--> with_ball --> give (a pass) | shelter (a kick that keeps it behind the body) --> decide
    decide --(nobody of the team is before him at it)--> meet (intercept) --> with_ball
    decide --(else)--> walk (advance) to where he is most open, or turn to the ball
    the neck beside it: on the ball, or, with the ball at his feet, on whom he has not seen for the longest

Purely reflexive, and of the attacker's skills: what he knows comes from the tier of knowledge, and he judges by the formulas of the
scripted keepers (`envs.players.kernels.keepers`), whose rules of when to pass these are, with numbers of his own.
"""

from __future__ import annotations

import functools

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Transition
from ...envs.controller import Observation
from ...envs.players.memory import MEMORY, embody
from ...envs.tasks import Task
from ...envs.tasks.keepaway import Keepaway
from ...errors import ParameterError
from ...simulator.state import PLAYERS, ViewWidth
from ..body import DEFAULT, Body, number
from ..percepts import Percepts
from ..play import SoccerAgent
from ..skills.advance import advance
from ..skills.intercept import intercept
from ..skills.kick import SURE, kick
from .constants import KeeperConstants
from .percepts import keeper_percepts

LOST = 6
"""Cycles without a sight of the ball after which he looks round."""
SEEN = 3
"""Cycles for which a ball in reach is trusted to be there."""
OFF_PLACE = 1.4
"""Metres off his place at which he goes there."""
OFF_AXIS = 20.0
"""Degrees off the ball at which he turns to it."""
STUDY = {"Keepaway3v2": "keeper"}
"""Task -> folder of the study whose numbers he plays it with."""
NARROW, NORMAL = int(ViewWidth.NARROW), int(ViewWidth.NORMAL)

_INPUTS = {
    "me_x": "me.x", "me_y": "me.y", "speed": "body.speed", "ball_age": "ball.age", "ball_distance": "ball.reckoned_distance",
    "ball_direction": "ball.reckoned_direction_deg", "before": "keepers.first", "open_x": "open.x", "open_y": "open.y",
    "gap": "takers.gap", "pass_room": "pass.room", "pass_distance": "pass.distance", "pass_direction": "pass.direction_deg",
    "shelter_distance": "cover.distance", "shelter_direction": "cover.direction_deg", "shelter_speed": "cover.speed",
    "oldest": "oldest.direction_deg", "oldest_age": "oldest.age",
}  # fmt: skip


@functools.lru_cache(maxsize=64)
def keeper_net(body: Body = DEFAULT, constants: KeeperConstants | None = None) -> PetriNet:
    """What he does, built from skills."""
    c = constants or KeeperConstants()
    return PetriNet(
        "keeper",
        places=(
            Place("looking", capacity=1, tokens=1), Place("viewing", capacity=1, tokens=1), Place("decide", capacity=1, tokens=1),
            Place("acted", capacity=1), Place("with_ball", capacity=1),
            *(Input(name, observes=observes) for name, observes in _INPUTS.items()),
            Math("lost", f"1 if ball_age > {LOST} else 0"),
            Math("reach", f"1 if ball_distance < {body.within(SURE)} and ball_age < {SEEN} else 0"),
            Math("chase", "1 if before < 1 else 0"),
            Math("off_place", "hypot(open_x - me_x, open_y - me_y)"),
            Math("off_axis", "abs(ball_direction)"),
            Math("can_pass", f"1 if gap < {number(c.pressed)} and pass_room > {number(c.room)} else 0"),
            Math("eyes", f"0 if lost else oldest if reach and oldest_age > {number(c.stale)} else ball_direction"),
            Math("cone", f"{NARROW} if reach else {NORMAL}"),
            Math("search_moment", body.turn("100")), Math("face_moment", body.turn("ball_direction")),
            Continuous("arriving", c.arriving),
        ),
        modules={"walk": advance(body), "meet": intercept(body), "give": kick(body), "shelter": kick(body)},
        fuse={
            "walk.place_x": "open_x", "walk.place_y": "open_y",
            "give.target_distance": "pass_distance", "give.target_direction": "pass_direction", "give.arriving": "arriving",
            "shelter.target_distance": "shelter_distance", "shelter.target_direction": "shelter_direction",
            "shelter.at_most": "shelter_speed",
        },
        transitions=(
            Transition("sweep", ("decide",), ("acted",), tests={"lost": 1}, emits=Command("turn", moment="search_moment"), priority=5),
            Transition("have", ("decide",), ("with_ball",), tests={"reach": 1}, priority=4),
            Transition("run_to_it", ("decide",), ("meet.begin",), tests={"chase": 1}, priority=3),
            Transition("get_open", ("decide",), ("walk.begin",), tests={"off_place": OFF_PLACE}, priority=2),
            Transition("face", ("decide",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="face_moment"),
                       priority=1),
            Transition("rest", ("decide",), ("acted",)),
            Transition("on", ("acted",), ("decide",), delay=1),
            # with the ball
            Transition("pass_it", ("with_ball",), ("give.begin",), tests={"can_pass": 1}, priority=1),
            Transition("keep_it", ("with_ball",), ("shelter.begin",)),
            # aborts passed down: something else is to be done
            *(
                Transition(f"leave_{module}_{why}", (), (f"{module}.abort",), tests={f"{module}.ongoing": 1, why: 1},
                           inhibitors=(f"{module}.abort", f"{module}.begin"), priority=7)
                for module, why in (("walk", "lost"), ("walk", "reach"), ("walk", "chase"), ("meet", "lost"), ("meet", "reach"))
            ),
            Transition("leave_meet_to_another", (), ("meet.abort",), tests={"meet.ongoing": 1},
                       inhibitors={"meet.abort": 1, "meet.begin": 1, "chase": 1}, priority=7),
            # outcomes
            Transition("meet_at_ball", ("meet.at_ball",), ("with_ball",), inhibitors=("meet.abort",)),
            Transition("meet_aborted", ("meet.aborted",), ("decide",), inhibitors=("meet.abort",)),
            Transition("walk_arrived", ("walk.arrived",), ("acted",), inhibitors=("walk.abort",)),
            Transition("walk_aborted", ("walk.aborted",), ("decide",), inhibitors=("walk.abort",)),
            *(
                Transition(f"{module}_{outcome}", (f"{module}.{outcome}",), ("decide",))
                for module in ("give", "shelter")
                for outcome in ("kicked", "failed", "aborted")
            ),
            # the neck
            Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="eyes")),
            Transition("narrow_or_widen", ("viewing",), ("viewing",), delay=1, emits=Command("change_view", width="cone")),
        ),
    )  # fmt: skip


KEEPER_NET = keeper_net()
"""Of a default player."""


class KeeperAgent(SoccerAgent):
    """A keeper as a controller.

    Parameters
    ----------
    task : Keepaway
    constants : KeeperConstants, optional
        Those set by hand if not given.
    """

    def __init__(self, task: Keepaway, constants: KeeperConstants | None = None) -> None:
        c, body = constants or KeeperConstants(), Body.of(task)
        self._task, self._half = task, task.size / 2 - c.edge
        self._records = np.zeros(0, MEMORY)
        net = keeper_net(body, c)
        super().__init__(CPRM(net.name, net=net), self._perceive, needs=("memory",), body=body)

    def _perceive(self, observation: Observation) -> Percepts:
        """`keeper_percepts`, for as many worlds as there are."""
        count = len(observation["level"])
        if len(self._records) != count:
            records = np.zeros((count, PLAYERS), MEMORY)
            embody(records, self._task.parameters)
            self._records = records[:, 0].copy()
        return keeper_percepts(observation, self._records, self._task.left, self._half)


def numbers_of(task: str) -> KeeperConstants:
    """A keeper's numbers in a task if no others are given."""
    return KeeperConstants.tuned("memory", STUDY[task]) if task in STUDY else KeeperConstants()


def make_controller(task: Task, agent: str, constants: KeeperConstants | None = None) -> KeeperAgent:
    """A keeper as a controller, with those of `numbers_of` the task if no numbers are given.

    Raises
    ------
    ParameterError
        For a taker, or a task that is no keepaway.
    """
    if not isinstance(task, Keepaway) or not agent.startswith("left"):
        raise ParameterError(f"{task.name}: keepers are on the left side of keepaway; {agent!r} is none")
    return KeeperAgent(task, constants or numbers_of(task.name))
