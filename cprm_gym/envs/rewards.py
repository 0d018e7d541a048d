"""Rewards as arguments: a task's own, a function of yours, or the task's own with named shaping terms added.

Shaping terms are potential-based: ``gamma * potential(s') - potential(s)`` with a potential of 0 after the end, so that the best policy
stays the best (Ng, Harada, Russell, ICML 1999). `to_ball` and `ball_to_goal` are below 0 (minus a distance), so with gamma below 1 *doing
nothing pays*: standing 52.5 m from the goal, ``0.01 * 5.25`` a cycle with gamma 0.99. The best policy is the same, but returns are
misleading to look at and to select models by. ``<term>_progress`` does not: ``potential(s') - potential(s)``, the plain gain of the
cycle, 0 for who stands still and 0 in all for who comes back; over an episode it sums to what was won on the way. It is not
discounted and nothing is given back at the end, so with gamma below 1 it is no potential-based shaping.
The reward of the HFO literature, `HausknechtStone`, is of that kind too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from ..errors import ParameterError, unknown_name
from ..simulator.state import LEFT, RIGHT
from .pitch import Pitch
from .tasks.base import Outcome

RewardFunction: TypeAlias = "Callable[[Pitch, Outcome], np.ndarray | Mapping[str, np.ndarray]]"
"""Called after every cycle with the worlds and the task's outcome; gives the reward (W, A), or terms of it, whose names stand in the
function's attribute ``terms`` (`named_terms`)."""
RewardOption: TypeAlias = "str | Sequence[str] | Mapping[str, float] | RewardFunction | None"
"""None: the task's own, with the shaping terms that belong to it (`Task.shaping`). ``sparse``: without them. Another name, names, or names
with weights: without them, plus those terms. A function: instead of all that."""
Potential: TypeAlias = "Callable[[Pitch], np.ndarray]"


def to_ball(pitch: Pitch) -> np.ndarray:
    """Minus the distance from the agent to the ball, in units of 10 m; (W, A)."""
    pos = pitch.sim.world["pos"]
    d = pos[:, pitch.players] - pos[:, :1]
    return -0.1 * np.hypot(d[..., 0], d[..., 1])


def ball_to_goal(pitch: Pitch) -> np.ndarray:
    """Minus the distance from the ball to the middle of the opponent's goal, in units of 10 m; (W, A)."""
    ball = pitch.sim.world["pos"][:, 0]
    goal = np.array([pitch.packed["goal_line"], 0.0])
    d = pitch.sides[:, None] * goal - ball[:, None]
    return -0.1 * np.hypot(d[..., 0], d[..., 1])


def facing_ball(pitch: Pitch) -> np.ndarray:
    """Cosine of the angle between the agent's body and the way to the ball; (W, A)."""
    w = pitch.sim.world
    d = w["pos"][:, :1] - w["pos"][:, pitch.players]
    return np.asarray(np.cos(np.arctan2(d[..., 1], d[..., 0]) - w["body"][:, pitch.players - 1]))


def possession(pitch: Pitch) -> np.ndarray:
    """1 where a player of the agent's team can kick the ball, else 0; (W, A)."""
    return pitch.of_sides(pitch.kickable_by(LEFT), pitch.kickable_by(RIGHT)).astype(np.float64)


POTENTIALS: Mapping[str, Potential] = {
    "to_ball": to_ball, "ball_to_goal": ball_to_goal, "facing_ball": facing_ball, "possession": possession,
}  # fmt: skip
"""The shaping terms by name."""


PROGRESS = "_progress"
"""Ending of the names of the undiscounted forms."""
SHAPING = (*POTENTIALS, *(name + PROGRESS for name in POTENTIALS))
"""Names of all shaping terms."""


@runtime_checkable
class Stateful(Protocol):
    """A reward function that remembers something between cycles, which saved states must hold."""

    def prepare(self, worlds: int, agents: int) -> None:
        """Make the arrays; called once."""

    def arrays(self) -> dict[str, np.ndarray]:
        """What it remembers, by name, the worlds first; its own arrays."""


def named_terms(*terms: str) -> Callable[[Any], Any]:
    """Decorator: the names of the terms that a reward function gives."""

    def name(function: Any) -> Any:
        function.terms = terms
        return function

    return name


