"""SlowApproach: the exact little world of the dissertation's Appendix A, one agent closing with a ball that lies still.

It is not soccer and has no simulator behind it: six numbers, items 1 to 7 of the appendix as printed, with the one sign that the printed
behaviour gets wrong left to the agent (theta is the direction of the ball relative to the agent, so ``omega = +theta`` faces it).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ...errors import CommandError, CprmError, ParameterError, UnknownName, did_you_mean, unknown_name
from ...simulator.player_types import PlayerType
from .base import Status, checked_reset, marked

ACCELERATE, TURN = 0, 1
REACH = PlayerType().kickable_area
"""Of the server's default player, m."""
NOISES = 8
"""Random numbers of a cycle: omega, a, x, y; theta, s, d; one spare. A start takes the same number."""
BLOCK = 256
BINS = np.array([-1.0, -0.5, -0.25, -0.1, -0.05, 0.0, 0.05, 0.1, 0.25, 0.5, 1.0])
"""Shares that the discrete view offers for either input."""
MODES = ("hybrid", "discrete", "box")


@dataclass(frozen=True)
class SlowApproach:
    """Parameters of the world; the names are those of the appendix, ``h...`` those with a hat.

    Attributes
    ----------
    gamma : float
        Share of the speed that is left in the next cycle.
    delta_s, delta_a, delta_omega : float
        Errors of motion (each of x and y up to delta_s / sqrt 2), acceleration and rotation.
    h_theta, h_s, h_d : float
        Errors of what is observed: radians, shares, shares.
    a_min, a_max, theta_max : float
        Bounds of the inputs; radians.
    epsilon_d : float
        The goal is a distance below it, m.
    d_start, s_start : (float, float)
        Ranges of the uniform starts; the direction is uniform.
    max_cycles : int

    Defaults are the server's (0.4 player decay, 0.1 noise, half a degree, the quantisation of distance and speed).
    """

    gamma: float = 0.4
    delta_s: float = 0.1
    delta_a: float = 0.0
    delta_omega: float = 0.1
    h_theta: float = math.radians(0.5)
    h_s: float = 0.05
    h_d: float = 0.084
    a_min: float = -0.6
    a_max: float = 0.6
    theta_max: float = math.pi
    epsilon_d: float = REACH
    d_start: tuple[float, float] = (REACH, 12.0)
    s_start: tuple[float, float] = (0.0, 1.0)
    max_cycles: int = 400

    def __post_init__(self) -> None:
        for name, low, high in (
            ("gamma", 0.0, 1.0), ("delta_s", 0.0, 1.0), ("delta_a", 0.0, 1.0), ("delta_omega", 0.0, 1.0), ("h_theta", 0.0, math.pi),
            ("h_s", 0.0, 1.0), ("h_d", 0.0, 1.0), ("theta_max", 1e-9, math.pi), ("epsilon_d", 0.0, math.inf), ("a_max", 1e-9, math.inf),
            ("a_min", -math.inf, 0.0),
        ):  # fmt: skip
            if not low <= getattr(self, name) <= high:
                raise ParameterError(f"SlowApproach: {name} is {getattr(self, name)!r}; allowed is {low:g} to {high:g}")
        if self.max_cycles < 1:
            raise ParameterError(f"SlowApproach: max_cycles is {self.max_cycles!r}; allowed is 1 and more")


