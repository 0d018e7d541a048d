"""What is known of self and others, measured: the truth has no error, a matching asks for no numbers, tiers are told apart in pairs."""

import numpy as np
import pytest

from cprm_gym.benchmark.scene.error import FAR, record_scene, scene_error, unmatched
from cprm_gym.envs.players.senses import Senses


def team(*places):
    known, where = np.zeros(11, bool), np.zeros((11, 2))
    known[: len(places)] = True
    where[: len(places)] = np.reshape(places, (-1, 2))
    return known, where


def test_whoever_they_are_numbers_do_not_count_but_who_is_missing_does():
    there = team((0, 0), (10, 0))
    assert unmatched(*team((10, 0), (0, 0)), *there) == 0.0
    assert unmatched(*team((0, 1), (10, 0)), *there) == pytest.approx(0.5)
    assert unmatched(*team((0, 0)), *there) == pytest.approx(FAR / 2)
    assert unmatched(*team((0, 0), (10, 0), (20, 0)), *there) == pytest.approx(FAR / 3)
    assert unmatched(*team(), *there) == FAR
    assert np.isnan(unmatched(*team(), *team()))


@pytest.mark.parametrize("senses", [Senses(), Senses(lost=0.6), Senses(gaussian=0.1), Senses(late=2)], ids=str)
def test_the_belief_knows_self_and_others_better_than_the_tracker(senses):
    record = record_scene("Goalie3v2", 30, 53, senses)
    belief, tracker = (scene_error(tier, record, senses, "Goalie3v2") for tier in ("belief", "tracker"))
    assert belief.place < tracker.place
    # where everything is late both carry it on by the same commands from the same looks: level, to a hundredth
    assert belief.face < (1.01 if senses.late else 1.0) * tracker.face
    assert belief.less(tracker)[2] < 0.0
    assert belief.anybody < tracker.anybody
    assert belief.density > tracker.density


def test_who_has_no_numbers_still_knows_where_players_are():
    senses = Senses(numbers=False)
    record = record_scene("Goalie3v2", 30, 53, senses)
    belief, tracker = (scene_error(tier, record, senses, "Goalie3v2") for tier in ("belief", "tracker"))
    assert belief.anybody < 0.9 * tracker.anybody
    assert belief.density > tracker.density


def test_a_match_has_twenty_one_others_to_know():
    record = record_scene("Soccer11v11", 3, 5, Senses())
    belief, tracker = (scene_error(tier, record, Senses(), "Soccer11v11") for tier in ("belief", "tracker"))
    assert (record.true[0]["memory_age"][:, 1:] == 0).sum(axis=1).tolist() == [22, 22, 22]
    assert belief.capped < tracker.capped
    assert belief.density > tracker.density
