"""Keepaway by the three policies of the literature: how long do they keep the ball?

    python -m cprm_baselines.keepaway                     3v2 in 20 x 20 m, with senses and with full state, beside the published means
    python -m cprm_baselines.keepaway --task Keepaway4v3 --episodes 200

The keepers are the scripted policies ``keep_random``, ``keep_hold`` and ``keep_hand`` of `cprm_gym.envs.players.scripted`, the takers
``take``.
"""

from __future__ import annotations

import argparse
import math
from typing import NamedTuple

import numpy as np

from cprm_gym.benchmark.arguments import at_least
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task

POLICIES = ("keep_random", "keep_hold", "keep_hand")
PUBLISHED = {"keep_random": 6.61, "keep_hold": 16.66, "keep_hand": 32.93}
"""Mean seconds of 3v2 in 20 x 20 m with full state, from the logs that come with aabayomi/keepaway (server of 2016)."""
CYCLES_PER_SECOND = 10.0


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
    made = make_task(task, full_state=full_state, max_cycles=longest)
    core = SoccerCore(made, episodes, controlled=(), others=(policy, "take"))
    core.reset(seed)
    length = np.zeros(episodes, np.int64)
    while not length.all():
        step = core.step(None)
        over = (step.terminated | step.truncated) & (length == 0)
        length[over] = core.cycle[over]
    seconds = length / CYCLES_PER_SECOND
    return Durations(policy, float(seconds.mean()), float(seconds.std(ddof=1)), episodes)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="Keepaway3v2")
    parser.add_argument("--episodes", type=at_least(1), default=300)
    parser.add_argument("--seed", type=at_least(0), default=0)
    arguments = parser.parse_args()
    print(f"{arguments.task}, mean seconds +- standard error of {arguments.episodes} episodes")
    print(f"{'policy':12s} {'senses':>14s} {'full state':>14s} {'published':>10s}")
    for policy in POLICIES:
        sensed, full = (durations(policy, arguments.task, f, arguments.episodes, arguments.seed) for f in (False, True))
        published = f"{PUBLISHED[policy]:10.1f}" if arguments.task == "Keepaway3v2" else f"{'':>10s}"
        print(f"{policy:12s} {sensed.mean:7.1f} +-{sensed.error:4.1f} {full.mean:8.1f} +-{full.error:4.1f} {published}")


if __name__ == "__main__":
    main()
