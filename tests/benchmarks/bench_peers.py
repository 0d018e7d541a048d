"""Our environments beside others, in one run: python tests/benchmarks/bench_peers.py [--seconds 0.4] [--rounds 5] [--only WORD] [--table]

Agent-steps per CPU second of one thread (OMP_NUM_THREADS=1). Every entry is made once; then each plays in turn for about so many seconds
of CPU time, round after round, so that a loaded machine hits all alike; medians over the rounds. An agent-step is one agent, whose action
somebody chooses, in one cycle; players whom an environment moves by itself are named and not counted. The last column says in what the work
differs: no two lines do equal work. What is not installed is left out and said: pip install vmas envpool mpe2.
"""

from __future__ import annotations

import argparse
import importlib
import statistics
import sys
import time
import types
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

ENDLESS = 10**9
OWN = "partial noisy sight, memory of it or none, stamina, all rules"
TRUE_STATE = "sees the true state, bodies without stamina or rules, no referee"


class Made(NamedTuple):
    """An environment that plays."""

    step: Callable[[], Any]
    agents: int
    """Agent-steps of a call."""


class Entry(NamedTuple):
    """A line of the table."""

    group: str
    text: str
    work: str
    make: Callable[[], Made]


def engine(task: str, worlds: int, **options: Any) -> Callable[[], Made]:
    """`SoccerCore` with all agents."""

    def make() -> Made:
        from cprm_gym.envs.core import SoccerCore
        from cprm_gym.envs.tasks import make_task

        core = SoccerCore(make_task(task, max_cycles=ENDLESS), worlds, **options)
        core.reset(1)
        rng, shape = np.random.default_rng(1), (worlds, len(core.agents))
        action = {"type": rng.integers(0, 3, shape), "params": rng.uniform(-1, 1, (*shape, 4))}
        return Made(lambda: core.step(action), shape[0] * shape[1])

    return make


def parallel(**options: Any) -> Callable[[], Made]:
    """A match as a PettingZoo environment."""

    def make() -> Made:
        from cprm_gym.envs import soccer_v2

        env = soccer_v2.parallel_env(max_cycles=ENDLESS, action_mode="discrete", **options)
        env.reset(seed=1)
        rng = np.random.default_rng(1)
        actions = {a: rng.integers(0, env.action_space(a).nvec) for a in env.agents}

        def step() -> None:
            env.step(actions)
            if not env.agents:  # the referee has ended the match
                env.reset()

        return Made(step, len(actions))

    return make


def vector(name: str, worlds: int, **options: Any) -> Callable[[], Made]:
    """A Gymnasium vector environment with discrete actions."""

    def make() -> Made:
        import gymnasium

        import cprm_gym  # noqa: F401

        envs: Any = gymnasium.make_vec(name, num_envs=worlds, vectorization_mode="vector_entry_point", **options)
        envs.reset(seed=1)
        actions = np.stack([envs.single_action_space.sample() for _ in range(worlds)])
        return Made(lambda: envs.step(actions), worlds)

    return make


def vmas(worlds: int, blue: int, red: int) -> Callable[[], Made]:
    """VMAS football on the CPU (torch)."""

    def make() -> Made:
        import torch
        from vmas import make_env

        torch.set_num_threads(1)
        env = make_env(
            "football", num_envs=worlds, device="cpu", continuous_actions=True, seed=1, max_steps=None, n_blue_agents=blue,
            n_red_agents=red, ai_red_agents=False,
        )  # fmt: skip
        env.reset()
        actions = [torch.rand(worlds, env.get_agent_action_size(a)) * 2 - 1 for a in env.agents]

        def step() -> None:
            with torch.no_grad():
                done = env.step(actions)[2]
                for world in done.nonzero().flatten().tolist():
                    env.reset_at(world)

        return Made(step, worlds * len(env.agents))

    return make


def envpool(name: str, worlds: int) -> Callable[[], Made]:
    """An environment of EnvPool (C++)."""

    def make() -> Made:
        # its other families want packages of assets: only the one that is played is registered
        sys.modules.setdefault("envpool.entry", types.ModuleType("envpool.entry"))
        pool: Any = importlib.import_module("envpool")
        importlib.import_module("envpool.classic_control.registration")
        env = pool.make(name, env_type="gymnasium", num_envs=worlds, num_threads=1)
        env.reset()
        actions = np.random.default_rng(1).integers(0, env.action_space.n, worlds).astype(np.int32)
        return Made(lambda: env.step(actions), worlds)

    return make


