"""A smallest conflict is found by few questions."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from cprm_gym.architecture.prm.inference.conflicts import smallest_conflict


@pytest.mark.parametrize("at_once", [1, 3, 64])
@pytest.mark.parametrize("seed", range(20))
def test_it_is_a_conflict_and_none_of_it_can_be_left_out(seed, at_once):
    rng = np.random.default_rng(seed)
    names = [f"n{k}" for k in range(int(rng.integers(1, 12)))]
    conflicts = [set(rng.choice(names, int(rng.integers(1, 1 + min(4, len(names)))), replace=False)) for _ in range(3)]

    def impossible(subsets):
        return [any(c <= set(s) for c in conflicts) for s in subsets]

    found = smallest_conflict(names, impossible, at_once)
    assert impossible([found]) == [True]
    assert not any(impossible([list(s) for s in itertools.combinations(found, len(found) - 1)]))


def test_two_of_a_thousand_readings_are_found_by_a_few_dozen_questions():
    """Every reading was left out in turn, a query of the whole net each."""
    names = [f"n{k}" for k in range(1000)]
    asked = []

    def impossible(subsets):
        asked.extend(subsets)
        return [{"n17", "n803"} <= set(s) for s in subsets]

    assert smallest_conflict(names, impossible) == ["n17", "n803"]
    assert len(asked) <= 3 * (math.log2(1001) + 1)
