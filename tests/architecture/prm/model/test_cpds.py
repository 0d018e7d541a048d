"""CPDs: rows with wildcards, functions, and noise integrated over bins."""

from __future__ import annotations

import functools
import math
import time

import numpy as np
import pytest
from cases import load
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, stats
from scipy.special import ndtr

from cprm_gym.architecture.prm.model.cpds import Chance, Dense, Mixture, Noise, NoisyOr, Prior, Switch, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.architecture.prm.model.formulas import Formula
from cprm_gym.architecture.prm.model.integration import nodes
from cprm_gym.errors import ModelError

ZONES = Labels(("own", "middle", "attack"))
DIST = Bins((0.0, 2.0, 5.0, 10.0, 20.0, 40.0), "m")


def test_first_matching_row_of_a_table_wins():
    table = Table({("yes", "*"): (0.2, 0.8), ("*", "own"): (0.5, 0.5), ("*", "*"): (0.9, 0.1)})
    out = table.table(BOOL, [("a", BOOL), ("z", ZONES)])
    assert out[1, 0].tolist() == [0.2, 0.8]
    assert out[0, 0].tolist() == [0.5, 0.5]
    assert out[0, 2].tolist() == [0.9, 0.1]


def test_a_gap_in_a_table_is_refused_by_row():
    table = Table({("yes", "*"): (0.2, 0.8), ("no", "own"): (0.5, 0.5)})
    with pytest.raises(ModelError, match=r"attribute 'x': no row for \('no', 'middle'\) \(2 rows are missing\)"):
        table.table(BOOL, [("a", BOOL), ("z", ZONES)], "attribute 'x'")


def test_a_row_that_does_not_sum_to_one_is_refused_by_row():
    with pytest.raises(ModelError, match=r"row \('yes',\): probabilities sum to 0.9"):
        Table({"yes": (0.2, 0.7), "no": (0.5, 0.5)})


def test_a_row_of_the_wrong_length_is_refused_by_row():
    with pytest.raises(ModelError, match=r"attribute 'near', row \('own',\): 3 probabilities for 2 states"):
        Table({"own": (0.2, 0.3, 0.5)}).table(BOOL, [("zone", ZONES)], "attribute 'near'")


@pytest.mark.parametrize("row", [(1.5, -0.5), (math.nan, 1.0), (math.inf, 0.0), ("a", "b")])
def test_what_is_no_probability_is_refused(row):
    with pytest.raises(ModelError, match="probabilit"):
        Prior(row)


def test_an_unknown_state_in_a_row_suggests_the_nearest():
    with pytest.raises(ModelError, match=r"'zone' has no state 'midle'. Did you mean 'middle'"):
        Table({"midle": (0.5, 0.5), "*": (1.0, 0.0)}).table(BOOL, [("zone", ZONES)])


def test_a_table_from_a_function_sees_state_names_and_bin_middles():
    seen = []

    def near(zone, dist):
        seen.append((zone, dist))
        return (0.5, 0.5) if zone == "own" and dist < 3 else (0.95, 0.05)

    out = Table.from_function(near, ZONES, DIST).table(BOOL, [("zone", ZONES), ("dist", DIST)])
    assert ("own", 3.5) in seen
    assert out[0, 0].tolist() == [0.5, 0.5]
    assert out[2, 0].tolist() == [0.95, 0.05]


def test_a_dense_table_remembers_the_bins_it_was_made_for():
    dense = Dense(np.full((5, 2), 0.5), (DIST.stamp, BOOL.stamp))
    assert dense.table(BOOL, [("dist", DIST)]).shape == (5, 2)
    with pytest.raises(ModelError, match="axis 0 was made for"):
        dense.table(BOOL, [("dist", Bins((0, 2, 5, 10, 20, 41)))])


def test_a_dense_row_that_does_not_sum_to_one_is_refused_by_the_names_of_its_states():
    values = np.full((3, 2), 0.5)
    values[1] = (0.5, 0.6)
    with pytest.raises(ModelError, match=r"row \('middle',\): probabilities sum to 1.1"):
        Dense(values).table(BOOL, [("zone", ZONES)])


def test_dense_tables_with_equal_numbers_are_equal_values():
    assert Dense([[0.5, 0.5]]) == Dense(np.array([[0.5, 0.5]]))
    assert Dense([[0.5, 0.5]]) != Dense([[0.4, 0.6]])
    assert hash(Dense([[0.5, 0.5]])) == hash(Dense([[0.5, 0.5]]))


