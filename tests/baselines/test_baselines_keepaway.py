"""The keepaway policies keep the order of the literature."""

import pytest

from baselines.keepaway import POLICIES, durations


@pytest.mark.parametrize("full_state", [False, True])
def test_random_is_beaten_by_hold_and_hold_by_hand(full_state):
    random, hold, hand = (durations(p, full_state=full_state, episodes=150, seed=5) for p in POLICIES)
    assert random.mean + random.error < hold.mean < hand.mean
    assert hold.mean < random.mean * 4
    assert random.mean > 2.0
