"""The taker: one of two or more who take the ball from keepers inside a square (keepaway).

    decide --(ball out of sight)--> look round
    decide --(ball at his feet)--> oust (a kick that sends it out of the square) --> decide
    decide --(a keeper has it, and a tackle is likely to hit it)--> tackle
    decide --(he is of the first at it)--> meet (intercept) --> oust
    decide --(else)--> walk (advance) into the way of a pass, or turn to the ball
    the neck beside it: on the ball

Purely reflexive, of the keeper's skills: what he knows comes from the tier of knowledge, and he judges by the formulas of the scripted
players. That the ball has left the square is his success too, so he kicks it out as soon as he can.
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
from ...simulator.state import PLAYERS
from ..body import DEFAULT, Body, number
from ..percepts import Percepts
from ..play import SoccerAgent
from ..skills.advance import advance
from ..skills.intercept import intercept
from ..skills.kick import SURE, kick
from .constants import TakerConstants
from .percepts import taker_percepts

LOST = 6
"""Cycles without a sight of the ball after which he looks round."""
SEEN = 3
"""Cycles for which a ball in reach is trusted to be there."""
OFF_PLACE = 1.0
"""Metres off his place at which he goes there."""
OFF_AXIS = 20.0
"""Degrees off the ball at which he turns to it."""

_INPUTS = {
    "me_x": "me.x", "me_y": "me.y", "speed": "body.speed", "ball_age": "ball.age", "ball_distance": "ball.reckoned_distance",
    "ball_direction": "ball.reckoned_direction_deg", "before": "takers.first", "cover_x": "cover.x", "cover_y": "cover.y",
    "gap": "keepers.gap", "chance": "tackle.chance", "out_distance": "out.distance", "out_direction": "out.direction_deg",
}  # fmt: skip


@functools.lru_cache(maxsize=64)
def taker_net(body: Body = DEFAULT, constants: TakerConstants | None = None) -> PetriNet:
    """What he does, built from skills."""
    c = constants or TakerConstants()
    return PetriNet(
        "taker",
        places=(
            Place("looking", capacity=1, tokens=1), Place("decide", capacity=1, tokens=1), Place("acted", capacity=1),
            Place("with_ball", capacity=1),
            *(Input(name, observes=observes) for name, observes in _INPUTS.items()),
            Math("lost", f"1 if ball_age > {LOST} else 0"),
            Math("reach", f"1 if ball_distance < {body.within(SURE)} and ball_age < {SEEN} else 0"),
            Math("tackles", f"1 if gap < {number(c.held)} and chance > {number(c.lunge)} and ball_age < {SEEN} and not reach else 0"),
            Math("chase", f"1 if before < {number(c.hunters)} else 0"),
            Math("off_place", "hypot(cover_x - me_x, cover_y - me_y)"),
            Math("off_axis", "abs(ball_direction)"),
            Math("eyes", "0 if lost else ball_direction"),
            Math("search_moment", body.turn("100")), Math("face_moment", body.turn("ball_direction")),
            Continuous("hard", body.server.ball_speed_max),
        ),
        modules={"walk": advance(body), "meet": intercept(body), "oust": kick(body)},
        fuse={
            "walk.place_x": "cover_x", "walk.place_y": "cover_y",
            "oust.target_distance": "out_distance", "oust.target_direction": "out_direction", "oust.arriving": "hard",
        },
        transitions=(
            Transition("sweep", ("decide",), ("acted",), tests={"lost": 1}, emits=Command("turn", moment="search_moment"), priority=6),
            Transition("have", ("decide",), ("with_ball",), tests={"reach": 1}, priority=5),
            Transition(
                "tackle", ("decide",), ("acted",), tests={"tackles": 1},
                emits=Command("tackle", direction="out_direction", foul=0.0), priority=4,
            ),
            Transition("run_to_it", ("decide",), ("meet.begin",), tests={"chase": 1}, priority=3),
            Transition("cover", ("decide",), ("walk.begin",), tests={"off_place": OFF_PLACE}, priority=2),
            Transition("face", ("decide",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="face_moment"),
                       priority=1),
            Transition("rest", ("decide",), ("acted",)),
            Transition("on", ("acted",), ("decide",), delay=1),
            Transition("kick_out", ("with_ball",), ("oust.begin",)),
            # aborts passed down: something else is to be done
            *(
                Transition(f"leave_{module}_{why}", (), (f"{module}.abort",), tests={f"{module}.ongoing": 1, why: 1},
                           inhibitors=(f"{module}.abort", f"{module}.begin"), priority=8)
                for module in ("walk", "meet")
                for why in ("lost", "reach", "tackles", *(("chase",) if module == "walk" else ()))
            ),
            Transition("leave_meet_to_another", (), ("meet.abort",), tests={"meet.ongoing": 1},
                       inhibitors={"meet.abort": 1, "meet.begin": 1, "chase": 1}, priority=8),
            # outcomes
            Transition("meet_at_ball", ("meet.at_ball",), ("with_ball",), inhibitors=("meet.abort",)),
            Transition("meet_aborted", ("meet.aborted",), ("decide",), inhibitors=("meet.abort",)),
            Transition("walk_arrived", ("walk.arrived",), ("acted",), inhibitors=("walk.abort",)),
            Transition("walk_aborted", ("walk.aborted",), ("decide",), inhibitors=("walk.abort",)),
            *(Transition(f"oust_{outcome}", (f"oust.{outcome}",), ("decide",)) for outcome in ("kicked", "failed", "aborted")),
            # the neck
            Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="eyes")),
        ),
    )  # fmt: skip


TAKER_NET = taker_net()
"""Of a default player."""


class TakerAgent(SoccerAgent):
    """A taker as a controller.

    Parameters
    ----------
    task : Keepaway
    constants : TakerConstants, optional
        Those set by hand if not given.
    """

    def __init__(self, task: Keepaway, constants: TakerConstants | None = None) -> None:
        self._task, self._constants = task, constants or TakerConstants()
        self._records = np.zeros(0, MEMORY)
        net = taker_net(Body.of(task), self._constants)
        super().__init__(CPRM(net.name, net=net), self._perceive, needs=("memory",), body=Body.of(task))

    def _perceive(self, observation: Observation) -> Percepts:
        """`taker_percepts`, for as many worlds as there are."""
        count = len(observation["level"])
        if len(self._records) != count:
            records = np.zeros((count, PLAYERS), MEMORY)
            embody(records, self._task.parameters)
            self._records = records[:, 0].copy()
        return taker_percepts(observation, self._records, self._task.right, self._task.size / 2, self.body, self._constants)


def make_controller(task: Task, agent: str, constants: TakerConstants | None = None) -> TakerAgent:
    """A taker as a controller, with the numbers of the study if no others are given.

    Raises
    ------
    ParameterError
        For a keeper, or a task that is no keepaway.
    """
    if not isinstance(task, Keepaway) or not agent.startswith("right"):
        raise ParameterError(f"{task.name}: takers are on the right side of keepaway; {agent!r} is none")
    return TakerAgent(task, constants or TakerConstants.tuned("memory"))
