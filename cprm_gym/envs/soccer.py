"""``soccer_v0``: tasks with one or more agents as PettingZoo environments (Parallel and AEC).

Agents are named ``left_1 ... left_11, right_1 ... right_11`` and stay for the whole episode.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec

from ..errors import CprmError, UnknownName
from .core import SoccerCore
from .rewards import RewardOption
from .spaces import SCHEMA_VERSION
from .tasks import make_task
from .tasks.base import Task

STATE_OBJECT = 7
"""Numbers per object in `SoccerParallelEnv.state`: x, y, vx, vy, body, neck, stamina (0 where a ball has none)."""


class SoccerParallelEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """2D soccer for several agents, one command each per cycle of 100 ms.

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
    render_mode : str, optional
        ``human``, ``rgb_array`` or ``ansi``.
    debug_info : bool
        Put the true positions into ``info["truth"]``.
    others : str or (str, str), optional
        Scripted policy of the players not controlled, or one for each side; the task's own if not given.
    include : sequence of str
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
        For a task, agent, action mode or render mode that does not exist.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "name": "soccer_v0", "render_modes": ["human", "rgb_array", "ansi"], "render_fps": 10, "is_parallelizable": True,
    }  # fmt: skip

    def __init__(
        self,
        task: str | Task = "Soccer",
        controlled: str | Sequence[str] | None = None,
        action_mode: str = "hybrid",
        max_cycles: int | None = None,
        render_mode: str | None = None,
        debug_info: bool = False,
        others: str | Sequence[str] | None = None,
        include: Sequence[str] = (),
        observation: str = "raw",
        flatten: bool = False,
        reward: RewardOption = None,
        reward_gamma: float = 0.99,
        **options: Any,
    ) -> None:
        if max_cycles is not None:
            options["max_cycles"] = max_cycles
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise UnknownName(f"render_mode {render_mode!r}: allowed are {', '.join(self.metadata['render_modes'])} or None")
        self.task = make_task(task, **options) if isinstance(task, str) else task
        self.max_cycles = self.task.max_cycles
        self.core = SoccerCore(self.task, 1, controlled=controlled, view=action_mode, others=others, include=include,
            observation=observation, flatten=flatten, reward=reward, reward_gamma=reward_gamma)
        self.possible_agents = list(self.core.agents)
        self.agents: list[str] = []
        self.observation_spaces = {a: self.core.observation_space() for a in self.possible_agents}
        self.action_spaces = {a: _copy_space(self.core.view.space) for a in self.possible_agents}
        self.state_space = state_space()
        self.render_mode = render_mode
        self.debug_info = debug_info
        self._seed_source = np.random.default_rng()
        self._seeded = False
        self._viewer: Any = None

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

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Start an episode; a seed fixes everything that follows."""
        if seed is None and not self._seeded:
            seed = int(self._seed_source.integers(2**31))
        self._seeded = True
        self.agents = self.possible_agents[:]
        self.core.reset(seed)
        if self.render_mode == "human":
            self.render()
        return self._observations(), self._infos(0, False)

    def step(self, actions: dict[str, Any]) -> tuple[
        dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
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
        if actions.keys() != self.observation_spaces.keys():
            for agent in actions:
                self._known(agent)
            missing = [a for a in self.agents if a not in actions]
            raise UnknownName(f"actions: none given for {', '.join(missing)}; every controlled agent acts in every cycle")
        step = self.core.step(self._batch(actions))
        terminated, truncated = bool(step.terminated[0]), bool(step.truncated[0])
        # wrappers and tests may shorten an episode by setting max_cycles
        truncated = truncated or (not terminated and int(self.core.cycle[0]) >= self.max_cycles)
        agents = self.agents
        rewards = dict(zip(agents, step.reward[0].tolist()))
        terminations = dict.fromkeys(agents, terminated)
        truncations = dict.fromkeys(agents, truncated)
        infos = self._infos(int(step.status[0]), bool(step.success[0]))
        terms: list[dict[str, float]] = [{} for _ in agents]
        for name, values in step.terms.items():
            for own, value in zip(terms, values[0].tolist()):
                own[name] = value
        for info, own in zip(infos.values(), terms):
            info["reward_terms"] = own
        if terminated or truncated:
            self.agents = []
        if self.render_mode == "human":
            self.render()
        return self._observations(), rewards, terminations, truncations, infos

    def _batch(self, actions: dict[str, Any]) -> Any:
        """The agents' actions as arrays with the axes (1 world, agents, ...)."""
        chosen = [actions[a] for a in self.possible_agents]
        first = chosen[0]
        if not isinstance(first, dict):
            return _together(chosen)
        keys, count = first.keys(), len(first)
        try:
            if all(len(action) == count for action in chosen):
                return {k: _together([action[k] for action in chosen]) for k in keys}
        except (TypeError, KeyError, IndexError):
            pass  # somebody's action is of another kind; it is named below
        for agent, action in zip(self.possible_agents, chosen):
            if not isinstance(action, dict) or action.keys() != keys:
                raise UnknownName(f"action of {agent}: expected a dict with the keys {', '.join(keys)}, got {action!r:.80}")
        return {k: _together([action[k] for action in chosen]) for k in keys}

    def _observations(self) -> dict[str, Any]:
        output = self.core.output
        if isinstance(output, np.ndarray):
            return dict(zip(self.possible_agents, output[0].copy()))
        names = tuple(output)
        rows = zip(*(values[0].copy() for values in output.values()))
        return {a: dict(zip(names, row)) for a, row in zip(self.possible_agents, rows)}

    def _infos(self, status: int, success: bool) -> dict[str, dict[str, Any]]:
        infos: dict[str, dict[str, Any]] = {}
        mask, word = self.core.action_mask, self.task.statuses[status]
        for i, a in enumerate(self.possible_agents):
            infos[a] = {"status": word, "is_success": success, "schema": SCHEMA_VERSION}
            if mask is not None:
                infos[a]["action_mask"] = mask[0, i].astype(np.int8)
            if self.debug_info:
                infos[a]["truth"] = self.core.sim.world["pos"][0].copy()
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

    def render(self) -> Any:
        """The pitch: a window (``human``), an RGB array (``rgb_array``) or text (``ansi``)."""
        if self.render_mode is None:
            return None
        if self._viewer is None:
            from .rendering import Viewer

            self._viewer = Viewer(self.render_mode, fps=self.metadata["render_fps"])
        return self._viewer.draw(self.core.sim.world[0])

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None


