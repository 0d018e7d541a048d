"""Formulas that bend, in the engine of Gaussian mixtures: lines that are taken again where readings lead to, and what guards them."""

import numpy as np
import pytest

from cprm_gym.architecture.prm import Attribute, Filter, Grounding, Interval, Model, Noise, PRMClass, Real
from cprm_gym.errors import ImpossibleEvidence

GRID = np.linspace(-6.0, 14.0, 40_001)


def world(*attributes):
    return Grounding(Model("test", (PRMClass("A", attributes),)), {"a": "A"})


def at_once(formula, mean, sd, noise):
    """A number and a reading that is no straight line of it."""
    return world(Attribute("x", Real("m"), Noise(str(mean), sd=sd)), Attribute("z", Real("m"), Noise(formula, sd=noise), ("x",)))


@pytest.mark.parametrize("sd", [2.0, 4.0])
def test_what_a_straight_line_predicts_is_not_taken_where_the_reading_leads_to(sd):
    """Only what bends is: else the prior would follow its own posterior. By a sum over a fine grid."""
    moving = world(
        Attribute("x", Real("m"), Noise("prev.x", sd=0.1), ("prev.x",), Noise("3", sd=1.0)),
        Attribute("z", Real("m"), Noise("x * x", sd=sd), ("x",)),
    )
    filter = Filter(moving, engine="mixture")
    filter.step({})
    answer = filter.step({"a.z": 16.0})
    p = np.exp(-0.5 * (GRID - 3.0) ** 2 / 1.01 - 0.5 * ((16.0 - GRID**2) / sd) ** 2)
    mean = np.average(GRID, weights=p)
    spread = np.sqrt(np.average((GRID - mean) ** 2, weights=p))
    assert not answer.report["astray"].any()
    assert abs(answer.read("a.x")[0] - mean) < 0.15 * spread
    assert abs(answer.read("a.x", "deviation")[0] / spread - 1.0) < 0.1


@pytest.mark.parametrize(("formula", "mean", "sd", "reading"), [("log(x)", 1.0, 0.3, -5.0), ("atan(20 * x)", 2.0, 1.0, -1.5),
                                                                ("1 / x", 1.0, 0.3, 100.0), ("exp(x)", 0.0, 2.0, 1e8)])  # fmt: skip
def test_lines_that_lead_astray_are_those_of_the_prediction_and_that_is_told(formula, mean, sd, reading):
    """Through the unscented points, once: mean and deviation by the same sum written down in numpy."""
    answer = Filter(at_once(formula, mean, sd, 0.1), engine="mixture").step({"a.z": reading})
    assert answer.report["astray"].tolist() == [True]
    points = mean + sd * np.sqrt(3.0) * np.array([0.0, 1.0, -1.0])
    share = np.array([2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0])
    function = {"log(x)": np.log, "atan(20 * x)": lambda x: np.arctan(20.0 * x), "1 / x": lambda x: 1.0 / x, "exp(x)": np.exp}[formula]
    # a point without a value counts as the middle
    values = np.array([function(x if formula != "log(x)" or x > 0.0 else mean) for x in points])
    expected = share @ values
    variance, together = share @ (values - expected) ** 2 + 0.01, share @ ((values - expected) * (points - mean))
    assert answer.read("a.x")[0] == pytest.approx(mean + together / variance * (reading - expected), rel=1e-6)
    assert answer.read("a.x", "variance")[0] == pytest.approx(sd**2 - together**2 / variance, rel=1e-6)


def test_agents_whose_lines_settle_are_not_called_astray():
    answer = Filter(at_once("log(x)", 1.0, 0.3, 0.1), batch=3, engine="mixture").step({"a.z": np.array([-5.0, 0.1, np.nan])})
    assert answer.report["astray"].tolist() == [True, False, False]


@pytest.mark.parametrize("reading", [1e160, -1e200, 1e308, Interval(1e200, 1e300), Interval(-1e308, 1e308), 1e-308])
def test_readings_beyond_the_range_of_numbers_leave_none_that_is_no_number(reading):
    linear = world(
        Attribute("x", Real("m"), Noise("prev.x", sd=0.1), ("prev.x",), Noise("3", sd=1.0)),
        Attribute("z", Real("m"), Noise("x", sd=1), ("x",)),
    )
    filter = Filter(linear, engine="mixture", on_impossible="restart")
    for told in (reading, 1.0):
        answer = filter.step({"a.z": told})
        assert np.isfinite([*answer.read("a.x"), *answer.read("a.x", "deviation"), *answer.log_likelihood]).all()
    if isinstance(reading, float) and abs(reading) > 1.0:
        with pytest.raises(ImpossibleEvidence, match=r"a\.z"):
            Filter(linear, engine="mixture").step({"a.z": reading})
