"""Failures of the simulator that hardly ever come, by splitting: a pass that strays farther than the team-mate reaches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...architecture.analysis.rare.splitting import SplitEstimate, split_worlds
from ...simulator.parameters import Rules, ServerParameters
from ...simulator.simulator import Simulator
from ...simulator.state import PlayMode


@dataclass(frozen=True)
class Pass:
    """A ball that was kicked along the x axis, and how far from it the team-mate can still take it.

    Attributes
    ----------
    speed : float
        At the beginning, m / cycle.
    target : float
        Where the team-mate stands, m.
    reach : float
        How far aside he takes it, m: beyond is a failure.
    """

    speed: float = 2.0
    target: float = 15.0
    reach: float = 2.75


class StrayingBall:
    """Worlds in which a ball rolls and is disturbed by the simulator's own noise; they can be copied (`Splittable`).

    Parameters
    ----------
    worlds : int
    kick : Pass
    parameters : ServerParameters, optional
    """

    def __init__(self, worlds: int, kick: Pass | None = None, parameters: ServerParameters | None = None) -> None:
        self.kick = kick or Pass()
        self.parameters = parameters or ServerParameters()
        self.sim = Simulator(worlds, self.parameters, rules=Rules.NONE, left=0, right=0, goalies=(0, 0), seed=0)
        self.cycles = 0

    def begin(self, seed: int) -> None:
        """The kick, in every world, with randomness from a seed."""
        sim = self.sim
        sim.reset(seed=seed)
        sim.world["mode"] = PlayMode.play_on
        sim.trainer.place_ball(0.0, 0.0, self.kick.speed, 0.0)

    def advance(self, active: NDArray[np.bool_]) -> None:
        """One cycle; those that have ended roll on unheeded."""
        self.sim.step()

    def levels(self) -> NDArray[np.float64]:
        """(W,) Metres aside at the target if nothing disturbs it any more; infinite where it has strayed."""
        w = self.sim.world
        x, y = w["pos"][:, 0].T
        vx, vy = w["vel"][:, 0].T
        left = np.maximum(self.kick.target - x, 0.0)
        aside = np.abs(y + np.where(np.abs(vx) > 1e-9, vy / np.where(np.abs(vx) > 1e-9, vx, 1.0), 0.0) * left)
        return np.where(self.ended() & (np.abs(y) > self.kick.reach), np.inf, np.where(self.ended(), np.abs(y), aside))

    def ended(self) -> NDArray[np.bool_]:
        """(W,) Whether it has come to the target, or rests before it."""
        w = self.sim.world
        return np.asarray((w["pos"][:, 0, 0] >= self.kick.target) | (np.hypot(*w["vel"][:, 0].T) < 0.01))

    def keep(self, world: int) -> Any:
        """The world's record."""
        return self.sim.world[world : world + 1].copy()

    def put(self, world: int, kept: Any, fresh: int) -> None:
        """The record, with streams of its own from now on."""
        self.sim.restore(kept, [world])
        self.sim.world["key"][world] = np.random.SeedSequence(fresh).generate_state(4, np.uint64)


class Plain(NamedTuple):
    """Plain sampling, for comparison."""

    failures: int
    runs: int
    cycles: int

    def cycles_for(self, relative: float) -> float:
        """Cycles that a relative deviation would take."""
        rate = self.failures / self.runs
        return float("inf") if rate == 0 else self.cycles / self.runs * (1 - rate) / rate / relative**2


def plain(runs: int, seed: int = 0, kick: Pass | None = None, batch: int = 2000) -> Plain:
    """Failures among plain runs in the simulator."""
    worlds = StrayingBall(batch, kick)
    failures = cycles = 0
    for block in range(-(-runs // batch)):
        worlds.begin(seed * 1_000_003 + block)
        going = np.ones(batch, bool)
        while going.any():
            worlds.advance(going)
            cycles += int(going.sum())
            fresh = worlds.ended() & going
            failures += int(np.isinf(worlds.levels()[fresh]).sum())
            going &= ~fresh
    return Plain(failures, -(-runs // batch) * batch, cycles)


def split(runs: int = 2000, repetitions: int = 5, seed: int = 0, kick: Pass | None = None) -> SplitEstimate:
    """The same by adaptive multilevel splitting; with few runs the repetitions are skewed, and mostly too low."""
    return split_worlds(lambda n: StrayingBall(n, kick), runs, repetitions, seed=seed)
