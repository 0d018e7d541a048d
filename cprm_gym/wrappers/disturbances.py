"""Things that go wrong, on purpose: to measure how agents recover (dissertation §4, "simulated interruptions").

A `Disturbance` is a value that says what happens, to the world or to what is seen of it; a `Disturber` makes it happen in a batch of
worlds, once per episode, at a cycle drawn for each world from (seed, number of the world) alone: every controller meets the same one.

    disturber = Disturber(core, BallDisplaced(), seed=0)
    core.reset(0); disturber.reset()
    while ...:
        disturber()                 # before each step
        core.step(actions)
    disturber.struck                # cycle in which each world was struck, -1 where it has not been

`Disturbed` and `ParallelDisturbed` are the same around an environment.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
from pettingzoo.utils import BaseParallelWrapper

from ..envs.core import SoccerCore
from ..errors import ParameterError
from ..simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ..simulator.senses import BallLevel, See
from ..simulator.state import PLAYERS

EDGE = 1.0
"""Metres that displaced things stay away from the lines."""
DRAWS = 8
"""Numbers drawn for each world and episode."""
NO_SIGHT = -10
"""Value of ``see_counter`` at which no see message is due."""


@dataclass(frozen=True)
class Disturbance:
    """Base: what strikes once in an episode.

    Parameters
    ----------
    first, last : int
        The cycle in which it strikes is drawn from ``first ... last``.

    Raises
    ------
    ParameterError
        When the cycles are not in order.
    """

    first: int = 40
    last: int = 200
    name: ClassVar[str] = ""
    lasts: ClassVar[int] = 1

    def __post_init__(self) -> None:
        if not 0 <= self.first <= self.last:
            raise ParameterError(f"{type(self).__name__}: first {self.first} and last {self.last}: needs 0 <= first <= last")

    @property
    def duration(self) -> int:
        """Cycles for which it works."""
        return self.lasts

    def ready(self, core: SoccerCore, worlds: np.ndarray) -> np.ndarray:
        """Which of the worlds that are due it can strike now, (n,) bool; the others are struck as soon as it can."""
        return np.ones(len(worlds), bool)

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """One cycle of it, before the step.

        Parameters
        ----------
        worlds : (n,) int array
        draws : (n, DRAWS) numbers in [0, 1), the same in every cycle of an episode
        age : (n,) int array
            Cycles since it struck, 0 in the first.
        """
        raise ParameterError(f"disturbance {type(self).__name__} does not say what it does")

    def blur(self, see: See, rows: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """What it does to what everybody sees after the step of such a cycle; nothing, if a kind does not say otherwise.

        Parameters
        ----------
        see : See
            Changed in place.
        rows : (n,) int array
            Where the worlds stand in `see`.
        draws, age : arrays
            As for `strike`.
        """


def _displacement(draws: np.ndarray, near: float, far: float) -> np.ndarray:
    """(n, 2) vectors `near` to `far` metres long in any direction."""
    length, angle = near + (far - near) * draws[:, 0], 2.0 * np.pi * draws[:, 1]
    return np.stack([length * np.cos(angle), length * np.sin(angle)], axis=1)


def _on_pitch(position: np.ndarray) -> np.ndarray:
    limit = np.array([HALF_LENGTH - EDGE, HALF_WIDTH - EDGE])
    return np.clip(position, -limit, limit)


@dataclass(frozen=True)
class BallDisplaced(Disturbance):
    """The ball lies elsewhere all at once, at rest, `near` to `far` metres from where it was."""

    near: float = 3.0
    far: float = 8.0
    name: ClassVar[str] = "ball displaced"

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Moves the ball."""
        place = _on_pitch(core.sim.world["pos"][worlds, 0] + _displacement(draws, self.near, self.far))
        core.place_ball(*place.T, worlds=worlds)


@dataclass(frozen=True)
class PlayerDisplaced(Disturbance):
    """One of the agents stands elsewhere all at once, looking anywhere, `near` to `far` metres from where he was."""

    near: float = 3.0
    far: float = 8.0
    name: ClassVar[str] = "player displaced"

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Moves an agent drawn among those controlled."""
        chosen = core.players[(draws[:, 2] * len(core.players)).astype(np.int64)]
        for player in core.players:
            here = chosen == player
            place = core.sim.world["pos"][worlds[here], player] + _displacement(draws[here], self.near, self.far)
            body = np.pi * (2.0 * draws[here, 3] - 1.0)
            core.place_player(int(player), *_on_pitch(place).T, body, (0.0, 0.0), worlds=worlds[here])


@dataclass(frozen=True)
class BlindSpell(Disturbance):
    """Nobody sees anything for `cycles` cycles: no see message comes; what is felt of the own body goes on."""

    cycles: int = 20
    name: ClassVar[str] = "blind spell"

    @property
    def duration(self) -> int:
        """`cycles`."""
        return self.cycles

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Keeps the eyes from opening."""
        core.sim.world["see_counter"][worlds] = NO_SIGHT
        over = worlds[age == self.cycles - 1]
        core.sim.world["see_counter"][over] = 0


