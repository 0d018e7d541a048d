"""What a filter is told: numbers, states and likelihoods, and what is refused by name."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, load
from inference_filters import Fixed, umbrella

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.evidence import StateRows
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.architecture.prm.model.domains import Index
from cprm_gym.errors import EvidenceError, ModelError, ParameterError


def test_a_number_falls_into_its_bin_and_an_angle_goes_round():
    edges = np.array([0.0, 1.0, 3.0, 6.0])
    names = {
        "d": GroundVariable("d", ("a", "b", "c"), edges),
        "a": GroundVariable("a", ("w", "n", "e"), np.array([-3.0, -1.0, 1.0, 3.0]), circular=True),
    }
    uniform = np.full(3, 1 / 3)
    slice_ = GroundSlice(names, (GroundCPD("d", (), uniform, 0), GroundCPD("a", (), uniform, 0)))
    filter_ = Filter(Fixed(slice_, slice_), batch=4)
    result = filter_.step({"d": np.array([0.0, 1.0, 5.9, 6.0]), "a": np.array([3.5, -2.5, 0.0, 8.9])})
    np.testing.assert_array_equal(result["d"].argmax(axis=1), [0, 1, 2, 2])
    np.testing.assert_array_equal(result["a"].argmax(axis=1), [0, 0, 1, 2])
    for wrong, match in ((np.inf, "'d'.*inf is not a finite"), (7, "'d'.*outside"), (7.0, "'d'.*outside"), (-0.1, "'d'.*outside")):
        with pytest.raises(EvidenceError, match=match):
            filter_.step({"d": wrong})
    with pytest.raises(EvidenceError, match="'d'"):
        filter_.step({"d": np.array([0.5, np.nan, 1.0, -1.0])})
    masked = np.ma.masked_array([0.5, np.nan, 1.0, 1.0], mask=[False, True, False, False])
    for unseen in (masked, np.array([0.5, np.nan, 1.0, 1.0]), [0.5, None, 1, 1], Index(np.array([0, -1, 1, 1]))):
        np.testing.assert_allclose(filter_.step({"d": unseen})["d"][1], uniform)


def test_an_integer_given_to_bins_is_a_quantity_and_an_index_says_that_it_is_one():
    """`5` was bin 5 and `5.0` the bin that holds 5 m; -1 was "not observed" where -1.0 was a quantity."""
    edges = np.array([-10.0, 0.0, 1.0, 3.0, 6.0])
    variables = {"d": GroundVariable("d", tuple("abcd"), edges)}
    slice_ = GroundSlice(variables, (GroundCPD("d", (), np.full(4, 0.25), 0),))
    filter_ = Filter(Fixed(slice_, slice_), batch=2)
    for value, bins in (
        (5, [3, 3]),
        (np.int64(5), [3, 3]),
        (-1, [0, 0]),
        (np.array([2, -1]), [2, 0]),
        ([2, -1], [2, 0]),
        (Index(1), [1, 1]),
        (Index(np.array([3, 1])), [3, 1]),
        (StateRows(("d",), np.array([[3, 1]])), [3, 1]),
        (np.array([[3, 1]]), [3, 1]),
    ):
        evidence = value if isinstance(value, StateRows) or np.ndim(value) == 2 else {"d": value}
        assert filter_.step(evidence)["d"].argmax(axis=1).tolist() == bins


@pytest.mark.parametrize("binned", [False, True])
@pytest.mark.parametrize(
    "value",
    [
        [],
        {},
        set(),
        2**80,
        -(2**80),
        [10**5000],
        [2**80],
        1e400,
        [[1, 2], [3]],
        [[0]],
        ["x", 1],
        b"a",
        1j,
        object,
        Index(9),
        Index(np.array([7])),
    ],
)
def test_a_value_that_is_none_is_an_error_of_ours_that_names_the_variable(value, binned):
    variables = {"d": GroundVariable("d", ("a", "b"), np.array([0.0, 1.0, 2.0]) if binned else None)}
    filter_ = Filter(Fixed(*[GroundSlice(variables, (GroundCPD("d", (), np.full(2, 0.5), 0),))] * 2), batch=2)
    with pytest.raises(EvidenceError, match="'d'"):
        filter_.step({"d": value})


def test_evidence_nested_beyond_reason_is_refused():
    deep = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(EvidenceError, match="evidence for 'umb': got a list"):
        umbrella().step({"umb": deep}, relations="prior")


def test_evidence_that_is_no_mapping_is_refused():
    for evidence in ([1], "umb", 3, np.array([0.5])):
        with pytest.raises(EvidenceError, match="evidence"):
            umbrella().step(evidence, relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence"):
        umbrella().step({}, soft=[1.0, 2.0], relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence for 'umb'"):
        umbrella().step({}, soft={"umb": ["a", "b"]}, relations="prior")
    with pytest.raises(EvidenceError, match="an Index is an integer"):
        Index(0.5)


def test_wrong_observations_are_refused_by_name_and_change_nothing():
    filter_ = umbrella(batch=2)
    filter_.step(relations="prior")
    before = filter_.state
    wrong = [
        ({"umb": 2}, "'umb': 2 is no state"),
        ({"umb": -2}, "'umb'"),
        ({"umb": [0, 5]}, "'umb': 5"),
        ({"umb": "wet"}, "'umb': unknown state 'wet'"),
        ({"umbr": 1}, "'umbr'.*umb"),
        ({"umb": [0, 1, 0]}, "'umb' has shape"),
        ({"umb": 0.5}, "'umb'.*names"),
        ({"umb": object()}, "'umb'"),
    ]
    for evidence, match in wrong:
        with pytest.raises(EvidenceError, match=match):
            filter_.step(evidence, relations="step")
    for soft, match in [
        ({"umb": [1.0]}, "shape"),
        ({"umb": [-1.0, 1.0]}, "negative"),
        ({"umb": [np.nan, 1.0]}, "finite"),
        ({"u": [1, 1]}, "'u'"),
    ]:
        with pytest.raises(EvidenceError, match=match):
            filter_.step({}, soft=soft, relations="step")
    assert filter_.state.belief is before.belief
    assert filter_.step_count == 1


def test_evidence_may_be_an_array_in_the_order_of_the_variables():
    one, other = umbrella(batch=3), umbrella(batch=3)
    for filter_ in (one, other):
        filter_.step(relations="prior")
    hard = np.full((2, 3), -1)
    hard[one.variables("step").index("umb")] = [0, 1, -1]
    np.testing.assert_array_equal(one.step(hard, relations="step")["rain"], other.step({"umb": [0, 1, None]}, relations="step")["rain"])
    with pytest.raises(EvidenceError, match="shape"):
        one.step(hard[:1], relations="step")


def test_an_unknown_name_in_a_question_is_answered_with_the_nearest():
    filter_ = umbrella()
    result = filter_.step(relations="prior")
    with pytest.raises(ModelError, match=r"'rian'.*'rain'"):
        result["rian"]
    with pytest.raises(ModelError, match="'um'"):
        result.joint("rain", "um")
    with pytest.raises(ModelError, match="twice"):
        result.joint("rain", "rain")


@pytest.mark.parametrize(
    "wrong", [{"batch": 0}, {"on_impossible": "ignore"}, {"eps": 0.0}, {"engine": "exakt"}, {"particles": 5}, {"threads": 0}]
)
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ParameterError):
        umbrella(**wrong)


def test_jeffrey_demands_a_posterior_and_pearl_weighs_it():
    filter_ = umbrella(batch=2)
    filter_.step(relations="prior")
    soft = filter_.jeffrey({"rain": [0.3, 0.7]})
    np.testing.assert_allclose(filter_.step({}, soft=soft, relations="step")["rain"], [[0.3, 0.7]] * 2, atol=1e-12)
    pearl = umbrella()
    pearl.step(relations="prior")
    doubled = pearl.step({}, soft={"rain": [0.6, 1.4]}, relations="step")
    np.testing.assert_allclose(doubled["rain"], [[0.3, 0.7]], atol=1e-12)
    assert doubled.increment[0] == pytest.approx(np.log(0.5 * 0.6 + 0.5 * 1.4))


def test_what_is_given_must_be_told():
    case = load("d10_places_observed")
    filter_ = Filter(Schedule(case, given=("pl", "tok")))
    with pytest.raises(EvidenceError, match="'tok' must be given"):
        filter_.step({"pl": 1}, relations="prior")
    with pytest.raises(EvidenceError, match="soft evidence for 'pl'"):
        filter_.step({"pl": 1, "tok": 0}, soft={"pl": [1.0, 2.0]}, relations="prior")
