"""An eleven of CPRM agents: the goalie and ten outfield players, each on his own percepts, who say nothing to each other.

`make_controller` gives one of them, as a client of its own; `Eleven` is the whole team of a side, each of them alone or the outfield
players as one batch.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..architecture.prm.grounding.grounding import Grounding
from ..architecture.prm.inference.engines.exact import ExactEngine
from ..envs.controller import Action, Observation
from ..envs.core import agent_names
from ..envs.tasks import Task
from ..errors import unknown_name
from .body import Body
from .goalie import GoalieAgent
from .outfielder.agent import OutfieldAgent, outfielder_cprm
from .play import SoccerAgent

FOR_GOALIE = ("t_b", "latency", "demand", "rehearsal")
"""When he infers, and how many slices he imagines before the first."""


def make_controller(task: Task, agent: str, **options: Any) -> SoccerAgent:
    """The goalie, or an outfield player, of a match as a controller.

    Parameters
    ----------
    task : Task
    agent : str
        ``left_1``: the goalie, if the team has one with that number.
    **options
        Of the `CPRMRunner`; the goalie takes those of `FOR_GOALIE`, an outfield player all of them.
    """
    side, _, number = agent.partition("_")
    goalie, opponents = (task.left_goalie, task.right) if side == "left" else (task.right_goalie, task.left)
    body = Body.of(task)
    if int(number) != goalie:
        return OutfieldAgent(body, **options)
    return GoalieAgent(opponents, body=body, **{name: options[name] for name in FOR_GOALIE if name in options})


class Eleven:
    """The team of a side, who decide one after the other.

    Parameters
    ----------
    task : Task
    side : str
        ``left`` or ``right``.
    together : bool
        The outfield players are copies of one controller, which decides for all of them at once. They are no less alone for that: each
        copy has its own observation, net and belief. Apart or together, outfield players share what inference compiles.

    Attributes
    ----------
    names : tuple of str
        Names of the players.
    agents : tuple of SoccerAgent
    rows : tuple of slice
        Which players each agent decides for.

    Raises
    ------
    UnknownName
        For another side.
    """

    def __init__(self, task: Task, side: str = "left", together: bool = False) -> None:
        if side not in ("left", "right"):
            raise unknown_name("side", side, ("left", "right"))
        self.names = tuple(name for name in agent_names(task.left, task.right) if name.startswith(side))
        apart = [slice(i, i + 1) for i in range(len(self.names))]
        goalie = task.left_goalie if side == "left" else task.right_goalie
        if together and goalie in (0, 1):
            first = 1 if goalie else 0
            self.rows = (*apart[:first], slice(first, len(self.names))) if len(self.names) > first else tuple(apart)
        else:
            self.rows = tuple(apart)
        cprm = outfielder_cprm(Body.of(task))
        assert cprm.model is not None
        shared = {"engine": ExactEngine(), "grounding": Grounding(cprm.model, cprm.objects)}
        self.agents = tuple(make_controller(task, self.names[rows.start], **shared) for rows in self.rows)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes.

        Parameters
        ----------
        observation : dict of (N, A, ...) arrays
            Of N worlds and the A players.
        seed : int
        worlds : (N,) bool array, optional
            Which worlds begin anew; all if not given.
        """
        for i, agent in enumerate(self.agents):
            part = self.view(observation, i)
            batch = self.rows[i].stop - self.rows[i].start
            agent.reset(part, seed + i, None if worlds is None else np.repeat(np.asarray(worlds, bool), batch))

    def view(self, observation: Observation, agent: int) -> Observation:
        """What an agent is given: the observations of its own players, (N * players, ...)."""
        rows = self.rows[agent]
        parts = {key: np.asarray(value)[:, rows] for key, value in observation.items()}
        return {key: value.reshape(-1, *value.shape[2:]) for key, value in parts.items()}

    def act(self, observation: Observation) -> Action:
        """Actions of all players, (N, A, ...)."""
        worlds = len(observation["level"])
        actions = [agent.act(self.view(observation, i)) for i, agent in enumerate(self.agents)]
        return {
            key: np.concatenate([action[key].reshape(worlds, -1, *action[key].shape[1:]) for action in actions], axis=1)
            for key in actions[0]
        }