@pytest.mark.parametrize(
    ("part", "mean", "sd", "axes"), [("identity", "d", 0.8, 1), ("drift", "d + v", 0.8, 2), ("circular", "a + 10", 12.0, 1)]
)
def test_integrated_cpds_match_the_recorded_ones(part, mean, sd, axes):
    case = load("g01")
    dist, speed, angle = Bins(tuple(case["edges"])), Bins(tuple(case["vedges"])), Bins.circle(8, "deg")
    parents = {"identity": [("d", dist)], "drift": [("d", dist), ("v", speed)], "circular": [("a", angle)]}[part]
    child = angle if part == "circular" else dist
    shape = [len(child), *(len(d) for _, d in parents)]
    recorded = np.moveaxis(np.array(case[part]["table"]).reshape(shape), 0, -1)
    made = Noise(mean, sd, floor=0.0).table(child, parents)
    assert made.ndim == axes + 1
    assert np.abs(made - recorded).max() < 1e-11


def test_far_tails_keep_their_digits():
    """A cell eight deviations away is as small as quadrature says, not rounded to nothing."""
    bins = Bins((0.0, 1.0, 9.0, 10.0))
    made = Noise("d", 1.0, floor=0.0).table(bins, [("d", bins)])
    exact, _ = integrate.quad(lambda x: stats.norm.sf(9.0 - x), 0.0, 1.0, epsabs=0.0)
    assert made[0, 2] == pytest.approx(exact, rel=1e-9)
    assert made[2, 0] == pytest.approx(exact, rel=1e-9)


def test_an_object_slower_than_a_bin_a_step_moves():
    """The mean moves by the speed, where a table of bin centres would stand still."""
    bins = Bins.linear(-40, 40, 40)
    row = Noise("d - 0.5", 0.1, floor=0.0).table(bins, [("d", bins)])[20]
    assert row @ np.array(bins.values) == pytest.approx(bins.values[20] - 0.5, abs=1e-9)


@given(st.floats(-2, 2), st.floats(0.05, 3), st.sampled_from(["normal", "uniform"]), st.booleans())
def test_integrated_rows_are_distributions_that_sum_to_one(coefficient, sd, shape, circular):
    bins = Bins.circle(7) if circular else Bins.linear(-3, 3, 7)
    out = Noise(f"{coefficient} * d + 0.3 * v", sd, shape).table(bins, [("d", bins), ("v", Bins.linear(-1, 1, 3))])
    assert out.min() > 0.0
    assert np.abs(out.sum(axis=-1) - 1.0).max() < 1e-12


def brute(child, function, sd, low, high, count=200_001):
    """Average over a fine grid of the parent of the noise's mass in each bin."""
    x = low + (np.arange(count) + 0.5) * (high - low) / count
    edges = np.concatenate([[-np.inf], child.edges[1:-1], [np.inf]])
    cdf = stats.norm.cdf((edges[:, None] - function(x)[None, :]) / sd(x)[None, :])
    return np.diff(cdf, axis=0).mean(axis=1)


def test_multiplicative_noise_equals_brute_force():
    made = Noise("d", "0.1 * d", floor=0.0).table(DIST, [("d", DIST)])
    for k in (1, 3):
        assert np.abs(made[k] - brute(DIST, lambda x: x, lambda x: 0.1 * x, DIST.edges[k], DIST.edges[k + 1])).max() < 1e-6


def test_a_mean_that_is_no_straight_line_equals_brute_force():
    made = Noise("sqrt(d)", 0.4, floor=0.0).table(DIST, [("d", DIST)])
    reference = brute(DIST, np.sqrt, lambda x: np.full_like(x, 0.4), 2.0, 5.0)
    assert np.abs(made[1] - reference).max() < 1e-9


def test_uniform_noise_is_a_trapezoid():
    """A value uniform in 0..1 plus noise uniform in -1/2..1/2 lies in 0..1 with probability 3/4."""
    bins = Bins((-5.0, 0.0, 1.0, 5.0))
    row = Noise("d", 0.5 / math.sqrt(3.0), "uniform", floor=0.0).table(bins, [("d", bins)])[1]
    assert row == pytest.approx([0.125, 0.75, 0.125], abs=1e-12)


def test_a_value_without_noise_goes_where_it_belongs():
    bins = Bins((0.0, 1.0, 2.0, 3.0))
    row = Noise("d + 0.25", 0.0, floor=0.0).table(bins, [("d", bins)])[0]
    assert row == pytest.approx([0.75, 0.25, 0.0], abs=1e-15)


