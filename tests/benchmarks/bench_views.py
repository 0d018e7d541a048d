"""What learners run: feature views, resets, opponents, memory: python tests/benchmarks/bench_views.py [--against CHECKOUT] [--only PART]

CPU microseconds per world and cycle of 11 against 11, one thread. With ``--against`` the same file runs in turn on another checkout of the
project and on this one, so that a loaded machine hits both alike; medians over the rounds.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import statistics
import subprocess
import sys
import time
import tracemalloc
from functools import partial
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve()
PRESETS = ("raw", "normalised", "memory", "full", "hfo_low", "hfo_high", "keepaway")
ENDLESS = 10**9
EPISODE = 40


def median_us(function, repeats: int, runs: int = 3) -> float:
    """Median over runs of CPU microseconds per call."""
    function()
    times = []
    for _ in range(runs):
        begin = time.process_time()
        for _ in range(repeats):
            function()
        times.append(1e6 * (time.process_time() - begin) / repeats)
    return statistics.median(times)


def running(worlds: int, **options):
    """A batch of matches in which all agents act, some cycles after the kick-off, and a call that plays a cycle of it."""
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task

    core = SoccerCore(make_task("Soccer11v11", max_cycles=ENDLESS), worlds, **options)
    core.reset(1)
    rng = np.random.default_rng(1)
    shape = (worlds, len(core.agents))
    actions = [
        {"type": rng.integers(0, 3, shape), "params": rng.uniform(-1, 1, (*shape, 4)).astype(np.float32)} for _ in range(16)
    ]  # fmt: skip
    count = [0]

    def cycle() -> None:
        count[0] += 1
        core.step(actions[count[0] % 16])

    for _ in range(20):
        cycle()
    return core, cycle


def views() -> dict[str, float]:
    """Every view for all 22 agents, 64 worlds and one world alone."""
    figures = {}
    for worlds, repeats in ((64, 10), (1, 150)):
        for name in PRESETS:
            include = ("memory",) if name == "memory" else ()
            _, cycle = running(worlds, observation="raw" if name == "memory" else name, include=include)
            figures[f"view {name}, {worlds} worlds"] = median_us(cycle, repeats) / worlds
    return figures


def defaults() -> dict[str, float]:
    """What learners ask for: one vector of ``raw``, of the default and of ``hfo_low``, per agent and cycle of random play with resets."""
    from cprm_gym.envs.core import SoccerCore

    figures = {}
    for task, worlds in (("GoToBall", 256), ("HFO1v1", 256), ("Soccer11v11", 16)):
        for name in ("raw", "normalised", "hfo_low"):
            core = SoccerCore(task, worlds, action_mode="discrete", observation=name, flatten=True)
            core.reset(1)
            rng, agents = np.random.default_rng(1), len(core.agents)
            actions = [rng.integers(0, [6, 5, 24, 5], (worlds, agents, 4)) for _ in range(16)]
            count = [0]

            def cycle(core=core, actions=actions, count=count) -> None:
                count[0] += 1
                step = core.step(actions[count[0] % 16])
                over = step.terminated | step.truncated
                if over.any():
                    core.reset(None, over)

            figures[f"{task}, {name}"] = median_us(cycle, 60) / worlds / agents
    return figures


def resets() -> dict[str, float]:
    """GoToBall in 64 worlds: endless episodes, episodes of 40 cycles that end at different times, and one reset."""
    import gymnasium

    import cprm_gym  # noqa: F401

    figures = {}
    for preset in ("raw", "hfo_low"):
        for name, cycles in (("endless", ENDLESS), ("staggered", EPISODE)):
            envs = gymnasium.make_vec(
                "cprm/GoToBall-v2", num_envs=64, max_cycles=cycles, copy=False, observation=preset,
                vector_kwargs=None, autoreset_mode="SameStep",
            )  # fmt: skip
            envs.reset(seed=1)
            envs.unwrapped.core.cycle[:] = np.arange(64) % EPISODE
            still = np.zeros((64, 4), int)
            figures[f"GoToBall {preset}, {name}"] = median_us(partial(envs.step, still), 80) / 64
        core = envs.unwrapped.core
        figures[f"reset of one world of 64, {preset}"] = median_us(partial(core.reset, None, np.array([7])), 40)
    return figures


def opponents() -> dict[str, float]:
    """One agent among scripted players, 64 worlds."""
    teams = ("hold", "weak", "medium", "strong")
    return {f"others {name}": median_us(running(64, controlled="left_1", others=name)[1], 12) / 64 for name in teams}


def memory() -> dict[str, float]:
    """Bytes of a world, and speed in and beyond the cache."""
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task

    figures = {}
    for name in ("GoToBall", "Soccer11v11"):
        held = []
        for worlds in (20, 40):
            gc.collect()
            tracemalloc.start()
            core = SoccerCore(make_task(name, max_cycles=ENDLESS), worlds)
            core.reset(1)
            core.step({"type": np.ones((worlds, len(core.agents)), int), "params": np.zeros((worlds, len(core.agents), 4))})
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])
            tracemalloc.stop()
            del core
        figures[f"bytes of a world of {name}"] = (held[1] - held[0]) / 20
    for worlds in (100, int(os.environ.get("BENCH_WORLDS", "4000"))):
        core = SoccerCore(make_task("GoToBall", max_cycles=ENDLESS), worlds)
        core.reset(1)
        actions = {"type": np.zeros((worlds, 1), int), "params": np.zeros((worlds, 1, 4))}
        figures[f"GoToBall, {worlds} worlds"] = median_us(partial(core.step, actions), max(1, 2000 // worlds), 3) / worlds
    return figures


def learning() -> dict[str, float]:
    """The environment's share, per cent, of PPO on one thread: one agent of GoToBall in 64 worlds, 22 agents of a PettingZoo match."""
    import torch
    from stable_baselines3 import PPO

    from cprm_gym.envs import soccer_v2
    from cprm_gym.wrappers.sb3 import ParallelVecEnv, SoccerVecEnv

    torch.set_num_threads(1)
    figures = {}
    makers = {
        "GoToBall hfo_low": lambda: SoccerVecEnv("GoToBall", worlds=64, observation="hfo_low"),
        "Parallel hfo_low": lambda: ParallelVecEnv(lambda: soccer_v2.parallel_env(observation="hfo_low", action_mode="discrete"), 3),
    }
    for name, make in makers.items():
        env = make()
        spent = [0.0]
        step = env.step_wait

        def timed(step=step, spent=spent):
            begin = time.process_time()
            result = step()
            spent[0] += time.process_time() - begin
            return result

        env.step_wait = timed
        learner = PPO("MlpPolicy", env, n_steps=64, batch_size=256, seed=1, device="cpu")
        learner.learn(64 * env.num_envs)
        spent[0], begin = 0.0, time.process_time()
        learner.learn(3 * 64 * env.num_envs)
        figures[f"share of {name}"] = 100 * spent[0] / (time.process_time() - begin)
    return figures


