"""Each kind of learner learns something on an easy task. The command for people: python -m cprm_baselines.rl.go_to_ball"""

import pytest

pytest.importorskip("sb3_contrib")

from cprm_baselines.rl.go_to_ball import learn


@pytest.mark.slow
@pytest.mark.parametrize("learner", ["ppo", "maskable_ppo", "sac", "shared_ppo"])
def test_success_at_least_doubles(learner):
    result = learn(learner, seed=1, episodes=200)
    assert result.after >= 2 * result.before
    assert result.after >= 0.1


def test_maskable_ppo_doubles_its_success_in_a_few_seconds():
    result = learn("maskable_ppo", steps=12_000, seed=0, episodes=100)
    assert result.after >= 2 * result.before