def test_an_angle_wraps_and_keeps_its_shape_under_turns():
    """Turning the mean by one bin turns the row by one bin, across the seam too."""
    circle = Bins.circle(8)
    turn = 2 * math.pi / 8
    still = Noise("a", 0.3, floor=0.0).table(circle, [("a", circle)])
    turned = Noise(f"a + {turn!r}", 0.3, floor=0.0).table(circle, [("a", circle)])
    for k in range(8):
        assert np.abs(np.roll(still[0], k) - still[k]).max() < 1e-14
        assert np.abs(np.roll(still[k], 1) - turned[k]).max() < 1e-14


def test_a_quantised_sense_is_integrated_like_any_other():
    """A reading rounded to whole numbers of its logarithm, as a sight that gets coarser with distance."""
    sense = Noise("exp(round(log(max(d, 0.1)) / 0.1) * 0.1)", 0.0, floor=0.0, points=2000)
    x = 2.0 + 3.0 * (np.arange(400_000) + 0.5) / 400_000
    wanted = np.histogram(np.exp(np.rint(np.log(x) / 0.1) * 0.1), DIST.edges)[0] / 400_000
    assert np.abs(sense.table(DIST, [("d", DIST)])[1] - wanted).max() < 1e-3


def test_noise_that_goes_round_a_circle_without_end_is_refused():
    circle = Bins.circle(4)
    with pytest.raises(ModelError, match="more than 500 times"):
        Noise("a", 1e6).table(circle, [("a", circle)])
    assert Noise("a", 10.0, floor=0.0).table(circle, [("a", circle)]) == pytest.approx(np.full((4, 4), 0.25))


def test_the_floor_makes_no_observation_impossible():
    out = Noise("d", 0.01, floor=1e-6).table(DIST, [("d", DIST)])
    assert out.min() == pytest.approx(1e-6 / 5, rel=1e-6)


def test_a_formula_with_a_name_that_is_no_parent_suggests_the_nearest():
    with pytest.raises(ModelError, match=r"'dist' is not a parent. Did you mean 'prev.dist'"):
        Noise("dist", 0.1).table(DIST, [("prev.dist", DIST)])


def test_a_negative_deviation_is_refused():
    with pytest.raises(ModelError, match="must not be negative"):
        Noise("d", "d - 10").table(DIST, [("d", DIST)])


def test_a_formula_without_a_finite_value_says_where():
    with pytest.raises(ModelError, match="has no finite value at p0 = "):
        Noise("log(0 - d)", 1.0).table(DIST, [("d", DIST)])


def test_a_formula_that_is_no_expression_is_refused_when_written():
    with pytest.raises(ModelError, match="__import__"):
        Noise("__import__('os')", 1.0)


def test_a_chance_is_averaged_over_the_bin():
    """p = d / 10 over the bin 2..5 is 0.35."""
    out = Chance("min(d / 10, 1)").table(BOOL, [("d", DIST)])
    assert out[1, 1] == pytest.approx(0.35, abs=1e-12)


def test_a_chance_above_one_is_refused():
    with pytest.raises(ModelError, match="a probability is 0 to 1"):
        Chance("d").table(BOOL, [("d", DIST)])


def test_a_switch_gives_each_state_its_cpd():
    cpd = Switch("seen", {"yes": Noise("d", 0.5, floor=0.0), "*": Uniform()})
    out = cpd.table(DIST, [("d", DIST), ("seen", BOOL)])
    assert np.array_equal(out[:, 1], Noise("d", 0.5, floor=0.0).table(DIST, [("d", DIST)]))
    assert np.all(out[:, 0] == 0.2)


def test_a_switch_without_a_case_names_the_state():
    with pytest.raises(ModelError, match="has no case for 'no'"):
        Switch("seen", {"yes": Uniform()}).table(DIST, [("seen", BOOL)])


def test_a_mixture_is_the_weighted_mean():
    out = Mixture((0.25, Prior((1.0, 0.0))), (0.75, (0.0, 1.0))).table(BOOL, [])
    assert out.tolist() == [0.25, 0.75]
    with pytest.raises(ModelError, match="sum to"):
        Mixture((0.5, Uniform()), (0.6, Uniform()))


def test_noisy_or_multiplies_the_failures():
    out = NoisyOr((0.8, 0.5), leak=0.1).table(BOOL, [("a", BOOL), ("b", BOOL)])
    assert out[..., 0] == pytest.approx(np.array([[0.9, 0.45], [0.18, 0.09]]))


