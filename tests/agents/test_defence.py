"""The defence of half field offence: who plays it, alone as in a batch, and that it holds."""

import pytest
from cprm_baselines.defence import goals

from cprm_gym.agents.goalie import ReckoningGoalie
from cprm_gym.agents.match.agent import MatchAgent
from cprm_gym.agents.match.half_field import make_controller
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError

TASK = make_task("HFO2v2", controlled="right", others="strong")


def test_number_one_is_the_goalie_and_the_others_are_defenders():
    assert isinstance(cprm(TASK, "right_1"), ReckoningGoalie)
    assert isinstance(cprm(TASK, "right_2"), MatchAgent)
    with pytest.raises(ParameterError, match="'left_1' attacks"):
        make_controller(TASK, "left_1")


def test_a_world_is_defended_alone_as_in_a_batch():
    batch = play_episodes(TASK, cprm, 6, seed=8)
    for k in range(2):
        alone = play_episodes(TASK, cprm, 1, seed=8, first_world=k)
        assert (alone.cycles[0], alone.success[0]) == (batch.cycles[k], batch.success[k])


def test_the_strong_attack_scores_less_often_than_against_the_strong_defence():
    found = {defence: goals("strong", defence, "HFO2v2", 100, seed=11).mean() for defence in ("strong", "cprm")}
    assert found["cprm"] < found["strong"]
