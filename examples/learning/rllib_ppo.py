"""PPO of RLlib, one policy for all agents of a side, on half field offence: worlds are played together by one env runner.

pip install "cprm-gym[rllib]"              # an environment of its own: RLlib pins Gymnasium
python examples/learning/rllib_ppo.py --iterations 10
"""

from __future__ import annotations

import argparse

import ray
from ray.rllib.algorithms.ppo import PPOConfig

from cprm_gym.bridges.rllib_env import SoccerEnvRunner, SoccerMultiAgentEnv


def main() -> None:
    """Train, and print what each iteration gave."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="HFO2v2")
    parser.add_argument("--iterations", type=int, default=10)
    parser.add_argument("--steps", type=int, default=4000, help="Cycles of each iteration.")
    parser.add_argument("--worlds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    ray.init(num_cpus=1, include_dashboard=False, logging_level="error")
    config = (
        PPOConfig()
        .environment(
            SoccerMultiAgentEnv,
            env_config={"task": arguments.task, "observation": "hfo_low", "reward": ["to_ball_progress", "ball_to_goal_progress"]},
            disable_env_checking=True,
        )
        .env_runners(env_runner_cls=SoccerEnvRunner, num_env_runners=0, num_envs_per_env_runner=arguments.worlds)
        .multi_agent(policies={"left"}, policy_mapping_fn=lambda agent, *_, **__: "left")
        .training(train_batch_size_per_learner=arguments.steps, minibatch_size=500, num_epochs=4, lr=3e-4)
        .debugging(seed=arguments.seed)
    )
    algorithm = config.build_algo()
    for k in range(arguments.iterations):
        told = algorithm.train()["env_runners"]
        print(f"iteration {k}: {told['num_env_steps_sampled_lifetime']:.0f} cycles, mean return {told.get('episode_return_mean', 0.0):.3f}")
    algorithm.stop()
    ray.shutdown()


if __name__ == "__main__":
    main()
