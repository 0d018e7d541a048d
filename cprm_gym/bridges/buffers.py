"""Agents of many worlds as rows of flat arrays that are written in place: the form of PufferLib, without needing it."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from ..envs.tasks import Task
from ..errors import CommandError, CprmError, UnknownName
from .worlds import AgentWorlds


class SoccerBuffers:
    """Every agent of every world is a row; agents of world k are the rows ``k * A ... (k + 1) * A - 1``.

    Episodes that end begin anew in the same step: the row then holds the first observation of the next one. A time-out is a truncation.

    Parameters
    ----------
    worlds, task, threads, **options
        As for `AgentWorlds`; observations are one vector (``flatten=True`` if the preset is not one).

    Attributes
    ----------
    num_agents : int
        Rows, W * A.
    observations : (rows, n) float32 array
    rewards : (rows,) float32 array
    terminals, truncations : (rows,) bool array
    masks : (rows,) bool array
        Rows whose agent takes part: all.
    action_masks : (rows, macros) bool array, or None
        What can be done now; the macro view alone.
    actions : array
        Of the last step.

    Raises
    ------
    UnknownName
        For the views ``hybrid`` and ``full``, whose actions are no one array.
    """

    def __init__(self, worlds: int = 1, task: str | Task = "Soccer", *, threads: int = 1, **options: Any) -> None:
        if options.get("action_mode") in ("hybrid", "full"):
            raise UnknownName(f"action_mode {options['action_mode']!r}: allowed here are discrete, box and macro")
        self.worlds = AgentWorlds(worlds, task, threads=threads, **{"flatten": True, **options})
        self.core = self.worlds.core
        space = self.worlds.observation_space
        if not isinstance(space, spaces.Box):
            raise UnknownName("include: 'action_mask' is in `action_masks` here; leave it out")
        self.single_observation_space: spaces.Box = space
        self.single_action_space = self.worlds.action_space
        self.agents_per_world = len(self.core.agents)
        self.num_agents = self.worlds.worlds * self.agents_per_world
        self.observation_space = batch_space(space, self.num_agents)
        self.action_space = batch_space(self.single_action_space, self.num_agents)
        self.observations: np.ndarray = np.zeros((self.num_agents, *space.shape), np.float32)
        self.rewards = np.zeros(self.num_agents, np.float32)
        self.terminals, self.truncations = np.zeros(self.num_agents, bool), np.zeros(self.num_agents, bool)
        self.masks = np.ones(self.num_agents, bool)
        self.actions: np.ndarray = np.zeros((self.num_agents, *(self.single_action_space.shape or ())), self.single_action_space.dtype)
        mask = self.core.action_mask
        self.action_masks = None if mask is None else np.zeros((self.num_agents, mask.shape[2]), bool)
        self._running = False

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, list[dict[str, Any]]]:
        """Begin all episodes."""
        self.worlds.reset(seed)
        self._running = True
        self.rewards[...], self.terminals[...], self.truncations[...] = 0.0, False, False
        self._tell()
        return self.observations, []

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play one cycle in every world.

        Parameters
        ----------
        actions : (rows, ...) array

        Returns
        -------
        observations, rewards, terminals, truncations : the arrays of this object
        infos : list of dict
            One for each episode that has ended: ``world``, ``status``, ``is_success`` (mean of its agents) and ``cycle``.

        Raises
        ------
        CprmError
            Before the first `reset`.
        CommandError
            When the actions do not fit.
        """
        if not self._running:
            raise CprmError("step before reset: call reset() first")
        actions = np.asarray(actions)
        if actions.shape != self.actions.shape:
            raise CommandError(f"actions: expected shape {self.actions.shape}, a row for each agent, got {actions.shape}")
        self.actions = actions
        count, agents = self.worlds.worlds, self.agents_per_world
        step = self.core.step(actions.reshape(count, agents, *actions.shape[1:]))
        self.rewards.reshape(count, agents)[...] = step.reward
        self.terminals.reshape(count, agents)[...] = step.terminated[:, None]
        self.truncations.reshape(count, agents)[...] = step.truncated[:, None]
        over = step.terminated | step.truncated
        ended: list[dict[str, Any]] = []
        if over.any():
            for k in np.flatnonzero(over):
                told = {"status": int(step.status[k]), "is_success": float(step.success[k].mean()), "cycle": int(self.core.cycle[k])}
                ended.append({"world": int(k), **told})
            self.worlds.reset(None, over)
        self._tell()
        return self.observations, self.rewards, self.terminals, self.truncations, ended

    def _tell(self) -> None:
        """Write what is seen now."""
        output = self.core.output
        assert isinstance(output, np.ndarray)
        self.observations[...] = output.reshape(self.observations.shape)
        if self.action_masks is not None and self.core.action_mask is not None:
            self.action_masks[...] = self.core.action_mask.reshape(self.action_masks.shape)

    def close(self) -> None:
        """Leave the server, if it is played on one."""
        self.core.close()
