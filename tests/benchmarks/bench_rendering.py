"""CPU time of a picture of 920 x 654 pixels, everybody moving: python tests/benchmarks/bench_rendering.py"""

from __future__ import annotations

import statistics
import time

import numpy as np

from cprm_gym.envs.rendering import Viewer
from cprm_gym.simulator.simulator import Simulator


def main() -> None:
    world = Simulator(1, seed=1).world[0]
    rng = np.random.default_rng(1)
    world["pos"][1:] = rng.uniform((-50, -32), (50, 32), (22, 2))
    world["mode"], times = 3, []
    viewer = Viewer("rgb_array")
    for cycle in range(60):
        world["steps"] = world["time"] = cycle
        world["pos"] += rng.uniform(-0.5, 0.5, (23, 2))
        world["body"] += 0.1
        begin = time.process_time()
        viewer.draw(world)
        times.append(1e3 * (time.process_time() - begin))
    print(f"a picture of {' x '.join(map(str, viewer.size))}: {statistics.median(times[20:]):.2f} ms of CPU time")


if __name__ == "__main__":
    main()
