"""Many worlds of one ego agent as a native Gymnasium `VectorEnv`: one kernel call for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ..errors import CprmError, ParameterError, UnknownName
from . import infos
from .core import SoccerCore
from .rendering import FPS, Viewer
from .single import ego_options
from .tasks.base import Task, checked_reset
from .tasks.base import marked as marked_worlds

RENDERED = ("rgb_array", "ansi")
"""Render modes: `SoccerVectorEnv.render` gives a picture of each world."""
NOW = ("action_mask", "truth")
"""Infos that belong to the observation, not to the cycle that led to it."""


class SoccerVectorEnv(gymnasium.vector.VectorEnv[Any, Any, np.ndarray]):
    """A task for one agent in `num_envs` worlds.

    Infos: `cprm_gym.envs.infos`. ``reset(options=...)`` takes ``reset_mask``, ``start`` and ``state``, as `SoccerEnv` does.

    Parameters
    ----------
    num_envs : int
        Worlds.
    task, **options
        As for `SoccerEnv`.
    autoreset_mode : AutoresetMode or str
        ``NextStep`` (default), ``SameStep`` or ``Disabled``, as Gymnasium defines them.
    copy : bool
        Return copies of the observations and action masks (default). ``False`` returns the same arrays every time.
    threads : int
        Threads that share the worlds.
    render_mode : str, optional
        ``rgb_array`` or ``ansi``: pictures of all worlds.

    Raises
    ------
    UnknownName
        For a task, agent, action mode or autoreset mode that does not exist.
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: str | Task = "GoToBall",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        threads: int = 1,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        if isinstance(num_envs, bool) or not isinstance(num_envs, (int, np.integer)) or num_envs < 1:
            raise ParameterError(f"num_envs: {num_envs!r} given, a whole number of at least 1 is needed")
        if render_mode not in (None, *RENDERED):
            raise UnknownName(f"render_mode {render_mode!r}: allowed are {', '.join(RENDERED)} or None; a window has room for one world")
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            raise UnknownName(f"autoreset_mode {autoreset_mode!r}: allowed are {', '.join(m.value for m in AutoresetMode)}") from None
        self.options = ego_options({"task": task, **options})
        self.core = SoccerCore(self.options, num_envs, threads=threads)
        self.task = self.core.task
        self.num_envs = num_envs
        self.metadata = {"render_modes": list(RENDERED), "render_fps": FPS, "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.single_observation_space = self.core.observation_space()
        self.single_action_space = self.core.view.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._viewers: list[Viewer] = []
        self._copy = copy
        self._over = np.zeros(num_envs, bool)
        self._everywhere = np.ones(num_envs, bool)
        self._seeded = False
        self._running = False

    def reset(self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start episodes: in all worlds, or in those of ``options["reset_mask"]`` (a (num_envs,) bool array).

        Parameters
        ----------
        seed : int or list, optional
            One number seeds all worlds: world k depends on it and k. A list has one for each world (None: it goes on as it is): world k
            is then what a `SoccerEnv` with its seed is.

        Raises
        ------
        ParameterError
            For an unknown option, a wrong mask or wrong seeds.
        """
        chosen = checked_reset(options, ("reset_mask", "start", "state"))
        mask = chosen.pop("reset_mask", None)
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != bool:
                raise ParameterError(f"reset_mask: expected bool of shape ({self.num_envs},), got {mask.dtype} of shape {mask.shape}")
        if seed is None or isinstance(seed, (int, np.integer)):
            super().reset(seed=seed)
        elif mask is not None and isinstance(seed, list) and len(seed) == self.num_envs:
            seed = [one for one, here in zip(seed, mask) if here]
        if seed is None and not self._seeded and "state" not in chosen:
            seed = int(self.np_random.integers(2**31))
        self.core.reset(seed, mask, **chosen)
        self._seeded = self._running = True
        self._over[slice(None) if mask is None else mask] = False
        return self._observation(), marked_worlds(self._everywhere, infos.of_worlds(self.core, None, self.options.debug_info, self._copy))

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
        reward, terminated, truncated = step.reward[:, 0].copy(), step.terminated.copy(), step.truncated
        info = infos.of_worlds(self.core, step, self.options.debug_info, self._copy)
        if starting is not None and starting.any():
            self.core.reset(None, starting)
            for values in (reward, terminated, truncated, *(values for name, values in info.items() if name not in NOW)):
                values[starting] = 0
            info |= infos.now_of_worlds(self.core, self.options.debug_info, self._copy)
        over = terminated | truncated
        marked = marked_worlds(self._everywhere, info)
        if self.autoreset_mode == AutoresetMode.SAME_STEP and over.any():
            final = np.empty(self.num_envs, object)
            for i in np.flatnonzero(over):
                final[i] = self._observation_of(int(i))
            last = {name: values.copy() for name, values in info.items()}
            self.core.reset(None, over)
            marked |= marked_worlds(self._everywhere, infos.now_of_worlds(self.core, self.options.debug_info, self._copy))
            marked |= marked_worlds(over, {"final_obs": final, "final_info": marked_worlds(over, last)})
            over = np.zeros(self.num_envs, bool)
        self._over = over
        return self._observation(), reward, terminated, truncated, marked

    def save_state(self) -> dict[str, np.ndarray]:
        """The running episodes as arrays; `load_state` and ``reset(options={"state": ...})`` go on from it, ``np.savez`` keeps it."""
        return {**self.core.save_state(), "over": self._over.copy()}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a state of `save_state`: of as many worlds, or of one, from which then all go on.

        Raises
        ------
        ParameterError
            When it is the state of an environment with other options.
        """
        self.core.load_state(state)
        self._over[...] = state["over"]
        self._seeded = self._running = True

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

    def render(self) -> tuple[Any, ...] | None:
        """A picture of each world (``rgb_array``) or a text (``ansi``); None without a render mode."""
        if self.render_mode is None:
            return None
        if not self._viewers:
            goal_width = self.core.parameters.goal_width
            self._viewers = [Viewer(str(self.render_mode), FPS, self.task.region, goal_width) for _ in range(self.num_envs)]
        return tuple(viewer.draw(self.core.sim.world[k]) for k, viewer in enumerate(self._viewers))

    def close_extras(self, **kwargs: Any) -> None:
        """Let go of what draws, and leave the server, if it is played on one."""
        for viewer in self._viewers:
            viewer.close()
        self._viewers = []
        self.core.close()


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
