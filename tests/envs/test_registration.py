"""Registered ids, and what is said of the old ones."""

import gymnasium
import pettingzoo
import pytest

import cprm_gym.envs
from cprm_gym.envs.registration import SMALL_CYCLES, TASK_CYCLES
from cprm_gym.envs.tasks import TASKS, make_task
from cprm_gym.envs.tasks.slow_approach import SlowApproach


def test_registration_knows_the_tasks_and_their_cycles_without_loading_them():
    assert {name: make_task(name).max_cycles for name in TASKS} == TASK_CYCLES
    assert SlowApproach().max_cycles == SMALL_CYCLES
    for name, cycles in (*TASK_CYCLES.items(), ("SlowApproach", SMALL_CYCLES)):
        assert gymnasium.spec(f"cprm/{name}-v2").max_episode_steps == cycles


@pytest.mark.filterwarnings("ignore:.*is out of date:DeprecationWarning")
def test_old_versions_name_the_new_ones():
    for old in ("v0", "v1"):
        with pytest.raises(gymnasium.error.DeprecatedEnv, match="Please use `cprm/GoToBall-v2` instead"):
            gymnasium.make(f"cprm/GoToBall-{old}")
    with pytest.raises(ImportError, match="soccer_v0 has been replaced by soccer_v2"):
        from cprm_gym.envs import soccer_v0  # noqa: F401
    with pytest.raises(ImportError, match="soccer_v1 has been replaced by soccer_v2: the default observation is normalised"):
        from cprm_gym.envs import soccer_v1  # noqa: F401
    with pytest.raises(AttributeError, match=r"Did you mean 'soccer_v2'"):
        cprm_gym.envs.soccer_v3  # noqa: B018
    if hasattr(pettingzoo, "make"):
        with pytest.raises(ImportError, match="soccer_v0 has been replaced by soccer_v2"):
            pettingzoo.make("parallel", "cprm/soccer_v0")
        with pytest.raises(ImportError, match="soccer_v1 has been replaced by soccer_v2"):
            pettingzoo.make("aec", "cprm/soccer_v1")
