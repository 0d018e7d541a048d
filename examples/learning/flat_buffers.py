"""Parameter-shared PPO in one page, over flat buffers: every agent of every world is a row.

pip install "cprm-gym[rl]"
python examples/learning/flat_buffers.py --iterations 20
"""

from __future__ import annotations

import argparse

import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

from cprm_gym.bridges.buffers import SoccerBuffers

GAMMA, LAMBDA, CLIP = 0.99, 0.95, 0.2


class Network(nn.Module):
    """Scores of the macros, and the value."""

    def __init__(self, seen: int, macros: int) -> None:
        super().__init__()
        self.actor = nn.Sequential(nn.Linear(seen, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, macros))
        self.critic = nn.Sequential(nn.Linear(seen, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, 1))

    def forward(self, seen: torch.Tensor, mask: torch.Tensor) -> tuple[Categorical, torch.Tensor]:
        """The distribution of what can be done, and the value."""
        return Categorical(logits=self.actor(seen).masked_fill(~mask, -1e9)), self.critic(seen).squeeze(-1)


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
    env = SoccerBuffers(arguments.worlds, arguments.task, action_mode="macro", observation="hfo_high")
    env.reset(arguments.seed)
    assert env.action_masks is not None
    rows, length = env.num_agents, arguments.cycles
    network = Network(env.observations.shape[1], env.action_masks.shape[1])
    optimiser = torch.optim.Adam(network.parameters(), lr=3e-4)
    seen = torch.zeros(length, rows, env.observations.shape[1])
    masks = torch.zeros(length, rows, env.action_masks.shape[1], dtype=torch.bool)
    acted = torch.zeros(length, rows, dtype=torch.int64)
    chances, values, rewards = (torch.zeros(length, rows) for _ in range(3))
    ends, late = (torch.zeros(length, rows, dtype=torch.bool) for _ in range(2))
    for k in range(arguments.iterations):
        outcomes: list[float] = []
        for t in range(length):
            seen[t], masks[t] = torch.from_numpy(env.observations), torch.from_numpy(env.action_masks)
            with torch.no_grad():
                policy, values[t] = network(seen[t], masks[t])
            acted[t] = policy.sample()
            chances[t] = policy.log_prob(acted[t])
            _, reward, terminal, truncation, ended = env.step(acted[t].numpy())
            rewards[t], ends[t], late[t] = torch.from_numpy(reward), torch.from_numpy(terminal), torch.from_numpy(truncation)
            outcomes += [episode["is_success"] for episode in ended]
        with torch.no_grad():
            following = network(torch.from_numpy(env.observations), torch.from_numpy(env.action_masks))[1]
        advantages, carried = torch.zeros(length, rows), torch.zeros(rows)
        for t in reversed(range(length)):
            # a time-out is no end of its own: the value of where it stopped, as told before the step, stands for the rest
            rest = torch.where(late[t], values[t], torch.where(ends[t], 0.0, following))
            carried = rewards[t] + GAMMA * rest - values[t] + GAMMA * LAMBDA * carried * ~(ends[t] | late[t])
            advantages[t], following = carried, values[t]
        targets = (advantages + values).reshape(-1)
        gained = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).reshape(-1)
        flat = seen.reshape(-1, seen.shape[2]), masks.reshape(-1, masks.shape[2]), acted.reshape(-1), chances.reshape(-1)
        for _ in range(4):
            for batch in torch.randperm(length * rows).chunk(8):
                policy, value = network(flat[0][batch], flat[1][batch])
                ratio = (policy.log_prob(flat[2][batch]) - flat[3][batch]).exp()
                better = torch.min(ratio * gained[batch], ratio.clamp(1 - CLIP, 1 + CLIP) * gained[batch]).mean()
                loss = 0.5 * (value - targets[batch]).square().mean() - better - 0.01 * policy.entropy().mean()
                optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(network.parameters(), 0.5)
                optimiser.step()
        share = float(np.mean(outcomes)) if outcomes else 0.0
        print(
            f"iteration {k}: {(k + 1) * length * arguments.worlds} cycles, {len(outcomes)} episodes ended, {share:.3f} of them with a goal"
        )


if __name__ == "__main__":
    main()
