"""The batch for stable-baselines3."""

import gymnasium
import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import CommandError, CprmError, ParameterError

pytest.importorskip("stable_baselines3")

from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from cprm_gym.wrappers.sb3 import ParallelVecEnv, SoccerVecEnv


def test_entries_are_agents_of_worlds_and_play_what_the_engine_plays():
    env = SoccerVecEnv("HFO2v1", worlds=3, action_mode="discrete", observation="raw", seed=4)
    core = SoccerCore(make_task("HFO2v1"), 3, action_mode="discrete")
    assert isinstance(env, VecEnv)
    assert env.num_envs == 6
    seen = env.reset()
    core.reset(4)
    actions = np.random.default_rng(0).integers(0, [6, 5, 24, 5], (20, 6, 4))
    for action in actions:
        for name, values in core.observation.items():
            assert (seen[name] == values.reshape(6, *values.shape[2:])).all()
        seen, rewards, _, _ = env.step(action)
        step = core.step(action.reshape(3, 2, 4))
        assert (rewards == step.reward.ravel()).all()


def test_worlds_that_end_begin_anew_and_hand_out_their_last_observation():
    env = SoccerVecEnv("GoToBall", worlds=2, task_options={"max_cycles": 5}, observation="hfo_low")
    env.reset()
    for t in range(5):
        seen, _, dones, infos = env.step(np.tile([1, 4, 11, 0], (2, 1)))
        assert dones.all() == (t == 4)
    for k in range(2):
        assert infos[k]["TimeLimit.truncated"]
        assert infos[k]["episode"]["l"] == 5
        assert infos[k]["terminal_observation"].shape == seen[k].shape
        assert not np.array_equal(infos[k]["terminal_observation"], seen[k])
    assert (env.core.cycle == 0).all()


def test_masks_are_offered_in_the_macro_view_only():
    env = SoccerVecEnv("HFO2v1", worlds=2, action_mode="macro")
    env.reset()
    assert env.has_attr("action_masks")
    assert np.stack(env.env_method("action_masks")).shape == (4, env.action_space.n)
    plain = SoccerVecEnv("HFO2v1")
    assert not plain.has_attr("action_masks")
    with pytest.raises(CprmError, match="only the macro view has masks"):
        plain.env_method("action_masks")
    with pytest.raises(ParameterError, match="has no Dict actions; action_mode is discrete, box or macro"):
        SoccerVecEnv("GoToBall", action_mode="hybrid")
    with pytest.raises(ParameterError, match="discrete, box or macro, not full"):
        SoccerVecEnv("GoToBall", action_mode="full")


def test_options_of_engine_and_task_are_arguments_and_others_are_refused():
    env = SoccerVecEnv("GoToBall", worlds=2, far=12.0, task_options={"near": 6.0}, flatten=True)
    assert (env.core.task.near, env.core.task.far, len(env.observation_space.shape)) == (6.0, 12.0, 1)
    with pytest.raises(ParameterError, match=r"task 'GoToBall' has no option 'farr'\. Did you mean 'far'\?"):
        SoccerVecEnv("GoToBall", farr=12.0)
    env.reset()
    for wrong in (np.zeros((3, 4)), np.zeros(()), None):
        with pytest.raises(CommandError, match="one for each of 2 worlds x 1 agents is needed"):
            env.step(wrong)


def test_episodes_count_as_monitored():
    assert SoccerVecEnv("GoToBall", worlds=2).env_is_wrapped(Monitor) == [True, True]
    assert SoccerVecEnv("GoToBall", worlds=1).env_is_wrapped(gymnasium.Wrapper) == [False]


def test_parallel_environments_that_cannot_be_learned_are_refused():
    with pytest.raises(ParameterError, match="copies is 0; allowed are whole numbers from 1"):
        ParallelVecEnv(soccer_v2.parallel_env, 0)
    with pytest.raises(ParameterError, match="stable-baselines3 has no Dict actions"):
        ParallelVecEnv(lambda: soccer_v2.parallel_env(left=1, right=1, action_mode="hybrid"))
