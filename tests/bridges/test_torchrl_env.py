"""TorchRL's own check, partial resets, masks and seeds; where TorchRL is installed (`scripts/learning_examples.sh torchrl`)."""

import numpy as np
import pytest

pytest.importorskip("torchrl")

import torch
from torchrl.envs import check_env_specs

from cprm_gym.bridges.torchrl_env import SoccerTorchEnv
from cprm_gym.bridges.worlds import AgentWorlds
from cprm_gym.errors import UnknownName

pytestmark = pytest.mark.filterwarnings("default")

FORMS = [
    {"task": "Soccer5v5", "controlled": "all", "observation": "raw"},
    {"task": "HFO2v2"},
    {"task": "HFO2v2", "action_mode": "macro", "observation": "hfo_low"},
    {"task": "HFO2v2", "action_mode": "box", "flatten": True, "controlled": "all"},
    {"task": "Keepaway3v2", "action_mode": "macro", "include": "action_mask", "observation": "keepaway", "state": False},
]


@pytest.mark.parametrize("options", FORMS)
def test_torchrl_finds_nothing_wrong(options):
    check_env_specs(SoccerTorchEnv(3, **options))


def test_groups_masks_and_the_state_are_those_of_the_worlds():
    env = SoccerTorchEnv(4, "HFO2v2", controlled="all", action_mode="macro", observation="hfo_high", seed=3)
    worlds = AgentWorlds(4, "HFO2v2", controlled="all", action_mode="macro", observation="hfo_high")
    worlds.reset(3)
    now = env.reset()
    for _ in range(15):
        assert now["left"].batch_size == (4, 2)
        for group in ("left", "right"):
            np.testing.assert_array_equal(now[group, "observation"].numpy(), worlds.observation(group))
            np.testing.assert_array_equal(now[group, "action_mask"].numpy(), worlds.mask(group))
        np.testing.assert_array_equal(now["state"].numpy(), worlds.state())
        now = env.rand_action(now)
        step = worlds.step({group: now[group, "action"].numpy() for group in ("left", "right")})
        now = env.step(now)["next"]
        np.testing.assert_array_equal(now["right", "reward"].numpy()[..., 0], step.reward[:, 2:].astype(np.float32))


def test_worlds_that_are_over_begin_anew_alone():
    env = SoccerTorchEnv(6, "HFO2v2", seed=0, flatten=True, max_cycles=30)
    torch.manual_seed(0)
    rolled = env.rollout(70, break_when_any_done=False)
    over = rolled["next", "done"].squeeze(-1)
    assert over.sum() >= 12
    cycles = [0] * 6
    for t in range(70):
        for k in range(6):
            cycles[k] = 0 if over[k, t] else cycles[k] + 1
    assert env.worlds.core.cycle.tolist() == cycles
    assert (rolled["next", "truncated"].sum() > 0).item()


def test_tensors_are_kept():
    env = SoccerTorchEnv(2, "HFO2v2", flatten=True, seed=0)
    first = env.reset()
    before = first["left", "observation"].clone()
    env.rollout(5)
    torch.testing.assert_close(first["left", "observation"], before)


def test_seeds_decide_everything():
    def play(seed):
        env = SoccerTorchEnv(3, "HFO2v2", flatten=True, observation="raw")
        env.set_seed(seed)
        torch.manual_seed(1)
        return env.rollout(20)["next", "left", "observation"]

    torch.testing.assert_close(play(5), play(5))
    assert not torch.equal(play(5), play(6))


def test_actions_that_are_no_tensor_are_refused():
    with pytest.raises(UnknownName, match="allowed here are discrete, box and macro"):
        SoccerTorchEnv(1, action_mode="hybrid")