class SlowWorlds:
    """W such worlds. World k depends on (seed, k) alone.

    Attributes
    ----------
    x, y, s, rho, ball_x, ball_y : (W,) float arrays
        The six variables of item 2.
    """

    def __init__(self, parameters: SlowApproach, worlds: int) -> None:
        self.parameters, self.worlds = parameters, worlds
        self.x, self.y, self.s, self.rho, self.ball_x, self.ball_y = (np.zeros(worlds) for _ in range(6))
        self.cycle = np.zeros(worlds, np.int64)
        self._generators: list[np.random.Generator] = []
        self._noise = np.zeros((worlds, BLOCK, NOISES))
        self._next: np.ndarray = np.full(worlds, BLOCK)
        self._rows = np.arange(worlds)

    def seed(self, seed: int | Sequence[int | None]) -> None:
        """Streams of all worlds; with a seed for each, world k is world 0 of its own, and None lets it go on.

        Raises
        ------
        ParameterError
            For another number of seeds, or a world without a seed that has none yet.
        """
        if isinstance(seed, (int, np.integer)):
            self._generators = [np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(k,))) for k in range(self.worlds)]
            self._next[:] = BLOCK
            return
        if len(seed) != self.worlds or (not self._generators and None in seed):
            raise ParameterError(f"seed: expected {self.worlds} whole numbers, got {list(seed)!r:.60}")
        old = self._generators or [np.random.default_rng(0)] * self.worlds
        new = [None if one is None else np.random.default_rng(np.random.SeedSequence(one, spawn_key=(0,))) for one in seed]
        self._generators = [o if n is None else n for o, n in zip(old, new)]
        self._next[[one is not None for one in seed]] = BLOCK

    def _draw(self, worlds: np.ndarray) -> np.ndarray:
        """(n, NOISES) numbers in [-1, 1) of the given worlds."""
        for k in worlds[self._next[worlds] == BLOCK]:
            self._noise[k] = self._generators[k].uniform(-1.0, 1.0, (BLOCK, NOISES))
            self._next[k] = 0
        numbers = self._noise[worlds, self._next[worlds]]
        self._next[worlds] += 1
        return numbers

    def reset(self, worlds: np.ndarray) -> None:
        """Starts: the ball at the origin, distance, direction and speed uniform."""
        p = self.parameters
        u = (self._draw(worlds) + 1.0) / 2.0
        d = p.d_start[0] + (p.d_start[1] - p.d_start[0]) * u[:, 0]
        bearing = 2 * math.pi * u[:, 1]
        self.ball_x[worlds] = self.ball_y[worlds] = 0.0
        self.x[worlds], self.y[worlds] = -d * np.cos(bearing), -d * np.sin(bearing)
        self.rho[worlds] = 2 * math.pi * u[:, 2]
        self.s[worlds] = p.s_start[0] + (p.s_start[1] - p.s_start[0]) * u[:, 3]
        self.cycle[worlds] = 0

    def step(self, a: np.ndarray, omega: np.ndarray) -> None:
        """Item 6: one cycle of all worlds with the inputs a and omega, each (W,)."""
        p = self.parameters
        u = self._draw(self._rows)
        self.rho = self.rho + omega * (1.0 + p.delta_omega * u[:, 0])
        self.s = p.gamma * self.s + a * (1.0 + p.delta_a * u[:, 1])
        spread = p.delta_s / math.sqrt(2.0)
        self.x = self.x + self.s * (np.cos(self.rho) + spread * u[:, 2])
        self.y = self.y + self.s * (np.sin(self.rho) + spread * u[:, 3])
        self.cycle += 1
        self._seen = u[:, 4:7]

    @property
    def d(self) -> np.ndarray:
        """(W,) distance to the ball, m."""
        return np.asarray(np.hypot(self.ball_x - self.x, self.ball_y - self.y))

    @property
    def theta(self) -> np.ndarray:
        """(W,) direction to the ball relative to the agent, radians in [-pi, pi)."""
        angle = np.arctan2(self.ball_y - self.y, self.ball_x - self.x) - self.rho
        return np.asarray((angle + math.pi) % (2 * math.pi) - math.pi)

    def observe(self, noise: np.ndarray | None = None) -> np.ndarray:
        """Item 7: (W, 3) theta, s and d as observed; with the noise of the cycle just played, or a new one."""
        p = self.parameters
        u = self._seen if noise is None else noise
        seen = np.stack([self.theta + p.h_theta * u[:, 0], self.s * (1.0 + p.h_s * u[:, 1]), self.d * (1.0 + p.h_d * u[:, 2])], axis=1)
        return seen.astype(np.float32)

    def start_noise(self, worlds: np.ndarray) -> None:
        """Observation noise of worlds that have just started."""
        if not hasattr(self, "_seen") or len(worlds) == self.worlds:
            self._seen = np.zeros((self.worlds, 3))
        self._seen[worlds] = self._draw(worlds)[:, 4:7]


