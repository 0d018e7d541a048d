"""Agents x worlds as one batch for stable-baselines3, without any wrapper in between.

    from cprm_gym.wrappers.sb3 import SoccerVecEnv
    model = PPO("MlpPolicy", SoccerVecEnv("GoToBall", worlds=16, action_mode="discrete", observation="hfo_low"))

All controlled agents of all worlds are entries of one `VecEnv`, so one policy is shared by all of them (parameter sharing). Entry
``world * agents + agent``. `MaskablePPO` finds the masks of the macro view.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces as gym_spaces

from ..envs.core import SoccerCore
from ..envs.options import EnvOptions
from ..envs.tasks.base import Task
from ..errors import CommandError, CprmError, ParameterError

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise CprmError("cprm_gym.wrappers.sb3 needs stable-baselines3: pip install 'cprm-gym[rl]'") from error


class SoccerVecEnv(VecEnv):  # type: ignore[misc]
    """A task as a `VecEnv` of stable-baselines3: one entry per world and controlled agent.

    Parameters
    ----------
    task : str or Task
    worlds : int
        Worlds of the batch.
    action_mode : str
        ``discrete`` (PPO), ``box`` (SAC, TD3, PPO) or ``macro`` (PPO, DQN with one agent, MaskablePPO). stable-baselines3 knows no
        hybrid actions.
    seed : int
        Of the first reset; `VecEnv.seed` changes it.
    threads : int
        Threads that share the worlds.
    **options
        As for `EnvOptions`, and fields of the task: ``controlled``, ``others``, ``include``, ``observation``, ``flatten``, ``reward`` ...

    Raises
    ------
    ParameterError
        For the hybrid and the full view, and for an option that neither the engine nor the task has.
    """

    def __init__(
        self, task: str | Task, worlds: int = 1, action_mode: str = "discrete", seed: int = 0, threads: int = 1, **options: Any
    ) -> None:
        if action_mode in ("hybrid", "full"):
            message = f"has no Dict actions; action_mode is discrete, box or macro, not {action_mode}"
            raise ParameterError(f"SoccerVecEnv: stable-baselines3 {message}")
        self.core = SoccerCore(EnvOptions.of({"task": task, "action_mode": action_mode, **options}), worlds, threads=threads)
        self.worlds, self.agents = worlds, len(self.core.agents)
        self.render_mode: str | None = None
        super().__init__(worlds * self.agents, self.core.observation_space(), self.core.view.space)
        self._seed: int | None = seed
        self._actions: Any = None
        self._returns = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, np.int64)

    # ------------------------------------------------------------------ the cycle

    def reset(self) -> Any:
        """Start episodes in all worlds."""
        self.core.reset(self._seed)
        self._seed = None
        self._returns[:], self._lengths[:] = 0.0, 0
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self._observation()

    def step_async(self, actions: Any) -> None:
        """Note the actions, (worlds * agents, ...).

        Raises
        ------
        CommandError
            For actions of another number.
        """
        actions = np.asarray(actions)
        if actions.ndim == 0 or len(actions) != self.num_envs:
            needed = f"one for each of {self.worlds} worlds x {self.agents} agents is needed"
            raise CommandError(f"actions: shape {actions.shape} given; {needed}")
        self._actions = actions.reshape(self.worlds, self.agents, *actions.shape[1:])

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play one cycle; worlds that end begin anew, their last observations stand in ``info["terminal_observation"]``."""
        step = self.core.step(self._actions)
        rewards = step.reward.reshape(-1).astype(np.float32)
        over = step.terminated | step.truncated
        dones = np.repeat(over, self.agents)
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if over.any():
            last = self._observation()
            for i in np.flatnonzero(dones):
                w = i // self.agents
                infos[i] = {
                    "terminal_observation": {k: v[i] for k, v in last.items()} if isinstance(last, dict) else last[i],
                    "TimeLimit.truncated": bool(step.truncated[w]),
                    "episode": {"r": float(self._returns[i]), "l": int(self._lengths[i]), "t": 0.0},
                    "is_success": bool(step.success[w, i % self.agents]),
                    "status": int(step.status[w]),
                }
            self._returns[dones], self._lengths[dones] = 0.0, 0
            self.core.reset(None, over)
        return self._observation(), rewards, dones, infos

    def _observation(self) -> Any:
        output = self.core.output
        if isinstance(output, np.ndarray):
            return output.reshape(self.num_envs, *output.shape[2:]).copy()
        return {k: v.reshape(self.num_envs, *v.shape[2:]).copy() for k, v in output.items()}

    # ------------------------------------------------------------------ what stable-baselines3 asks

    def action_masks(self) -> np.ndarray:
        """(worlds * agents, macros) bool: what can be done now.

        Raises
        ------
        CprmError
            For another view than macro.
        """
        mask = self.core.action_mask
        if mask is None:
            raise CprmError("action_masks: only the macro view has masks; make the environment with action_mode='macro'")
        return mask.reshape(self.num_envs, -1)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed of the next reset."""
        self._seed = seed
        return [seed] * self.num_envs

    def close(self) -> None:
        """Nothing is held open."""

    def has_attr(self, attr_name: str) -> bool:
        """Whether the environment has an attribute; ``action_masks`` only in the macro view."""
        if attr_name == "action_masks":
            return self.core.action_mask is not None
        return hasattr(self, attr_name)

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The attribute, once per entry."""
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the whole batch."""
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        """Call a method for entries; ``action_masks`` gives each its own mask."""
        chosen = list(self._get_indices(indices))
        if method_name == "action_masks":
            masks = self.action_masks()
            return [masks[i] for i in chosen]
        result = getattr(self, method_name)(*arguments, **options)
        return [result] * len(chosen)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No wrappers, but episodes are monitored as by stable-baselines3's own `Monitor`."""
        return [wrapper_class is Monitor] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[np.ndarray | None]:
        """There are no pictures of a batch."""
        return [None] * self.num_envs


