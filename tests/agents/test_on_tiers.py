"""Agents on a tier of knowledge by name: ``cprm:tier=belief``."""

import numpy as np
import pytest

from cprm_gym.agents.knowledge import Informed, informed
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.registry import make_controller
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.others.registry import load_controller
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError, UnknownName


def test_the_goalie_on_a_tier_is_the_suites_player_without_a_model_of_his_own():
    task = make_task("Goalie")
    named = play_episodes(task, load_controller("cprm:tier=belief"), 12, 3)
    player = play_episodes(task, PLAYERS["Goalie"].on("belief"), 12, 3)
    assert np.array_equal(named.success, player.success)
    assert np.array_equal(named.cycles, player.cycles)
    assert named.success.any()


@pytest.mark.parametrize("task", ["GoToBall", "PassAndAdvance"])
def test_an_agent_without_a_player_plays_behind_the_tier_with_its_options(task):
    made = make_controller(make_task(task), make_task(task).controlled.split(",")[0], tier="belief")
    assert isinstance(made, Informed)
    assert made.tier.name == "belief"
    assert "memory" not in made.needs
    assert set(made.needs) >= {"landmarks", "lines"}


@pytest.mark.parametrize("name", ["Goalie", "Goalie2v1", "PassAndAdvance"])
def test_who_has_a_model_plays_on_the_belief_unless_another_is_named(name):
    """And on the first one, of bins, where that is named; on what the environment tells then."""
    task = make_task(name)
    agent = task.controlled.split(",")[0]
    plain, first = make_controller(task, agent), make_controller(task, agent, model="bins")
    assert plain.tier.name == "belief"
    assert first.cprm.model is not None
    assert first.needs == ("memory",)
    assert make_controller(task, agent, tier="memory", model="bins").controller.cprm.model is not None
    assert make_controller(task, agent, tier="memory").tier.name == "memory"


@pytest.mark.parametrize(
    "name",
    [
        "KickOffShot",
        "KickOffShot2v2",
        "PassAndAdvance2v1",
        "HFO1v1",
        "FrontGoalSupportOption",
        "FrontGoalPassingLane",
        "LostAndFound",
        "Keepaway3v2",
        "Hike",
    ],
)
def test_who_has_no_model_plays_on_the_belief_unless_another_is_named(name):
    """He is told what it knows; the environment's memory where `bins` asks for who was there first."""
    task = make_task(name)
    plain, first, named = (
        make_controller(task, "left_2" if name == "KickOffShot2v2" else "left_1", **how)
        for how in ({}, {"model": "bins"}, {"tier": "memory"})
    )
    assert plain.tier.name == "belief"
    assert "memory" not in plain.needs
    assert plain.cprm is not None
    assert first.needs == ("memory",)
    assert named.tier.name == "memory"


@pytest.mark.parametrize("name", ["GoToBall", "Soccer5v5"])
def test_the_seeker_and_who_plays_a_match_keep_their_own_models(name):
    made = make_controller(make_task(name), "left_1")
    assert not isinstance(made, Informed)
    assert made.cprm.model is not None


def test_the_seeker_on_the_belief_meets_the_ball_sooner_than_on_his_ten_bins():
    task = make_task("GoToBall")
    bins, belief = (play_episodes(task, load_controller(name), 60, 4) for name in ("cprm", "cprm:tier=belief"))
    assert belief.success.all()
    assert bins.success.all()
    assert belief.cycles.mean() < bins.cycles.mean()


def test_a_controller_on_a_tier_that_is_put_on_another_one_is_on_that_alone():
    task = make_task("Goalie")
    made = informed(make_controller, "tracker")(task, "left_1")
    assert made.tier.name == "tracker"
    assert not isinstance(made.controller, Informed)


def test_tiers_that_there_are_not_oracles_and_options_of_a_missing_model_are_refused():
    task = make_task("Goalie")
    with pytest.raises(UnknownName, match=r"beleif.*Did you mean 'belief'"):
        make_controller(task, "left_1", tier="beleif")
    with pytest.raises(UnknownName, match="state"):
        make_controller(task, "left_1", tier="state")
    with pytest.raises(UnknownName, match=r"model 'bin'.*Did you mean 'bins'"):
        make_controller(task, "left_1", model="bin")
    with pytest.raises(ParameterError, match="no option 't_b'; write model=bins"):
        make_controller(task, "left_1", t_b=5)
    with pytest.raises(ParameterError, match="no option 't_b'"):
        make_controller(task, "left_1", tier="belief", t_b=5)
