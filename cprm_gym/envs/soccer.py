"""``soccer_v0``: tasks with one or more agents as PettingZoo environments (Parallel and AEC).

Agents are named ``left_1 ... left_11, right_1 ... right_11`` and stay for the whole episode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec

from ..errors import CommandError, CprmError, UnknownName
from .core import SoccerCore
from .faces import FPS, RENDER_MODES, Pictured, chosen_render_mode, chosen_task
from .observations import SCHEMA_VERSION
from .rewards import RewardOption
from .tasks.base import Task

STATE_OBJECT = 7
"""Numbers per object in `SoccerParallelEnv.state`: x, y, vx, vy, body, neck, stamina (0 where a ball has none)."""


class SoccerParallelEnv(Pictured, ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """2D soccer for several agents, one command each per cycle of 100 ms.

    An agent's info holds ``status`` (of ``task.statuses``), ``is_success``, the named parts of his reward in ``reward_terms``, the
    version of the observations in ``schema``, and with macros what he can do now in ``action_mask``.

    Parameters
    ----------
    task : str or Task
        What is played; by default a match.
    controlled : str or sequence of str, optional
        Who acts: ``all``, ``left``, ``right``, agent names, or several of them.
    action_mode : str
        ``hybrid`` (default), ``full`` (with say, attention and point), ``discrete``, ``box`` or ``macro``.
    max_cycles : int, optional
        Cycles per episode; the task's own if not given.
    copy : bool
        Every observation is the agent's to keep (default). ``False`` returns the same dicts of arrays every time, overwritten by the next
        step, which then takes a quarter less time for 22 agents.
    render_mode, debug_info, others, include, observation, flatten, reward, reward_gamma, **options
        As for `cprm_gym.envs.single.SoccerEnv`.

    Raises
    ------
    UnknownName
        For a task, agent, action mode or render mode that does not exist.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "name": "soccer_v0", "render_modes": list(RENDER_MODES), "render_fps": FPS, "is_parallelizable": True,
    }  # fmt: skip

    def __init__(
        self,
        task: str | Task = "Soccer",
        controlled: str | Sequence[str] | None = None,
        action_mode: str = "hybrid",
        max_cycles: int | None = None,
        render_mode: str | None = None,
        debug_info: bool = False,
        copy: bool = True,
        others: str | Sequence[str] | None = None,
        include: str | Sequence[str] = (),
        observation: str = "raw",
        flatten: bool = False,
        reward: RewardOption = None,
        reward_gamma: float = 0.99,
        **options: Any,
    ) -> None:
        self.task = chosen_task(task, max_cycles, options)
        self.render_mode = chosen_render_mode(render_mode)
        self.max_cycles = self.task.max_cycles
        self.core = SoccerCore(
            self.task,
            1,
            controlled=controlled,
            view=action_mode,
            others=others,
            include=include,
            observation=observation,
            flatten=flatten,
            reward=reward,
            reward_gamma=reward_gamma,
        )
        if not self.core.agents:
            raise UnknownName("controlled: nobody chosen; somebody has to act")
        self.possible_agents = list(self.core.agents)
        self.agents: list[str] = []
        self.observation_spaces = {a: self.core.observation_space() for a in self.possible_agents}
        # each with a random stream of its own
        self.action_spaces = {a: deepcopy(self.core.view.space) for a in self.possible_agents}
        self.state_space = state_space()
        self.debug_info = debug_info
        self._seed_source = np.random.default_rng()
        self._seeded = False
        self._views = None if copy else self._divided(self.core.observation)

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Space of the agent's observations; the same object every time."""
        return self.observation_spaces[self._known(agent)]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Space of the agent's actions; the same object every time."""
        return self.action_spaces[self._known(agent)]

    def _known(self, agent: str) -> str:
        if agent not in self.observation_spaces:
            raise UnknownName(f"agent {agent!r} is not controlled here; controlled are {', '.join(self.possible_agents)}")
        return agent

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Start an episode; a seed fixes everything that follows."""
        if seed is None and not self._seeded:
            seed = int(self._seed_source.integers(2**31))
        self._seeded = True
        self.agents = self.possible_agents[:]
        self.core.reset(seed)
        self._show()
        return self._observations(), self._infos(0, False)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Play one cycle; every agent must act.

        Raises
        ------
        CprmError
            Before `reset` or after the end.
        UnknownName
            When an action is given for somebody who is not controlled, or one is missing.
        CommandError
            When an action does not fit its space.
        """
        if not self.agents:
            raise CprmError("step before reset: call reset() first; the episode has not begun or is over")
        try:
            chosen = list(map(actions.__getitem__, self.possible_agents))
            complete = len(chosen) == len(actions)
        except (AttributeError, TypeError, LookupError):
            complete = False
        if not complete:
            raise self._wrong_agents(actions)
        try:
            step = self.core.step(_together(chosen))
        except CommandError:
            self._blame(chosen)
            raise
        terminated = bool(step.terminated[0])
        # wrappers and tests may shorten an episode by setting max_cycles
        truncated = bool(step.truncated[0]) or (not terminated and int(self.core.cycle[0]) >= self.max_cycles)
        rewards = dict(zip(self.agents, step.reward[0].tolist()))
        terminations = dict.fromkeys(rewards, terminated)
        truncations = dict.fromkeys(rewards, truncated)
        infos = self._infos(-1 if truncated else int(step.status[0]), bool(step.success[0]))
        for name, values in step.terms.items():
            for info, value in zip(infos.values(), values[0].tolist()):
                info["reward_terms"][name] = value
        if terminated or truncated:
            self.agents = []
        self._show()
        return self._observations(), rewards, terminations, truncations, infos

    def _wrong_agents(self, actions: Any) -> CprmError:
        """The error for actions that are not one of every agent."""
        if not isinstance(actions, Mapping):
            return CommandError(f"actions: expected a dict with an action for every agent, got {type(actions).__name__} {actions!r:.60}")
        for agent in actions:
            self._known(agent)
        missing = [a for a in self.possible_agents if a not in actions]
        return UnknownName(f"actions: none given for {', '.join(missing)}; every controlled agent acts in every cycle")

    def _blame(self, chosen: list[Any]) -> None:
        """Raise the error of the first agent whose action is refused by itself."""
        for agent, action in zip(self.possible_agents, chosen):
            try:
                self.core.check(action)
            except CommandError as error:
                raise CommandError(f"{agent}: {error}") from None

    def _observations(self) -> dict[str, Any]:
        """The agents' observations, each with arrays of its own (``copy=False``: views)."""
        output = self.core.output
        if isinstance(output, np.ndarray):
            return dict(zip(self.possible_agents, output[0].copy()))
        if self._views is not None:
            return self._views
        return self._divided({name: values.copy() for name, values in output.items()})

    def _divided(self, parts: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Each agent's rows of arrays with the axes (1 world, agents, ...)."""
        rows: list[dict[str, Any]] = [{} for _ in self.possible_agents]
        for name, values in parts.items():
            for row, value in zip(rows, values[0]):
                row[name] = value
        return dict(zip(self.possible_agents, rows))

    def _infos(self, status: int, success: bool) -> dict[str, dict[str, Any]]:
        """An info for each agent; `status` as an index into ``task.statuses``, whose last one means out of time."""
        word = self.task.statuses[status]
        infos: dict[str, dict[str, Any]] = {
            a: {"status": word, "is_success": success, "schema": SCHEMA_VERSION, "reward_terms": {}} for a in self.possible_agents
        }
        if self.core.action_mask is not None:
            for info, mask in zip(infos.values(), self.core.action_mask[0].astype(np.int8)):
                info["action_mask"] = mask
        if self.debug_info:
            for info in infos.values():
                info["truth"] = self.core.sim.world["pos"][0].copy()
        return infos

    def state(self) -> np.ndarray:
        """The true state for centralised critics, float32 (`state_space`).

        For ball and players x, y, vx, vy, body, neck, stamina; then mode, time, score left, score right, cycle, stoppage.
        """
        w = self.core.sim.world[0]
        table = np.zeros((23, STATE_OBJECT))
        table[:, 0:2], table[:, 2:4] = w["pos"], w["vel"]
        table[1:, 4], table[1:, 5], table[1:, 6] = w["body"], w["neck"], w["stamina"]
        table[1:] *= w["enabled"][:, None]
        tail = (w["mode"], w["time"], w["score"][0], w["score"][1], self.core.cycle[0], w["stoppage"])
        return np.concatenate([table.ravel(), np.array(tail, dtype=np.float64)]).astype(np.float32)


def state_space() -> spaces.Box:
    """Space of `SoccerParallelEnv.state`: metres, m / cycle, radians and stamina per object, then clocks and score."""
    high = np.array([1e3, 1e3, 20.0, 20.0, 7.0, 7.0, 1e5], np.float32)
    tail = np.array([51, 1e6, 1e4, 1e4, 1e6, 1e6], np.float32)
    low = np.concatenate([np.tile(np.where(np.arange(STATE_OBJECT) < 6, -high, 0.0), 23), np.zeros(6)])
    return spaces.Box(low.astype(np.float32), np.concatenate([np.tile(high, 23), tail]), dtype=np.float32)


def _together(chosen: list[Any]) -> Any:
    """The agents' actions as arrays with the axes (1 world, agents, ...).

    Raises
    ------
    CommandError
        When they are of different kinds or shapes.
    """
    try:
        if not isinstance(chosen[0], dict):
            return np.array(chosen)[None]
        keys = tuple(chosen[0])
        # equally many keys, and in what follows the same ones
        if sum(map(len, chosen)) == len(keys) * len(chosen):
            return {key: np.array([action[key] for action in chosen])[None] for key in keys}
    except (TypeError, ValueError, LookupError):
        pass
    raise CommandError("actions: they differ between the agents in their keys or shapes; all agents act in the same form")


def parallel_env(**kwargs: Any) -> SoccerParallelEnv:
    """The Parallel environment; arguments as for `SoccerParallelEnv`."""
    return SoccerParallelEnv(**kwargs)


def raw_env(**kwargs: Any) -> AECEnv[str, Any, Any]:
    """The AEC environment without wrappers; arguments as for `SoccerParallelEnv`."""
    return parallel_to_aec(SoccerParallelEnv(**kwargs))


def env(**kwargs: Any) -> AECEnv[str, Any, Any]:
    """The AEC environment with PettingZoo's order-enforcing wrapper; arguments as for `SoccerParallelEnv`."""
    return wrappers.OrderEnforcingWrapper(raw_env(**kwargs))
