"""Failures of the simulator that hardly ever come, by splitting: a ball, or a pass of a player's net, that strays beyond reach."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...agents.worlds.splitting import SplitStage
from ...architecture.analysis.rare.splitting import SplitEstimate, split_worlds
from ...architecture.analysis.sampling.intervals import clopper_pearson
from ...architecture.analysis.sampling.runs import UNFINISHED
from ...simulator.parameters import Rules, ServerParameters
from ...simulator.simulator import Simulator
from ...simulator.state import PlayMode
from ..arguments import at_least


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


REACH = 2.5
"""Metres by which a pass hardly ever strays from where the kick sent it."""


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


class StrayingPass(SplitStage):
    """The passer's net plays to his team-mate 8 to 18 m away; a failure is a ball that comes by him too far from where the kick sent it.

    The skill ends as soon as the ball is on its way; the run goes on until it comes by, or rests. Worlds are copied with the passer in
    them. How well he aims is left out: a bad kick is one bad draw, which no copy makes likelier.

    Parameters
    ----------
    worlds : int
    reach : float
        How far it may stray, m.
    """

    def __init__(self, worlds: int, reach: float = REACH) -> None:
        super().__init__("pass_ball", worlds, UNFINISHED, lambda core, cycles: np.abs(self.strayed()), limit=90)
        self.reach = reach
        self.sent = np.full(worlds, np.nan)
        """(W,) Metres to the right of the team-mate at which the kick sent it by, nan before it."""

    def begin(self, seed: int) -> None:
        """Episodes begin."""
        super().begin(seed)
        self.sent[:] = np.nan

    def heading(self) -> NDArray[np.float64]:
        """(W,) The same if nothing disturbs the ball any more."""
        world = self.stage.core.sim.world
        gap, flies = world["pos"][:, 2] - world["pos"][:, 0], world["vel"][:, 0]
        return (gap[:, 0] * flies[:, 1] - gap[:, 1] * flies[:, 0]) / np.maximum(np.hypot(*flies.T), 1e-9)

    def strayed(self) -> NDArray[np.float64]:
        """(W,) How far it has strayed by now, 0 before the kick."""
        return np.where(np.isnan(self.sent), 0.0, self.heading() - self.sent)

    def judge(self, active: NDArray[np.bool_]) -> None:
        """Come by, taken or at rest: over; come by too far off: failed."""
        world = self.stage.core.sim.world
        gap, flies = world["pos"][:, 2] - world["pos"][:, 0], world["vel"][:, 0]
        rolls = np.hypot(*flies.T) > ROLLS
        kicked = np.hypot(*(world["pos"][:, 0] - world["pos"][:, 1]).T) > KICKED
        sends = active & kicked & rolls & np.isnan(self.sent)
        self.sent[sends] = self.heading()[sends]
        taken = np.hypot(*gap.T) < TAKEN
        by = kicked & rolls & ((gap * flies).sum(axis=1) <= 0.0)
        over = active & ~self.over & (taken | by | (kicked & ~rolls) | (self.cycles >= self.limit))
        self.came |= over & by & (np.abs(self.strayed()) > self.reach)
        self.over |= over

    def keep(self, world: int) -> Any:
        """The world with its passer, and where the kick sent the ball."""
        return super().keep(world), float(self.sent[world])

    def put(self, world: int, kept: Any, fresh: int) -> None:
        """Both again."""
        state, self.sent[world] = kept
        super().put(world, state, fresh)


ROLLS, KICKED, TAKEN = 0.1, 1.5, 1.2
"""m / cycle from which on a ball rolls; metres from the passer at which it is on its way, from the team-mate at which he has it."""


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
    return counted(StrayingBall(batch, kick), runs, seed, batch)


def counted(worlds: StrayingBall | StrayingPass, runs: int, seed: int, batch: int) -> Plain:
    """Failures among plain runs of worlds that can be copied, `batch` of them."""
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


def split_passes(runs: int = 1000, repetitions: int = 5, seed: int = 0, reach: float = REACH) -> SplitEstimate:
    """Passes that stray, the passer's net in every copy."""
    return split_worlds(lambda n: StrayingPass(n, reach), runs, repetitions, seed=seed)


def main() -> None:
    """Print an estimate by splitting, and what plain runs would take: ``python -m cprm_gym.benchmark.behaviours.straying``."""
    parser = argparse.ArgumentParser(description="Passes of a player's net that stray, by splitting.")
    parser.add_argument("--reach", type=float, default=REACH, help="metres by which it may stray")
    parser.add_argument("--runs", type=at_least(2), default=1000)
    parser.add_argument("--repetitions", type=at_least(2), default=5)
    parser.add_argument("--plain", type=at_least(0), default=0, help="plain runs beside them")
    parser.add_argument("--seed", type=at_least(0), default=0)
    options = parser.parse_args()
    found = split_passes(options.runs, options.repetitions, options.seed, options.reach)
    told = ", ".join(f"{e:.3g}" for e in found.estimates)
    print(f"split: {found.value:.3g} +- {found.deviation:.2g} {found.interval} ({told})")
    length = found.steps / options.runs / options.repetitions
    print(f"to 20 %: {found.steps_for(0.2):.3g} cycles; {found.steps:,} were played, {length:.0f} for each first run")
    few = counted(StrayingPass(500, options.reach), max(options.plain, 500), options.seed + 1, 500)
    each = few.cycles / few.runs
    print(f"plain to 20 %: {each * (1 - found.value) / found.value / 0.04 if found.value else math.inf:.3g} cycles, {each:.1f} each")
    if options.plain:
        print(f"plain: {few.failures} of {few.runs} {clopper_pearson(few.failures, few.runs)}")


if __name__ == "__main__":
    main()
