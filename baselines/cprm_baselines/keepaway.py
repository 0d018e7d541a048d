"""Keepaway by the three policies of the literature: how long do they keep the ball?

    python -m cprm_baselines.keepaway                     3v2 in 20 x 20 m, with senses and with full state, beside the published means
    python -m cprm_baselines.keepaway --task Keepaway4v3 --episodes 200
    python -m cprm_baselines.keepaway --controllers cprm,code --episodes 1000      controllers beside `keep_hand`, with its senses
    python -m cprm_baselines.keepaway --takers cprm,code --keepers keep_hold       takers beside `take`, against scripted keepers

The keepers are the scripted policies ``keep_random``, ``keep_hold`` and ``keep_hand`` of `cprm_gym.envs.players.scripted`, the takers
``take``.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.statistics import Interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.others.registry import load_controller
from cprm_gym.envs.tasks import make_task

POLICIES = ("keep_random", "keep_hold", "keep_hand")
PUBLISHED = {"keep_random": 6.61, "keep_hold": 16.66, "keep_hand": 32.93}
"""Mean seconds of 3v2 in 20 x 20 m with full state, from the logs that come with aabayomi/keepaway (server of 2016)."""
CYCLES_PER_SECOND = 10.0
NORMAL = 1.96
"""Standard errors of a 95 % interval."""


class Durations(NamedTuple):
    """Seconds for which a policy kept the ball."""

    policy: str
    mean: float
    deviation: float
    episodes: int

    @property
    def error(self) -> float:
        """Standard error of the mean."""
        return self.deviation / math.sqrt(self.episodes)


def seconds(policy: str, task: str, full_state: bool, episodes: int, seed: int, longest: int = 6000, takers: str = "take") -> np.ndarray:
    """(episodes,) seconds for which a scripted policy kept the ball from `takers` in each of so many worlds."""
    made = make_task(task, full_state=full_state, max_cycles=longest)
    core = SoccerCore(made, episodes, controlled=(), others=(policy, takers))
    core.reset(seed)
    length = np.zeros(episodes, np.int64)
    while not length.all():
        step = core.step(None)
        over = (step.terminated | step.truncated) & (length == 0)
        length[over] = core.cycle[over]
    return length / CYCLES_PER_SECOND


def durations(
    policy: str, task: str = "Keepaway3v2", full_state: bool = False, episodes: int = 300, seed: int = 0, longest: int = 6000
) -> Durations:
    """Play `episodes` worlds to their ends.

    Parameters
    ----------
    policy : str
        Of the keepers.
    task : str
    full_state : bool
        Players know the truth instead of what they perceive.
    episodes : int
    seed : int
    longest : int
        Cycles after which an episode is stopped.
    """
    found = seconds(policy, task, full_state, episodes, seed, longest)
    return Durations(policy, float(found.mean()), float(found.std(ddof=1)), episodes)


def beside_hand(
    controllers: Sequence[str], task: str, episodes: int, seed: int, longest: int = 6000
) -> list[tuple[Durations, float, Interval]]:
    """How long controllers keep the ball, and by how much longer than ``keep_hand`` with the same senses in the same worlds, paired."""
    hand, found = seconds("keep_hand", task, False, episodes, seed, longest), []
    for name in controllers:
        kept = play_episodes(make_task(task, max_cycles=longest), load_controller(name), episodes, seed).cycles / CYCLES_PER_SECOND
        more = Durations(name, float((kept - hand).mean()), float((kept - hand).std(ddof=1)), episodes)
        interval = Interval(more.mean - NORMAL * more.error, more.mean + NORMAL * more.error)
        found.append((Durations(name, float(kept.mean()), float(kept.std(ddof=1)), episodes), more.mean, interval))
    return found


def beside_take(
    takers: Sequence[str], keepers: str, task: str, episodes: int, seed: int, longest: int = 6000
) -> list[tuple[Durations, float, Interval]]:
    """How long scripted keepers keep the ball from takers, and by how much longer than from ``take`` in the same worlds, paired."""
    take, found = seconds(keepers, task, False, episodes, seed, longest), []
    for name in takers:
        kept = seconds(keepers, task, False, episodes, seed, longest, name)
        more = Durations(name, float((kept - take).mean()), float((kept - take).std(ddof=1)), episodes)
        interval = Interval(more.mean - NORMAL * more.error, more.mean + NORMAL * more.error)
        found.append((Durations(name, float(kept.mean()), float(kept.std(ddof=1)), episodes), more.mean, interval))
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="Keepaway3v2")
    parser.add_argument("--episodes", type=at_least(1), default=300)
    parser.add_argument("--seed", type=at_least(0), default=0)
    parser.add_argument("--controllers", help="instead of the policies: controllers, separated by commas")
    parser.add_argument("--takers", help="instead of the policies: takers, separated by commas")
    parser.add_argument("--keepers", default="keep_hand", choices=POLICIES, help="from whom takers take the ball")
    arguments = parser.parse_args()
    if arguments.controllers or arguments.takers:
        task, episodes, seed = arguments.task, arguments.episodes, arguments.seed
        rival = "keep_hand" if arguments.controllers else "take"
        print(f"{task}, mean seconds +- standard error of {episodes} episodes; longer than {rival} by, paired 95 %")
        if arguments.controllers:
            rows = beside_hand(arguments.controllers.split(","), task, episodes, seed)
        else:
            rows = beside_take(arguments.takers.split(","), arguments.keepers, task, episodes, seed)
        for kept, more, interval in rows:
            print(f"{kept.policy:14s} {kept.mean:6.1f} +-{kept.error:4.1f} {more:+7.1f} ({interval.low:+.1f}, {interval.high:+.1f})")
        return
    print(f"{arguments.task}, mean seconds +- standard error of {arguments.episodes} episodes")
    print(f"{'policy':12s} {'senses':>14s} {'full state':>14s} {'published':>10s}")
    for policy in POLICIES:
        sensed, full = (durations(policy, arguments.task, f, arguments.episodes, arguments.seed) for f in (False, True))
        published = f"{PUBLISHED[policy]:10.1f}" if arguments.task == "Keepaway3v2" else f"{'':>10s}"
        print(f"{policy:12s} {sensed.mean:7.1f} +-{sensed.error:4.1f} {full.mean:8.1f} +-{full.error:4.1f} {published}")


if __name__ == "__main__":
    main()
