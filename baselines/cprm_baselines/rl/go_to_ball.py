"""Four learners on an easy GoToBall: how much of it do they learn in a minute or two?

    python -m cprm_baselines.rl.go_to_ball                    all four, a table
    python -m cprm_baselines.rl.go_to_ball --learner sac      one of ppo, maskable_ppo, sac, shared_ppo

The ball lies still 4 to 12 m away (10 to 20 m for macros) in any direction. Success is measured with the policy's own randomness
before and after learning, on worlds that learning did not see.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from cprm_gym.benchmark.arguments import at_least
from cprm_gym.envs import soccer_v2
from cprm_gym.wrappers.sb3 import ParallelVecEnv, SoccerVecEnv

EASY = {"near": 4.0, "far": 12.0, "rolling": 0.0, "max_cycles": 40}
"""Fields of the task."""
FARTHER = {"near": 10.0, "far": 20.0, "rolling": 0.0, "max_cycles": 30}
"""For macros, with which chance alone often reaches a near ball."""
SHAPED = {"observation": "hfo_low", "reward": {"to_ball": 1.0}, "reward_gamma": 0.95}
UNFAMILIAR = 10_000
"""Seed of the worlds in which success is measured."""


class Learning(NamedTuple):
    """What learning brought."""

    learner: str
    before: float
    """Success rate of the policy before it learned."""
    after: float
    episodes: int
    """Behind each of the two."""
    steps: int
    """Agent-steps learned from."""
    seconds: float
    """Processor time of the learning."""


def success_rate(model: Any, env: Any, episodes: int, masks: bool = False) -> float:
    """Share of episodes that end with success; the policy draws its actions."""
    env.seed(UNFAMILIAR)
    observation = env.reset()
    won: list[bool] = []
    while len(won) < episodes:
        options = {"action_masks": np.stack(env.env_method("action_masks"))} if masks else {}
        actions, _ = model.predict(observation, deterministic=False, **options)
        observation, _, dones, infos = env.step(actions)
        won += [bool(infos[i]["is_success"]) for i in np.flatnonzero(dones)]
    return float(np.mean(won))


def _ppo(seed: int) -> tuple[Any, Any]:
    from stable_baselines3 import PPO

    env = SoccerVecEnv("GoToBall", worlds=32, action_mode="discrete", task_options=EASY, seed=seed, **SHAPED)
    return PPO("MlpPolicy", env, n_steps=64, batch_size=512, n_epochs=6, gamma=0.95, learning_rate=1e-3, ent_coef=0.001, seed=seed,
               device="cpu"), env  # fmt: skip


def _maskable_ppo(seed: int) -> tuple[Any, Any]:
    from sb3_contrib import MaskablePPO

    env = SoccerVecEnv("GoToBall", worlds=32, action_mode="macro", task_options=FARTHER, seed=seed, **SHAPED)
    return MaskablePPO("MlpPolicy", env, n_steps=32, batch_size=256, n_epochs=6, gamma=0.95, learning_rate=1e-3, seed=seed,
                       device="cpu"), env  # fmt: skip


def _sac(seed: int) -> tuple[Any, Any]:
    from stable_baselines3 import SAC

    env = SoccerVecEnv("GoToBall", worlds=32, action_mode="box", task_options=EASY, seed=seed, **SHAPED)
    return SAC("MlpPolicy", env, learning_starts=1000, batch_size=256, train_freq=1, gradient_steps=16, gamma=0.95, learning_rate=1e-3,
               ent_coef=0.01, policy_kwargs={"net_arch": [64, 64]}, seed=seed, device="cpu"), env  # fmt: skip


def _shared_ppo(seed: int) -> tuple[Any, Any]:
    from stable_baselines3 import PPO

    def make() -> Any:
        return soccer_v2.parallel_env(task="GoToBall", left=2, controlled="left", action_mode="discrete", **EASY, **SHAPED)

    env = ParallelVecEnv(make, copies=16, seed=seed)
    return PPO("MlpPolicy", env, n_steps=64, batch_size=512, n_epochs=6, gamma=0.95, learning_rate=1e-3, ent_coef=0.001, seed=seed,
               device="cpu"), env  # fmt: skip


LEARNERS: dict[str, tuple[Callable[[int], tuple[Any, Any]], int]] = {
    "ppo": (_ppo, 200_000), "maskable_ppo": (_maskable_ppo, 12_000), "sac": (_sac, 40_000), "shared_ppo": (_shared_ppo, 150_000),
}  # fmt: skip
"""Learners and how many agent-steps they get."""


def learn(learner: str, steps: int | None = None, seed: int = 0, episodes: int = 300) -> Learning:
    """Measure, learn, measure again.

    Parameters
    ----------
    learner : str
        One of `LEARNERS`.
    steps : int, optional
        Agent-steps to learn from.
    seed : int
    episodes : int
        Episodes per measurement.
    """
    import torch

    torch.set_num_threads(1)  # such small networks are slower with more
    make, usual = LEARNERS[learner]
    steps = usual if steps is None else steps
    model, env = make(seed)
    masks = learner == "maskable_ppo"
    before = success_rate(model, env, episodes, masks)
    env.seed(seed)
    begin = time.process_time()
    model.learn(steps)
    seconds = time.process_time() - begin
    return Learning(learner, before, success_rate(model, env, episodes, masks), episodes, steps, seconds)


def main() -> None:
    """Learn and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--learner", choices=sorted(LEARNERS), default=None)
    parser.add_argument("--steps", type=at_least(1), default=None)
    parser.add_argument("--seed", type=at_least(0), default=0)
    arguments = parser.parse_args()
    for name in [arguments.learner] if arguments.learner else LEARNERS:
        r = learn(name, arguments.steps, arguments.seed)
        print(f"{r.learner:13s} {r.before:5.2f} -> {r.after:5.2f}   {r.steps} steps, {r.seconds:.0f} s of processor time", flush=True)


if __name__ == "__main__":
    main()