def slow_behaviour(observation: np.ndarray, parameters: SlowApproach, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Figure A.2's "Slow", with the sign of omega as it must be: a and omega, each (W,).

    Parameters
    ----------
    observation : (W, 3) array
    parameters : SlowApproach
    turn : (W,) bool array
        Where to turn; elsewhere the agent accelerates.
    """
    p = parameters
    theta, s, d = observation.T.astype(np.float64)
    c = (1.0 - p.gamma) / ((1.0 + p.delta_s) * (1.0 + p.delta_a))
    a = c * (d / (1.0 + p.h_d) - s / (1.0 - p.h_s) * p.gamma / (1.0 - p.gamma) * (1.0 + p.delta_s))
    a = np.where(turn, 0.0, np.clip(a, p.a_min, p.a_max))
    return a, np.where(turn, np.clip(theta, -p.theta_max, p.theta_max), 0.0)


class _Actions:
    """The three action spaces and what they mean."""

    def __init__(self, mode: str, parameters: SlowApproach) -> None:
        if mode not in MODES:
            raise unknown_name("action view", mode, MODES)
        self.mode, self.parameters = mode, parameters
        self.space: spaces.Space[Any]
        if mode == "hybrid":
            self.space = spaces.Dict({"type": spaces.Discrete(2), "params": spaces.Box(-1.0, 1.0, (1,), np.float32)})
        elif mode == "discrete":
            self.space = spaces.Discrete(2 * len(BINS))
        else:
            self.space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def inputs(self, action: Any, worlds: int) -> tuple[np.ndarray, np.ndarray]:
        """a and omega of a batch of actions."""
        try:
            if self.mode == "hybrid":
                kind, share = np.asarray(action["type"], np.int64), np.asarray(action["params"], np.float64).reshape(worlds, -1)[:, 0]
                turn = kind == TURN
                if not np.isin(kind, (ACCELERATE, TURN)).all():
                    raise CommandError(f"action 'type': {kind.tolist()} given; allowed are 0 (accelerate) and 1 (turn)")
            elif self.mode == "discrete":
                index = np.asarray(action, np.int64)
                if ((index < 0) | (index >= 2 * len(BINS))).any():
                    raise CommandError(f"action: {index.tolist()} given; allowed are 0 to {2 * len(BINS) - 1}")
                turn, share = index >= len(BINS), BINS[index % len(BINS)]
            else:
                values = np.asarray(action, np.float64).reshape(worlds, 2)
                turn, share = values[:, 0] >= 0.0, values[:, 1]
            turn, share = np.reshape(turn, worlds), np.reshape(share, worlds)
        except (TypeError, KeyError, ValueError) as error:
            if isinstance(error, CommandError):
                raise
            raise CommandError(f"action: expected {self.space} for each of {worlds} worlds, got {action!r:.80}") from None
        if not (np.abs(share) <= 1.0).all():
            raise CommandError(f"action: shares are finite numbers from -1 to 1, got {share.tolist()}")
        p = self.parameters
        acceleration = np.where(share >= 0.0, share * p.a_max, -share * p.a_min)
        return np.where(turn, 0.0, acceleration), np.where(turn, share * p.theta_max, 0.0)


def _space(p: SlowApproach) -> spaces.Box:
    fastest = max(p.s_start[1], max(p.a_max, -p.a_min) * (1 + p.delta_a) / max(1e-6, 1.0 - p.gamma)) * (1 + p.h_s)
    farthest = (p.d_start[1] + 2.0 * fastest * p.max_cycles) * (1 + p.h_d)
    high = np.array([math.pi + p.h_theta, fastest, farthest], np.float32) * np.float32(1.001)
    return spaces.Box(np.array([-high[0], -high[1], 0.0], np.float32), high, dtype=np.float32)


def _parameters(options: dict[str, Any], max_episode_steps: int | None) -> SlowApproach:
    names = [f.name for f in fields(SlowApproach)]
    for name in options:
        if name not in names:
            raise ParameterError(f"task 'SlowApproach' has no option {name!r}.{did_you_mean(name, names)} Options: {', '.join(names)}.")
    if max_episode_steps is not None:
        options = {"max_cycles": max_episode_steps, **options}
    return SlowApproach(**options)


class SlowApproachEnv(gymnasium.Env[np.ndarray, Any]):
    """Close with a ball that lies still, in the world of Appendix A.

    Description
    -----------
    A point with a position, a speed and one direction for facing and moving; a turn redirects the speed (unlike in soccer).

    Actions
    -------
    ``action_mode``: ``discrete`` (default; 11 shares of each), ``hybrid`` Dict(type: 0 accelerate, 1 turn; params: share of the bound) or
    ``box`` (turn if the first is >= 0; share).

    Observations
    ------------
    theta (radians), s (m / cycle), d (m), each with its error; float32 (3,).

    Rewards
    -------
    1 when d < epsilon_d, else 0.

    Start
    -----
    Uniform distance, direction and speed (`SlowApproach`).

    End
    ---
    Terminated at the ball; truncated after `max_cycles`.

    Arguments
    ---------
    The fields of `SlowApproach`.

    References
    ----------
    Dissertation, Appendix A, items 1 to 7.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self, action_mode: str = "discrete", render_mode: str | None = None, max_episode_steps: int | None = None, **options: Any
    ) -> None:
        if render_mode not in (None, "ansi"):
            raise UnknownName(f"render_mode {render_mode!r}: allowed are ansi or None")
        self.parameters = _parameters(options, max_episode_steps)
        self.core = SlowWorlds(self.parameters, 1)
        self._actions = _Actions(action_mode, self.parameters)
        self.action_space, self.observation_space = self._actions.space, _space(self.parameters)
        self.render_mode = render_mode
        self._seeded = self._running = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode."""
        checked_reset(options, ())
        super().reset(seed=seed)
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**31))
        if seed is not None:
            self.core.seed(seed)
        self._seeded = self._running = True
        everyone = np.arange(1)
        self.core.reset(everyone)
        self.core.start_noise(everyone)
        return self.core.observe()[0], {"status": 0, "is_success": False, "cycle": 0, "reward_reached": 0.0}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Play one cycle.

        Raises
        ------
        CprmError
            Before `reset` or after the end.
        CommandError
            For an action outside the space.
        """
        if not self._running:
            raise CprmError("step before reset: call reset() first; the episode has not begun or is over")
        self.core.step(*self._actions.inputs(action, 1))
        reached = bool(self.core.d[0] < self.parameters.epsilon_d)
        late = not reached and int(self.core.cycle[0]) >= self.parameters.max_cycles
        self._running = not (reached or late)
        status = int(Status.SUCCESS if reached else Status.OUT_OF_TIME if late else Status.IN_GAME)
        info = {"status": status, "is_success": reached, "cycle": int(self.core.cycle[0]), "reward_reached": float(reached)}
        return self.core.observe()[0], float(reached), reached, late, info

    def render(self) -> str | None:  # type: ignore[override]
        """The three summary variables as text."""
        if self.render_mode is None:
            return None
        return f"d {self.core.d[0]:.2f} m  theta {math.degrees(self.core.theta[0]):.1f} deg  s {self.core.s[0]:.2f} m/cycle"


