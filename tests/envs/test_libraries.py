"""Other people's learners take the environments as they are; what is not installed is skipped."""

import gymnasium
import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.wrappers import MacroSteps

HFO = {"task": "HFO2v1", "max_cycles": 30}


@pytest.mark.filterwarnings("ignore:PettingZoo in TorchRL is tested using version:UserWarning")
@pytest.mark.parametrize(
    "options", [{"action_mode": "macro"}, {"action_mode": "box", "flatten": True}, {}], ids=["macro", "box", "default"]
)
def test_torchrl_takes_the_parallel_environment(options):
    torchrl = pytest.importorskip("torchrl.envs")
    from torchrl.envs.utils import check_env_specs

    env = torchrl.PettingZooWrapper(soccer_v2.parallel_env(**HFO, **options), use_mask=False)
    check_env_specs(env)
    rollout = env.rollout(12)
    group = rollout["left"]
    assert group["info", "status"].shape[:2] == group["info", "reward_goal"].shape[:2] == (12, 2)
    if options.get("action_mode") == "macro":
        assert "action_mask" in set(group.keys()), "the mask lies where TorchRL's policies look for it"
        chosen = group["action"].argmax(-1) if group["action"].shape[-1] > 2 else group["action"]
        allowed = group["action_mask"].gather(-1, chosen[..., None].long())
        assert allowed.all(), "random actions of TorchRL keep to the mask"


@pytest.mark.parametrize("mode", ["SameStep", "Disabled"])
def test_torchrl_takes_the_vector_environment(mode):
    torchrl = pytest.importorskip("torchrl.envs")
    envs = gymnasium.make_vec("cprm/GoToBall-v2", num_envs=3, autoreset_mode=mode, flatten=True, action_mode="box", max_episode_steps=6)
    env = torchrl.GymWrapper(envs)
    rollout = env.rollout(14, break_when_any_done=False)
    assert rollout["observation"].shape[:2] == (3, 14)
    assert rollout["next", "done"].any()


def test_maskable_ppo_finds_the_masks_of_the_plain_environment():
    contrib = pytest.importorskip("sb3_contrib")
    from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
    from stable_baselines3.common.vec_env import DummyVecEnv

    make = [lambda: gymnasium.make("cprm/HFO1v0-v2", action_mode="macro", observation="hfo_high")]
    env = DummyVecEnv(make)
    assert is_masking_supported(env)
    env.reset()
    assert (get_action_masks(env)[0] == env.envs[0].unwrapped.core.action_mask[0, 0]).all()
    model = contrib.MaskablePPO("MlpPolicy", env, n_steps=16, batch_size=16, n_epochs=1, seed=0)
    model.learn(32)
    steps = MacroSteps(SoccerEnv("HFO1v0", action_mode="macro"))
    _, info = steps.reset(seed=1)
    assert (steps.action_masks() == info["action_mask"]).all()


def test_rllib_finds_the_mask_in_the_observation():
    env = soccer_v2.parallel_env(**HFO, action_mode="macro", observation="hfo_high", include="action_mask")
    for agent in env.possible_agents:
        # what RLlib's action-masking module asks of a space
        space = env.observation_space(agent)
        assert isinstance(space, gymnasium.spaces.Dict)
        assert set(space.spaces) == {"observations", "action_mask"}
        assert space["action_mask"].shape == (env.action_space(agent).n,)
    pettingzoo_env = pytest.importorskip("ray.rllib.env.wrappers.pettingzoo_env")
    wrapped = pettingzoo_env.ParallelPettingZooEnv(env)
    observations, _ = wrapped.reset(seed=1)
    for _ in range(30):
        actions = {a: np.flatnonzero(o["action_mask"])[-1] for a, o in observations.items()}
        observations, _, terminated, truncated, _ = wrapped.step(actions)
        if terminated["__all__"] or truncated["__all__"]:
            break
    assert terminated["__all__"] or truncated["__all__"]


def test_supersuits_black_death_lives_to_the_end_of_an_episode():
    supersuit = pytest.importorskip("supersuit")
    env = supersuit.black_death_v3(soccer_v2.parallel_env(**HFO, flatten=True, action_mode="box"))
    env.reset(seed=1)
    over = False
    while not over:
        observations, _, terminated, truncated, infos = env.step({a: env.action_space(a).sample() for a in env.agents})
        assert set(observations) == set(infos) == {"left_1", "left_2"}
        over = any(terminated.values()) or any(truncated.values())
    assert not env.agents