class ParallelVecEnv(VecEnv):  # type: ignore[misc]
    """Several copies of any PettingZoo parallel environment as a `VecEnv`: one entry per copy and agent, one policy for all.

    Parameters
    ----------
    make : callable
        Gives a new parallel environment whose agents have equal spaces and stay to the end.
    copies : int
    seed : int
        Of the first resets; copy k starts with ``seed + k``.

    Raises
    ------
    ParameterError
        When the agents have different spaces, or actions that stable-baselines3 does not know.
    """

    def __init__(self, make: Callable[[], Any], copies: int = 1, seed: int = 0) -> None:
        if not isinstance(copies, int) or copies < 1:
            raise ParameterError(f"ParallelVecEnv: copies is {copies!r}; allowed are whole numbers from 1")
        self.envs = [make() for _ in range(copies)]
        self.agents: list[str] = list(self.envs[0].possible_agents)
        first = self.agents[0]
        spaces = self.envs[0].observation_space(first), self.envs[0].action_space(first)
        for agent in self.agents:
            if (self.envs[0].observation_space(agent), self.envs[0].action_space(agent)) != spaces:
                raise ParameterError(f"ParallelVecEnv: {agent} has other spaces than {first}; one policy needs equal ones")
        if isinstance(spaces[1], gym_spaces.Dict):
            raise ParameterError("ParallelVecEnv: stable-baselines3 has no Dict actions; make environments with other ones (action_mode)")
        self.render_mode: str | None = None
        super().__init__(copies * len(self.agents), *spaces)
        self.seed(seed)
        self._actions: Any = None
        self._totals = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, np.int64)

    def _start(self, copy: int) -> list[Any]:
        seen, _ = self.envs[copy].reset(seed=self._seeds[copy])
        self._seeds[copy] = None
        return [seen[a] for a in self.agents]

    def reset(self) -> Any:
        """Start episodes in all copies."""
        self._totals[:], self._lengths[:] = 0.0, 0
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return _together([o for k in range(len(self.envs)) for o in self._start(k)])

    def step_async(self, actions: Any) -> None:
        """Note the actions, (copies * agents, ...)."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Play one cycle in every copy; copies that end begin anew."""
        seen: list[Any] = []
        rewards, dones = np.zeros(self.num_envs, np.float32), np.zeros(self.num_envs, bool)
        infos: list[dict[str, Any]] = []
        for k, env in enumerate(self.envs):
            begin = k * len(self.agents)
            o, r, terminated, truncated, info = env.step({a: self._actions[begin + i] for i, a in enumerate(self.agents)})
            rows = slice(begin, begin + len(self.agents))
            rewards[rows] = [r[a] for a in self.agents]
            self._totals[rows] += rewards[rows]
            self._lengths[rows] += 1
            here = [dict(info[a]) for a in self.agents]
            now = [o[a] for a in self.agents]
            if not env.agents:
                dones[rows] = True
                for i, a in enumerate(self.agents):
                    here[i]["terminal_observation"] = o[a]
                    here[i]["TimeLimit.truncated"] = bool(truncated[a] and not terminated[a])
                    here[i]["episode"] = {"r": float(self._totals[begin + i]), "l": int(self._lengths[begin + i]), "t": 0.0}
                self._totals[rows], self._lengths[rows] = 0.0, 0
                now = self._start(k)
            seen += now
            infos += here
        return _together(seen), rewards, dones, infos

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seeds of the next resets."""
        self._seeds: list[int | None] = [None if seed is None else seed + k for k in range(len(self.envs))]
        return self._seeds

    def close(self) -> None:
        """Close the copies."""
        for env in self.envs:
            env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The attribute of each entry's copy."""
        return [getattr(self.envs[i // len(self.agents)], attr_name) for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the entries' copies."""
        for i in self._get_indices(indices):
            setattr(self.envs[i // len(self.agents)], attr_name, value)

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        """Call a method of each entry's copy."""
        return [getattr(self.envs[i // len(self.agents)], method_name)(*arguments, **options) for i in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No wrappers, but episodes are monitored as by stable-baselines3's own `Monitor`."""
        return [wrapper_class is Monitor] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[np.ndarray | None]:
        """What the copies render, once per copy."""
        return [env.render() for env in self.envs]


def _together(observations: list[Any]) -> Any:
    """Observations of all entries, stacked."""
    if isinstance(observations[0], dict):
        return {k: np.stack([o[k] for o in observations]) for k in observations[0]}
    return np.stack(observations)
