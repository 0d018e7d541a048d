"""Whole matches of scripted teams."""

import pytest

from baselines.matches import play_matches

SET_PLAYS = ("kick_in_l", "kick_in_r", "goal_kick_l", "goal_kick_r", "corner_kick_l", "corner_kick_r", "free_kick_l", "free_kick_r")


@pytest.mark.slow
def test_the_strongest_team_beats_the_weakest_in_nine_of_ten_matches():
    for left, right, sign in (("strong", "weak", 1), ("weak", "strong", -1)):
        matches = play_matches(left, right, 10, seed=3)
        better = sign * (matches.score[:, 0] - matches.score[:, 1]) > 0
        assert better.mean() >= 0.9
        assert matches.finished.all()


@pytest.mark.slow
def test_a_match_has_goals_set_plays_and_offsides_and_never_stands_still():
    matches = play_matches("strong", "strong", 12, seed=1)
    begun = matches.begun
    assert matches.score.sum() > 0
    assert sum(begun.get(name, 0) for name in SET_PLAYS) > 12
    assert begun.get("offside_l", 0) + begun.get("offside_r", 0) > 0
    assert matches.longest <= 250, "the drop ball comes after 200 cycles"
    assert matches.finished.mean() >= 0.5, "the others are in extra time or shoot out"


def test_a_batch_of_short_matches_runs():
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task

    core = SoccerCore(make_task("Soccer11v11"), 3, controlled=(), others=("strong", "weak"))
    core.reset(1)
    for _ in range(300):
        core.step(None)
    moved = core.sim.world["counts"][:, :, 1].sum(axis=1)
    assert (moved > 300).all()
    assert (core.sim.world["time"] > 200).all()
