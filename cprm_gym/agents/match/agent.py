"""The outfield player of a match: the attacker's net, with a place in the formation.

    with the ball he decides as the attacker does: shoot, pass (into the run of a team-mate, or to his feet), push it on
    without it, of those nearest to the ball: support who has it; or cover behind the one who fights for it
    else his place in the formation, or between an opponent near it and the goal
    decide --(an opponent has the ball, and a tackle is likely to hit it)--> tackle

What he knows of the pitch comes from the tier of knowledge. Where he goes stands in the places of the attacker's net that say where to wait
for a pass.
"""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Command, Input, Math, PetriNet, Place, Transition
from ...envs.controller import Observation
from ...envs.tasks import Task
from ..attacker.agent import attacker_net
from ..attacker.percepts import Motion, terms
from ..body import DEFAULT, Body, number
from ..goalie import GoalieAgent
from ..play import SoccerAgent
from .constants import MatchConstants
from .percepts import match_percepts, place_terms


@functools.lru_cache(maxsize=64)
def match_net(body: Body = DEFAULT, constants: MatchConstants | None = None) -> PetriNet:
    """What he does: the attacker's net, and tackles."""
    c = constants or MatchConstants()
    net = attacker_net(0, body, c)
    return replace(
        net,
        name="match_player",
        places=(
            *net.places, Place("fallen", capacity=1),
            Input("chance", observes="tackle.chance"), Input("rival_gap", observes="rival.gap"),
            Math("tackles", f"1 if playing and not reach and ball_age < 2 and rival_gap < {number(c.held)} and "
                            f"chance > {number(c.lunge)} else 0"),
            Math("ahead", "norm_deg(-facing)"),
        ),
        transitions=(
            *net.transitions,
            Transition("tackle", ("decide",), ("fallen",), tests={"tackles": 1}, emits=Command("tackle", direction="ahead", foul=0.0),
                       priority=5),
            Transition("rise", ("fallen",), ("decide",), delay=1),
            *(
                Transition(f"leave_{module}_to_tackle", (), (f"{module}.abort",), tests={f"{module}.ongoing": 1, "tackles": 1},
                           inhibitors=(f"{module}.abort", f"{module}.begin"), priority=8)
                for module in ("meet", "walk")
            ),
        ),
    )  # fmt: skip


MATCH_NET = match_net()
"""Of a default player."""


class MatchAgent(SoccerAgent):
    """An outfield player of a match as a controller.

    Parameters
    ----------
    mates, opponents : int
        How many there are.
    goalie, keeper : int
        Number of the own goalie, to whom is not passed, and of theirs; 0 if there is none.
    body : Body
    constants : MatchConstants, optional
        Those set by hand if not given.
    """

    def __init__(
        self, mates: int = 10, opponents: int = 11, goalie: int = 1, keeper: int = 1, body: Body = DEFAULT,
        constants: MatchConstants | None = None,
    ) -> None:  # fmt: skip
        c = constants or MatchConstants()
        judged_by, places, self.motion = terms(body, c, keeper - 1), place_terms(c), Motion(opponents)
        net = match_net(body, c)
        super().__init__(
            CPRM(net.name, net=net),
            lambda observation: match_percepts(observation, judged_by, places, self.motion, mates, goalie, body, c),
            needs=("memory",),
            body=body,
        )

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes; the copies are made at the first one."""
        super().reset(observation, seed, worlds)
        self.motion.reset(len(observation["level"]), worlds)


def make_outfielder(task: Task, agent: str, constants: MatchConstants | None = None) -> MatchAgent:
    """An outfield player of a match as a controller."""
    own, other = (task.left, task.left_goalie), (task.right, task.right_goalie)
    (mates, goalie), (opponents, keeper) = (own, other) if agent.startswith("left") else (other, own)
    return MatchAgent(mates - 1, opponents, goalie, keeper, Body.of(task), constants)


def make_controller(task: Task, agent: str, constants: MatchConstants | None = None) -> SoccerAgent:
    """The goalie, with his model, or an outfield player, as a controller.

    Parameters
    ----------
    task : Task
    agent : str
    constants : MatchConstants, optional
        Of outfield players.
    """
    side, _, unum = agent.partition("_")
    goalie, opponents = (task.left_goalie, task.right) if side == "left" else (task.right_goalie, task.left)
    if int(unum) == goalie:
        return GoalieAgent(opponents, body=Body.of(task))
    return make_outfielder(task, agent, constants)
