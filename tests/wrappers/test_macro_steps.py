"""Macros that last, in many worlds and for several agents: the same decisions as alone, rewards, masks, refusals."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from pettingzoo.test import parallel_api_test

from cprm_gym.envs import SoccerEnv, SoccerVectorEnv, soccer_v2
from cprm_gym.errors import ParameterError
from cprm_gym.wrappers import MacroSteps, ParallelMacroSteps, VectorMacroSteps

OPTIONS = {"task": "HFO2v1", "action_mode": "macro", "observation": "hfo_high", "reward": {"to_ball": 1.0}, "max_cycles": 60}


def decide(mask, k):
    """Some macro that can be done, the same for the same step."""
    return int(np.flatnonzero(mask)[k % mask.sum()])


def test_each_world_is_what_it_is_alone():
    many = VectorMacroSteps(SoccerVectorEnv(4, autoreset_mode="SameStep", **OPTIONS), longest=8, gamma=0.9)
    observed, _ = many.reset(seed=[11, 12, 13, 14])
    alone = [MacroSteps(SoccerEnv(**OPTIONS), longest=8, gamma=0.9) for _ in range(4)]
    for k, env in enumerate(alone):
        np.testing.assert_array_equal(env.reset(seed=11 + k)[0], observed[k])
    lengths, ends = set(), 0
    for t in range(40):
        masks = many.action_masks()
        chosen = np.array([decide(mask, t) for mask in masks])
        observed, rewards, terminated, truncated, info = many.step(chosen)
        for k, env in enumerate(alone):
            np.testing.assert_array_equal(env.action_masks(), masks[k])
            expected, reward, ended, late, told = env.step(chosen[k])
            assert rewards[k] == pytest.approx(reward, abs=1e-12)
            assert (terminated[k], truncated[k], info["macro_steps"][k]) == (ended, late, told["macro_steps"])
            assert info["reward_to_ball"][k] == pytest.approx(told["reward_to_ball"])
            lengths.add(told["macro_steps"])
            if ended or late:
                np.testing.assert_array_equal(info["final_obs"][k], expected)
                assert info["_final_obs"][k]
                assert info["final_info"]["status"][k] == told["status"]
                expected, told = env.reset()
            np.testing.assert_array_equal(observed[k], expected)
        ends += (terminated | truncated).sum()
    assert ends >= 4
    assert len(lengths) >= 3


def test_a_world_that_begins_anew_with_the_next_step_is_the_same_in_any_batch():
    """A world that is over is played on for the cycle in which it begins anew, as the vector form does; alone nothing waits for it."""
    many, *alone = (
        VectorMacroSteps(SoccerVectorEnv(n, autoreset_mode="NextStep", **OPTIONS), longest=8, gamma=0.9) for n in (4, 1, 1, 1, 1)
    )
    many.reset(seed=[11, 12, 13, 14])
    for k, env in enumerate(alone):
        env.reset(seed=[11 + k])
    over, begun = np.zeros(4, bool), 0
    for t in range(40):
        chosen = np.array([decide(mask, t) for mask in many.action_masks()])
        observed, *told, info = many.step(chosen)
        for k, env in enumerate(alone):
            expected, *expected_told, expected_info = env.step(chosen[k : k + 1])
            np.testing.assert_array_equal(observed[k], expected[0])
            assert [values[k] for values in told] == [values[0] for values in expected_told]
            for name in ("macro_steps", "status", "reward_to_ball", "cycle"):
                assert info[name][k] == expected_info[name][0]
            if over[k]:
                assert (told[0][k], info["macro_steps"][k]) == (0.0, 0)
                begun += 1
        over = told[1] | told[2]
    assert begun >= 4


def test_of_make_vec_and_of_what_has_no_macros():
    env = VectorMacroSteps(gymnasium.make_vec("cprm/HFO1v1-v2", num_envs=2, action_mode="macro"))
    env.reset(seed=0)
    assert env.step(env.action_masks().argmax(axis=1))[4]["macro_steps"].shape == (2,)
    with pytest.raises(ParameterError, match="action_mode='macro'; this one has discrete"):
        VectorMacroSteps(SoccerVectorEnv(2))
    with pytest.raises(ParameterError, match="NextStep or SameStep"):
        VectorMacroSteps(SoccerVectorEnv(2, autoreset_mode=AutoresetMode.DISABLED, action_mode="macro"))
    with pytest.raises(ParameterError, match="longest is 0"):
        VectorMacroSteps(SoccerVectorEnv(2, action_mode="macro"), longest=0)
    with pytest.raises(ParameterError, match="action_mode='macro'"):
        ParallelMacroSteps(soccer_v2.parallel_env(task="HFO2v1"))


def test_agents_decide_each_when_his_macro_ends():
    env = ParallelMacroSteps(soccer_v2.parallel_env(**OPTIONS), longest=10)
    bare = soccer_v2.parallel_env(**OPTIONS)
    _, infos = env.reset(seed=3)
    bare.reset(seed=3)
    doing, waited, t = {}, 0, 0
    while env.agents:
        actions = {}
        for agent in env.agents:
            mask = infos[agent]["action_mask"]
            if infos[agent].get("decides", 1):
                doing[agent] = decide(mask, t)
            else:
                assert np.flatnonzero(mask).tolist() == [doing[agent]]
                waited += 1
            actions[agent] = doing[agent] if infos[agent].get("decides", 1) else 0  # what is given for him does not count
        observed, rewards, terminated, _, infos = env.step(actions)
        total = dict.fromkeys(bare.possible_agents, 0.0)
        for _ in range(infos["left_1"]["macro_steps"]):
            expected, now, ended, _, _ = bare.step(dict(doing))
            total = {agent: total[agent] + now[agent] for agent in total}
        assert rewards == pytest.approx(total)
        assert terminated == ended
        for agent, seen in observed.items():
            np.testing.assert_array_equal(seen, expected[agent])
        t += 1
    assert waited > 3
    assert not bare.agents


def test_pettingzoo_finds_nothing_wrong():
    parallel_api_test(ParallelMacroSteps(soccer_v2.parallel_env(include="action_mask", **OPTIONS)), num_cycles=60)