@dataclass(frozen=True)
class NoiseBurst(Disturbance):
    """For `cycles` cycles everybody sees ball and players badly: each number is off by a normal error of its own in every cycle.

    Whether something is seen, and how much of it (the level), stays as it is. What the players remember is what they saw.

    Parameters
    ----------
    cycles : int
    distance : float
        Standard deviation of the logarithm of a distance, so about a share of it.
    direction : float
        Of a direction, degrees.
    distance_change : float
        Of a distance change, m / cycle.
    direction_change : float
        Of a direction change, degrees / cycle.
    """

    cycles: int = 30
    distance: float = 0.15
    direction: float = 8.0
    distance_change: float = 0.3
    direction_change: float = 6.0
    name: ClassVar[str] = "noise burst"

    @property
    def duration(self) -> int:
        """`cycles`."""
        return self.cycles

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Touches nothing: the world goes on as it would."""

    def blur(self, see: See, rows: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Adds errors to what is seen of ball (row 0 of them) and players, observer by observer."""
        sd = np.array([self.distance, np.radians(self.direction), self.distance_change, np.radians(self.direction_change)])
        for k, row in enumerate(rows):
            # the errors of a cycle follow from the drawn numbers alone, whoever sees what
            seed = [*(draws[k] * 2.0**32).astype(np.uint64).tolist(), int(age[k])]
            errors = sd * np.random.default_rng(np.random.SeedSequence(seed)).standard_normal((PLAYERS, PLAYERS + 1, 4))
            _add_errors(see.ball[row], see.ball_level[row], errors[:, 0])
            _add_errors(see.players[row], see.players_level[row], errors[:, 1:])


def _add_errors(rows: np.ndarray, level: np.ndarray, errors: np.ndarray) -> None:
    """Errors (..., 4) in place to the distances and directions of what is seen, and to the changes where they are told."""
    seen, moving = level > 0, level >= BallLevel.MOVING
    rows[..., 0] = np.where(seen, rows[..., 0] * np.exp(errors[..., 0]), rows[..., 0])
    direction = rows[..., 1] + errors[..., 1]
    rows[..., 1] = np.where(seen, (direction + np.pi) % (2.0 * np.pi) - np.pi, rows[..., 1])
    rows[..., 2:4] += np.where(moving[..., None], errors[..., 2:4], 0.0)


@dataclass(frozen=True)
class Push(Disturbance):
    """For `cycles` cycles ball and players are pushed about, by accelerations of up to `ball` and `player` m / cycle in any direction."""

    cycles: int = 10
    ball: float = 0.5
    player: float = 0.2
    name: ClassVar[str] = "pushed about"

    @property
    def duration(self) -> int:
        """`cycles`."""
        return self.cycles

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Adds to the velocities; the directions turn irregularly with the drawn numbers and the cycle."""
        velocity = core.sim.world["vel"]
        for thing in (0, *core.players):
            size = self.ball if thing == 0 else self.player
            # a fresh direction and length in every cycle, from the drawn numbers alone
            angle = 2.0 * np.pi * np.modf(997.0 * draws[:, 4] * (age + 1) + 331.0 * thing * draws[:, 5])[0]
            length = size * np.modf(613.0 * draws[:, 6] * (age + 1) + 127.0 * thing * draws[:, 7])[0]
            velocity[worlds, thing, 0] += length * np.cos(angle)
            velocity[worlds, thing, 1] += length * np.sin(angle)


@dataclass(frozen=True)
class BallStopped(Disturbance):
    """A rolling ball runs into something that nobody sees and lies still, once it is faster than `speed` m / cycle and out of reach."""

    speed: float = 0.5
    away: float = 2.0
    name: ClassVar[str] = "ball stopped"

    def ready(self, core: SoccerCore, worlds: np.ndarray) -> np.ndarray:
        """While it rolls, `away` metres from every agent."""
        world = core.sim.world
        rolls = np.hypot(*world["vel"][worlds, 0].T) > self.speed
        for player in core.players:
            gap = world["pos"][worlds, player] - world["pos"][worlds, 0]
            rolls &= np.hypot(gap[:, 0], gap[:, 1]) > self.away
        return rolls

    def strike(self, core: SoccerCore, worlds: np.ndarray, draws: np.ndarray, age: np.ndarray) -> None:
        """Takes the ball's velocity."""
        core.sim.world["vel"][worlds, 0] = 0.0


DISTURBANCES: dict[str, Disturbance] = {
    d.name: d for d in (BallDisplaced(), PlayerDisplaced(), BlindSpell(), NoiseBurst(), Push(), BallStopped())
}
"""One of each kind with its default sizes, by name."""


