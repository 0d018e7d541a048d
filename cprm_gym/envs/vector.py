"""Many worlds of one ego agent as a native Gymnasium `VectorEnv`: one kernel call for all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ..errors import CprmError, ParameterError, UnknownName
from .core import SoccerCore
from .faces import FPS, chosen_task
from .rewards import RewardOption
from .single import ego_agent
from .tasks.base import Task


class SoccerVectorEnv(gymnasium.vector.VectorEnv[Any, Any, np.ndarray]):
    """A task for one agent in `num_envs` worlds.

    Parameters
    ----------
    num_envs : int
        Worlds.
    task, agent, action_mode, others, include, observation, flatten, reward, reward_gamma, **options
        As for `SoccerEnv`.
    autoreset_mode : AutoresetMode or str
        ``NextStep`` (default), ``SameStep`` or ``Disabled``, as Gymnasium defines them.
    copy : bool
        Return copies of the observations and action masks (default). ``False`` returns the same arrays every time.
    threads : int
        Threads that share the worlds.

    Raises
    ------
    UnknownName
        For a task, agent, action mode or autoreset mode that does not exist.
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: str | Task = "GoToBall",
        agent: str | None = None,
        action_mode: str = "discrete",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        threads: int = 1,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        others: str | Sequence[str] | None = None,
        include: str | Sequence[str] = (),
        observation: str = "raw",
        flatten: bool = False,
        reward: RewardOption = None,
        reward_gamma: float = 0.99,
        **options: Any,
    ) -> None:
        if not isinstance(num_envs, (int, np.integer)) or num_envs < 1:
            raise ParameterError(f"num_envs: {num_envs!r} given, a whole number of at least 1 is needed")
        if render_mode is not None:
            raise UnknownName(f"render_mode {render_mode!r}: only None is allowed; pictures are drawn by `SoccerEnv` and soccer_v0")
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            raise UnknownName(f"autoreset_mode {autoreset_mode!r}: allowed are {', '.join(m.value for m in AutoresetMode)}") from None
        self.task = chosen_task(task, max_episode_steps, options)
        agent = ego_agent(self.task, agent)
        self.core = SoccerCore(
            self.task,
            num_envs,
            controlled=agent,
            view=action_mode,
            others=others,
            include=include,
            observation=observation,
            flatten=flatten,
            reward=reward,
            reward_gamma=reward_gamma,
            threads=threads,
        )
        self.num_envs = num_envs
        self.metadata = {"render_modes": [], "render_fps": FPS, "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.single_observation_space = self.core.observation_space()
        self.single_action_space = self.core.view.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._copy = copy
        self._over = np.zeros(num_envs, bool)
        self._seeded = False
        self._running = False

    def reset(self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start episodes: in all worlds, or in those of ``options["reset_mask"]`` (a (num_envs,) bool array)."""
        if seed is not None and not isinstance(seed, (int, np.integer)):
            raise ParameterError(f"seed: one whole number seeds all worlds (world k depends on it and k), got {seed!r:.60}")
        super().reset(seed=seed)
        mask = None if not options else options.get("reset_mask")
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != bool:
                raise ParameterError(f"reset_mask: expected bool of shape ({self.num_envs},), got {mask.dtype} of shape {mask.shape}")
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**31))
        self.core.reset(seed, mask)
        self._seeded = self._running = True
        self._over[slice(None) if mask is None else mask] = False
        return self._observation(), self._with_mask({})

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Play one cycle in every world, with the chosen autoreset.

        Raises
        ------
        CprmError
            Before the first `reset`, or (autoreset disabled) when a world that is over is stepped.
        CommandError
            When the actions do not fit the action space.
        """
        if not self._running:
            raise CprmError("step before reset: call reset() first")
        starting = self._over.copy() if self.autoreset_mode == AutoresetMode.NEXT_STEP else None
        if self.autoreset_mode == AutoresetMode.DISABLED and self._over.any():
            raise CprmError(f"worlds {np.flatnonzero(self._over).tolist()[:8]} are over: reset them with options={{'reset_mask': ...}}")
        step = self.core.step(_with_agents(actions))
        reward, terminated, truncated = step.reward[:, 0].copy(), step.terminated.copy(), step.truncated.copy()
        success, status = step.success.copy(), step.status.copy()
        terms = {name: values[:, 0].copy() for name, values in step.terms.items()}
        if starting is not None and starting.any():
            self.core.reset(None, starting)
            for values in (reward, terminated, truncated, success, status, *terms.values()):
                values[starting] = 0
        everywhere = np.ones(self.num_envs, bool)
        info = _where(everywhere, is_success=success, status=status, reward_terms=_where(everywhere, **terms))
        over = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and over.any():
            final = np.empty(self.num_envs, object)
            for i in np.flatnonzero(over):
                final[i] = self._observation_of(int(i))
            last = _where(over, is_success=success.copy(), status=status.copy(), reward_terms=_where(over, **terms))
            info |= _where(over, final_obs=final, final_info=last)
            self.core.reset(None, over)
            over = np.zeros(self.num_envs, bool)
        self._over = over
        return self._observation(), reward, terminated, truncated, self._with_mask(info)

    def _with_mask(self, info: dict[str, Any]) -> dict[str, Any]:
        """`info` with what can be done now, for the macro view."""
        mask = self.core.action_mask
        if mask is not None:
            info |= _where(np.ones(self.num_envs, bool), action_mask=mask[:, 0].copy() if self._copy else mask[:, 0])
        return info

    def _observation(self) -> Any:
        output = self.core.output
        if isinstance(output, np.ndarray):
            return output[:, 0].copy() if self._copy else output[:, 0]
        return {name: values[:, 0].copy() if self._copy else values[:, 0] for name, values in output.items()}

    def _observation_of(self, world: int) -> Any:
        """A copy of one world's observation."""
        output = self.core.output
        if isinstance(output, np.ndarray):
            return output[world, 0].copy()
        return {name: values[world, 0].copy() for name, values in output.items()}

    def close_extras(self, **kwargs: Any) -> None:
        """Nothing is held open."""


def _where(worlds: np.ndarray, **values: Any) -> dict[str, Any]:
    """Values of the worlds in Gymnasium's form: each followed by the array that says for which of them it counts."""
    return {key: value for name, given in values.items() for key, value in ((name, given), (f"_{name}", worlds))}


def _with_agents(actions: Any) -> Any:
    """Actions of one agent per world with an axis for that agent."""
    if isinstance(actions, dict):
        return {key: _lift(value) for key, value in actions.items()}
    return _lift(actions)


def _lift(value: Any) -> Any:
    """`value` with a second axis of length one; what has no axes is left for the view to refuse."""
    try:
        return np.asarray(value)[:, None]
    except (TypeError, ValueError, IndexError):
        return value