PARTS = {"defaults": defaults, "views": views, "resets": resets, "opponents": opponents, "memory": memory, "learning": learning}


def measured(checkout: Path, parts: list[str]) -> dict[str, float]:
    """The figures of a checkout, from a process of its own."""
    path = os.pathsep.join([str(checkout), str(checkout / "baselines")])
    threads = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "MKL", "OPENBLAS", "NUMBA")}
    run = subprocess.run(
        [sys.executable, str(HERE), "--figures", "--only", ",".join(parts)], env={**os.environ, **threads, "PYTHONPATH": path},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    figures: dict[str, float] = json.loads(run.stdout.splitlines()[-1])
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--against", type=Path, help="another checkout, measured in turn with this one")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="views,resets,opponents,memory", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--figures", action="store_true", help="one run of what is on the path, as JSON")
    options = parser.parse_args()
    parts = options.only.split(",")
    if options.figures:
        print(json.dumps({name: value for part in parts for name, value in PARTS[part]().items()}))
        return
    checkouts = [*([options.against.resolve()] if options.against else []), HERE.parents[2]]
    runs: list[list[dict[str, float]]] = [[] for _ in checkouts]
    for _ in range(options.rounds):
        for checkout, found in zip(checkouts, runs):
            found.append(measured(checkout, parts))
    heads = (["before"] if options.against else []) + ["now"]
    print(f"{'':44s}" + "".join(f"{head:>10s}" for head in heads))
    for name in runs[-1][0]:
        print(f"{name:44s}" + "".join(f"{statistics.median(one[name] for one in found):10.1f}" for found in runs))


if __name__ == "__main__":
    main()
