"""The report on what bins do to a belief."""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import soccer

from cprm_gym.architecture.prm.model.cpds import Noise, Switch, Uniform
from cprm_gym.architecture.prm.model.diffusion import diffusion_report
from cprm_gym.architecture.prm.model.domains import BOOL, Bins
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, PRMClass
from cprm_gym.errors import ParameterError


def approaching(count, sd=0.3, speed=-0.5):
    dist = Bins.linear(0, 60, count, "m")
    cpd = Noise(f"prev.dist + {speed}", sd)
    return Model("m", (PRMClass("Ball", (Attribute("dist", dist, cpd, parents=("prev.dist",), initial=Uniform()),)),))


def test_two_metre_bins_spread_an_approaching_ball_threefold():
    """20 steps of -0.5 m with deviation 0.3: 1.4 m become 3.9 m, total variation 0.43 (specification/inference.md 2)."""
    (row,) = diffusion_report(approaching(30), steps=20).rows
    assert row.shift == pytest.approx(-0.5)
    assert row.deviation == pytest.approx(np.sqrt(20 * 0.09 + 4 / 12), rel=0.02)
    assert row.binned_deviation == pytest.approx(3.9, abs=0.1)
    assert row.binned_mean == pytest.approx(row.mean, abs=0.1)
    assert row.distance == pytest.approx(0.43, abs=0.03)
    assert row.inflation == pytest.approx(2.7, abs=0.15)


def test_narrower_bins_spread_less():
    distances = [diffusion_report(approaching(n)).rows[0].distance for n in (15, 60, 240)]
    assert distances[0] > distances[1] > distances[2]


def test_the_leak_adds_the_variance_that_the_rule_of_thumb_says():
    """Motion p bins a step without noise: the variance grows by about w^2 p (1 - p) a step."""
    (row,) = diffusion_report(approaching(30, sd=0.0), steps=20).rows
    p = 0.25
    assert row.binned_deviation**2 - 4 / 12 == pytest.approx(20 * 4 * p * (1 - p), rel=0.02)


def test_every_motion_of_the_soccer_model_is_reported_at_three_settings():
    report = diffusion_report(soccer(6), steps=5)
    quantities = {row.key[1:3] for row in report.rows}
    assert ("Ball", "dist") in quantities
    assert ("attended", "o.dir") in quantities
    assert ("Ball", "obs_dist") not in quantities
    speeds = [row.given["prev.vdist"] for row in report.rows if row.key[1:3] == ("Ball", "dist")]
    assert speeds == ["-3..-2", "-1..0", "2..3"]
    assert all(0.0 < row.mean < 30.0 for row in report.rows if row.key[2] in ("dist", "o.dist"))
    assert str(report).count("\n") == len(report.rows) + 1
    assert report.worst is not None
    assert report.worst.distance == max(row.distance for row in report.rows)


def test_an_angle_that_turns_through_the_seam_is_compared_the_short_way_round():
    circle = Bins.circle(12)
    turning = Attribute("dir", circle, Noise("prev.dir + 0.1", 0.1), parents=("prev.dir",), initial=Uniform())
    (row,) = diffusion_report(Model("m", (PRMClass("C", (turning,)),)), steps=10).rows
    expected = circle.values[0] + 1.0
    assert row.mean == pytest.approx(expected, abs=0.02)
    assert row.binned_mean == pytest.approx(expected, abs=0.05)
    assert row.deviation < row.binned_deviation < 1.0


def test_each_case_of_a_switch_is_reported_with_its_state():
    cpd = Switch("moving", {"yes": Noise("prev.x + 1", 0.2), "no": Noise("prev.x", 0.2)})
    c = PRMClass(
        "C",
        (Attribute("moving", BOOL), Attribute("x", Bins.linear(0, 20, 10), cpd, parents=("prev.x", "moving"), initial=Uniform())),
    )
    rows = diffusion_report(Model("m", (c,)), steps=4).rows
    assert [(r.given["moving"], round(r.shift, 6)) for r in rows] == [("yes", 1.0), ("no", 0.0)]


def test_a_model_without_motion_says_so():
    report = diffusion_report(Model("m", (PRMClass("C", (Attribute("x", BOOL),)),)))
    assert str(report) == "no binned quantity moves by a noise model"
    assert report.worst is None


def test_no_steps_are_refused():
    with pytest.raises(ParameterError, match="at least 1 step"):
        diffusion_report(approaching(5), steps=0)
