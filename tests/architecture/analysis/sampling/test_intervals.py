"""Intervals from counts against reference values, and their coverage."""

import json

import numpy as np
import pytest
from paths import SHARED
from scipy.stats import binom

from cprm_gym.architecture.analysis.sampling.intervals import clopper_pearson, lower_limit, simultaneous, upper_limit, wilson
from cprm_gym.errors import ModelError

STATS = SHARED / "cases" / "markov" / "stats"


@pytest.mark.skipif(not STATS.is_dir(), reason="data of ../shared absent")
def test_reference_values():
    for case in json.loads((STATS / "binomial_intervals.json").read_text())["cases"]:
        k, n, confidence = case["k"], case["n"], 1 - case["alpha"]
        assert clopper_pearson(k, n, confidence) == pytest.approx(case["clopper_pearson"], abs=1e-9)
        assert wilson(k, n, confidence) == pytest.approx(case["wilson"], abs=1e-12)
        assert upper_limit(k, n, confidence) == pytest.approx(case["cp_upper_one_sided"], abs=1e-9)
    for case in json.loads((STATS / "multinomial_intervals.json").read_text())["cases"]:
        found = simultaneous({str(i): c for i, c in enumerate(case["counts"])}, 1 - case["alpha"])
        assert np.array(list(found.values())) == pytest.approx(np.array(case["clopper_pearson_bonferroni"]), abs=1e-9)


@pytest.mark.parametrize("p", [1e-4, 1e-3, 0.01, 1.76e-4, 0.5, 0.97])
def test_coverage_is_at_least_what_is_said_and_wilsons_is_not(p):
    """Exact: the probability of all counts whose interval holds p."""
    n = 1000
    k = np.arange(n + 1)
    mass = binom.pmf(k, n, p)
    held = np.array([clopper_pearson(int(i), n).holds(p) for i in k if mass[i] > 1e-12])
    assert mass[mass > 1e-12][held].sum() >= 0.95 - 1e-9
    if p == 1.76e-4:
        assert sum(mass[i] for i in k if wilson(int(i), n).holds(p)) < 0.85


def test_all_outcomes_are_held_at_once():
    rng = np.random.default_rng(3)
    chances = {"kicked": 0.9, "failed": 0.07, "lost": 0.03}
    missed = 0
    for _ in range(1000):
        counts = dict(zip(chances, rng.multinomial(200, list(chances.values())).tolist()))
        found = simultaneous(counts)
        missed += not all(found[name].holds(p) for name, p in chances.items())
    assert missed <= 50 + 3 * (1000 * 0.05 * 0.95) ** 0.5


def test_one_sided_limits_are_nearer():
    assert upper_limit(3, 100) < clopper_pearson(3, 100).high
    assert lower_limit(97, 100) > clopper_pearson(97, 100).low
    assert lower_limit(0, 10) == 0.0
    assert upper_limit(10, 10) == 1.0


@pytest.mark.parametrize(("k", "n", "confidence"), [(3, 2, 0.95), (-1, 2, 0.95), (1, 2, 1.0), (1, 2, 0.0)])
def test_counts_that_cannot_be_are_refused(k, n, confidence):
    with pytest.raises(ModelError):
        clopper_pearson(k, n, confidence)
