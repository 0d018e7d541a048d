"""Skills of the architecture as options: which of them goes on is chosen, by a learned policy or by whoever asks.

An option (Sutton, Precup and Singh, 1999) is the net of one skill. It is begun when it is chosen and was not going on before, or has
ended; it may be left for another one at every choice.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..agents.body import Body
from ..agents.worlds.trials import TRIALS
from ..envs.controller import Action, no_action
from ..envs.core import player_number
from ..envs.tasks.base import Task

OUTFIELD = ("go_to_ball", "meet_ball", "dribble", "shoot")
"""Options of who is no goalie."""
WITH_MATE = ("pass_ball", "receive")
"""Further ones of who has a team-mate."""
GOALIE = ("watch_ball", "reposition", "catch_ball", "clear")
"""Options of a goalie."""


def option_names(task: Task, agent: str) -> tuple[str, ...]:
    """Names of the options of an agent, in the order of their numbers."""
    player = player_number(agent)
    left = player <= 11
    if (player - 1) % 11 + 1 == (task.left_goalie if left else task.right_goalie):
        return GOALIE
    return OUTFIELD + (WITH_MATE if (task.left if left else task.right) > 1 else ())


class OptionPlayer:
    """The options of one agent in N worlds.

    Parameters
    ----------
    task : Task
    agent : str
    worlds : int

    Attributes
    ----------
    names : tuple of str
    """

    needs = ("memory",)

    def __init__(self, task: Task, agent: str, worlds: int) -> None:
        self.names = option_names(task, agent)
        body = Body.of(task)
        self._agents = [TRIALS[name].agent(name, body, settle=0) for name in self.names]
        self._chosen = np.full(worlds, -1)

    def begin(self, observation: Mapping[str, np.ndarray], seed: int, worlds: np.ndarray | None = None) -> None:
        """Episodes begin, of all worlds or of some, (N,) bool: no option goes on."""
        if worlds is None:
            for agent in self._agents:
                agent.reset(observation, seed)
        self._chosen[slice(None) if worlds is None else worlds] = -1

    def act(self, observation: Mapping[str, np.ndarray], chosen: np.ndarray) -> Action:
        """Hybrid actions of one cycle of the options, (N,) int."""
        action = no_action(len(chosen))
        for k, agent in enumerate(self._agents):
            here = chosen == k
            if not here.any():
                continue
            assert agent.controller is not None
            fresh = here & ((self._chosen != k) | (agent.controller.executor.read("done") > 0))
            if fresh.any():
                agent.reset(observation, 0, fresh)
            given = agent.act(observation)
            for key, values in action.items():
                values[here] = np.asarray(given[key])[here]
        self._chosen[:] = chosen
        return action
