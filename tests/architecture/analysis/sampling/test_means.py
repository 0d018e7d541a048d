"""Means: intervals that hold, how wide they are, numbers of runs, what is refused."""

import json
import math

import gymnasium
import numpy as np
import pytest

from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.generators import walk_chain
from cprm_gym.architecture.analysis.sampling.gymnasium_runs import GymnasiumRuns
from cprm_gym.architecture.analysis.sampling.means import mean_interval, mean_sequence
from cprm_gym.architecture.analysis.sampling.numbers import Number
from cprm_gym.architecture.analysis.sampling.runs import ChainRuns, Run
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.errors import ExpressionError, FormatError, ModelError, UnknownName

WALK = walk_chain(10, 0.45)
HEIGHT = {"height": np.arange(11.0)}
KINDS = {
    "narrow": (lambda rng, n: rng.beta(10, 30, n), 0.25),
    "rare": (lambda rng, n: (rng.random(n) < 0.02).astype(float), 0.02),
    "even": (lambda rng, n: rng.random(n), 0.5),
    "two ends": (lambda rng, n: rng.beta(0.1, 0.2, n), 1 / 3),
}


@pytest.mark.parametrize("kind", KINDS)
def test_within_a_range_the_mean_is_inside_as_often_as_said(kind):
    """1000 repetitions, nominal 95 %: at most 50 misses and three standard errors."""
    draw, mean = KINDS[kind]
    rng = np.random.default_rng(11)
    missed = sum(not mean_interval(draw(rng, 60), within=(0, 1)).holds(mean) for _ in range(1000))
    assert missed <= 50 + 3 * math.sqrt(1000 * 0.05 * 0.95)


def test_without_a_range_it_holds_about_so_often():
    rng = np.random.default_rng(12)
    missed = sum(not mean_interval(rng.normal(3.0, 2.0, 30)).holds(3.0) for _ in range(1000))
    assert 50 - 3 * math.sqrt(1000 * 0.05 * 0.95) <= missed <= 50 + 3 * math.sqrt(1000 * 0.05 * 0.95)


@pytest.mark.parametrize("within", [(0.0, 1.0), None])
def test_a_sequence_may_be_looked_at_again_and_again(within):
    """200 repetitions, each looked at 12 times."""
    rng = np.random.default_rng(13)
    erred = peeked = 0
    for _ in range(200):
        x = rng.beta(2, 3, 500)
        looks = np.unique(np.geomspace(20, 500, 12).astype(int))
        erred += any(not mean_sequence(x[:n], within=within).holds(0.4) for n in looks)
        peeked += any(not mean_interval(x[:n]).holds(0.4) for n in looks)
    assert erred <= 0.05 * 200
    assert peeked > 0.12 * 200


def test_what_varies_little_is_known_better_than_its_range_says():
    x = np.random.default_rng(14).beta(10, 30, 1000)
    hoeffding = 2 * math.sqrt(math.log(2 / 0.05) / 2 / 1000)
    narrow = mean_interval(x, within=(0, 1)).width
    assert narrow < 0.2 * hoeffding
    assert narrow < 1.6 * mean_interval(x).width
    assert mean_sequence(x, within=(0, 1)).width < 0.25 * hoeffding


def test_range_and_scale_do_not_matter():
    x = np.random.default_rng(15).random(200)
    low, high = mean_interval(x, within=(0, 1))
    assert mean_interval(5.0 * x - 2.0, within=(-2, 3)) == pytest.approx((5 * low - 2, 5 * high - 2), abs=1e-8)
    assert mean_interval(-x, within=(-1, 0)) == pytest.approx((-high, -low), abs=1e-8)
    assert mean_interval([], within=(0, 7)) == mean_sequence([], within=(0, 7)) == (0, 7)
    assert mean_interval([3.0] * 50, within=(3, 3)) == (3, 3)
    assert mean_interval([3.0]) == (-math.inf, math.inf)


def test_many_values_are_rounded_outward():
    x = np.random.default_rng(16).random(30_000)
    assert mean_sequence(x, within=(0, 1)).holds(float(x.mean()))
    assert mean_sequence(x, within=(0, 1)).width < 0.02


@pytest.mark.parametrize(
    ("values", "given", "message"),
    [
        ([0.0, 2.0], {"within": (0, 1)}, r"value 1 is 2, outside of the stated range from 0 to 1"),
        ([math.nan], {}, "value 0 is nan"),
        ([1.0], {"confidence": 1.0}, "confidence 1.0"),
        ([1.0], {"within": (2, 1)}, "do not fall"),
        ([1.0], {"within": (0, math.inf)}, "finite"),
    ],
)
def test_values_without_sense_are_refused(values, given, message):
    for interval in (mean_interval, mean_sequence):
        with pytest.raises(ModelError, match=message):
            interval(values, **given)


