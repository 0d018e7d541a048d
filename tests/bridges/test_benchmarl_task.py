"""BenchMARL's task; where BenchMARL is installed (`scripts/learning_examples.sh benchmarl`)."""

import pytest

pytest.importorskip("benchmarl")

from torchrl.envs import check_env_specs

from cprm_gym.bridges.benchmarl_task import SoccerTask
from cprm_gym.errors import ParameterError, UnknownName

pytestmark = pytest.mark.filterwarnings("default")


@pytest.mark.parametrize("continuous", [False, True])
def test_its_specs_are_those_of_the_environment(continuous):
    task = SoccerTask("HFO2v2", {"controlled": "all", "observation": "hfo_high"})
    env = task.get_env_fun(3, continuous, 0, "cpu")()
    check_env_specs(env)
    assert task.group_map(env) == {"left": ["left_1", "left_2"], "right": ["right_1", "right_2"]}
    assert set(task.observation_spec(env)["left"].keys()) == {"observation"}
    assert task.state_spec(env)["state"].shape == env.observation_spec["state"].shape[1:]
    assert (task.action_mask_spec(env) is None) == continuous
    assert task.max_steps(env) == 500
    assert task.action_spec(env)["right", "action"].shape[0] == 2


def test_a_task_that_there_is_not_is_refused_at_once():
    with pytest.raises(UnknownName, match="Did you mean"):
        SoccerTask("HFO2v22")
    with pytest.raises(ParameterError, match="no option"):
        SoccerTask("HFO2v2", {"tempo": 3})
    assert not SoccerTask("HFO2v2", {"action_mode": "macro"}).supports_continuous_actions()
