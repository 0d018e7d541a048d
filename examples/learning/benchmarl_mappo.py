"""MAPPO of BenchMARL on half field offence with macros: two attackers against a defender and a goalie.

pip install "cprm-gym[benchmarl]"          # an environment of its own: BenchMARL needs torchrl < 0.12
python examples/learning/benchmarl_mappo.py --frames 200000
"""

from __future__ import annotations

import argparse
import tempfile

from benchmarl.algorithms import MappoConfig
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torch import nn

from cprm_gym.bridges.benchmarl_task import SoccerTask


def main() -> None:
    """Train, and print what the last collection gave."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="HFO2v2")
    parser.add_argument("--frames", type=int, default=200_000)
    parser.add_argument("--worlds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    config = ExperimentConfig.get_from_yaml()
    config.sampling_device = config.train_device = "cpu"
    config.max_n_frames, config.max_n_iters = arguments.frames, None
    config.on_policy_n_envs_per_worker = arguments.worlds
    config.on_policy_collected_frames_per_batch = min(6000, arguments.frames)
    config.on_policy_minibatch_size, config.on_policy_n_minibatch_iters = 600, 10
    config.evaluation, config.loggers, config.create_json = False, [], False
    config.prefer_continuous_actions = False
    config.save_folder = tempfile.mkdtemp()
    model = MlpConfig(num_cells=[64, 64], activation_class=nn.Tanh, layer_class=nn.Linear)
    experiment = Experiment(
        task=SoccerTask(arguments.task, {"observation": "hfo_high"}), algorithm_config=MappoConfig.get_from_yaml(), model_config=model,
        critic_model_config=MlpConfig(num_cells=[64, 64], activation_class=nn.Tanh, layer_class=nn.Linear), seed=arguments.seed,
        config=config,
    )  # fmt: skip
    experiment.run()
    print(f"{arguments.task}: {experiment.total_frames} cycles, mean return of the last collection {experiment.mean_return:.3f}")


if __name__ == "__main__":
    main()
