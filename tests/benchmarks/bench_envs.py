"""Speed of the environments beyond the kernels: python tests/benchmarks/bench_envs.py

CPU time of one process, medians of several runs; the last column is what is left after the simulator's own step and senses.
"""

from __future__ import annotations

import statistics
import time
from functools import partial

import gymnasium
import numpy as np

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.actions import NO_COMMAND
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.simulator import Simulator

RUNS = 7


def median_us(function, repeats: int) -> float:
    """Median over runs of CPU microseconds per call."""
    function()
    times = []
    for _ in range(RUNS):
        begin = time.process_time()
        for _ in range(repeats):
            function()
        times.append(1e6 * (time.process_time() - begin) / repeats)
    return statistics.median(times)


def kernels(worlds: int) -> float:
    """The simulator's step, see and sense_body of 11 against 11, per world."""
    sim = Simulator(worlds, seed=1)
    sim.commands[...] = NO_COMMAND[0]
    sim.world["mode"] = 3

    def cycle() -> None:
        sim.step()
        sim.see()
        sim.sense_body()

    return median_us(cycle, max(1, 2000 // worlds)) / worlds


def main() -> None:
    base = {n: kernels(n) for n in (1, 64)}
    rows = []

    run = {"type": 1, "params": np.array([0.5, 0, 0, 0], np.float32), "turn_neck": np.zeros(1, np.float32), "view": 0}
    for copy, name in ((True, "Parallel, 22 agents, hybrid, per step"), (False, "the same with copy=False")):
        env = soccer_v2.parallel_env(action_mode="hybrid", max_cycles=10**9, copy=copy)
        env.reset(seed=1)
        actions = {agent: dict(run) for agent in env.agents}
        rows.append((name, median_us(partial(env.step, actions), 500), base[1]))

    single = gymnasium.make("cprm/Soccer11v11-v2", others="hold", max_cycles=10**9).unwrapped
    single.reset(seed=1)
    move = np.array([1, 2, 11, 0])
    rows.append(("Gymnasium, one agent of 11 v 11, per step", median_us(lambda: single.step(move), 1000), base[1]))

    small = gymnasium.make("cprm/GoToBall-v2", max_cycles=10**9).unwrapped
    small.reset(seed=1)
    away = np.array([0, 0, 0, 0])
    rows.append(("Gymnasium, GoToBall, per step", median_us(lambda: small.step(away), 2000), 0.0))

    envs = gymnasium.make_vec("cprm/Soccer11v11-v2", num_envs=64, others="hold", max_cycles=10**9, copy=False)
    envs.reset(seed=1)
    many = np.tile(move, (64, 1))
    rows.append(("vector, 64 worlds of 11 v 11, one agent each, per world", median_us(lambda: envs.step(many), 30) / 64, base[64]))

    core = SoccerCore(make_task("Soccer11v11", max_cycles=10**9), 64)
    core.reset(1)
    all_actions = {"type": np.ones((64, 22), int), "params": np.full((64, 22, 4), 0.3)}
    per_world = median_us(lambda: core.step(all_actions), 30) / 64
    rows.append(("batch, 64 worlds of 11 v 11, all 22 agents, per world", per_world, base[64]))

    print(f"{'what':62s} {'CPU us':>9s} {'kernels':>9s} {'beyond':>9s}")
    for name, total, kernel in rows:
        print(f"{name:62s} {total:9.1f} {kernel:9.1f} {total - kernel:9.1f}")
    print(f"batch of 64: {22e6 / per_world:,.0f} agent-steps per CPU second")


if __name__ == "__main__":
    main()