def test_lengths_and_heights_of_runs_beside_outcomes():
    exact = absorption(WALK)
    found = sample(
        ChainRuns(WALK, limit=400, signals=HEIGHT), 2000, numbers={"length": (0, 400), "max height": (0, 10), "last height": None}
    )
    assert found.mean("length").holds(exact.expected_time.value)
    assert found.mean_sequence("length").holds(exact.expected_time.value)
    assert found.mean("last height").holds(10 * exact.probability("rich").value)
    assert max(found.values("max height")) == 10
    assert all(found.means()[name].width >= found.mean(name).width for name in found.ranges)
    told = found.to_json()["numbers"]
    assert told["length"]["interval"][0] <= told["length"]["mean"] <= told["length"]["interval"][1]
    assert told["last height"]["range"] is None
    with pytest.raises(UnknownName, match="Did you mean 'length'"):
        found.mean("lenght")


def test_sampling_stops_when_a_mean_is_known_well_enough():
    found = sample(ChainRuns(WALK, limit=400), 10**5, numbers={"length": (0, 400)}, width={"length": 6.0})
    assert found.reason == "width"
    assert found.mean_sequence("length").width <= 6.0
    assert found.mean_sequence("length").holds(absorption(WALK).expected_time.value)
    with pytest.raises(UnknownName, match="width, outcome or number 'lenght'"):
        sample(ChainRuns(WALK), 10, width={"lenght": 1.0})


def test_numbers_are_taken_up_again_in_their_order(tmp_path):
    journal = tmp_path / "runs.jsonl"
    wanted = {"numbers": {"length": (0, 400)}, "block": 50, "journal": journal}
    sample(ChainRuns(WALK, limit=400), 200, **wanted)
    lines = journal.read_text().splitlines()
    journal.write_text("\n".join([lines[0], lines[3], lines[1]]) + "\n")
    again = sample(ChainRuns(WALK, limit=400), 200, **wanted)
    assert again.values("length") == sample(ChainRuns(WALK, limit=400), 200, numbers=["length"]).values("length")
    damaged = json.loads(lines[1])
    damaged["numbers"]["length"].pop()
    journal.write_text("\n".join([lines[0], json.dumps(damaged)]) + "\n")
    with pytest.raises(FormatError, match="does not add up"):
        sample(ChainRuns(WALK, limit=400), 200, **wanted)


def test_return_and_length_of_any_environment():
    """An arm that always gives 1 and a coin for the end: the return is the length."""
    found = sample(GymnasiumRuns("CartPole-v1"), 60, numbers={"return": (0, 500), "length": (1, 500), "max abs(obs.o2)": None})
    assert found.values("return") == found.values("length")
    assert 5 < found.mean("return").low < found.mean("return").high < 60
    discounted = sample(GymnasiumRuns("CartPole-v1", discount=0.9), 60, numbers={"return": (0, 10)})
    assert discounted.values("return") == pytest.approx([(1 - 0.9**n) / 0.1 for n in found.values("length")])
    assert max(found.values("max abs(obs.o2)")) < 0.5


def test_numbers_that_runs_do_not_have_are_named():
    run = Run("goal", 2, {"speed": np.array([0.1, 0.4])}, {"return": 3.0})
    assert Number("min speed").of(run) == 0.1
    with pytest.raises(ModelError, match="Did you mean 'return'"):
        Number("retun").of(run)
    with pytest.raises(ExpressionError, match="Did you mean 'speed'"):
        Number("sum sped").of(run)
    with pytest.raises(ModelError, match=r"run 0: number 'length': .* outside of the stated range from 0 to 1"):
        sample(ChainRuns(WALK), 10, numbers={"length": (0, 1)})
    for text, within in (("", None), ("length", (1, 0)), ("length", 3), ("length", (0, math.nan))):
        with pytest.raises(ModelError):
            Number(text, within)


def test_environments_that_there_are_not_are_named():
    with pytest.raises(UnknownName, match="Did you mean 'CartPole-v1'"):
        GymnasiumRuns("CartPoel-v1")
    with pytest.raises(UnknownName, match=r"Registered: CartPole-v0, CartPole-v1"):
        GymnasiumRuns("CartPole-v7")
    with pytest.raises(ModelError, match="no_such_module"):
        sample(GymnasiumRuns("no_such_module:CartPole-v1"), 2)
    with pytest.raises(ModelError, match="options"):
        sample(GymnasiumRuns("CartPole-v1", options={"speed": 3}), 2)
    with pytest.raises(ModelError, match="discount 2"):
        GymnasiumRuns("CartPole-v1", discount=2)
    assert "CartPole-v1" in gymnasium.registry
