"""What attributes can be, and how values become states."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels, as_domain, bin_indices, state_index
from cprm_gym.errors import EvidenceError, ModelError

DIST = Bins((0.0, 2.0, 5.0, 10.0), unit="m")


def test_a_repeated_state_is_refused_by_name():
    with pytest.raises(ModelError, match="'own' is named twice"):
        Labels(("own", "middle", "own"))


def test_states_given_as_a_bare_string_are_refused():
    with pytest.raises(ModelError, match="tuple of names"):
        as_domain("yes", "attribute 'x'")


def test_edges_that_do_not_increase_are_refused_by_position():
    with pytest.raises(ModelError, match=r"edge 1 is 5\.0, edge 2 is 5\.0"):
        Bins((0, 5, 5, 7))


def test_bin_names_are_their_intervals():
    assert DIST.states == ("0..2", "2..5", "5..10")


def test_bin_names_stay_distinct_when_edges_are_close():
    assert len(set(Bins((1.0000001, 1.0000002, 1.0000003)).states)) == 2


@pytest.mark.parametrize(("value", "state"), [(0.0, 0), (1.99, 0), (2.0, 1), (9.9, 2), (10.0, 2), (3, 1), (np.float32(3), 1), ("2..5", 1)])
def test_a_number_falls_into_its_bin(value, state):
    assert state_index(DIST, value, "evidence") == state


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, -0.1, 10.1])
def test_nan_and_numbers_outside_the_bins_are_refused_by_name(value):
    with pytest.raises(EvidenceError, match=r"evidence for 'ball.dist'.*0\.0 to 10\.0 m"):
        state_index(DIST, value, "evidence for 'ball.dist'")


def test_clipped_bins_take_values_outside_but_never_nan():
    clipped = Bins(DIST.edges, clip=True)
    assert [state_index(clipped, v, "e") for v in (-3.0, 40.0)] == [0, 2]
    with pytest.raises(EvidenceError, match="not a finite number"):
        state_index(clipped, math.nan, "e")


@given(st.floats(-50, 50), st.integers(1, 40))
def test_an_angle_and_the_same_angle_after_a_turn_share_a_bin(angle, count):
    circle = Bins.circle(count)
    first = state_index(circle, angle, "e")
    assert circle.edges[first] - 1e-9 <= (angle + math.pi) % (2 * math.pi) - math.pi <= circle.edges[first + 1] + 1e-9
    off_edge = min(abs((angle - e + math.pi) % (2 * math.pi) - math.pi) for e in circle.edges) > 1e-6
    if off_edge:
        assert state_index(circle, angle + 2 * math.pi, "e") == first


def test_labels_take_a_name_an_index_or_a_flag():
    assert [state_index(BOOL, v, "e") for v in ("no", "yes", 0, 1, True, np.int64(1), np.True_)] == [0, 1, 0, 1, 1, 1, 1]


def test_an_unknown_state_lists_the_known_ones_and_the_nearest():
    with pytest.raises(EvidenceError, match=r"unknown state 'atack'. Known: own, middle, attack\. Did you mean 'attack'\?"):
        state_index(Labels(("own", "middle", "attack")), "atack", "evidence for 'ball.zone'")


def test_an_index_outside_the_states_is_refused():
    with pytest.raises(EvidenceError, match="state index 2 is outside 0 to 1"):
        state_index(BOOL, 2, "e")


@given(st.floats(-60, 60) | st.sampled_from(DIST.edges), st.sampled_from([DIST, Bins(DIST.edges, clip=True), Bins.circle(7)]))
def test_one_value_and_many_are_binned_alike(x, bins):
    many = int(bin_indices(bins, np.array([x]))[0])
    try:
        assert state_index(bins, x, "e") == many
    except EvidenceError:
        assert many == -1


def test_many_values_are_binned_at_once_and_bad_ones_marked():
    out = bin_indices(DIST, np.array([[1.0, 7.0], [math.nan, 11.0]]))
    assert out.tolist() == [[0, 2], [-1, -1]]
