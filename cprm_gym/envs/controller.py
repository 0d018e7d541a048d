"""The one interface of every controller, hand-written or learned.

A controller sees observations of one agent in each of N worlds and answers with N actions of the canonical (`hybrid`) view. It never
sees truth, other agents' observations or the worlds themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ..errors import ControllerError
from .tasks.base import Task

Observation = Mapping[str, np.ndarray]
Action = dict[str, np.ndarray]


@runtime_checkable
class Controller(Protocol):
    """Decides for one agent in each of N worlds at once."""

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes.

        Parameters
        ----------
        observation : dict of (N, ...) arrays
            The first observations.
        seed : int
            Decides every random choice of the controller.
        worlds : (N,) bool array, optional
            The worlds that begin anew, all if not given; the others go on undisturbed.
        """

    def act(self, observation: Observation) -> Action:
        """Actions for the observations.

        Parameters
        ----------
        observation : dict of (N, ...) arrays

        Returns
        -------
        dict of (N, ...) arrays
            ``type`` (N,), ``params`` (N, 4), ``turn_neck`` (N, 1), ``view`` (N,); see `cprm_gym.envs.actions.hybrid_space`, and
            `cprm_gym.envs.actions.scaled` for parameters in the server's units.
        """


class SeededController(Controller, Protocol):
    """A controller whose luck is each world's own: world k is then the same in any batch."""

    def begin(self, observation: Observation, seeds: np.ndarray, worlds: np.ndarray | None = None) -> None:
        """Begin episodes, instead of `reset`.

        Parameters
        ----------
        observation : dict of (N, ...) arrays
        seeds : (N,) int64 array
            One for each world, below 2**62, the same for all players of it; entries of worlds that go on mean nothing.
        worlds : (N,) bool array, optional
            The worlds that begin anew, all if not given.
        """


class SavedController(Controller, Protocol):
    """A controller that can be saved with an environment."""

    def state(self) -> dict[str, np.ndarray]:
        """The live arrays, (N, ...), that decide what it does next; an environment that is set back writes into them."""


ControllerFactory = Callable[[Task, str], Controller]
"""Makes the controller of one agent for a task; raises `UnknownName` for a task that it cannot play."""


def no_action(worlds: int) -> Action:
    """Actions that do nothing, for `worlds` worlds."""
    return {
        "type": np.zeros(worlds, np.int64),
        "params": np.zeros((worlds, 4)),
        "turn_neck": np.zeros((worlds, 1)),
        "view": np.zeros(worlds, np.int64),
    }


def check_action(name: str, action: Any, worlds: int) -> Action:
    """The action of a controller, if it has the shapes that were promised and holds finite numbers.

    Raises
    ------
    ControllerError
        Naming the controller, the entry, what it gave and what is expected.
    """
    if not isinstance(action, dict):
        raise ControllerError(f"controller {name!r}: act returned {type(action).__name__}, expected a dict of arrays")
    expected = no_action(worlds)
    for key, value in expected.items():
        if key not in action:
            raise ControllerError(f"controller {name!r}: act returned no {key!r}; expected {', '.join(expected)}")
        if np.shape(action[key]) != value.shape:
            raise ControllerError(f"controller {name!r}: {key!r} has shape {np.shape(action[key])}, expected {value.shape}")
        if not np.isfinite(action[key]).all():
            raise ControllerError(f"controller {name!r}: {key!r} holds what is no finite number, in world {_first_bad(action[key])}")
    return action


def _first_bad(values: Any) -> int:
    """The first world whose entries are not all finite."""
    return int(np.argwhere(~np.isfinite(values))[0][0])


class Predict:
    """A controller with the `predict` of stable-baselines3, so that its tools (`evaluate_policy`) accept it.

    Parameters
    ----------
    controller : Controller
        Who decides.
    seed : int
        Handed to the controller at its resets.
    """

    def __init__(self, controller: Controller, seed: int = 0) -> None:
        self.controller = controller
        self.seed = seed

    def predict(
        self,
        observation: Observation,
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: np.ndarray | None = None,
        deterministic: bool = False,
    ) -> tuple[Action, tuple[np.ndarray, ...]]:
        """Actions, and a state that says that the episodes are under way.

        Parameters
        ----------
        observation : dict of (N, ...) arrays, or of one observation without the first axis
        state : ignored but for None, which begins all episodes
        episode_start : (N,) bool array, optional
            Worlds that begin anew.
        deterministic : bool
            Ignored: a controller's randomness is fixed by its seed.
        """
        single = np.ndim(observation["level"]) == 1
        if single:
            observation = {key: np.asarray(value)[None] for key, value in observation.items()}
        worlds = len(observation["level"])
        if state is None:
            self.controller.reset(observation, self.seed)
        elif episode_start is not None and np.any(episode_start):
            self.controller.reset(observation, self.seed, np.asarray(episode_start, bool))
        action = self.controller.act(observation)
        if single:
            action = {key: value[0] for key, value in action.items()}
        return action, (np.ones(worlds, bool),)
