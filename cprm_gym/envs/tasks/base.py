"""What a task is: who plays, where things start, what is good, when it ends.

A task is a value without state; the batch engine (`cprm_gym.envs.core.SoccerCore`) owns the worlds and asks it. All methods work
on many worlds at once, and see them as a `Pitch`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from math import inf
from typing import Any, NamedTuple

import numpy as np

from ...errors import ParameterError, did_you_mean
from ...simulator.parameters import Rules, ServerParameters
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ..pitch import Pitch
from ..players.mixing import Mix


class Status(IntEnum):
    """How an episode stands, the same numbers in every task; the first six are HFO's."""

    IN_GAME = 0
    """It goes on."""
    GOAL = 1
    """A goal that counts."""
    CAPTURED_BY_DEFENSE = 2
    """The defence has the ball."""
    OUT_OF_BOUNDS = 3
    """The ball left where the game takes place, or a fault was called."""
    OUT_OF_TIME = 4
    """Truncated after ``max_cycles``."""
    SERVER_DOWN = 5
    """HFO's alone: there is no server here that could go down."""
    SUCCESS = 6
    """The task is done: the ball is reached."""
    SAVED = 7
    """The goalie kept the ball out."""
    TAKEN = 8
    """The takers have the ball."""
    MATES_GOAL = 9
    """A goal, but of the team-mate."""
    TOO_EARLY = 10
    """A goal, but without enough passes."""
    FULL_TIME = 11
    """The referee ended the match."""


def within(default: float, low: float, high: float) -> Any:
    """A field of a task whose value lies between two numbers."""
    return field(default=default, metadata={"within": (low, high)})


class Outcome(NamedTuple):
    """What a cycle brought, for every world and controlled agent."""

    reward: np.ndarray
    """(W, A) float."""
    terminated: np.ndarray
    """(W,) bool: the task came to an end of its own."""
    success: np.ndarray
    """(W, A) bool: it ended as the agent wishes; only where `terminated` or ``pitch.late``."""
    status: np.ndarray
    """(W,) int: `Status`; ``IN_GAME`` while the episode goes on and where it is late (the engine adds ``OUT_OF_TIME``)."""
    terms: Mapping[str, np.ndarray]
    """The parts of the reward named in `Task.terms`, each (W, A); their sum is `reward`. `Task.shaping` is added by the engine."""


@dataclass(frozen=True)
class Task:
    """Base of all tasks.

    Attributes
    ----------
    name : str
        ``GoToBall``; the environment id is ``cprm/<name>-v2``.
    left, right : int
        Players of each side.
    controlled : str
        Default of who acts: ``left``, ``right``, ``all``, ``left_1``, or several separated by commas.
    others : str or (str, str)
        Scripted policy of the players that no agent controls, or one for each side (`cprm_gym.envs.players.scripted.POLICIES`).
    max_cycles : int
        Cycles until the episode is truncated.
    rules : Rules
        Referee modules that are on.
    metric : str
        What a report tells of its episodes: ``success`` (the share of them) or ``duration`` (mean seconds).
    statuses : tuple of Status
        How its episodes can end.
    terms : tuple of str
        Names of the parts of its reward.
    shaping : tuple of (str, float)
        Shaping terms (`cprm_gym.envs.rewards`) that belong to the task's own reward, with their weights.
    full_state : bool
        The memories behind scripted players, macros and memory presets hold the truth instead of what was perceived.
    mix : Mix or mapping of its fields
        How scripted players of the policy ``mixing`` mix (`cprm_gym.envs.players.mixing`).
    """

    name: str = ""
    left: int = 1
    right: int = 0
    left_goalie: int = 0
    right_goalie: int = 0
    controlled: str = "left_1"
    others: str | tuple[str, str] = "hold"
    max_cycles: int = 200
    rules: Rules = Rules.NONE
    parameters: ServerParameters = field(default_factory=ServerParameters)
    full_state: bool = False
    mix: Mix = Mix()  # noqa: RUF009
    metric: str = "success"
    statuses: tuple[Status, ...] = (Status.SUCCESS, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ()
    shaping: tuple[tuple[str, float], ...] = ()
    task_features: tuple[tuple[str, float, float], ...] = ()

    def __post_init__(self) -> None:
        """Refuse numbers that are none, infinite, negative or not `within`; what the engine checks itself is left to it."""
        object.__setattr__(self, "mix", Mix.of(self.mix))
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name in ("left", "right", "left_goalie", "right_goalie", "max_cycles") or entry.type not in ("int", "float"):
                continue
            whole = entry.type == "int"
            kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
            low, high = entry.metadata.get("within", (0, inf))
            if isinstance(value, bool) or not isinstance(value, kinds) or not low <= value <= high or value == inf:
                extent = "of at least 0" if high == inf else f"from {low:g} to {high:g}"
                allowed = f"{'whole' if whole else 'finite'} numbers {extent}"
                raise ParameterError(f"task {self.name!r}: {entry.name}: {value!r} given; allowed are {allowed}")

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Put players and ball of the given worlds where an episode starts.

        Parameters
        ----------
        pitch : Pitch
            `Pitch.place_ball`, `Pitch.place_player`, `Pitch.draw` do the work.
        worlds : (n,) int array
            Indices of the worlds that start anew.
        """
        raise TypeError(f"task {self.name!r} does not say how an episode starts")

    def outcome(self, pitch: Pitch) -> Outcome:
        """Reward, end and success of the cycle just played in every world."""
        raise TypeError(f"task {self.name!r} does not say what an outcome is")

    @property
    def region(self) -> tuple[float, float]:
        """Half length and half width of where the game takes place, m."""
        return HALF_LENGTH, HALF_WIDTH

    def restrict(self, names: tuple[str, ...], mask: np.ndarray) -> None:
        """Take macros out of `mask`, (W, A, macros), that have no place in this task; by default none."""

    def decide(self, names: tuple[str, ...], mask: np.ndarray, action: Any) -> Any:
        """The macros carried out when the agents choose `action`; by default those."""
        return action

    def features(self, pitch: Pitch, out: np.ndarray) -> None:
        """Write the ``task`` part of the observation, (W, A, len(task_features)); by default there is none."""


# --- forms that Gymnasium gives resets and infos


def checked_reset(options: Mapping[str, Any] | None, known: Sequence[str]) -> dict[str, Any]:
    """The options of a reset.

    Raises
    ------
    ParameterError
        For one that there is not; the message lists those that there are.
    """
    if options is None:
        return {}
    for name in options:
        if name not in known:
            raise ParameterError(f"reset: unknown option {name!r}.{did_you_mean(str(name), known)} Options: {', '.join(known)}.")
    return dict(options)


def marked(worlds: np.ndarray, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the worlds in Gymnasium's form: each followed by the array that says for which of them it counts."""
    return {key: value for name, given in values.items() for key, value in ((name, given), (f"_{name}", worlds))}
