"""Recovery measured: the passing pair with and without its recovery parts under each disturbance (dissertation ch. 4).

``python -m cprm_gym.benchmark.recovery --episodes 1000`` prints the table.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..agents.passer import make_controller
from ..envs.controller import Controller
from ..envs.core import SoccerCore
from ..envs.tasks import Task, make_task
from ..simulator.state import Count
from ..wrappers.disturbances import DISTURBANCES, Disturbance, Disturber
from .statistics import Interval, wilson_interval

BLOCK = 250
"""Episodes played as one batch."""

Factory = Callable[[Task, str], Controller]


@dataclass(frozen=True)
class Recovery:
    """What a controller made of a disturbance.

    Attributes
    ----------
    success : (N,) bool array
        The task was done.
    struck : (N,) bool array
        The disturbance came before the end of the episode.
    time : (N,) float array
        Cycles from the strike until an agent kicked the ball again, that is, until the pair had the ball; NaN where nobody did.
    cycles : (N,) int array
        Length of the episode.
    """

    success: np.ndarray
    struck: np.ndarray
    time: np.ndarray
    cycles: np.ndarray

    @property
    def interval(self) -> Interval:
        """Wilson interval of the rate of success."""
        return wilson_interval(int(self.success.sum()), len(self.success))

    @property
    def recovered(self) -> tuple[int, int]:
        """Episodes in which the pair had the ball again, and those that were struck."""
        return int(np.isfinite(self.time[self.struck]).sum()), int(self.struck.sum())

    @property
    def median_time(self) -> float:
        """Median of the cycles until it had the ball again, where it did; NaN if it never did."""
        times = self.time[self.struck & np.isfinite(self.time)]
        return float(np.median(times)) if len(times) else float("nan")


def measure(factory: Factory, disturbance: Disturbance | None, episodes: int = 1000, seed: int = 0, task: Task | None = None) -> Recovery:
    """Play episodes with a disturbance (or none); every controller meets the same worlds and the same strikes.

    Parameters
    ----------
    factory : callable
        (task, agent) -> controller, called once for each agent.
    disturbance : Disturbance, optional
    episodes, seed : int
    task : Task, optional
        PassAndAdvance by default.
    """
    task = task or make_task("PassAndAdvance")
    parts = [_block(factory, disturbance, min(BLOCK, episodes - first), first, seed, task) for first in range(0, episodes, BLOCK)]
    return Recovery(*(np.concatenate([getattr(part, key) for part in parts]) for key in ("success", "struck", "time", "cycles")))


def _block(factory: Factory, disturbance: Disturbance | None, count: int, first: int, seed: int, task: Task) -> Recovery:
    core = SoccerCore(task, count, seed=seed, first_world=first, include=("memory",))
    players = [factory(task, agent) for agent in core.agents]
    observation = core.reset(seed)
    for i, player in enumerate(players):
        player.reset({key: value[:, i] for key, value in observation.items()}, seed)
    disturber = Disturber(core, disturbance, seed) if disturbance else None
    running, success = np.ones(count, bool), np.zeros(count, bool)
    cycles, struck, time = np.zeros(count, np.int64), np.zeros(count, bool), np.full(count, np.nan)
    rows = core.players - 1
    while running.any():
        if disturber:
            disturber()
            struck |= running & (disturber.struck >= 0)
        before = core.sim.world["counts"][:, rows, Count.KICK].sum(axis=1)
        actions = [player.act({key: value[:, i] for key, value in observation.items()}) for i, player in enumerate(players)]
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        kicked = core.sim.world["counts"][:, rows, Count.KICK].sum(axis=1) > before
        if disturber:
            over = core.cycle - disturber.struck >= disturber.disturbance.duration
            again = running & struck & kicked & over & np.isnan(time)
            time[again] = (core.cycle - disturber.struck)[again]
        cycles += running
        success |= running & step.success
        running &= ~(step.terminated | step.truncated)
    return Recovery(success, struck, time, cycles)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Recovery of the passing pair, with and without its recovery parts.")
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(f"PassAndAdvance, {options.episodes} episodes, seed {options.seed}; success with its Wilson interval (95 %)")
    print(f"{'disturbance':18}{'recovering':28}{'without':28}{'ball again':>14}{'without':>14}{'cycles':>8}{'without':>8}")
    for name, disturbance in ((("none", None)), *DISTURBANCES.items()):
        results = [
            measure(partial(make_controller, recovering=recovering), disturbance, options.episodes, options.seed)
            for recovering in (True, False)
        ]
        cells = [f"{r.success.mean():6.1%} [{r.interval.low:.1%}, {r.interval.high:.1%}]" for r in results]
        again = ["{}/{}".format(*r.recovered) if disturbance else "" for r in results]
        times = [f"{r.median_time:.0f}" if disturbance else "" for r in results]
        print(f"{name:18}{cells[0]:28}{cells[1]:28}{again[0]:>14}{again[1]:>14}{times[0]:>8}{times[1]:>8}", flush=True)


if __name__ == "__main__":
    main()
