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
from cprm_gym.envs import soccer_v2
from cprm_gym.envs.registration import TASK_NAMES
from cprm_gym.envs.tasks import TASKS

SMALL = {"task": "Soccer", "left": 2, "right": 2, "max_cycles": 40}
MODES = ("hybrid", "discrete", "box", "macro")


def test_every_task_is_registered():
    assert tuple(TASKS) == TASK_NAMES
    for name in TASKS:
        assert f"cprm/{name}-v2" in gymnasium.registry


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", TASK_NAMES)
def test_gymnasium_accepts_the_environment(name, mode):
    env = gymnasium.make(f"cprm_gym:cprm/{name}-v2", action_mode=mode).unwrapped
    check_env(env)
    env.close()


def test_gymnasium_renders_every_mode():
    for mode in ("human", "rgb_array", "ansi"):
        env = gymnasium.make("cprm/GoToBall-v2", render_mode=mode)
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


FLAT = {"flatten": True, "action_mode": "box", "max_cycles": 25}
"""What PettingZoo likes best: one box in, one box out."""


def small(name):
    """A task with few cycles and, in matches, few players."""
    options = {"task": name, "max_cycles": 25}
    if name in ("Soccer", "Soccer5v5", "Soccer11v11"):
        options |= {"left": 2, "right": 2, "others": "hold"}
    return options


@pytest.mark.parametrize("name", TASK_NAMES)
def test_pettingzoo_accepts_every_task(name):
    # the flat form passes every test of the library without a warning
    options = {**small(name), **FLAT}
    parallel_api_test(soccer_v2.parallel_env(**options), num_cycles=40)
    api_test(soccer_v2.env(**options), num_cycles=30)
    env = soccer_v2.parallel_env(**options)
    state_test(soccer_v2.env(**options), env)
    env.reset(seed=3)
    assert env.state_space.contains(env.state())


@pytest.mark.parametrize("name", TASK_NAMES)
def test_every_task_ends_at_max_cycles(name):
    class Module:
        @staticmethod
        def parallel_env(max_cycles):
            return soccer_v2.parallel_env(**{**small(name), "max_cycles": max_cycles, "action_mode": "discrete"})

        @staticmethod
        def env(max_cycles):
            return soccer_v2.env(**{**small(name), "max_cycles": max_cycles, "action_mode": "discrete"})

    if name == "Goalie":
        # a shot reaches the goal in fewer cycles than the test of the library plays
        env = Module.parallel_env(3)
        env.reset(seed=1)
        for t in range(3):
            truncated = env.step({"left_1": [0, 0, 0, 0]})[3]["left_1"]
            assert truncated == (t == 2)
        return
    max_cycles_test(Module)


@pytest.mark.slow
@pytest.mark.parametrize("name", TASK_NAMES)
def test_pettingzoo_renders_every_task(name):
    render_test(lambda **kwargs: soccer_v2.env(**small(name), **kwargs))


@pytest.mark.parametrize("mode", [*MODES, "full"])
def test_pettingzoo_accepts_every_action_view(mode):
    parallel_api_test(soccer_v2.parallel_env(action_mode=mode, **SMALL), num_cycles=120)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.filterwarnings("ignore:Observation space for each agent probably should be:UserWarning")
@pytest.mark.filterwarnings("ignore:Action space for each agent probably should be:UserWarning")
@pytest.mark.filterwarnings("ignore:Observation is not a NumPy array:UserWarning")
def test_pettingzoo_accepts_the_aec_environment(mode):
    # the three warnings are PettingZoo's taste for Box observations and simple actions; our observations are flat dicts by design
    api_test(soccer_v2.env(action_mode=mode, **SMALL), num_cycles=80)


def test_pettingzoo_renders():
    render_test(lambda **kwargs: soccer_v2.env(**SMALL, **kwargs))


@pytest.mark.parametrize("observation", [{"flatten": True}, {"observation": "hfo_low"}], ids=["flat", "hfo_low"])
@pytest.mark.parametrize("mode", ["discrete", "box", "macro"])
@pytest.mark.parametrize("name", TASK_NAMES)
def test_stable_baselines_accepts_every_task(name, mode, observation):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(f"cprm/{name}-v2", action_mode=mode, **observation, disable_env_checker=True).unwrapped)


@pytest.mark.parametrize("mode", ["discrete", "box"])
def test_stable_baselines_accepts_the_world_of_the_appendix(mode):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make("cprm/SlowApproach-v2", action_mode=mode, disable_env_checker=True).unwrapped)


def test_pettingzoo_registry_makes_the_environment():
    import pettingzoo

    env = pettingzoo.make("parallel", "cprm/soccer_v2", **SMALL)
    env.reset(seed=1)
    assert env.possible_agents == ["left_1", "left_2", "right_1", "right_2"]


EPISODE = """
import hashlib, sys
import numpy as np
from cprm_gym.envs import soccer_v2
env = soccer_v2.parallel_env(task=sys.argv[2], max_cycles=150)
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


def episode_hash(name, seed):
    env = {**os.environ, "PYTHONHASHSEED": str(seed + 1)}
    run = subprocess.run([sys.executable, "-c", EPISODE, str(seed), name], capture_output=True, text=True, check=True, env=env)
    return run.stdout.strip()


@pytest.mark.parametrize("name", ["Soccer5v5", *(pytest.param(n, marks=pytest.mark.slow) for n in TASK_NAMES if n != "Soccer5v5")])
def test_a_seed_decides_whole_episodes_in_every_process(name):
    first = episode_hash(name, 5)
    assert len(first) == len(hashlib.sha256().hexdigest())
    assert first == episode_hash(name, 5)
    assert first != episode_hash(name, 6)


def test_the_package_tells_its_version():
    assert cprm_gym.__version__ == "0.1.0"
