"""Rewards as arguments: a task's own, a function of yours, or the task's own with named shaping terms added.

Shaping terms are potential-based: ``gamma * potential(s') - potential(s)`` with a potential of 0 after the end, so that the best policy
stays the best (Ng, Harada, Russell, ICML 1999). The one exception, `hausknecht_stone`, is the reward of the HFO literature and says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..errors import ParameterError, unknown_name
from .tasks.base import Outcome

if TYPE_CHECKING:
    from .core import SoccerCore

RewardFunction: TypeAlias = "Callable[[SoccerCore, Outcome], np.ndarray | Mapping[str, np.ndarray]]"
"""Called after every cycle with the engine and the task's outcome; gives the reward (W, A), or named terms of it."""
RewardOption: TypeAlias = "str | Sequence[str] | Mapping[str, float] | RewardFunction | None"
"""None: the task's own. A name, names, or names with weights: the task's own plus those terms. A function: instead of the task's own."""
Potential: TypeAlias = "Callable[[SoccerCore], np.ndarray]"

_GOAL = np.array([52.5, 0.0])


def to_ball(core: SoccerCore) -> np.ndarray:
    """Minus the distance from the agent to the ball, in units of 10 m; (W, A)."""
    pos = core.sim.world["pos"]
    d = pos[:, core.players] - pos[:, :1]
    return -0.1 * np.hypot(d[..., 0], d[..., 1])


def ball_to_goal(core: SoccerCore) -> np.ndarray:
    """Minus the distance from the ball to the middle of the opponent's goal, in units of 10 m; (W, A)."""
    ball = core.sim.world["pos"][:, 0]
    d = core.sides[:, None] * _GOAL - ball[:, None]
    return -0.1 * np.hypot(d[..., 0], d[..., 1])


def facing_ball(core: SoccerCore) -> np.ndarray:
    """Cosine of the angle between the agent's body and the way to the ball; (W, A)."""
    w = core.sim.world
    d = w["pos"][:, :1] - w["pos"][:, core.players]
    return np.asarray(np.cos(np.arctan2(d[..., 1], d[..., 0]) - w["body"][:, core.players - 1]))


def possession(core: SoccerCore) -> np.ndarray:
    """1 where a player of the agent's team can kick the ball, else 0; (W, A)."""
    has = {side: np.zeros(core.worlds, bool) for side in (1.0, -1.0)}
    for number in range(1, core.task.left + 1):
        has[1.0] |= core.kickable(number)
    for number in range(12, core.task.right + 12):
        has[-1.0] |= core.kickable(number)
    return np.stack([has[side] for side in core.sides], axis=1).astype(np.float64)


POTENTIALS: Mapping[str, Potential] = {
    "to_ball": to_ball, "ball_to_goal": ball_to_goal, "facing_ball": facing_ball, "possession": possession,
}  # fmt: skip
"""The shaping terms by name."""


class Reward:
    """What an engine pays.

    Parameters
    ----------
    option : RewardOption
    gamma : float
        Discount of the shaping terms; that of the learner keeps them neutral.

    Raises
    ------
    UnknownName
        For a term that does not exist; the message lists those that do.
    ParameterError
        For a weight that is no number, or another type of option.
    """

    def __init__(self, option: RewardOption = None, gamma: float = 0.99) -> None:
        self.function: RewardFunction | None = None
        self.weights: dict[str, float] = {}
        self.gamma = gamma
        if isinstance(gamma, bool) or not isinstance(gamma, (int, float)) or not 0.0 <= gamma <= 1.0:
            raise ParameterError(f"reward_gamma: {gamma!r} given, allowed is 0 to 1")
        if isinstance(option, str):
            option = {} if option == "sparse" else {option: 1.0}
        if option is None:
            pass
        elif isinstance(option, Mapping):
            self.weights = dict(option)
        elif isinstance(option, Sequence):
            self.weights = dict.fromkeys(option, 1.0)
        elif callable(option):
            self.function = option
        else:
            raise ParameterError(f"reward: expected None, names of terms, names with weights or a function, got {type(option).__name__}")
        for name, weight in self.weights.items():
            if name not in POTENTIALS:
                raise unknown_name("reward term", str(name), ("sparse", *POTENTIALS))
            if isinstance(weight, bool) or not isinstance(weight, (int, float)) or not np.isfinite(weight):
                raise ParameterError(f"reward term {name!r}: its weight is {weight!r}; allowed are finite numbers")
        self._before: dict[str, np.ndarray] = {}

    @property
    def plain(self) -> bool:
        """Whether this is the task's own reward and nothing else."""
        return self.function is None and not self.weights

    def begin(self, core: SoccerCore, worlds: np.ndarray) -> None:
        """An episode begins in the given worlds."""
        for name in self.weights:
            now = POTENTIALS[name](core)
            if name not in self._before:
                self._before[name] = now
            else:
                self._before[name][worlds] = now[worlds]

    def apply(self, core: SoccerCore, outcome: Outcome) -> Outcome:
        """`outcome` with this reward and its terms."""
        if self.function is not None:
            given: Any = self.function(core, outcome)
            terms = dict(given) if isinstance(given, Mapping) else {"reward": given}
            shape = outcome.reward.shape
            for name, value in terms.items():
                terms[name] = np.asarray(value, np.float64)
                if terms[name].shape != shape:
                    raise ParameterError(f"reward function: {name!r} has shape {terms[name].shape}, expected {shape} (worlds, agents)")
            return outcome._replace(reward=sum(terms.values(), np.zeros(shape)), terms=terms)
        reward, terms = outcome.reward.astype(np.float64, copy=True), dict(outcome.terms)
        for name, weight in self.weights.items():
            after = POTENTIALS[name](core)
            # after the end of the task nothing is worth anything
            worth = np.where(outcome.terminated[:, None], 0.0, after)
            terms[name] = weight * (self.gamma * worth - self._before[name])
            reward += terms[name]
            self._before[name] = after
        return outcome._replace(reward=reward, terms=terms)


class HausknechtStone:
    """The shaped reward of the HFO literature, as a function to pass in: ``reward=HausknechtStone()``.

    Progress of agent to ball, 1 for the first time that the ball is kickable, 3 times progress of ball to goal, 5 for a goal (Hausknecht
    and Stone, ICLR 2016, distances in metres as there; not potential-based).
    """

    def __init__(self) -> None:
        self._state: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def __call__(self, core: SoccerCore, outcome: Outcome) -> Mapping[str, np.ndarray]:
        """The four terms."""
        near, far = -10.0 * to_ball(core), -10.0 * ball_to_goal(core)
        kickable = np.stack([core.kickable(int(p)) for p in core.players], axis=1)
        if self._state is None or self._state[0].shape != near.shape:
            self._state = (near.copy(), far.copy(), np.zeros(near.shape, bool))
        last_near, last_far, had = self._state
        first = core.cycle[:, None] <= 1
        last_near, last_far, had = np.where(first, near, last_near), np.where(first, far, last_far), had & ~first
        self._state = (near, far, had | kickable)
        return {
            "move_to_ball": last_near - near,
            "kickable": (kickable & ~had).astype(np.float64),
            "ball_to_goal": 3.0 * (last_far - far),
            "goal": 5.0 * (outcome.reward > 0) * outcome.terminated[:, None],
        }
