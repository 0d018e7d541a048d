"""What a told distance says: the bands of the eye, also where they are put together once more."""

import numpy as np
import pytest

from cprm_gym.agents.knowledge.kernels.eye import all_told_between, told_between
from cprm_gym.simulator.kernels.rounding import banded_distance

TRUE = np.exp(np.arange(np.log(0.4), np.log(90.0), 0.0005))


def told_by_the_eye(factor):
    """As the server tells `TRUE`, and as coarser senses round that."""
    told = np.array([banded_distance(d, 0.1) for d in TRUE])
    step = 0.1 * factor
    return np.exp(step * np.round(np.log(told) / step)) if factor > 1.0 else told


@pytest.mark.parametrize("factor", [1.0, 1.5, 2.0, 4.0])
def test_the_ends_are_those_of_all_distances_that_are_told_so(factor):
    told = told_by_the_eye(factor)
    for value in np.unique(told):
        low, high = told_between(value, 0.1, factor)
        there = TRUE[told == value]
        assert low <= there.min() * 1.0001
        assert high >= there.max() * 0.9999
        if 0.5 < value < 80.0:
            assert low == pytest.approx(there.min(), rel=2e-3)
            assert high == pytest.approx(there.max(), rel=2e-3)


def test_bands_that_are_put_together_lie_beside_what_is_told():
    """Every second band of the eye lies in the middle between two coarser steps, and goes to one of them."""
    middles = []
    for value in np.unique(told_by_the_eye(2.0)):
        low, high = told_between(value, 0.1, 2.0)
        middles.append(np.log(low * high) / 2.0 - np.log(value))
    assert np.abs(middles).max() > 0.04


@pytest.mark.parametrize(("told", "factor"), [(14.14, 4.0), (13.47, 1.0)])
def test_what_the_eye_never_tells_is_of_no_band(told, factor):
    assert told_between(told, 0.1, factor) == (0.0, 0.0)
    low, high = np.array([1.0, 2.0]), np.array([3.0, 4.0])
    all_told_between(np.array([told, np.nan]), 0.1, factor, low, high)
    assert low.tolist() == [1.0, 2.0]
    assert high.tolist() == [3.0, 4.0]
