"""Episodes of one task, its agents played by a controller, in given worlds and with given senses."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..agents.knowledge import Informed
from ..envs.controller import Controller, check_action
from ..envs.core import SoccerCore, Step, select_agents
from ..envs.players.senses import Senses
from ..envs.tasks import Task

SLOTS = 50
"""Episodes played side by side."""
TOGETHER = 4
"""A share of the slots, one in so many, has to be free before they are used again."""


class Episodes(NamedTuple):
    """What became of each."""

    success: np.ndarray
    """(n,) bool."""
    cycles: np.ndarray
    """(n,) int."""
    reward: np.ndarray
    """(n,) float: mean of the agents' sums."""
    seconds: float
    """CPU time inside the controllers."""
    decisions: int
    """Actions of one agent in one world."""


class Observer(Protocol):
    """Looks at episodes while they are played, or meddles with them."""

    def begin(self, core: SoccerCore, slots: np.ndarray, episodes: np.ndarray) -> None:
        """In slots (n,) int, episodes (n,) int begin, numbered from 0 on."""

    def before(self, core: SoccerCore) -> None:
        """A cycle is about to be played."""

    def after(self, core: SoccerCore, step: Step, playing: np.ndarray) -> None:
        """A cycle was played; `playing` (slots,) int: the episode of each slot, the number of all where there is none."""


def play_episodes(
    task: Task,
    make: Callable[[Task, str], Controller],
    count: int,
    seed: int,
    first_world: int = 0,
    senses: Senses | None = None,
    slots: int = SLOTS,
    observer: Observer | None = None,
    limit: AbstractContextManager[Any] | None = None,
    most: int | None = None,
) -> Episodes:
    """Play ``count`` worlds from `first_world` on; every controller meets the same worlds.

    Episodes differ in length, so `slots` of them are played side by side, and each that ends makes room for the next world. World k is
    the same in any slot.

    Parameters
    ----------
    task : Task
    make : callable
        (task, agent) -> controller, for each of the task's agents; those on an oracle's tier are shown the worlds.
    count, seed, first_world : int
    senses : Senses, optional
    slots : int
        At least 1.
    observer : Observer, optional
    limit : context manager, optional
        Entered around every call of a controller: what takes too long is its to end.
    most : int, optional
        Cycles after which it stops, whatever is still being played.
    """
    limit = limit or nullcontext()
    slots = min(slots, count)
    controllers = [make(task, agent) for agent in select_agents(task.controlled, task.left, task.right)]
    needs = tuple(dict.fromkeys(part for controller in controllers for part in getattr(controller, "needs", ())))
    core = SoccerCore(task, slots, seed=seed, first_world=first_world, include=needs, senses=senses or Senses())
    observation = core.reset(seed)
    for i, (agent, controller) in enumerate(zip(core.agents, controllers)):
        if isinstance(controller, Informed):
            controller.connect(core, agent)
        with limit:
            controller.reset({key: value[:, i] for key, value in observation.items()}, seed)
    if observer:
        observer.begin(core, np.arange(slots), np.arange(slots))
    playing = np.arange(slots)  # the episode of each slot; `count` where there is none left
    following = slots
    success, cycles, reward = np.zeros(count + 1, bool), np.zeros(count + 1, np.int64), np.zeros(count + 1)
    spent, played = 0.0, 0
    while (playing < count).any() and (most is None or played < most):
        actions = []
        for i, controller in enumerate(controllers):
            mine = {key: value[:, i] for key, value in observation.items()}
            spent -= time.process_time()
            with limit:
                action = controller.act(mine)
            spent += time.process_time()
            actions.append(check_action(type(controller).__name__, action, slots))
        if observer:
            observer.before(core)
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        cycles[playing] += 1  # where nothing is played, of the entry that is left out
        success[playing] |= step.success.any(axis=1)
        reward[playing] += step.reward.mean(axis=1)
        played += 1
        if observer:
            observer.after(core, step, playing)
        playing[(step.terminated | step.truncated) & (playing < count)] = count
        # to begin costs a look in every slot: it is done for several at once
        free = np.flatnonzero(playing == count)[: count - following]
        if len(free) < min(slots // TOGETHER, count - following) or not len(free):
            continue
        playing[free] = np.arange(following, following + len(free))
        following += len(free)
        worlds = [np.random.SeedSequence(seed, spawn_key=(first_world + int(k),)) for k in playing[free]]
        observation = core.reset(worlds, free)
        begun = np.isin(np.arange(slots), free)
        for i, controller in enumerate(controllers):
            with limit:
                controller.reset({key: value[:, i] for key, value in observation.items()}, seed, begun)
        if observer:
            observer.begin(core, free, playing[free])
    decisions = played * slots * len(controllers)
    return Episodes(success[:count], cycles[:count], reward[:count], spent, decisions)
