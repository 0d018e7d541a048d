"""Many episodes of a setup, several side by side, each the one that the run of its world would be."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...agents.play import agent_in
from ...envs.controller import check_action
from ...envs.core import SoccerCore
from ...envs.tasks import Status
from ...errors import ParameterError
from ...wrappers.disturbances import DISTURBANCES, Disturber
from ..running.run import make_players, needs_of
from ..running.setup import Setup

TOGETHER = 20
"""Worlds side by side: few enough that the first results come soon."""
MOST = 10_000
"""Episodes at a time."""


class Episode(NamedTuple):
    """What became of one."""

    world: int
    success: bool
    status: str
    cycles: int
    struck: int

    def said(self) -> dict[str, Any]:
        """For a page."""
        return self._asdict()


def play_episodes(setup: Setup, count: int, going: Callable[[], bool] = lambda: True) -> Iterator[list[Episode]]:
    """Play the worlds ``setup.world ... setup.world + count - 1``, a few at a time.

    Parameters
    ----------
    setup : Setup
    count : int
    going : callable
        Asked in every cycle; False ends it, and what is not finished is left out.

    Returns
    -------
    iterator of list of Episode
        Those that ended, in the order of their worlds.

    Raises
    ------
    ParameterError
        For another number of episodes, or a setup without a controller.
    """
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST:
        raise ParameterError(f"episodes: 1 to {MOST}, got {count!r}")
    if not setup.controller:
        raise ParameterError("episodes are played by a controller; choose one")
    return _batches(setup, count, going)


def _batches(setup: Setup, count: int, going: Callable[[], bool]) -> Iterator[list[Episode]]:
    for first in range(setup.world, setup.world + count, TOGETHER):
        played = _batch(setup, first, min(TOGETHER, setup.world + count - first), going)
        if played is None:
            return
        yield played


def _batch(setup: Setup, first: int, worlds: int, going: Callable[[], bool]) -> list[Episode] | None:
    task = setup.made()
    players = make_players(setup, task)
    for inner in filter(None, map(agent_in, players)):
        inner.options["trace"] = False
    core = SoccerCore(task, worlds, seed=setup.seed, first_world=first, include=("memory", *needs_of(players)))
    for agent, player in zip(core.agents, players):
        connect = getattr(player, "connect", None)
        if connect is not None:
            connect(core, agent)
    observation = core.reset(setup.seed)
    for i, player in enumerate(players):
        player.reset({key: value[:, i] for key, value in observation.items()}, setup.seed)
    disturber = None if setup.disturbance is None else Disturber(core, DISTURBANCES[setup.disturbance], setup.seed)
    found: dict[int, Episode] = {}
    while len(found) < worlds:
        if not going():
            return None
        if disturber is not None:
            disturber()
        views = [{key: value[:, i] for key, value in observation.items()} for i in range(len(players))]
        actions = [check_action(a, player.act(view), worlds) for a, player, view in zip(core.agents, players, views)]
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        for k in np.flatnonzero(step.terminated | step.truncated).tolist():
            if k not in found:
                struck = -1 if disturber is None else int(disturber.struck[k])
                found[k] = Episode(first + k, bool(step.success[k].any()), Status(int(step.status[k])).name, int(core.cycle[k]), struck)
    return [found[k] for k in range(worlds)]
