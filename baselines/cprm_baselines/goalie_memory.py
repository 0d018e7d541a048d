"""The goalie's net without a model, on the environment's own memory: the fair rival of the goalie who believes.

Net, skills and thresholds are those of `cprm_gym.agents.goalie`; where he holds beliefs, this one reads what the observation's part
``memory`` reckons: what was last seen, carried on through blind cycles by a decaying roll. What a model adds to the net is the
difference to this one, not that to `goalie_raw`, which freezes its readings.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.agents.body import DEFAULT, Body, of_body
from cprm_gym.agents.goalie import FAR, goalie_net, goalie_percepts, opponent_attributes
from cprm_gym.agents.percepts import Percepts
from cprm_gym.agents.play import SoccerAgent
from cprm_gym.architecture.cprm import CPRM
from cprm_gym.architecture.petri import Input
from cprm_gym.envs.controller import Observation
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import UnknownName

RECKONED = (
    *(Input(f"ball_{name}", observes=f"ball.{name}") for name in ("x", "y", "vx", "vy")),
    Input("watched_x", observes="rival.x", value=FAR), Input("watched_y", observes="rival.y"),
)  # fmt: skip
"""The ball as it is reckoned, and the opponent nearest to it, in the places of beliefs."""


@of_body
def goalie_memory_cprm(body: Body) -> CPRM:
    """The net alone."""
    return CPRM("goalie_memory", net=goalie_net(RECKONED, attended=0, name="goalie_memory", body=body))


class MemoryGoalie(SoccerAgent):
    """The net on the memory, as a controller."""

    def __init__(self, opponents: int = 11, body: Body = DEFAULT) -> None:
        super().__init__(goalie_memory_cprm(body), self._read, needs=("memory",), body=body)
        self.opponents = opponents

    def _read(self, observation: Observation) -> Percepts:
        """`goalie_percepts`, and the place of the opponent who is most dangerous."""
        percepts = goalie_percepts(observation, self.opponents)
        danger = np.asarray(opponent_attributes(observation, self.opponents)["Opponent"]["danger"])
        nearest, rows = danger.argmax(axis=1), np.arange(len(danger))
        known = danger[rows, nearest] > 0
        memory = np.asarray(observation["memory"], np.float64)[rows, 12 + nearest]
        percepts["rival.x"] = np.where(known, memory[:, 0], FAR)
        percepts["rival.y"] = np.where(known, memory[:, 1], 0.0)
        return percepts


def make_controller(task: Task, agent: str) -> MemoryGoalie:
    """The goalie on his memory.

    Raises
    ------
    UnknownName
        For a task without a goalie to play.
    """
    if task.name != "Goalie":
        raise UnknownName(f"controller 'goalie_memory' cannot play task {task.name!r}; it plays Goalie")
    return MemoryGoalie(task.right if agent.startswith("left") else task.left, Body.of(task))
