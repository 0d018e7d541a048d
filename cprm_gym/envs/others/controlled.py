"""Players beside the agents whom controllers play: each has observations of his own, as an agent has, and sees nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import ControllerError, CprmError, ParameterError
from ...simulator.simulator import Simulator
from ...simulator.state import PLAYERS, Stream
from ..actions import action_view
from ..controller import Controller, ControllerFactory, check_action
from ..observations import MAX_AGE, observation_space
from ..pitch import Pitch
from ..players.memory import Memories
from ..tasks.base import Task
from ..vectors.normalised import Normalised
from .percepts import Sensed, tell

SEEDS = 2**62
"""Seeds of controllers are whole numbers below this."""
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB), np.uint64(0x9E3779B97F4A7C15))


class ControlledPlayers:
    """Players of W worlds, one controller for each of them, who decides in all worlds at once.

    They have the senses of the server, whatever the senses of the agents are. A controller's luck in a world follows from the world's own
    streams, if it takes seeds of worlds (`cprm_gym.envs.controller.SeededController`).

    Parameters
    ----------
    pitch : Pitch
        The worlds.
    task : Task
    factories : mapping of int to (str, ControllerFactory)
        Object number 1..22 -> name for messages, and who makes the controller.

    Attributes
    ----------
    include : tuple of str
        Parts of the observation that they need.
    observation : dict of (W, P, ...) arrays
        What the P of them are told.

    Raises
    ------
    ParameterError
        For a controller that is shown the truth.
    """

    def __init__(self, pitch: Pitch, task: Task, factories: Mapping[int, tuple[str, ControllerFactory]]) -> None:
        players = sorted(factories)
        self.task = task
        self.names = [factories[p][0] for p in players]
        self.controllers: list[Controller] = [factories[p][1](task, _agent(p)) for p in players]
        for name, controller in zip(self.names, self.controllers):
            if hasattr(controller, "connect") and getattr(controller, "oracle", True):
                raise ParameterError(f"others: {name!r} is shown the truth; who plays beside the agents knows what players perceive")
        self.include: tuple[str, ...] = tuple(dict.fromkeys(part for c in self.controllers for part in getattr(c, "needs", ())))
        self.pitch = pitch.seen_by(np.array(players, np.int64))
        worlds = pitch.worlds
        self._normal = Normalised(self.pitch, task.task_features) if "normalised" in self.include else None
        vector = self._normal.columns.space(flatten=True) if self._normal else None
        space = observation_space(task.task_features, self.include, vector=vector)  # type: ignore[arg-type]
        self.observation = {name: np.zeros((worlds, len(players), *(s.shape or ())), s.dtype) for name, s in space.items()}
        self.pitch.observation = self.observation
        self.memories: Memories | None = None
        if {"memory", "normalised"} & {*self.include}:
            self.memories = Memories(pitch.sim, np.isin(np.arange(1, PLAYERS + 1), players), task.full_state)
        self._view = action_view("full")
        self._rows = [self.pitch.players[i : i + 1] - 1 for i in range(len(players))]
        self._begun = False

    def forget(self, worlds: np.ndarray) -> None:
        """Nothing is known of earlier episodes in the given worlds."""
        self.observation["age"][worlds] = MAX_AGE
        if self.memories is not None:
            self.memories.forget(worlds)

    def perceive(self, sensed: Sensed, sent: np.ndarray) -> None:
        """Take in the percepts of a cycle; `sent`: (W, 22) commands of the cycle before."""
        if self.memories is not None:
            self.memories.update(sensed.see, sensed.body, sent, sensed.worlds)
        tell(self.pitch, sensed, None if self.memories is None else self.memories.records, self.observation)
        if self._normal is not None and self.memories is not None:
            self._normal.write(self.pitch, sensed.worlds, self.memories.records, self.observation["normalised"])

    def look(self, max_cycles: int) -> None:
        """What the task adds to the observations, once everybody has perceived."""
        self.pitch.max_cycles = max_cycles
        if "task" in self.observation:
            self.task.features(self.pitch, self.observation["task"])
            if self._normal is not None:
                self._normal.add_task(self.observation["task"], self.observation["normalised"])

    def begin(self, worlds: np.ndarray) -> None:
        """The controllers begin episodes in the given worlds, (n,), from the observations there are now."""
        seeds = np.zeros(self.pitch.worlds, np.int64)
        seeds[worlds] = episode_seeds(self.pitch.sim, worlds)
        everywhere = len(np.unique(worlds)) == self.pitch.worlds or not self._begun
        self._begun = True
        mask = None if everywhere else np.isin(self.pitch.every, worlds)
        for i, controller in enumerate(self.controllers):
            seen = {key: value[:, i] for key, value in self.observation.items()}
            if hasattr(controller, "begin"):
                controller.begin(seen, seeds, mask)
            else:
                first = int(seeds[worlds[0]]) if len(worlds) else 0
                controller.reset(seen, (first + int(self.pitch.players[i])) % 2**31, mask)

    def act(self, commands: np.ndarray) -> None:
        """Write their commands of this cycle, (W, 22) array of COMMAND.

        Raises
        ------
        ControllerError, CommandError
            When a controller's action is none, naming controller and player.
        """
        for i, (name, controller) in enumerate(zip(self.names, self.controllers)):
            seen = {key: value[:, i] for key, value in self.observation.items()}
            action = check_action(name, controller.act(seen), self.pitch.worlds)
            try:
                self._view.commands({key: np.asarray(value)[:, None] for key, value in action.items()}, commands, self._rows[i])
            except CprmError as error:
                raise ControllerError(f"others: controller {name!r} of {_agent(int(self.pitch.players[i]))}: {error}") from None

    def state(self) -> dict[str, np.ndarray]:
        """The live arrays that decide how they go on, worlds first.

        Raises
        ------
        CprmError
            When a controller does not tell its own.
        """
        arrays = {f"others/{name}": values for name, values in self.observation.items()}
        if self.memories is not None:
            arrays["others/memories"] = self.memories.records
        for name, controller in zip(self.names, self.controllers):
            if not hasattr(controller, "state"):
                raise CprmError(f"save_state: the controller {name!r} among the others does not tell its state (a method `state`)")
        if not self._begun:  # so that the controllers have arrays into which a state can be written
            self.begin(self.pitch.every)
        for i, controller in enumerate(self.controllers):
            told: dict[str, Any] = controller.state()  # type: ignore[attr-defined]
            arrays |= {f"others/{_agent(int(self.pitch.players[i]))}/{key}": value for key, value in told.items()}
        return arrays


def episode_seeds(sim: Simulator, worlds: np.ndarray) -> np.ndarray:
    """(n,) int64 seeds of what begins in these worlds now, from each world's own stream of resets, which does not go on by it."""
    world = sim.world
    x = world["key"][worlds, Stream.RESETS].copy()
    for counter in ("steps", "draws"):
        with np.errstate(over="ignore"):
            x = x + (world[counter][worlds].astype(np.uint64) + np.uint64(1)) * _MIX[2]
            x = (x ^ (x >> np.uint64(30))) * _MIX[0]
            x = (x ^ (x >> np.uint64(27))) * _MIX[1]
            x ^= x >> np.uint64(31)
    return (x % np.uint64(SEEDS)).astype(np.int64)


def _agent(player: int) -> str:
    return f"left_{player}" if player <= 11 else f"right_{player - 11}"
