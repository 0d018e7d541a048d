"""The goalie's net without a model: it acts on what was last seen, as it was seen.

Net, skills, thresholds and derived quantities are those of `cprm_gym.agents.goalie`; the places that there hold beliefs are inputs
here. What is not seen in a cycle (every second one is blind) keeps its last reading: a weak rival, behind
anything that carries the ball on. What inference is worth is told by `goalie_memory`.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.agents.body import DEFAULT, Body, of_body
from cprm_gym.agents.goalie import FAR, goalie_net, goalie_percepts
from cprm_gym.agents.percepts import Percepts
from cprm_gym.agents.play import SoccerAgent
from cprm_gym.architecture.cprm import CPRM
from cprm_gym.architecture.petri import Input
from cprm_gym.envs.controller import Observation
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import UnknownName

RAW = (
    Input("ball_x", observes="raw.ball_x"), Input("ball_y", observes="raw.ball_y"),
    Input("ball_vx", observes="raw.ball_vx"), Input("ball_vy", observes="raw.ball_vy"),
    Input("watched_x", observes="raw.rival_x", value=FAR), Input("watched_y", observes="raw.rival_y"),
)  # fmt: skip
"""Last readings in the places of beliefs."""
STARTING = {"raw.ball_x": 0.0, "raw.ball_y": 0.0, "raw.ball_vx": 0.0, "raw.ball_vy": 0.0, "raw.rival_x": FAR, "raw.rival_y": 0.0}
"""Before anything was seen."""


@of_body
def goalie_raw_cprm(body: Body) -> CPRM:
    """The net alone."""
    return CPRM("goalie_raw", net=goalie_net(RAW, attended=0, name="goalie_raw", body=body))


class RawGoalie(SoccerAgent):
    """The net on raw readings, as a controller."""

    def __init__(self, opponents: int = 11, body: Body = DEFAULT) -> None:
        super().__init__(goalie_raw_cprm(body), self._read, needs=("memory",), body=body)
        self.opponents = opponents
        self.last: Percepts = {}

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes and forget the last readings."""
        count = len(observation["level"])
        if worlds is None or not self.last:
            self.last = {name: np.full(count, value) for name, value in STARTING.items()}
        else:
            for name, value in STARTING.items():
                self.last[name][worlds] = value
        super().reset(observation, seed, worlds)

    def _read(self, observation: Observation) -> Percepts:
        """`goalie_percepts` and the last readings of ball and nearest opponent."""
        percepts = goalie_percepts(observation, self.opponents)
        seen, moving = percepts["ball.placed"] > 0, percepts["ball.moving"] > 0
        for name, when in (("x", seen), ("y", seen), ("vx", moving), ("vy", moving)):
            self.last[f"raw.ball_{name}"] = np.where(when, percepts[f"ball.{name}"], self.last[f"raw.ball_{name}"])
        least = np.full(len(seen), np.inf)
        for k in range(1, self.opponents + 1):
            x, y = percepts[f"o{k}.x"], percepts[f"o{k}.y"]
            gap = np.hypot(x - self.last["raw.ball_x"], y - self.last["raw.ball_y"])
            nearer = (percepts[f"o{k}.seen"] > 0) & (gap < least)
            least = np.where(nearer, gap, least)
            self.last["raw.rival_x"] = np.where(nearer, x, self.last["raw.rival_x"])
            self.last["raw.rival_y"] = np.where(nearer, y, self.last["raw.rival_y"])
        return {**percepts, **self.last}


def make_controller(task: Task, agent: str) -> RawGoalie:
    """The goalie without a model.

    Raises
    ------
    UnknownName
        For a task without a goalie to play.
    """
    if task.name != "Goalie":
        raise UnknownName(f"controller 'goalie_raw' cannot play task {task.name!r}; it plays Goalie")
    return RawGoalie(task.right if agent.startswith("left") else task.left, Body.of(task))
