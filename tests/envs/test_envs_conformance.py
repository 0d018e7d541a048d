"""The environments against the conformance tests of their libraries."""

import hashlib
import os
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import api_test, max_cycles_test, parallel_api_test, render_test, state_test

import cprm_gym
from cprm_gym.envs import soccer_v0
from cprm_gym.envs.registration import TASK_NAMES
from cprm_gym.envs.tasks import TASKS

SMALL = {"task": "Soccer", "left": 2, "right": 2, "max_cycles": 40}
MODES = ("hybrid", "discrete", "box", "macro")


def test_every_task_is_registered():
    assert tuple(TASKS) == TASK_NAMES
    for name in TASKS:
        assert f"cprm/{name}-v0" in gymnasium.registry


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", TASK_NAMES)
def test_gymnasium_accepts_the_environment(name, mode):
    env = gymnasium.make(f"cprm_gym:cprm/{name}-v0", action_mode=mode).unwrapped
    check_env(env)
    env.close()


def test_gymnasium_renders_every_mode():
    for mode in ("human", "rgb_array", "ansi"):
        env = gymnasium.make("cprm/GoToBall-v0", render_mode=mode)
        env.reset(seed=1)
        picture = env.render()
        if mode == "rgb_array":
            assert picture.dtype == np.uint8
            assert picture.shape == (654, 920, 3)
        elif mode == "ansi":
            assert "o" in picture
            assert "1" in picture
        else:
            assert picture is None
        env.close()


@pytest.mark.parametrize("mode", MODES)
def test_pettingzoo_accepts_the_parallel_environment(mode):
    parallel_api_test(soccer_v0.parallel_env(action_mode=mode, **SMALL), num_cycles=120)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.filterwarnings("ignore:Observation space for each agent probably should be:UserWarning")
@pytest.mark.filterwarnings("ignore:Action space for each agent probably should be:UserWarning")
@pytest.mark.filterwarnings("ignore:Observation is not a NumPy array:UserWarning")
def test_pettingzoo_accepts_the_aec_environment(mode):
    # the three warnings are PettingZoo's taste for Box observations and simple actions; our observations are flat dicts by design
    api_test(soccer_v0.env(action_mode=mode, **SMALL), num_cycles=80)


def test_state_is_one_flat_array():
    env = soccer_v0.parallel_env(**SMALL)
    state_test(soccer_v0.env(**SMALL), env)
    env.reset(seed=3)
    assert env.state_space.contains(env.state())


def test_pettingzoo_renders():
    render_test(lambda **kwargs: soccer_v0.env(**SMALL, **kwargs))


def test_max_cycles_ends_the_episode():
    class Module:
        @staticmethod
        def parallel_env(max_cycles):
            return soccer_v0.parallel_env(**{**SMALL, "max_cycles": max_cycles})

        @staticmethod
        def env(max_cycles):
            return soccer_v0.env(**{**SMALL, "max_cycles": max_cycles})

    max_cycles_test(Module)


def test_pettingzoo_registry_makes_the_environment():
    import pettingzoo

    env = pettingzoo.make("parallel", "cprm/soccer_v0", **SMALL)
    env.reset(seed=1)
    assert env.possible_agents == ["left_1", "left_2", "right_1", "right_2"]


EPISODE = """
import hashlib, sys
import numpy as np
from cprm_gym.envs import soccer_v0
env = soccer_v0.parallel_env(task="Soccer", left=3, right=2, max_cycles=150)
for a in env.possible_agents:
    env.action_space(a).seed(7)
digest = hashlib.sha256()
observations, infos = env.reset(seed=int(sys.argv[1]))
while env.agents:
    observations, rewards, terminated, truncated, infos = env.step({a: env.action_space(a).sample() for a in env.agents})
    for agent in observations:
        for value in observations[agent].values():
            digest.update(value.tobytes())
        digest.update(repr((rewards[agent], terminated[agent], truncated[agent], sorted(infos[agent].items()))).encode())
    digest.update(env.state().tobytes())
print(digest.hexdigest())
"""


def episode_hash(seed):
    env = {**os.environ, "PYTHONHASHSEED": str(seed + 1)}
    return subprocess.run([sys.executable, "-c", EPISODE, str(seed)], capture_output=True, text=True, check=True, env=env).stdout.strip()


def test_a_seed_decides_whole_episodes_in_every_process():
    first = episode_hash(5)
    assert len(first) == len(hashlib.sha256().hexdigest())
    assert first == episode_hash(5)
    assert first != episode_hash(6)


def test_the_package_tells_its_version():
    assert cprm_gym.__version__ == "0.1.0"
