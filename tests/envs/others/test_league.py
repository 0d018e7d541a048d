"""A league of earlier selves: who is drawn, how often, by whose luck."""

import numpy as np
import pytest

from cprm_gym.envs import SoccerVectorEnv
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.others.league import League
from cprm_gym.errors import ParameterError, UnknownName

IDLE = {"type": np.zeros((40, 2), np.int64), "params": np.zeros((40, 2, 4))}


def test_players_of_one_world_have_the_same_member_and_worlds_differ():
    core = SoccerCore("HFO2v2", 40, controlled="left", others=League(("random", "scripted", "eased")))
    core.reset(2)
    first, second = (c.opponents for c in core.played.controllers)
    np.testing.assert_array_equal(first, second)
    assert set(first) == {"random", "scripted", "eased"}
    before = first.copy()
    core.step(IDLE)
    core.reset(None, np.arange(20))
    np.testing.assert_array_equal(first[20:], before[20:])
    assert (first[:20] != before[:20]).any()


def test_a_world_draws_the_same_member_alone():
    batch = SoccerCore("HFO1v1", 6, others=League(("random", "scripted", "eased")))
    batch.reset(9)
    for k in range(6):
        alone = SoccerCore("HFO1v1", 1, others=League(("random", "scripted", "eased")), first_world=k)
        alone.reset(9)
        assert alone.played.controllers[0].opponents[0] == batch.played.controllers[0].opponents[k]


def test_each_member_acts_in_its_worlds():
    class Kicks:
        def reset(self, observation, seed, worlds=None):
            pass

        def act(self, observation):
            return {**no_action(len(observation["level"])), "type": np.full(len(observation["level"]), 3)}

    core = SoccerCore("HFO1v1", 40, others=League({"kicks": lambda task, agent: Kicks(), "random": "random"}))
    core.reset(0)
    core.step({key: value[:, :1] for key, value in IDLE.items()})
    mine = core.played.controllers[0].opponents == "kicks"
    assert 5 < mine.sum() < 35
    assert (core._commands["kind"][mine, 11] == 3).all()
    assert not (core._commands["kind"][~mine, 11] == 3).all()


def test_who_beats_the_learner_is_drawn_more_often():
    league = League(("random", "scripted"), power=2.0)
    np.testing.assert_allclose(league.chances(), 0.5)
    league.tell(np.array(["random"] * 9 + ["scripted"] * 9), np.array([True] * 9 + [False] * 9))
    # (1 - 9.5 / 10) ** 2 and (1 - 0.5 / 10) ** 2
    np.testing.assert_allclose(league.chances(), np.array([0.0025, 0.9025]) / 0.905)
    assert league.results["random"].tolist() == [9, 9]


def test_a_learner_joins_while_it_trains_and_the_oldest_self_leaves():
    league = League(("random",), needs=("memory",), most=3)
    env = SoccerVectorEnv(16, "HFO1v1", others=league)
    env.reset(seed=0)
    for k in range(4):
        league.add(f"self_{k}", "scripted")
    assert league.members == ("random", "self_2", "self_3")
    env.reset(seed=1)
    assert set(env.core.played.controllers[0].opponents) == {"random", "self_2", "self_3"}
    env.step(env.action_space.sample())


def test_what_is_no_member_is_refused():
    with pytest.raises(ParameterError, match="it has no members"):
        SoccerCore("HFO1v1", 1, others=League())
    with pytest.raises(UnknownName, match="controller"):
        League(("randon",))
    with pytest.raises(UnknownName, match="several members"):
        League("random")
    with pytest.raises(ParameterError, match="whole numbers of at least 1"):
        League(most=0)
    with pytest.raises(ParameterError, match="numbers from 0 to 100"):
        League(power=-1)
    league = League(("random",))
    with pytest.raises(ParameterError, match="already"):
        league.add("random", "scripted")
    with pytest.raises(UnknownName, match="member of the league"):
        league.tell(np.array(["nobody"]), np.array([True]))
    env = SoccerVectorEnv(30, "HFO1v1", others=league)
    league.add("late", "scripted")
    with pytest.raises(ParameterError, match="needs memory"):
        env.reset(seed=0)