class Reward:
    """What an engine pays.

    Parameters
    ----------
    option : RewardOption
    gamma : float
        Discount of the shaping terms; that of the learner keeps them neutral.
    task_terms : tuple of str
        Terms of the task's own reward.
    shaping : sequence of (str, float)
        The task's own shaping terms and their weights.

    Attributes
    ----------
    terms : tuple of str
        Names of all terms; that of a function without named terms is ``function``.

    Raises
    ------
    UnknownName
        For a term that does not exist; the message lists those that do.
    ParameterError
        For a weight that is no number, or another type of option.
    """

    def __init__(
        self,
        option: RewardOption = None,
        gamma: float = 0.99,
        task_terms: tuple[str, ...] = (),
        shaping: Sequence[tuple[str, float]] = (),
    ) -> None:
        self.function: RewardFunction | None = None
        self.weights: dict[str, float] = {}
        own = dict(shaping) if option is None else {}
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
        self.weights |= own
        for name, weight in self.weights.items():
            if name not in SHAPING:
                raise unknown_name("reward term", str(name), ("sparse", *SHAPING))
            if isinstance(weight, bool) or not isinstance(weight, (int, float)) or not np.isfinite(weight):
                raise ParameterError(f"reward term {name!r}: its weight is {weight!r}; allowed are finite numbers")
        named = getattr(self.function, "terms", ("function",))
        self.terms: tuple[str, ...] = (*task_terms, *self.weights) if self.function is None else tuple(named)
        self._before: dict[str, np.ndarray] = {}

    @property
    def plain(self) -> bool:
        """Whether this is the task's own reward and nothing else."""
        return self.function is None and not self.weights

    def prepare(self, worlds: int, agents: int) -> None:
        """Make room for what the terms are measured against; called once."""
        self._before = {name: np.zeros((worlds, agents)) for name in self.weights}
        if isinstance(self.function, Stateful):
            self.function.prepare(worlds, agents)

    def begin(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """An episode begins in the given worlds."""
        for name in self.weights:
            self._before[name][worlds] = POTENTIALS[name.removesuffix(PROGRESS)](pitch)[worlds]

    def apply(self, pitch: Pitch, outcome: Outcome) -> Outcome:
        """`outcome` with this reward and its terms."""
        if self.function is not None:
            return self._of_function(pitch, outcome)
        reward, terms = outcome.reward.astype(np.float64, copy=True), dict(outcome.terms)
        for name, weight in self.weights.items():
            after = POTENTIALS[name.removesuffix(PROGRESS)](pitch)
            if name.endswith(PROGRESS):
                terms[name] = weight * (after - self._before[name])
            else:
                # after the end of the task nothing is worth anything
                worth = np.where(outcome.terminated[:, None], 0.0, after)
                terms[name] = weight * (self.gamma * worth - self._before[name])
            reward += terms[name]
            self._before[name] = after
        return outcome._replace(reward=reward, terms=terms)

    def _of_function(self, pitch: Pitch, outcome: Outcome) -> Outcome:
        assert self.function is not None
        given: Any = self.function(pitch, outcome)
        terms = dict(given) if isinstance(given, Mapping) else {"function": given}
        if tuple(terms) != self.terms:
            told = "none; see named_terms" if self.terms == ("function",) else ", ".join(self.terms)
            raise ParameterError(f"reward function: gave the terms {', '.join(map(str, terms))}, but its attribute `terms` names {told}")
        shape = outcome.reward.shape
        for name, value in terms.items():
            terms[name] = np.asarray(value, np.float64)
            if terms[name].shape != shape:
                raise ParameterError(f"reward function: {name!r} has shape {terms[name].shape}, expected {shape} (worlds, agents)")
        return outcome._replace(reward=sum(terms.values(), np.zeros(shape)), terms=terms)

    def _arrays(self) -> dict[str, np.ndarray]:
        arrays = {f"reward/{name}": values for name, values in self._before.items()}
        if isinstance(self.function, Stateful):
            arrays |= {f"reward/{name}": values for name, values in self.function.arrays().items()}
        return arrays

    def save_state(self) -> dict[str, np.ndarray]:
        """What the terms are measured against, by name, the worlds first."""
        return {name: values.copy() for name, values in self._arrays().items()}

    def load_state(self, state: Mapping[str, np.ndarray], worlds: np.ndarray, rows: np.ndarray) -> None:
        """Take it from rows of a saved state into the given worlds.

        Raises
        ------
        ParameterError
            When it is the state of another reward.
        """
        missing = [name for name in self._arrays() if name not in state]
        if missing:
            raise ParameterError(f"state: {missing[0]!r} is missing; it is the state of another reward")
        for name, values in self._arrays().items():
            values[worlds] = state[name][rows]


class HausknechtStone:
    """The shaped reward of the HFO literature, as a function to pass in: ``reward=HausknechtStone()``.

    Progress of agent to ball, 1 for the first time that the ball is kickable, 3 times progress of ball to goal, 5 for a goal (Hausknecht
    and Stone, ICLR 2016, distances in metres as there; not potential-based).
    """

    terms = ("move_to_ball", "kickable", "ball_to_goal", "goal")

    def __init__(self) -> None:
        self.prepare(0, 0)

    def prepare(self, worlds: int, agents: int) -> None:
        """Make the arrays."""
        self._near, self._far, self._had = (np.zeros((worlds, agents)) for _ in range(3))

    def arrays(self) -> dict[str, np.ndarray]:
        """Distances of the cycle before, and who has had the ball."""
        return {"near": self._near, "far": self._far, "had": self._had}

    def __call__(self, pitch: Pitch, outcome: Outcome) -> Mapping[str, np.ndarray]:
        """The four terms."""
        near, far = -10.0 * to_ball(pitch), -10.0 * ball_to_goal(pitch)
        kickable = np.stack([pitch.kickable(int(p)) for p in pitch.players], axis=1)
        first = pitch.cycle[:, None] <= 1
        last_near, last_far = np.where(first, near, self._near), np.where(first, far, self._far)
        had = (self._had > 0) & ~first
        self._near, self._far, self._had = near, far, (had | kickable).astype(np.float64)
        return {
            "move_to_ball": last_near - near,
            "kickable": (kickable & ~had).astype(np.float64),
            "ball_to_goal": 3.0 * (last_far - far),
            "goal": 5.0 * (outcome.reward > 0) * outcome.terminated[:, None],
        }
