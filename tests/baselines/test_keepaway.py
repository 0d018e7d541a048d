"""The keepaway policies keep the order of the literature."""

import pytest
from cprm_baselines.keepaway import POLICIES, beside_hand, beside_take, durations


def three(full_state, episodes, **options):
    return [durations(policy, full_state=full_state, episodes=episodes, seed=5, **options) for policy in POLICIES]


@pytest.mark.parametrize("full_state", [False, True], ids=["senses", "full state"])
def test_random_is_beaten_by_hold_and_hold_by_hand(full_state):
    random, hold, hand = three(full_state, 120, longest=600)
    assert random.mean + 2 * random.error < hold.mean - hold.error
    assert hold.mean + hold.error < hand.mean - hand.error
    assert random.mean > 2.0


def test_the_keepers_net_keeps_the_ball_longer_than_the_hand_coded_policy_with_the_same_senses():
    ((kept, more, interval),) = beside_hand(["cprm"], "Keepaway3v2", 150, seed=5, longest=1000)
    assert kept.mean > 10.0
    assert interval.low < more < interval.high
    assert interval.high > 0.0


def test_takers_are_compared_with_the_scripted_ones_in_the_same_worlds():
    (same, gap, _), (kept, more, interval) = beside_take(["take", "random"], "keep_hand", "Keepaway3v2", 40, seed=5, longest=300)
    assert gap == 0.0
    assert kept.mean == pytest.approx(same.mean + more)
    assert 0.0 < interval.low < more < interval.high


@pytest.mark.slow
def test_with_full_state_they_keep_the_ball_about_as_long_as_published():
    random, hold, hand = three(True, 300)
    assert 5.0 < random.mean < 8.0
    assert 10.0 < hold.mean < 25.0
    assert hold.mean + 2 * hold.error < hand.mean
    assert hand.mean > 25.0