def test_a_table_too_large_to_be_meant_is_refused_before_it_is_made():
    huge = Bins.linear(0, 1, 1000)
    with pytest.raises(ModelError, match="cells"):
        Uniform().table(huge, [("a", huge), ("b", huge)])


THREE = [(name, Bins.linear(0.0, 10.0, 8)) for name in "abc"]


@pytest.mark.parametrize(
    ("cpd", "child"),
    [
        (Noise("a * b * c", 0.1), Bins.linear(0.0, 10.0, 8)),
        (Noise("1000 * a + b * c", 0.01), Bins.circle(8)),
        (Chance("1 / (1 + exp(a + b * c))", points=128), BOOL),
    ],
)
def test_a_cpd_that_would_take_long_to_integrate_is_refused_and_told_how_to_be_cheaper(cpd, child):
    """Three parents of 8 bins with a narrow deviation took 3.8 s; on a circle each turn took it again."""
    begun = time.process_time()
    with pytest.raises(ModelError, match=r"values would be computed .*at most .*: set fewer `points` or bins"):
        cpd.table(child, THREE, "attribute 'x'")
    assert time.process_time() - begun < 3.0


def test_fewer_points_bring_a_cpd_within_the_limit():
    table = Noise("a * b * c", 0.1, points=16).table(Bins.linear(0.0, 10.0, 8), THREE)
    assert table.sum(axis=-1) == pytest.approx(1.0)


@pytest.mark.parametrize("text", ["a + b + c", "2 * a - b / 3 + 0.001 * c", "a - b + 0 * c", "(1 + l) * a - l * b + c", "a + b + c + d"])
@pytest.mark.parametrize("deviation", [0.3, 0.9, "0.3 + 0.1 * l"])
def test_the_mean_of_a_sum_of_parents_is_the_one_of_a_fine_grid(text, deviation):
    """Two parents that enter by a sum take one quadrature; the reference averages over a grid of points in every parent."""
    parents = [("a", Bins((0.0, 1.0, 1.5))), ("b", Bins((0.0, 0.5, 1.2))), ("c", Bins((0.0, 0.7, 1.0)))]
    parents += [("d", Bins((0.0, 0.4, 1.0)))] if "d" in text else []
    parents += [("l", Labels(("x", "y", "z")))]
    child = Bins((0.0, 1.0, 2.0, 4.0))
    table = Noise(text, deviation, floor=0.0).table(child, parents)
    formula, spread = Formula(text), Formula(str(deviation))
    rng = np.random.default_rng(5)
    for index in (rng.integers(0, [len(d) for _, d in parents]) for _ in range(4)):
        points = 20 if "d" in text else 40
        grids = []
        for (_, domain), k in zip(parents, index):
            x, w = nodes(*domain.edges[k : k + 2], points) if isinstance(domain, Bins) else (np.array([float(k)]), np.ones(1))
            grids.append((x, w))
        flat = {n: m.ravel() for (n, _), m in zip(parents, np.meshgrid(*[x for x, _ in grids], indexing="ij"))}
        weight = functools.reduce(np.multiply.outer, [w for _, w in grids]).ravel()
        mean, sd = formula(flat, len(weight)), spread(flat, len(weight))
        below = [weight @ ndtr((edge - mean) / sd) for edge in child.edges[1:-1]]
        expected = np.diff([0.0, *below, 1.0])
        assert table[tuple(index)] == pytest.approx(expected, abs=1e-6)


def test_a_sum_of_three_parents_with_a_narrow_deviation_is_integrated_at_once():
    """3.8 s before: 128 nodes in each of two parents, in each of 64 combinations of bins."""
    begun = time.process_time()
    table = Noise("a + b - c", 0.01).table(Bins.linear(0.0, 10.0, 8), THREE)
    assert time.process_time() - begun < 1.0
    assert table.sum(axis=-1) == pytest.approx(1.0)


@pytest.mark.parametrize("mean", ["3", "a", "a + b"])
def test_a_deviation_as_small_as_a_number_can_be_is_none(mean):
    """5e-324 overflowed in a quotient."""
    tiny = Noise(mean, 5e-324).table(Bins.linear(0.0, 10.0, 8), THREE)
    assert np.allclose(tiny, Noise(mean, 0.0).table(Bins.linear(0.0, 10.0, 8), THREE), atol=1e-4)
