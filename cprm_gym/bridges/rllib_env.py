"""RLlib: many worlds as one `VectorMultiAgentEnv`, and the env runner that makes it instead of one environment a world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from ray.rllib.env.multi_agent_env import MultiAgentEnv
from ray.rllib.env.multi_agent_env_runner import MultiAgentEnvRunner
from ray.rllib.env.vector.vector_multi_agent_env import VectorMultiAgentEnv

from ..envs.core import Step
from ..envs.soccer_v2 import parallel_env
from ..errors import CprmError
from .worlds import AgentWorlds

VECTOR: Mapping[str, Any] = {"flatten": True, "action_mode": "box"}
"""Options of environments here, where others are not given: forms that RLlib's default networks take."""


class SoccerMultiAgentEnv(MultiAgentEnv):  # type: ignore[misc]
    """One world as RLlib's `MultiAgentEnv`.

    Parameters
    ----------
    config : mapping
        Options of `cprm_gym.envs.soccer_v2.parallel_env`, and `VECTOR`'s where they are not given.
    """

    def __init__(self, config: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        self.env = parallel_env(**{**VECTOR, **(config or {})})
        self.possible_agents = list(self.env.possible_agents)
        self.agents = list(self.possible_agents)
        self.observation_spaces = {a: self.env.observation_space(a) for a in self.possible_agents}
        self.action_spaces = {a: self.env.action_space(a) for a in self.possible_agents}
        self.observation_space, self.action_space = spaces.Dict(self.observation_spaces), spaces.Dict(self.action_spaces)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode."""
        return self.env.reset(seed, options)

    def step(self, action_dict: dict[str, Any]) -> tuple[Any, Any, Any, Any, Any]:
        """Play one cycle."""
        observed, rewards, terminated, truncated, told = self.env.step(action_dict)
        terminated["__all__"], truncated["__all__"] = all(terminated.values()), all(truncated.values())
        return observed, rewards, terminated, truncated, told

    def get_state(self) -> np.ndarray:
        """The true state, for centralised critics."""
        return self.env.state()


class SoccerVectorMultiAgentEnv(VectorMultiAgentEnv):  # type: ignore[misc]
    """Worlds that are played together, for RLlib's runner; an episode that has ended begins anew with the next step.

    Parameters
    ----------
    num_envs : int
        Worlds.
    config : mapping, optional
        Options of `AgentWorlds`, and `VECTOR`'s where they are not given.
    """

    metadata = {"autoreset_mode": "next_step"}  # noqa: RUF012

    def __init__(self, num_envs: int = 1, config: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        given = {**VECTOR, **(config or {})}
        self.worlds = AgentWorlds(num_envs, **given)
        self.num_envs = self.worlds.worlds
        self.agents = [a for group in self.worlds.groups.values() for a in group]
        # the runner asks a member for spaces, and what there is for one world
        member = SoccerMultiAgentEnv(given)
        self.envs = [member] * self.num_envs
        self.single_observation_spaces, self.single_action_spaces = member.observation_spaces, member.action_spaces
        self.single_observation_space = spaces.Dict(self.single_observation_spaces)
        self.single_action_space = spaces.Dict(self.single_action_spaces)
        self._over = np.zeros(self.num_envs, bool)
        self._nothing = self._idle()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[list[Any], list[Any]]:
        """Begin episodes in all worlds."""
        super().reset(seed=seed)
        self.worlds.reset(seed)
        self._over[:] = False
        return self._observations(), self._infos(None)

    def step(self, actions: list[dict[str, Any]]) -> tuple[list[Any], list[Any], list[Any], list[Any], list[Any]]:
        """Play one cycle; worlds that are over begin anew instead, and need no actions.

        Raises
        ------
        CprmError
            For another number of actions than worlds.
        """
        if len(actions) != self.num_envs:
            raise CprmError(f"step: actions of {len(actions)} worlds given, there are {self.num_envs}")
        starting = self._over.copy()
        step = self.worlds.step(self._together(actions))
        if starting.any():
            self.worlds.reset(None, starting)
        terminated, truncated = step.terminated & ~starting, step.truncated & ~starting
        self._over = terminated | truncated
        rewards = np.where(starting[:, None], 0.0, step.reward)
        told = self._infos(step)
        return (
            self._observations(),
            [dict(zip(self.agents, row)) for row in rewards.tolist()],
            [self._flags(flag) for flag in terminated.tolist()],
            [self._flags(flag) for flag in truncated.tolist()],
            told,
        )

    def close_extras(self, **kwargs: Any) -> None:
        """Leave the server, if it is played on one."""
        self.worlds.core.close()

    # ------------------------------------------------------------------ forms

    def _idle(self) -> Any:
        """An action of nobody in particular, for worlds that begin anew."""
        space = self.worlds.action_space
        if isinstance(space, spaces.Discrete):
            return np.int64(0)
        return np.zeros(space.shape or (), space.dtype)

    def _together(self, actions: list[dict[str, Any]]) -> dict[str, np.ndarray]:
        """(worlds, agents, ...) of each group."""
        return {
            group: np.array([[world.get(a, self._nothing) for a in agents] for world in actions])
            for group, agents in self.worlds.groups.items()
        }

    def _flags(self, flag: bool) -> dict[str, bool]:
        return {**dict.fromkeys(self.agents, flag), "__all__": flag}

    def _observations(self) -> list[dict[str, Any]]:
        output = self.worlds.core.output
        if isinstance(output, np.ndarray):
            return [dict(zip(self.agents, row)) for row in output.copy()]
        parts = {name: values.copy() for name, values in output.items()}
        return [
            {agent: {name: values[k, i] for name, values in parts.items()} for i, agent in enumerate(self.agents)}
            for k in range(self.num_envs)
        ]

    def _infos(self, step: Step | None) -> list[dict[str, Any]]:
        """Whether each agent has what it wishes, and the status, where an episode has ended."""
        if step is None or not self._over.any():
            return [{} for _ in range(self.num_envs)]
        return [
            {a: {"status": int(step.status[k]), "is_success": bool(won)} for a, won in zip(self.agents, step.success[k])} if over else {}
            for k, over in enumerate(self._over.tolist())
        ]


class SoccerEnvRunner(MultiAgentEnvRunner):  # type: ignore[misc]
    """RLlib's runner over worlds that are played together: ``config.env_runners(env_runner_cls=SoccerEnvRunner)``.

    ``config.environment(SoccerMultiAgentEnv, env_config={"task": "HFO2v2"})`` says what is played;
    ``num_envs_per_env_runner`` is the number of worlds.
    """

    def make_env(self) -> None:
        """Make the worlds of this runner."""
        before: SoccerVectorMultiAgentEnv | None = getattr(self, "env", None)
        if before is not None:
            before.close()
        self.env: Any = SoccerVectorMultiAgentEnv(self.config.num_envs_per_env_runner, dict(self.config.env_config))
        self.env.spec = gymnasium.envs.registration.EnvSpec("cprm/soccer_v2")
        self.num_envs = self.env.num_envs
        self._needs_initial_reset = True
