"""Multi-agent PPO of TorchRL, shared weights and a central critic, on half field offence with macros and their masks.

pip install "cprm-gym[torchrl]"            # an environment of its own
python examples/learning/torchrl_ppo.py --iterations 20
"""

from __future__ import annotations

import argparse

import torch
from tensordict.nn import TensorDictModule
from torchrl.data import LazyTensorStorage, ReplayBuffer, SamplerWithoutReplacement
from torchrl.envs import check_env_specs
from torchrl.modules import MaskedCategorical, MultiAgentMLP, ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss, ValueEstimators

from cprm_gym.bridges.torchrl_env import SoccerTorchEnv

GROUP = "left"


def main() -> None:
    """Train, and print what each iteration gave."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="HFO2v2")
    parser.add_argument("--iterations", type=int, default=20)
    parser.add_argument("--worlds", type=int, default=32)
    parser.add_argument("--cycles", type=int, default=100, help="Cycles of each world in an iteration.")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    torch.manual_seed(arguments.seed)
    env = SoccerTorchEnv(arguments.worlds, arguments.task, seed=arguments.seed, action_mode="macro", observation="hfo_high")
    check_env_specs(env)
    env.set_seed(arguments.seed)
    agents = len(env.group_map[GROUP])
    seen = env.observation_spec[GROUP, "observation"].shape[-1]
    macros = env.observation_spec[GROUP, "action_mask"].shape[-1]
    sizes = {"n_agents": agents, "share_params": True, "depth": 2, "num_cells": 64, "activation_class": torch.nn.Tanh}
    net = MultiAgentMLP(n_agent_inputs=seen, n_agent_outputs=macros, centralized=False, **sizes)
    actor = ProbabilisticActor(
        TensorDictModule(net, [(GROUP, "observation")], [(GROUP, "logits")]), spec=env.action_spec_unbatched,
        in_keys={"logits": (GROUP, "logits"), "mask": (GROUP, "action_mask")}, out_keys=[(GROUP, "action")],
        distribution_class=MaskedCategorical, return_log_prob=True, log_prob_key=(GROUP, "log_prob"),
    )  # fmt: skip
    critic_net = MultiAgentMLP(n_agent_inputs=seen, n_agent_outputs=1, centralized=True, **sizes)
    critic = ValueOperator(critic_net, in_keys=[(GROUP, "observation")], out_keys=[(GROUP, "state_value")])
    loss = ClipPPOLoss(actor, critic, clip_epsilon=0.2, entropy_coeff=0.01, normalize_advantage=True)
    loss.set_keys(
        reward=(GROUP, "reward"), action=(GROUP, "action"), value=(GROUP, "state_value"), done=(GROUP, "done"),
        terminated=(GROUP, "terminated"), sample_log_prob=(GROUP, "log_prob"), advantage=(GROUP, "advantage"),
        value_target=(GROUP, "value_target"),
    )  # fmt: skip
    loss.make_value_estimator(ValueEstimators.GAE, gamma=0.99, lmbda=0.95)
    frames = arguments.worlds * arguments.cycles
    buffer = ReplayBuffer(storage=LazyTensorStorage(frames), sampler=SamplerWithoutReplacement(), batch_size=max(frames // 8, 1))
    optimiser = torch.optim.Adam(loss.parameters(), lr=3e-4)
    state = env.reset()
    for k in range(arguments.iterations):
        with torch.no_grad():
            batch = env.rollout(arguments.cycles, actor, break_when_any_done=False, auto_reset=False, tensordict=state)
        state = batch[..., -1]["next"].exclude("_reset")
        state = env.maybe_reset(state)
        over = batch["next", "done"].squeeze(-1)
        won = batch["next", GROUP, "is_success"][..., 0, 0] & over
        for key in ("done", "terminated"):
            shape = batch["next", GROUP, "reward"].shape
            batch["next", GROUP, key] = batch["next", key].unsqueeze(-1).expand(shape)
        with torch.no_grad():
            loss.value_estimator(batch, params=loss.critic_network_params, target_params=loss.target_critic_network_params)
        buffer.extend(batch.reshape(-1))
        for _ in range(4):
            for sample in buffer:
                losses = loss(sample)
                total = losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]
                optimiser.zero_grad()
                total.backward()
                torch.nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
                optimiser.step()
        share = float(won.sum()) / max(float(over.sum()), 1.0)
        print(f"iteration {k}: {(k + 1) * frames} cycles, {int(over.sum())} episodes ended, {share:.3f} of them with a goal")


if __name__ == "__main__":
    main()
