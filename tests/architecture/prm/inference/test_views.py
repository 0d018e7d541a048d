"""Numbers read from beliefs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import load, names, variables_of
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cprm_gym.architecture.prm.grounding.grounding import GroundVariable
from cprm_gym.architecture.prm.inference.views import View, view
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.errors import EvidenceError, ModelError

DIST = Bins((0.0, 2.0, 5.0, 10.0, 20.0, 40.0), "m")
TEXTS = (
    "expectation", "variance", "variance(midpoints)", "deviation", "mode", "argmax", "entropy", "quantile(0.9)",
    "probability(2..5)", "probability(2..5|5..10)", "probability(..7)", "probability(3..)", "probability(1.5..1e1)",
)  # fmt: skip


def close(a, b):
    assert abs(float(a) - b) <= 1e-9, (float(a), b)


def test_moments_match_the_recorded_ones():
    case = load("m01")
    bins, p = Bins(tuple(case["edges"])), np.array(case["p"])
    close(view("expectation")(p, bins), case["mean"])
    close(view("variance(midpoints)")(p, bins), case["variance_midpoints"])
    close(view("variance")(p, bins), case["variance_with_within_bin"])
    assert view("argmax")(p, bins) == case["argmax"]
    angle = case["circular"]
    circle, q = Bins(tuple(angle["edges"]), "deg", circular=True), np.array(angle["p"])
    close(view("expectation")(q, circle), angle["mean_deg"])
    close(view("resultant")(q, circle), angle["resultant"])
    straight = Bins(circle.edges)
    close(view("expectation")(q, straight), angle["naive_linear_mean"])


@pytest.mark.parametrize("name", names("filter"))
def test_views_of_recorded_posteriors_match_the_recorded_moments(name):
    """In these files expectation and variance are of the state index."""
    case = load(name)
    variables = variables_of(case)
    for step in case["steps"]:
        for variable, mean in step.get("expectation", {}).items():
            p = np.array(step["posterior"][variable])
            close(view("expectation")(p, variables[variable]), mean)
            close(view("variance")(p, variables[variable]), step["variance"][variable])


@pytest.mark.parametrize("text", TEXTS)
def test_a_view_and_its_text_are_one(text):
    assert View.parse(text).text == text
    assert View.parse(View.parse(text).text) == View.parse(text)


@pytest.mark.parametrize("text", TEXTS)
def test_a_view_of_many_beliefs_is_the_view_of_each(text):
    beliefs = np.random.default_rng(1).dirichlet(np.ones(5), (3, 4))
    many = view(text)(beliefs, DIST)
    assert many.shape == (3, 4)
    for index in np.ndindex(3, 4):
        assert many[index] == pytest.approx(float(view(text)(beliefs[index], DIST)), abs=1e-13)


@given(arrays(float, 5, elements=st.floats(0.01, 1)), st.floats(0, 1))
def test_quantile_inverts_the_probability_of_an_interval(weights, share):
    p = weights / weights.sum()
    at = float(view(f"quantile({share})")(p, DIST))
    assert float(view(f"probability(..{at!r})")(p, DIST)) == pytest.approx(share, abs=1e-9)


@given(arrays(float, 5, elements=st.floats(0.0, 1)), st.floats(0, 40), st.floats(0, 40))
def test_an_interval_and_what_is_outside_it_sum_to_one(weights, a, b):
    p = (weights + 1e-3) / (weights + 1e-3).sum()
    a, b = min(a, b), max(a, b)
    parts = [f"..{a!r}", f"{a!r}..{b!r}", f"{b!r}.."]
    assert sum(float(view(f"probability({part})")(p, DIST)) for part in parts) == pytest.approx(1.0, abs=1e-9)


def test_moments_equal_those_of_the_piecewise_uniform_density():
    p = np.array([0.1, 0.25, 0.4, 0.2, 0.05])
    inside = (np.arange(20_000) + 0.5) / 20_000
    x = np.array(DIST.edges)[:-1, None] + np.array(DIST.widths)[:, None] * inside
    mass = np.repeat(p / 20_000, 20_000)
    mean = mass @ x.ravel()
    assert float(view("expectation")(p, DIST)) == pytest.approx(mean, abs=1e-9)
    assert float(view("variance")(p, DIST)) == pytest.approx(mass @ (x.ravel() - mean) ** 2, rel=1e-7)
    assert float(view("quantile(0.3)")(p, DIST)) == pytest.approx(x.ravel()[np.searchsorted(np.cumsum(mass), 0.3)], abs=1e-3)


def test_an_interval_of_an_angle_may_wrap():
    circle = Bins.circle(4, "deg")
    p = np.array([0.1, 0.2, 0.3, 0.4])
    assert float(view("probability(135..-135)")(p, circle)) == pytest.approx(0.5 * 0.4 + 0.5 * 0.1)
    assert float(view("probability(-45..45)")(p, circle)) == pytest.approx(0.5 * 0.2 + 0.5 * 0.3)
    assert float(view("probability(90..180)")(p, circle)) == pytest.approx(0.4)
    assert float(view("probability(-180..180)")(p, circle)) == 1.0


def test_variance_of_an_angle_does_not_depend_on_where_the_circle_is_cut():
    p = np.array([0.5, 0.1, 0.0, 0.0, 0.0, 0.0, 0.1, 0.3])
    circle = Bins.circle(8)
    for turn in range(8):
        assert float(view("variance")(np.roll(p, turn), circle)) == pytest.approx(float(view("variance")(p, circle)))


def test_named_states():
    zones = GroundVariable("ball.zone", ("own", "middle", "attack"))
    p = np.array([0.2, 0.5, 0.3])
    assert float(view("probability(own|attack)")(p, zones)) == pytest.approx(0.5)
    assert float(view("expectation")(p, zones)) == pytest.approx(1.1)
    assert float(view("mode")(p, zones)) == 1.0
    assert float(view("quantile(0.75)")(p, zones)) == 2.0
    assert float(view("probability(yes)")(np.array([0.25, 0.75]), BOOL)) == 0.75


def test_entropy_of_a_certain_and_of_an_even_belief():
    assert float(view("entropy")(np.array([1.0, 0.0]), BOOL)) == 0.0
    assert float(view("entropy")(np.array([0.5, 0.5]), BOOL)) == pytest.approx(math.log(2))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("expectaton", "unknown view 'expectaton'. Did you mean 'expectation'"),
        ("probability", "needs an argument"),
        ("probability(", "bracket is not closed"),
        ("probability()", "nothing stands in the brackets"),
        ("quantile(1.5)", "a share is 0 to 1"),
        ("quantile(nan)", "a share is 0 to 1"),
        ("expectation(x)", "takes no argument"),
    ],
)
def test_a_wrong_view_is_refused_when_written(text, message):
    with pytest.raises(ModelError, match=message):
        view(text)


@pytest.mark.parametrize(
    ("text", "domain", "message"),
    [
        ("probability(atack)", Labels(("own", "attack")), "unknown state 'atack'. Did you mean 'attack'"),
        ("probability(1..2)", Labels(("own", "attack")), "unknown state '1..2'"),
        ("probability(7..2)", DIST, "the interval is empty"),
        ("quantile(0.5)", Bins.circle(4), "an angle has no order"),
        ("resultant", DIST, "only an angle has one"),
    ],
)
def test_a_view_that_a_variable_does_not_have_is_refused(text, domain, message):
    with pytest.raises(ModelError, match=message):
        view(text).check(domain)


def test_a_belief_of_the_wrong_size_is_refused():
    with pytest.raises(EvidenceError, match="a belief over 5 states is needed"):
        view("expectation")(np.ones(4) / 4, DIST)


@pytest.mark.parametrize("argument", ["50..60", "-5..-1", "40.5..", "..-0.5"])
def test_an_interval_beyond_the_bins_is_an_error_and_not_a_probability_of_zero(argument):
    with pytest.raises(ModelError, match="interval"):
        View.parse(f"probability({argument})")(np.array([0.5, 0.5]), Bins((0, 20, 40)))


def test_an_interval_that_reaches_beyond_the_bins_counts_what_lies_inside():
    assert View.parse("probability(30..100)")(np.array([0.5, 0.5]), Bins((0, 20, 40))) == pytest.approx(0.25)
