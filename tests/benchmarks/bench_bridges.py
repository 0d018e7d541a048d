"""Speed of the bridges, 11 against 11, all agents acting at random: python tests/benchmarks/bench_bridges.py

Agent-steps per CPU second of one process and one thread, the best of several runs; what is not installed is left out. VMAS's football is
its own scenario of 11 against 11 (discs that move at will and know the state), with as many worlds and with 1,024, which suit it best.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from cprm_gym.bridges.buffers import SoccerBuffers
from cprm_gym.bridges.worlds import AgentWorlds
from cprm_gym.envs.presets import PRESETS

AGENTS, RUNS, KEPT = 22, 5, 8


def best(step: Callable[[int], Any], worlds: int, repeats: int) -> float:
    """Million agent-steps per CPU second, of the best run."""
    for k in range(KEPT):
        step(k)
    times = []
    for _ in range(RUNS):
        begin = time.process_time()
        for k in range(repeats):
            step(k % KEPT)
        times.append(time.process_time() - begin)
    return worlds * AGENTS * repeats / min(times) / 1e6


def chosen(worlds: int) -> list[np.ndarray]:
    """Random discrete actions, (worlds, 22, 4) each."""
    rng = np.random.default_rng(0)
    return [rng.integers(0, [6, 5, 24, 5], size=(worlds, AGENTS, 4)) for _ in range(KEPT)]


def engine(worlds: int, repeats: int, **options: Any) -> float:
    """Arrays of the engine, without copies."""
    env = AgentWorlds(worlds, "Soccer11v11", controlled="all", **options)
    env.reset(0)
    actions = chosen(worlds)
    return best(lambda k: env.core.step(actions[k]), worlds, repeats)


def buffers(worlds: int, repeats: int, **options: Any) -> float:
    """Rows of flat buffers."""
    env = SoccerBuffers(worlds, "Soccer11v11", controlled="all", **options)
    env.reset(0)
    actions = [a.reshape(-1, 4) for a in chosen(worlds)]
    return best(lambda k: env.step(actions[k]), worlds, repeats)


def torchrl(worlds: int, repeats: int, **options: Any) -> float:
    """Tensors, stepped and begun anew by TorchRL."""
    import torch

    from cprm_gym.bridges.torchrl_env import SoccerTorchEnv

    torch.set_num_threads(1)
    env = SoccerTorchEnv(worlds, "Soccer11v11", controlled="all", seed=0, **options)
    actions = [env.action_spec.rand() for _ in range(KEPT)]
    now = [env.reset()]

    def step(k: int) -> None:
        now[0].update(actions[k])
        now[0] = env.step_and_maybe_reset(now[0])[1]

    return best(step, worlds, repeats)


def rllib(worlds: int, repeats: int, **options: Any) -> float:
    """Dicts of agents, as RLlib's runner takes them."""
    from cprm_gym.bridges.rllib_env import SoccerVectorMultiAgentEnv

    env = SoccerVectorMultiAgentEnv(worlds, {"task": "Soccer11v11", "controlled": "all", "action_mode": "discrete", **options})
    env.reset(seed=0)
    actions = [[dict(zip(env.agents, world)) for world in a] for a in chosen(worlds)]
    return best(lambda k: env.step(actions[k]), worlds, repeats)


def vmas(worlds: int, repeats: int) -> float:
    """VMAS's football, 11 against 11."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    env = make_env("football", worlds, device="cpu", seed=0, n_blue_agents=11, n_red_agents=11, ai_red_agents=False)
    env.reset()
    actions = [[env.get_random_action(agent) for agent in env.agents] for _ in range(KEPT)]
    return best(lambda k: env.step(actions[k]), worlds, repeats)


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=20)
    arguments = parser.parse_args()
    sizes = arguments.worlds, arguments.repeats
    views = [("raw", {"observation": "raw", "flatten": True})]
    if "normalised" in PRESETS:
        views.append(("normalised (default)", {"observation": "normalised", "flatten": True}))
    rows: list[tuple[str, str, float]] = []
    for view, options in views:
        rows.append(("engine", view, engine(*sizes, **options)))
        rows.append(("flat buffers", view, buffers(*sizes, **options)))
        if find_spec("torchrl"):
            rows.append(("TorchRL", view, torchrl(*sizes, **options)))
            rows.append(("TorchRL without `state`", view, torchrl(*sizes, state=False, **options)))
        if find_spec("ray"):
            rows.append(("RLlib", view, rllib(*sizes, **options)))
    if find_spec("vmas"):
        for worlds, repeats in (sizes, (1024, 4)):
            rows.append((f"VMAS football, {worlds} worlds", "its own", vmas(worlds, repeats)))
    print("| 11 v 11 | view | M agent-steps per CPU s |\n|---|---|---|")
    for name, view, speed in rows:
        print(f"| {name} | {view} | {speed:.3f} |")


if __name__ == "__main__":
    main()
