"""One agent of a parallel environment as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import gymnasium

from ..errors import CprmError, UnknownName, did_you_mean

Policy = Callable[[Any], Any]
"""An observation in, an action out."""


class SingleAgent(gymnasium.Env[Any, Any]):
    """The world of a parallel environment through the eyes of one of its agents; policies play the others.

    Parameters
    ----------
    env : pettingzoo.ParallelEnv
    agent : str
        Who acts.
    others : mapping of str to policy, or one policy for all, optional
        Functions from an agent's observation to its action. Who has none acts at random.

    Raises
    ------
    UnknownName
        For an agent that is not there.
    """

    def __init__(self, env: Any, agent: str, others: Mapping[str, Policy] | Policy | None = None) -> None:
        names = env.possible_agents
        policies = dict(others) if isinstance(others, Mapping) else {a: others for a in names if a != agent and others is not None}
        for name in (agent, *policies):
            if name not in names:
                raise UnknownName(f"agent {name!r} is not in this environment.{did_you_mean(name, names)} Agents: {', '.join(names)}.")
        self.env, self.agent, self.policies = env, agent, policies
        self.observation_space = env.observation_space(agent)
        self.action_space = env.action_space(agent)
        self.metadata = dict(env.metadata)
        self.render_mode = env.render_mode
        self._seen: dict[str, Any] = {}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        super().reset(seed=seed)
        if seed is not None:
            for k, name in enumerate(self.env.possible_agents):
                if name != self.agent:
                    self.env.action_space(name).seed(seed + k)
        self._seen, infos = self.env.reset(seed=seed, options=options)
        return self._seen[self.agent], infos[self.agent]

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play one cycle.

        Raises
        ------
        CprmError
            When the episode is over or has not begun.
        """
        if self.agent not in self.env.agents:
            raise CprmError("step before reset: call reset() first; the episode has not begun or is over")
        actions = {self.agent: action}
        for name in self.env.agents:
            if name != self.agent:
                policy = self.policies.get(name)
                actions[name] = self.env.action_space(name).sample() if policy is None else policy(self._seen[name])
        self._seen, rewards, terminated, truncated, infos = self.env.step(actions)
        a = self.agent
        return self._seen[a], float(rewards[a]), bool(terminated[a]), bool(truncated[a]), infos[a]

    def render(self) -> Any:
        """What the environment renders."""
        return self.env.render()

    def close(self) -> None:
        """Close the environment."""
        self.env.close()
