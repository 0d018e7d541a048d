"""Whole matches of scripted teams."""

import numpy as np
import pytest
from cprm_baselines.matches import play_matches

SET_PLAYS = ("kick_in", "goal_kick", "corner_kick", "free_kick", "kick_off")


def per_match(matches, *names):
    """How often one of the modes began, for either side, per match."""
    return sum(matches.begun.get(f"{name}_{side}", 0) for name in names for side in "lr") / len(matches.score)


@pytest.mark.slow
def test_the_strongest_team_beats_the_weakest_in_nine_of_ten_matches():
    for left, right, sign in (("strong", "weak", 1), ("weak", "strong", -1)):
        matches = play_matches(left, right, 20, seed=3)
        better = sign * (matches.score[:, 0] - matches.score[:, 1]) > 0
        assert better.mean() >= 0.9
        assert matches.finished.all()


@pytest.mark.slow
def test_a_match_has_goals_set_plays_and_offsides_and_never_stands_still():
    matches = play_matches("strong", "strong", 16, seed=1)
    assert 2.0 <= matches.score.sum(axis=1).mean() <= 6.0
    assert per_match(matches, "offside") >= 1.5
    for name in SET_PLAYS:
        assert per_match(matches, name) > 0.0, name
    assert per_match(matches, *SET_PLAYS) > 10.0
    assert matches.longest <= 250, "the drop ball comes after 200 cycles"
    assert matches.finished.mean() >= 0.5, "the others are in extra time or shoot out"


def test_a_batch_of_short_matches_runs_and_the_strong_team_plays_ahead():
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task

    core = SoccerCore(make_task("Soccer11v11"), 6, controlled=(), others=("strong", "weak"))
    core.reset(1)
    ahead = np.zeros(6)
    for _ in range(500):
        core.step(None)
        ahead += core.sim.world["pos"][:, 0, 0]
    moved = core.sim.world["counts"][:, :, 1].sum(axis=1)
    assert (moved > 300).all()
    assert ahead.mean() / 500 > 5.0, "the ball is mostly in the weak half"
    assert core.sim.world["score"][:, 0].sum() > core.sim.world["score"][:, 1].sum()


def test_between_equal_strong_teams_somebody_is_caught_offside_within_minutes():
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task
    from cprm_gym.simulator.state import PlayMode

    core = SoccerCore(make_task("Soccer11v11"), 8, controlled=(), others="strong")
    core.reset(4)
    offside, standing = 0, np.zeros(8, int)
    for _ in range(1500):
        core.step(None)
        mode = core.sim.world["mode"]
        offside += int(((mode == PlayMode.offside_l) | (mode == PlayMode.offside_r)).any())
        standing = np.where(mode == PlayMode.play_on, 0, standing + 1)
        assert standing.max() <= 250
    assert offside > 0
