"""Paired comparisons, corrected for their number."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.benchmark.chapter5.comparisons import Pair, compare, interval
from cprm_gym.benchmark.chapter5.pieces import sentence


def rates(a, b, n, task="t"):
    """Pairs in which the first alone succeeds `a` times and the second alone `b` times."""
    ones, others = np.zeros(n, bool), np.zeros(n, bool)
    ones[:a], others[a : a + b] = True, True
    return Pair(task, "default", "one", "other", "success", ones, others)


def test_one_comparison_is_mcnemars_and_bonett_and_prices():
    (c,) = compare([rates(30, 10, 100)])
    assert c.p == pytest.approx(0.00222, abs=1e-4)
    assert c.difference == pytest.approx(0.2)
    assert (c.low, c.high) == pytest.approx((0.07751, 0.31465), abs=1e-4)
    assert c.effect == pytest.approx(2 * np.arcsin(np.sqrt(0.3)) - 2 * np.arcsin(np.sqrt(0.1)))
    assert c.better == "one"
    assert sentence(c).startswith("one > other in t: +20.0 points (+7.8, +31.5)")


def test_holm_multiplies_the_smallest_by_the_number_the_next_by_one_less_and_never_falls():
    pairs = [rates(30, 10, 100), rates(26, 14, 100), rates(40, 5, 100)]
    alone = [compare([pair])[0] for pair in pairs]
    together = compare(pairs)
    assert together[2].p == pytest.approx(min(1, 3 * alone[2].p))
    assert together[0].p == pytest.approx(2 * alone[0].p)
    assert together[1].p == pytest.approx(max(2 * alone[0].p, alone[1].p))
    assert [bool(c.better) for c in together] == [True, False, True]
    for one, many in zip(alone[:1] + alone[2:], together[:1] + together[2:]):
        assert many.low < one.low < one.high < many.high
    assert interval(pairs[2], 0.05 / 3)[1:] == (together[2].low, together[2].high)


def test_what_is_not_decided_has_no_better_and_the_worse_is_named_when_it_is_the_first():
    assert compare([rates(12, 10, 100)])[0].better == ""
    assert compare([rates(0, 0, 50)])[0].p == 1.0
    (worse,) = compare([rates(2, 30, 100)])
    assert worse.better == "other"
    assert worse.difference < 0
    assert sentence(worse).startswith("other > one in t: +28.0 points (+1")
    means = Pair("t", "default", "a", "b", "cycles", np.arange(20.0), np.arange(20.0) + np.tile([1.0, 2.0], 10))
    (c,) = compare([means])
    assert (c.better, c.difference, c.effect < -2) == ("b", -1.5, True)
    with pytest.raises(ValueError, match="needs two of one length"):
        compare([replace(means, others=np.arange(3.0))])


def test_many_comparisons_of_equals_are_seldom_decided():
    rng = np.random.default_rng(0)
    wrong = 0
    for _ in range(60):
        pairs = [Pair("t", "c", "a", "b", "success", rng.random(200) < 0.8, rng.random(200) < 0.8) for _ in range(10)]
        wrong += any(c.better for c in compare(pairs))
    assert wrong <= 8