def state_space() -> spaces.Box:
    """Space of `SoccerParallelEnv.state`: metres, m / cycle, radians and stamina per object, then clocks and score."""
    high = np.array([1e3, 1e3, 20.0, 20.0, 7.0, 7.0, 1e5], np.float32)
    tail = np.array([51, 1e6, 1e4, 1e4, 1e6, 1e6], np.float32)
    low = np.concatenate([np.tile(np.where(np.arange(STATE_OBJECT) < 6, -high, 0.0), 23), np.zeros(6)])
    return spaces.Box(low.astype(np.float32), np.concatenate([np.tile(high, 23), tail]), dtype=np.float32)


def _copy_space(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """An equal space with its own random stream, so that agents sample independently."""
    import copy

    return copy.deepcopy(space)


def _together(values: list[Any]) -> Any:
    """The agents' values as one array with the axes (1 world, agents, ...); what has no common shape is left for the view to refuse."""
    try:
        return np.array(values)[None]
    except (TypeError, ValueError):
        return values


def parallel_env(**kwargs: Any) -> SoccerParallelEnv:
    """The Parallel environment; arguments as for `SoccerParallelEnv`."""
    return SoccerParallelEnv(**kwargs)


def raw_env(**kwargs: Any) -> AECEnv[str, Any, Any]:
    """The AEC environment without wrappers; arguments as for `SoccerParallelEnv`."""
    return parallel_to_aec(SoccerParallelEnv(**kwargs))


def env(**kwargs: Any) -> AECEnv[str, Any, Any]:
    """The AEC environment with PettingZoo's order-enforcing wrapper; arguments as for `SoccerParallelEnv`."""
    return wrappers.OrderEnforcingWrapper(raw_env(**kwargs))
