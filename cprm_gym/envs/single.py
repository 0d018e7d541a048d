"""One ego agent as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np

from ..errors import CprmError, UnknownName
from .core import SoccerCore, batch_of_one, select_agents
from .faces import FPS, RENDER_MODES, Pictured, chosen_render_mode, chosen_task
from .rewards import RewardOption
from .tasks.base import Task


class SoccerEnv(Pictured, gymnasium.Env[Any, Any]):
    """A task for one agent.

    Parameters
    ----------
    task : str or Task
        Name of a task, or a task.
    agent : str, optional
        Who the ego agent is; the task's first controlled agent if not given.
    action_mode : str
        ``discrete`` (default), ``box``, ``hybrid``, ``full`` (hybrid with say, attention and point) or ``macro``.
    render_mode : str, optional
        ``human``, ``rgb_array`` or ``ansi``.
    max_episode_steps : int, optional
        Overrides the task's ``max_cycles``.
    debug_info : bool
        Put the true positions into ``info["truth"]``.
    others : str or (str, str), optional
        Scripted policy of the other players, or one for each side; the task's own if not given.
    include : str or sequence of str
        Further parts of the observation: ``memory`` (a picture of the pitch kept from the agent's own percepts), ``landmarks``,
        ``hear``.
    observation : str
        Preset: ``raw`` (default), ``memory``, ``full``, ``hfo_low``, ``hfo_high`` or ``keepaway`` (`cprm_gym.envs.presets`).
    flatten : bool
        One vector instead of a dict.
    reward : None, str, sequence or mapping of str, or function
        The task's own, with named shaping terms added, or a function instead of it (`cprm_gym.envs.rewards`).
    reward_gamma : float
        Discount of the shaping terms.
    **options
        Passed on to the task.

    Raises
    ------
    UnknownName
        For a task, agent or action mode that does not exist; the message lists those that do.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": FPS}  # noqa: RUF012

    def __init__(
        self,
        task: str | Task = "GoToBall",
        agent: str | None = None,
        action_mode: str = "discrete",
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        debug_info: bool = False,
        others: str | Sequence[str] | None = None,
        include: str | Sequence[str] = (),
        observation: str = "raw",
        flatten: bool = False,
        reward: RewardOption = None,
        reward_gamma: float = 0.99,
        **options: Any,
    ) -> None:
        self.task = chosen_task(task, max_episode_steps, options)
        self.render_mode = chosen_render_mode(render_mode)
        self.agent = ego_agent(self.task, agent)
        self.core = SoccerCore(
            self.task,
            1,
            controlled=self.agent,
            view=action_mode,
            others=others,
            include=include,
            observation=observation,
            flatten=flatten,
            reward=reward,
            reward_gamma=reward_gamma,
        )
        self.observation_space: gymnasium.spaces.Space[Any] = self.core.observation_space()
        self.action_space = self.core.view.space
        self.debug_info = debug_info
        self._seeded = False
        self._running = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode; the first reset without a seed draws one."""
        super().reset(seed=seed)
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**31))
        self._seeded = True
        self._running = True
        self.core.reset(seed)
        self._show()
        return self._observation(), self._info("IN_GAME", False)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play one cycle.

        Raises
        ------
        CprmError
            Before the first `reset`, or after the end of an episode.
        CommandError
            When the action does not fit the action space; the message names the entry.
        """
        if not self._running:
            raise CprmError("step before reset: call reset() first; the episode has not begun or is over")
        step = self.core.step(batch_of_one(action))
        terminated, truncated = bool(step.terminated[0]), bool(step.truncated[0])
        self._running = not (terminated or truncated)
        info = self._info(self.task.statuses[step.status[0]], bool(step.success[0]))
        info["reward_terms"] = {name: float(values[0, 0]) for name, values in step.terms.items()}
        self._show()
        return self._observation(), float(step.reward[0, 0]), terminated, truncated, info

    def _observation(self) -> Any:
        output = self.core.output
        if isinstance(output, np.ndarray):
            return output[0, 0].copy()
        return {name: values[0, 0].copy() for name, values in output.items()}

    def _info(self, status: str, success: bool) -> dict[str, Any]:
        info: dict[str, Any] = {"status": status, "is_success": success, "cycle": int(self.core.cycle[0])}
        if self.core.action_mask is not None:
            info["action_mask"] = self.core.action_mask[0, 0].astype(np.int8)
        if self.debug_info:
            info["truth"] = self.core.sim.world["pos"][0].copy()
        return info


def ego_agent(task: Task, agent: str | None) -> str:
    """The one agent of a single-agent environment: the given one, or the first that the task lets act."""
    chosen = select_agents(task.controlled if agent is None else agent, task.left, task.right)
    if agent is not None and len(chosen) != 1:
        raise UnknownName(f"agent {agent!r}: one agent is needed here, such as {chosen[0]!r}; use soccer_v0 for several")
    return chosen[0]
