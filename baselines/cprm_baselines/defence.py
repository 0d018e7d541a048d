"""The defence of half fields: how often does a scripted attack score against it?

    python -m cprm_baselines.defence                                            the strong attack of HFO2v2 against cprm, strong and medium
    python -m cprm_baselines.defence --task HFO3v3 --defences cprm,strong --episodes 1000

Defences are scripted policies and controllers; all meet the same worlds, and the difference to the first is paired.
"""

from __future__ import annotations

import argparse

import numpy as np

from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.statistics import paired_difference, wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import Status, make_task


def goals(attack: str, defence: str, task: str, episodes: int, seed: int) -> np.ndarray:
    """(episodes,) bool: an attack scored against a defence, in each of so many worlds."""
    core = SoccerCore(make_task(task), episodes, controlled=(), others=(attack, defence))
    core.reset(seed)
    scored, over = np.zeros(episodes, bool), np.zeros(episodes, bool)
    while not over.all():
        step = core.step(None)
        scored |= ~over & (step.status == Status.GOAL)
        over |= step.terminated | step.truncated
    return scored


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="HFO2v2")
    parser.add_argument("--attack", default="strong")
    parser.add_argument("--defences", default="cprm,strong,medium")
    parser.add_argument("--episodes", type=at_least(1), default=300)
    parser.add_argument("--seed", type=at_least(0), default=0)
    given = parser.parse_args()
    names = given.defences.split(",")
    found = {name: goals(given.attack, name, given.task, given.episodes, given.seed) for name in names}
    print(f"{given.task}, {given.attack} attacks, {given.episodes} worlds of seed {given.seed}\n")
    print(f"| defence | goals against it %, Wilson 95 % | less {names[0]}, paired 95 % |\n|---|---|---|")
    for name, scored in found.items():
        low, high = wilson_interval(int(scored.sum()), given.episodes)
        less = paired_difference(scored, found[names[0]])
        said = "" if name == names[0] else f"{100 * less.mean:+.1f} ({100 * less.low:+.1f}, {100 * less.high:+.1f})"
        print(f"| {name} | {100 * scored.mean():.1f} ({100 * low:.1f} - {100 * high:.1f}) | {said} |")


if __name__ == "__main__":
    main()