class Disturber:
    """Makes a disturbance happen in the worlds of a core.

    Parameters
    ----------
    core : SoccerCore
    disturbance : Disturbance
    seed : int
        World k of the core depends on (seed, ``core.sim.first_world + k``) and on how many episodes it has begun, nothing else.

    Attributes
    ----------
    struck : (W,) int array
        Cycle of the episode in which the world was struck; -1 while it has not been.
    """

    def __init__(self, core: SoccerCore, disturbance: Disturbance, seed: int = 0) -> None:
        self.core = core
        self.disturbance = disturbance
        self._seed = seed
        first = core.sim.first_world
        self._streams = [np.random.default_rng(np.random.SeedSequence([seed, first + k])) for k in range(core.worlds)]
        self.struck = np.full(core.worlds, -1, np.int64)
        self._due = np.zeros(core.worlds, np.int64)
        self._draws = np.zeros((core.worlds, DRAWS))
        self._now = self._cycle = np.zeros(0, np.int64)
        core.see_changes.append(self._blur)
        self.reset()

    def reset(self, worlds: np.ndarray | None = None, numbers: np.ndarray | None = None) -> None:
        """Draw anew for the worlds that begin an episode.

        Parameters
        ----------
        worlds : (W,) bool or (n,) int array, optional
            All if not given.
        numbers : (n,) int array, optional
            They become worlds of these numbers, in their first episode.
        """
        chosen = np.arange(self.core.worlds) if worlds is None else np.asarray(worlds)
        chosen = np.flatnonzero(chosen) if chosen.dtype == bool else chosen
        if numbers is not None:
            for k, number in zip(chosen, numbers):
                self._streams[k] = np.random.default_rng(np.random.SeedSequence([self._seed, int(number)]))
        for k in chosen:
            self._draws[k] = self._streams[k].random(DRAWS)
            self._due[k] = self._streams[k].integers(self.disturbance.first, self.disturbance.last + 1)
        self.struck[chosen] = -1

    def __call__(self) -> None:
        """Disturb the worlds whose time has come; to be called before every step."""
        cycle = self.core.cycle
        waiting = np.flatnonzero((self.struck < 0) & (cycle >= self._due))
        if len(waiting):
            hit = waiting[self.disturbance.ready(self.core, waiting)]
            self.struck[hit] = cycle[hit]
        active = np.flatnonzero((self.struck >= 0) & (cycle - self.struck < self.disturbance.duration))
        self._now, self._cycle = active, cycle[active]
        if len(active):
            self.disturbance.strike(self.core, active, self._draws[active], self._cycle - self.struck[active])

    def _blur(self, see: See, worlds: np.ndarray) -> None:
        """What is seen after the step, in those of the worlds that were struck in it and have not begun another episode since."""
        row = np.full(self.core.worlds, -1)
        row[worlds] = np.arange(len(worlds))
        here = (self.core.cycle[self._now] == self._cycle + 1) & (row[self._now] >= 0)
        struck = self._now[here]
        if len(struck):
            self.disturbance.blur(see, row[struck], self._draws[struck], self._cycle[here] - self.struck[struck])


def _disturber(env: Any, disturbance: Disturbance, seed: int) -> Disturber:
    core = getattr(env.unwrapped, "core", None)
    if core is None:
        raise ParameterError(f"disturbances need an environment of cprm_gym; got {env}")
    return Disturber(core, disturbance, seed)


class Disturbed(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A Gymnasium environment of ours in which something goes wrong once in every episode.

    Parameters
    ----------
    env : gymnasium.Env
        `cprm_gym.envs.single.SoccerEnv`, wrapped or not.
    disturbance : Disturbance
    seed : int
        The strikes of the episodes follow from it alone.

    Raises
    ------
    ParameterError
        For another environment.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], disturbance: Disturbance, seed: int = 0) -> None:
        super().__init__(env)
        self.disturber = _disturber(env, disturbance, seed)

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode and draw when it will be disturbed."""
        result = self.env.reset(**kwargs)
        self.disturber.reset()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play one cycle; ``info["struck"]`` is the cycle in which the disturbance came, -1 before."""
        self.disturber()
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, {**info, "struck": int(self.disturber.struck[0])}


class ParallelDisturbed(BaseParallelWrapper):  # type: ignore[misc]
    """`Disturbed` for the parallel environment; the same parameters, ``struck`` in everybody's info."""

    def __init__(self, env: Any, disturbance: Disturbance, seed: int = 0) -> None:
        super().__init__(env)
        self.disturber = _disturber(env, disturbance, seed)

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Start an episode and draw when it will be disturbed."""
        result = self.env.reset(seed=seed, options=options)
        self.disturber.reset()
        return result

    def step(self, actions: dict[str, Any]) -> Any:
        """Play one cycle."""
        self.disturber()
        *result, infos = self.env.step(actions)
        struck = int(self.disturber.struck[0])
        return *result, {agent: {**info, "struck": struck} for agent, info in infos.items()}
