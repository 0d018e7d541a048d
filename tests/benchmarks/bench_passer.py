"""What a decision of the passing pair costs, alone and in batches, and how much of it is inference.

python tests/benchmarks/bench_passer.py [copies ...]
"""

from __future__ import annotations

import sys
import time

import numpy as np
from cpu_time import timed

from cprm_gym.agents.passer import make_controller
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task

CYCLES, WARM = 200, 50


def measure(copies: int) -> tuple[float, float, float, float]:
    """CPU milliseconds per decision: mean, its inference, median and 99th percentile over the cycles after the first `WARM`."""
    core = SoccerCore(make_task("PassAndAdvance"), copies, seed=3, include=("memory",))
    players = [make_controller(core.task, agent) for agent in core.agents]
    observation = core.reset(3)
    inferring = [0.0]
    for i, player in enumerate(players):
        player.reset({key: value[:, i] for key, value in observation.items()}, 3)
        player.controller._infer = timed(player.controller._infer, inferring)
    spent = []
    for cycle in range(CYCLES):
        if cycle == WARM:
            inferring[0] = 0.0
        start = time.process_time()
        actions = [player.act({key: value[:, i] for key, value in observation.items()}) for i, player in enumerate(players)]
        spent.append(1e3 * (time.process_time() - start) / len(players) / copies)
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        over = step.terminated | step.truncated
        if over.any():
            observation = core.reset(worlds=over)
            for i, player in enumerate(players):
                player.reset({key: value[:, i] for key, value in observation.items()}, 3, over)
    decisions = (CYCLES - WARM) * len(players) * copies
    late = np.array(spent[WARM:])
    return float(late.mean()), 1e3 * inferring[0] / decisions, float(np.median(late)), float(np.percentile(late, 99))


def main(sizes: list[int]) -> None:
    """Print the table."""
    print(f"{'copies':>8}{'ms/decision':>14}{'inference':>12}{'median':>10}{'99 %':>10}   (CPU time)")
    for copies in sizes:
        print(f"{copies:8}" + "{:14.3f}{:12.3f}{:10.3f}{:10.3f}".format(*measure(copies)), flush=True)


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [1, 10, 250])
