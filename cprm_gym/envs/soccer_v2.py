"""``soccer_v2``: tasks with one or more agents as PettingZoo environments (Parallel and AEC).

Agents are named ``left_1 ... left_11, right_1 ... right_11`` and stay for the whole episode.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec

from ..errors import CommandError, CprmError, UnknownName
from ..simulator.state import PLAYERS
from . import infos as of_infos
from .core import SoccerCore, Step
from .options import RENDER_MODES, EnvOptions, chosen_render_mode
from .players.mixing import NOBODY, Mode
from .rendering import FPS, Pictured
from .tasks.base import Task, checked_reset

STATE_OBJECT = 7
"""Numbers per object in `SoccerParallelEnv.state`: x, y, vx, vy, body, neck, stamina (0 where a ball has none)."""


class SoccerParallelEnv(Pictured, ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """2D soccer for several agents, one command each per cycle of 100 ms.

    Infos: `cprm_gym.envs.infos`. ``reset(options=...)`` takes ``start`` (where ball and players shall be, `Pitch.start_at`) and ``state``
    (of `save_state`).

    Parameters
    ----------
    task : str or Task
        What is played; by default a match.
    render_mode : str, optional
        ``human``, ``rgb_array`` or ``ansi``.
    copy : bool
        Every observation is the agent's to keep (default). ``False`` returns the same dicts of arrays every time, overwritten by the next
        step, which then takes a quarter less time for 22 agents.
    **options
        As for `EnvOptions`, and fields of the task.

    Raises
    ------
    UnknownName
        For a task, agent, action mode or render mode that does not exist.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "name": "soccer_v2", "render_modes": list(RENDER_MODES), "render_fps": FPS, "is_parallelizable": True,
    }  # fmt: skip

    def __init__(self, task: str | Task = "Soccer", render_mode: str | None = None, copy: bool = True, **options: Any) -> None:
        self.render_mode = chosen_render_mode(render_mode)
        self.options = EnvOptions.of({"task": task, **options})
        self.core = SoccerCore(self.options, 1)
        self.task = self.core.task
        if not self.core.agents:
            raise UnknownName("controlled: nobody chosen; somebody has to act")
        self.possible_agents = list(self.core.agents)
        self.agents: list[str] = []
        self.observation_spaces = {a: self.core.observation_space() for a in self.possible_agents}
        # each with a random stream of its own
        self.action_spaces = {a: deepcopy(self.core.view.space) for a in self.possible_agents}
        self.state_space = state_space(self.core.mixes)
        self._seed_source = np.random.default_rng()
        self._seeded = False
        lasting = {} if copy else self.core.preset.lasting(self.core.observation)
        self._views = self._divided(lasting) if lasting else None

    @property
    def max_cycles(self) -> int:
        """Cycles until an episode is out of time; wrappers and tests may shorten it."""
        return self.core.max_cycles

    @max_cycles.setter
    def max_cycles(self, cycles: int) -> None:
        self.core.max_cycles = cycles

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
        """Start an episode; a seed fixes everything that follows.

        Raises
        ------
        ParameterError
            For an unknown option.
        """
        # PettingZoo's own tests give an option of this name, which means nothing
        given = None if options is None else {name: value for name, value in options.items() if name != "options"}
        chosen = checked_reset(given, ("start", "state"))
        if seed is None and not self._seeded and "state" not in chosen:
            seed = int(self._seed_source.integers(2**31))
        self.core.reset(seed, **chosen)
        self._seeded = True
        self.agents = self.possible_agents[:]
        self._show()
        return self._observations(), self._infos(None)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Play one cycle; every agent must act. After the end, no actions give nothing.

        Raises
        ------
        CprmError
            Before `reset` or after the end.
        UnknownName
            When an action is given for somebody who is not controlled, or one is missing.
        CommandError
            When an action does not fit its space.
        """
        if not self.agents and self._seeded and isinstance(actions, Mapping) and not actions:
            # nobody is left to act, as wrappers that keep the agents alive say it
            return {}, {}, {}, {}, {}
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
        truncated = bool(step.truncated[0])
        rewards = dict(zip(self.agents, step.reward[0].tolist()))
        terminations = dict.fromkeys(rewards, terminated)
        truncations = dict.fromkeys(rewards, truncated)
        infos = self._infos(step)
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

    def _infos(self, step: Step | None) -> dict[str, dict[str, Any]]:
        """An info for each agent."""
        return dict(zip(self.possible_agents, of_infos.of_agents(self.core, step, self.options.debug_info)))

    def save_state(self) -> dict[str, np.ndarray]:
        """The running episode as arrays; `load_state` and ``reset(options={"state": ...})`` go on from it, ``np.savez`` keeps it."""
        return {**self.core.save_state(), "over": np.array([not self.agents])}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a state of `save_state`, of an environment with the same options.

        Raises
        ------
        ParameterError
            When it is the state of another one.
        """
        self.core.load_state(state)
        self.agents = [] if bool(state["over"][0]) else self.possible_agents[:]
        self._seeded = True

    def state(self) -> np.ndarray:
        """The true state for centralised critics, float32 (`state_space`).

        For ball and players x, y, vx, vy, body, neck, stamina; then mode, time, score left, score right, cycle, stoppage; where players
        mix, what each of the 22 has in mind (`cprm_gym.envs.players.mixing.Mode`, -1 for who does not mix).
        """
        return states(self.core)[0]


def states(core: SoccerCore) -> np.ndarray:
    """(W, n) float32: `SoccerParallelEnv.state` of every world."""
    w, count = core.sim.world, core.worlds
    table = np.zeros((count, 23, STATE_OBJECT), np.float32)
    table[..., 0:2], table[..., 2:4] = w["pos"], w["vel"]
    table[:, 1:, 4], table[:, 1:, 5], table[:, 1:, 6] = w["body"], w["neck"], w["stamina"]
    table[:, 1:] *= w["enabled"][..., None]
    parts = [table.reshape(count, -1)]
    parts += [np.asarray(c, np.float32).reshape(count, -1) for c in (w["mode"], w["time"], w["score"], core.cycle, w["stoppage"])]
    if core.mixes:
        parts.append(core.intentions().astype(np.float32))
    return np.concatenate(parts, axis=1)


def state_space(mixes: bool = False) -> spaces.Box:
    """Space of `SoccerParallelEnv.state`: metres, m / cycle, radians and stamina per object, clocks and score, modes where players mix."""
    high = np.array([1e3, 1e3, 20.0, 20.0, 7.0, 7.0, 1e5], np.float32)
    tail = np.array([51, 1e6, 1e4, 1e4, 1e6, 1e6], np.float32)
    low = np.concatenate([np.tile(np.where(np.arange(STATE_OBJECT) < 6, -high, 0.0), 23), np.zeros(6)])
    modes = PLAYERS if mixes else 0
    low, high = np.append(low, np.full(modes, NOBODY)), np.concatenate([np.tile(high, 23), tail, np.full(modes, max(Mode))])
    return spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)


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