def mpe(module: str) -> Callable[[], Made]:
    """A particle world of MPE as a PettingZoo environment."""

    def make() -> Made:
        env = importlib.import_module(f"mpe2.{module}").parallel_env(max_cycles=ENDLESS)
        env.reset(seed=1)
        actions = {a: env.action_space(a).sample() for a in env.agents}
        return Made(lambda: env.step(actions), len(actions))

    return make


FULL_MATCH, SINGLE, SMALL = "11 against 11, all act", "11 against 11, one acts", "small worlds"
ENTRIES = (
    *(Entry(FULL_MATCH, f"SoccerCore, {w} worlds, raw", OWN, engine("Soccer11v11", w)) for w in (1, 64, 1024)),
    Entry(FULL_MATCH, "SoccerCore, 64 worlds, hfo_low", OWN, engine("Soccer11v11", 64, observation="hfo_low")),
    Entry(FULL_MATCH, "SoccerCore, 64 worlds, full", "true state, stamina, all rules", engine("Soccer11v11", 64, observation="full")),
    Entry(FULL_MATCH, "PettingZoo, hfo_low", OWN, parallel(observation="hfo_low")),
    *(Entry(FULL_MATCH, f"VMAS football, {w} worlds", TRUE_STATE, vmas(w, 11, 11)) for w in (1, 64, 1024)),
    *(
        Entry(SINGLE, f"vector, 64 worlds, others {o}", OWN, vector(
            "cprm/Soccer11v11-v2", 64, others=o, observation="raw", action_mode="discrete", max_cycles=ENDLESS))
        for o in ("hold", "medium")
    ),
    *(
        Entry(SMALL, f"GoToBall, vector, {w} worlds", "one player, no rules; partial noisy sight",
              vector("cprm/GoToBall-v2", w, observation="hfo_low", action_mode="discrete"))
        for w in (64, 1024)
    ),
    Entry(SMALL, "VMAS football 3 against 2, 1024 worlds", TRUE_STATE, vmas(1024, 3, 2)),
    Entry(SMALL, "MPE simple_spread", "3 points in the plane, no ball", mpe("simple_spread_v3")),
    Entry(SMALL, "EnvPool CartPole, 64 worlds", "one pole, compiled C++", envpool("CartPole-v1", 64)),
    Entry(SMALL, "Gymnasium CartPole, vector, 1024 worlds", "one pole: the floor of the interface", vector("CartPole-v1", 1024)),
)  # fmt: skip


def calls_per(step: Callable[[], Any], seconds: float) -> int:
    """How many calls take about so many seconds of CPU time; the first ones, which may compile, do not count."""
    for _ in range(3):
        step()
    begin, calls = time.process_time(), 0
    while calls < 2 or time.process_time() - begin < 0.05:
        step()
        calls += 1
    return max(1, int(seconds * calls / (time.process_time() - begin)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=0.4)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="", help="entries whose group or text holds this")
    parser.add_argument("--table", action="store_true", help="as a table of Markdown")
    options = parser.parse_args()
    warnings.filterwarnings("ignore")
    ready: list[tuple[Entry, Made, int, list[float]]] = []
    missing: list[str] = []
    for entry in ENTRIES:
        if options.only.lower() in f"{entry.group} {entry.text}".lower():
            try:
                made = entry.make()
                ready.append((entry, made, calls_per(made.step, options.seconds), []))
            except ImportError as error:
                missing.append(f"{entry.text}: {error}")
    for _ in range(options.rounds):
        for _, made, calls, rates in ready:
            begin = time.process_time()
            for _ in range(calls):
                made.step()
            rates.append(made.agents * calls / (time.process_time() - begin))
    line = "| {} | {} | {} | {} | {} |" if options.table else "{:24s} {:44s} {:>14s} {:>10s}  {}"
    print(line.format("", "environment", "agent-steps/s", "us of each", "in what the work differs"))
    if options.table:
        print("|---|---|---|---|---|")
    for entry, _, _, rates in ready:
        rate = statistics.median(rates)
        print(line.format(entry.group, entry.text, f"{rate:,.0f}", f"{1e6 / rate:.2f}", entry.work))
    for text in missing:
        print(f"left out: {text}")


if __name__ == "__main__":
    main()
