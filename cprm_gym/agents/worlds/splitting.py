"""Rare outcomes of a behaviour in the simulator, by splitting: worlds with their agents are copied where they came far."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...architecture.analysis.budget import Budget
from ...architecture.analysis.rare.splitting import SplitEstimate, split_worlds
from ...architecture.analysis.sampling.runs import UNFINISHED
from ...envs.core import SoccerCore
from ...errors import ModelError, unknown_name
from ..play import SoccerAgent
from .learned import behaviour
from .stage import Change, Stage

Level = Callable[[SoccerCore, NDArray[np.int64]], NDArray[np.float64]]
"""(core, cycles played) -> (W,) how far each world is on the way to the outcome."""


class _Kept(NamedTuple):
    state: dict[str, np.ndarray]
    agents: list[tuple[Any, float, int]]
    cycle: int


class SplitStage:
    """A behaviour in worlds that can be copied, agents and all (`Splittable`).

    Parameters
    ----------
    name : str
        Of `learned.BEHAVIOURS`; its players act on percepts alone, without a model.
    worlds : int
    outcome : str
        That is rare: one of the behaviour's, or `UNFINISHED`, not to have ended by the limit.
    level : callable
    limit : int, optional
        Cycles; the behaviour's own if not given.
    change : callable, optional
        Makes another net of the skill's.

    Raises
    ------
    UnknownName
    ModelError
        For players with a model, whose beliefs cannot be copied from one world to another.
    """

    def __init__(self, name: str, worlds: int, outcome: str, level: Level, limit: int | None = None, change: Change | None = None) -> None:
        cast = behaviour(name).cast(change)
        if outcome not in (*cast.outcomes, UNFINISHED):
            raise unknown_name("outcome", outcome, (*cast.outcomes, UNFINISHED))
        if any(agent.cprm.model is not None for agent in cast.agents.values()):
            raise ModelError(f"behaviour {name!r}: a player with a model cannot be copied from world to world")
        self.stage, self.outcome, self.level = Stage(cast, worlds, 0), outcome, level
        self.limit = cast.limit if limit is None else limit
        self.cycles = np.zeros(worlds, np.int64)
        self.came = np.zeros(worlds, bool)  # to the outcome
        self.over = np.zeros(worlds, bool)

    @property
    def _agents(self) -> list[SoccerAgent]:
        return list(self.stage.cast.agents.values())

    def begin(self, seed: int) -> None:
        """Episodes begin, with randomness from a seed."""
        observation = self.stage.core.reset(seed)
        for at, agent in enumerate(self._agents):
            agent.reset({k: v[:, at] for k, v in observation.items()}, seed)
        self.cycles[:] = 0
        self.came[:] = self.over[:] = False

    def advance(self, active: NDArray[np.bool_]) -> None:
        """One cycle; those that have ended play on unheeded."""
        self.act()
        self.cycles += active
        self.judge(active)

    def act(self) -> None:
        """Players act, and the world goes on by a cycle."""
        core = self.stage.core
        actions = [agent.act({k: v[:, at] for k, v in core.observation.items()}) for at, agent in enumerate(self._agents)]
        core.step({k: np.stack([np.asarray(a[k]) for a in actions], axis=1) for k in actions[0]})

    def judge(self, active: NDArray[np.bool_]) -> None:
        """Which of the active have ended, and which of these have come to the outcome (`over`, `came`)."""
        for outcome, place in self.stage.cast.outcomes.items():
            fresh = active & ~self.over & (self.stage._read(place) > 0)
            self.over |= fresh
            self.came |= fresh & (outcome == self.outcome)
        late = active & ~self.over & (self.cycles >= self.limit)
        self.over |= late
        self.came |= late & (self.outcome == UNFINISHED)

    def levels(self) -> NDArray[np.float64]:
        """(W,) How far each is; infinite where it has come to the outcome."""
        return np.where(self.came, np.inf, self.level(self.stage.core, self.cycles))

    def ended(self) -> NDArray[np.bool_]:
        """(W,) Whether each has ended."""
        return self.over

    def keep(self, world: int) -> Any:
        """The world, and what its agents remember."""
        rows = slice(world, world + 1)
        agents = []
        for agent in self._agents:
            assert agent.controller is not None
            agents.append((agent.controller.executor.snapshot(rows), float(agent._turned[world]), int(agent.controller._cycle[world])))
        return _Kept(self.stage.core.save_state(world), agents, int(self.cycles[world]))

    def put(self, world: int, kept: Any, fresh: int) -> None:
        """Both again, with luck of their own from now on."""
        core = self.stage.core
        core.load_state(kept.state, np.array([world]))
        core.sim.world["key"][world] = np.random.SeedSequence(fresh).generate_state(4, np.uint64)
        for agent, (snapshot, turned, cycle) in zip(self._agents, kept.agents):
            assert agent.controller is not None
            agent.controller.executor.restore(snapshot, slice(world, world + 1))
            agent._turned[world], agent.controller._cycle[world] = turned, cycle
        self.cycles[world], self.over[world] = kept.cycle, False
        self.came[world] = False


def split_behaviour(
    name: str, outcome: str, level: Level, runs: int = 500, repetitions: int = 8, *, seed: int = 0, limit: int | None = None,
    change: Change | None = None, budget: Budget | None = None,
) -> SplitEstimate:  # fmt: skip
    """How likely a behaviour comes to a rare outcome in the simulator, by adaptive multilevel splitting.

    Parameters
    ----------
    name, outcome, level, limit, change
        As of `SplitStage`.
    runs, repetitions, seed : int
    budget : Budget, optional
        Its seconds; what was finished by then is kept.
    """
    return split_worlds(lambda n: SplitStage(name, n, outcome, level, limit, change), runs, repetitions, seed=seed, budget=budget)
