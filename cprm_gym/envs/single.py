"""One ego agent as a Gymnasium environment."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np

from ..errors import CprmError, UnknownName
from . import infos
from .core import SoccerCore, batch_of_one, select_agents
from .options import RENDER_MODES, EnvOptions, chosen_render_mode
from .rendering import FPS, Pictured
from .tasks.base import Task, checked_reset


class SoccerEnv(Pictured, gymnasium.Env[Any, Any]):
    """A task for one agent.

    Infos: `cprm_gym.envs.infos`. ``reset(options=...)`` takes ``start`` (where ball and players shall be, `Pitch.start_at`) and ``state``
    (of `save_state`).

    Parameters
    ----------
    task : str or Task
        Name of a task, or a task.
    render_mode : str, optional
        ``human``, ``rgb_array`` or ``ansi``.
    **options
        As for `EnvOptions`, and fields of the task. ``agent``: who the ego agent is; the task's first controlled agent if not given.

    Raises
    ------
    UnknownName
        For a task, agent or action mode that does not exist; the message lists those that do.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": FPS}  # noqa: RUF012

    def __init__(self, task: str | Task = "GoToBall", render_mode: str | None = None, **options: Any) -> None:
        self.render_mode = chosen_render_mode(render_mode)
        self.options = ego_options({"task": task, **options})
        self.core = SoccerCore(self.options, 1)
        self.task, self.agent = self.core.task, self.core.agents[0]
        self.observation_space: gymnasium.spaces.Space[Any] = self.core.observation_space()
        self.action_space = self.core.view.space
        self._seeded = False
        self._running = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode; the first reset without a seed draws one.

        Raises
        ------
        ParameterError
            For an unknown option.
        """
        chosen = checked_reset(options, ("start", "state"))
        if self._running:
            self._tell_of_limit()
        super().reset(seed=seed)
        if seed is None and not self._seeded and "state" not in chosen:
            seed = int(self.np_random.integers(2**31))
        self.core.reset(seed, **chosen)
        self._seeded = self._running = True
        self._show()
        return self._observation(), infos.of_agents(self.core, None, self.options.debug_info)[0]

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
        info = infos.of_agents(self.core, step, self.options.debug_info)[0]
        self._show()
        return self._observation(), float(step.reward[0, 0]), terminated, truncated, info

    def action_masks(self) -> np.ndarray:
        """(macros,) bool: what can be done now; the method that MaskablePPO calls.

        Raises
        ------
        CprmError
            For another view than macro.
        """
        return _mask(self.core)[0, 0].copy()

    def save_state(self) -> dict[str, np.ndarray]:
        """The running episode as arrays; `load_state` and ``reset(options={"state": ...})`` go on from it, ``np.savez`` keeps it."""
        return {**self.core.save_state(), "over": np.array([not self._running])}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a state of `save_state`, of an environment with the same options.

        Raises
        ------
        ParameterError
            When it is the state of another one.
        """
        self.core.load_state(state)
        self._running, self._seeded = not bool(state["over"][0]), True

    def _tell_of_limit(self) -> None:
        """Say so when Gymnasium's own limit has cut an episode that was made longer."""
        spec = None if self.spec is None else gymnasium.registry.get(self.spec.id)
        limit = None if spec is None else spec.max_episode_steps
        if limit is not None and int(self.core.cycle[0]) == limit < self.core.max_cycles:
            warnings.warn(
                f"the episode was cut after {limit} steps, the registered max_episode_steps of {spec.id if spec else ''}, before "
                f"max_cycles={self.core.max_cycles}: give gymnasium.make also max_episode_steps={self.core.max_cycles}",
                stacklevel=3,
            )

    def _observation(self) -> Any:
        output = self.core.output
        if isinstance(output, np.ndarray):
            return output[0, 0].copy()
        return {name: values[0, 0].copy() for name, values in output.items()}


def ego_options(given: Mapping[str, Any]) -> EnvOptions:
    """The options of a face of one agent: its `controlled` is one name, the given one or the first that the task lets act.

    Raises
    ------
    UnknownName
        When several agents are meant.
    """
    options = EnvOptions.of(given)
    task = options.played()
    chosen = select_agents(task.controlled if options.controlled is None else options.controlled, task.left, task.right)
    if options.controlled is not None and len(chosen) != 1:
        raise UnknownName(f"agent {options.controlled!r}: one agent is needed here, such as {chosen[0]!r}; use soccer_v2 for several")
    return replace(options, controlled=chosen[0])


def _mask(core: SoccerCore) -> np.ndarray:
    """(W, A, macros) bool.

    Raises
    ------
    CprmError
        For another view than macro.
    """
    if core.action_mask is None:
        raise CprmError("action_masks: only the macro view has masks; make the environment with action_mode='macro'")
    return core.action_mask
