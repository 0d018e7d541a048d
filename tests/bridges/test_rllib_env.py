"""RLlib's environments; where RLlib is installed (`scripts/learning_examples.sh rllib`)."""

import numpy as np
import pytest

pytest.importorskip("ray.rllib")

from ray.rllib.utils.pre_checks.env import check_multiagent_environments

from cprm_gym.bridges.rllib_env import SoccerMultiAgentEnv, SoccerVectorMultiAgentEnv
from cprm_gym.bridges.worlds import AgentWorlds
from cprm_gym.errors import CprmError

pytestmark = pytest.mark.filterwarnings("default")


def test_rllib_finds_nothing_wrong():
    check_multiagent_environments(SoccerMultiAgentEnv({"task": "HFO2v2", "observation": "hfo_high"}))


def test_worlds_are_those_of_the_engine():
    many = SoccerVectorMultiAgentEnv(3, {"task": "HFO2v2", "observation": "hfo_high"})
    worlds = AgentWorlds(3, "HFO2v2", observation="hfo_high", action_mode="box")
    observed, _ = many.reset(seed=2)
    worlds.reset(2)
    rng = np.random.default_rng(0)
    for _ in range(10):
        for k in range(3):
            for i, agent in enumerate(many.agents):
                np.testing.assert_array_equal(observed[k][agent], worlds.core.output[k, i])
        chosen = rng.uniform(-1, 1, (3, 2, 6)).astype(np.float32)
        observed, rewards, *_ = many.step([dict(zip(many.agents, row)) for row in chosen])
        step = worlds.step({"left": chosen})
        assert [list(r.values()) for r in rewards] == step.reward.tolist()


def test_a_world_that_is_over_begins_anew_with_the_next_step():
    many = SoccerVectorMultiAgentEnv(2, {"task": "HFO2v2", "max_cycles": 3, "others": "hold"})
    many.reset(seed=0)
    idle = [{a: np.zeros(6, np.float32) for a in many.agents}] * 2
    for k in range(8):
        _, rewards, terminated, truncated, told = many.step([{}, {}] if k % 4 == 3 else idle)
        assert truncated[0] == dict.fromkeys((*many.agents, "__all__"), k % 4 == 2)
        assert not terminated[1]["__all__"]
        assert (told[0] != {}) == (k % 4 == 2)
    assert rewards[0] == {"left_1": 0.0, "left_2": 0.0}
    assert many.worlds.core.cycle.tolist() == [0, 0]
    with pytest.raises(CprmError, match="actions of 1 worlds given, there are 2"):
        many.step([{}])