class SlowApproachVectorEnv(gymnasium.vector.VectorEnv[np.ndarray, Any, np.ndarray]):
    """`SlowApproachEnv` in `num_envs` worlds at once, with the autoreset modes of Gymnasium; world k depends on (seed, k) alone."""

    def __init__(
        self, num_envs: int = 1, action_mode: str = "discrete", autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None, max_episode_steps: int | None = None, **options: Any,
    ) -> None:  # fmt: skip
        if num_envs < 1:
            raise UnknownName(f"num_envs: {num_envs!r} given, at least 1 is needed")
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            raise UnknownName(f"autoreset_mode {autoreset_mode!r}: allowed are {', '.join(m.value for m in AutoresetMode)}") from None
        self.parameters = _parameters(options, max_episode_steps)
        self.core = SlowWorlds(self.parameters, num_envs)
        self._actions = _Actions(action_mode, self.parameters)
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.metadata = {"render_modes": [], "render_fps": 10, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = self._actions.space, _space(self.parameters)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._over = np.zeros(num_envs, bool)
        self._seeded = False

    def _begin(self, worlds: np.ndarray) -> None:
        self.core.reset(worlds)
        self.core.start_noise(worlds)
        self._over[worlds] = False

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start episodes: in all worlds, or in those of ``options["reset_mask"]``."""
        mask = checked_reset(options, ("reset_mask",)).get("reset_mask")
        super().reset(seed=None if isinstance(seed, list) else seed)
        if seed is None and not self._seeded:
            seed = int(self.np_random.integers(2**31))
        if seed is not None:
            self.core.seed(seed)
        self._seeded = True
        self._begin(np.arange(self.num_envs) if mask is None else np.flatnonzero(mask))
        return self.core.observe(), self._infos(np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool))

    def _infos(self, reached: np.ndarray, late: np.ndarray) -> dict[str, Any]:
        status = np.where(reached, int(Status.SUCCESS), np.where(late, int(Status.OUT_OF_TIME), 0))
        cycle = self.core.cycle.copy()
        values = {"status": status, "is_success": reached.copy(), "cycle": cycle, "reward_reached": reached.astype(np.float64)}
        return marked(np.ones(self.num_envs, bool), values)

    def step(self, actions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Play one cycle in every world, with the chosen autoreset."""
        if not self._seeded:
            raise CprmError("step before reset: call reset() first")
        if self.autoreset_mode == AutoresetMode.DISABLED and self._over.any():
            raise CprmError(f"worlds {np.flatnonzero(self._over).tolist()[:8]} are over: reset them with options={{'reset_mask': ...}}")
        starting = np.flatnonzero(self._over)
        self.core.step(*self._actions.inputs(actions, self.num_envs))
        if len(starting):
            self._begin(starting)
        reached = self.core.d < self.parameters.epsilon_d
        reached[starting] = False
        late = ~reached & (self.core.cycle >= self.parameters.max_cycles)
        self._over = reached | late
        observation = self.core.observe()
        info = self._infos(reached, late)
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._over.any():
            final, over = np.empty(self.num_envs, object), self._over.copy()
            for i in np.flatnonzero(over):
                final[i] = observation[i].copy()
            last = {name: over if name.startswith("_") else values.copy() for name, values in info.items()}
            info.update(final_obs=final, _final_obs=over, final_info=last, _final_info=over)
            self._begin(np.flatnonzero(over))
            observation = self.core.observe()
        return observation, reached.astype(np.float64), reached, late, info
