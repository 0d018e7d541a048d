"""Oracles: tiers that read the truth, to say how much knowledge could be worth. Nobody else may (`SoccerCore.truth`, `branch`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ...envs.controller import Action, Observation
from ...envs.core import SoccerCore
from ...errors import ParameterError
from ...simulator.state import Count
from .tiers import not_connected

TOUCHES = (int(Count.KICK), int(Count.TACKLE))
"""Commands by which others change the ball's way."""


class State:
    """Everything as it is: himself, the ball, the others."""

    name: ClassVar[str] = "state"
    oracle: ClassVar[bool] = True

    def __init__(self) -> None:
        self._core: SoccerCore | None = None
        self._agent = ""

    def connect(self, core: SoccerCore, agent: str) -> None:
        """The worlds whose truth it tells, and to whom."""
        self._core, self._agent = core, agent

    @property
    def core(self) -> SoccerCore:
        """The worlds.

        Raises
        ------
        ControllerError
            When it has been shown none.
        """
        if self._core is None:
            raise not_connected(self.name)
        return self._core

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Nothing to begin."""

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """The truth."""
        return self.core.truth(self._agent)


class Foresight(State):
    """`State`, and the next kick of another player is known before it happens.

    The worlds are branched and run on with the agents idle. Where another player touches the ball within `ahead` cycles, the ball is
    told as if that had already happened: at the place and with the velocity with which a free ball would be where it then will be.

    Parameters
    ----------
    ahead : int
        Cycles, at least 1.
    """

    name: ClassVar[str] = "foresight"

    def __init__(self, ahead: int = 1) -> None:
        super().__init__()
        if isinstance(ahead, bool) or not isinstance(ahead, (int, np.integer)) or ahead < 1:
            raise ParameterError(f"foresight: ahead: {ahead!r} given; allowed are whole numbers of at least 1")
        self.ahead = int(ahead)
        self._branch: SoccerCore | None = None

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """The truth, and the first touch to come."""
        core = self.core
        told = core.truth(self._agent)
        self._branch = future = core.branch(self._branch)
        player = int(core.players[core.agents.index(self._agent)])
        others = np.arange(1, 23) != player
        decay = core.parameters.ball_decay
        waiting = np.ones(core.worlds, bool)
        before = touches(future, others)
        for cycle in range(1, self.ahead + 1):
            (future.step if cycle < self.ahead else future.advance)(idle(future))
            after = touches(future, others)
            hit = waiting & (after > before)
            before = after
            if hit.any():
                x, y, vx, vy = future.truth(self._agent)["memory"][hit, 0].astype(np.float64).T
                for _ in range(cycle):  # a free ball moves, then slows down
                    vx, vy = vx / decay, vy / decay
                    x, y = x - vx, y - vy
                told["memory"][hit, 0] = np.stack([x, y, vx, vy], axis=1)
                waiting &= ~hit
        return told


def touches(core: SoccerCore, players: np.ndarray) -> np.ndarray:
    """(W,) kicks and tackles of the players of a mask (22,) so far."""
    counts = core.sim.world["counts"][:, :, TOUCHES]
    return np.asarray(counts[:, players].sum(axis=(1, 2)))


def idle(core: SoccerCore) -> dict[str, Any]:
    """Actions with which no agent does anything."""
    shape = (core.worlds, len(core.agents))
    return {"type": np.zeros(shape, np.int64), "params": np.zeros((*shape, 4))}
