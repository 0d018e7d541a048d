"""Interval chains: known answers, chains that lie within, the text's bounds, natures that never let go."""

import json

import numpy as np
import pytest
from markov_chains import as_chain, random_rational_chain
from paths import SHARED

from cprm_gym.architecture.analysis.bounded.interval_chain import IntervalChain, load_interval_chain
from cprm_gym.architecture.analysis.bounded.unknown_state import unknown_state_bounds
from cprm_gym.architecture.analysis.bounded.value_iteration import bounds_over_time, interval_bounds
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.generators import behaviour_chain, random_chain, walk_chain
from cprm_gym.errors import FormatError, ModelError, UnknownName

CASES = sorted((SHARED / "cases" / "markov" / "idtmc").glob("*.json"))


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("file", CASES or ["absent"], ids=lambda f: getattr(f, "stem", f))
def test_known_answers(file):
    case = json.loads(file.read_text())
    chain = load_interval_chain(file)
    found = interval_bounds(chain)
    exact = case["expected_float"]
    assert found.probabilities["goal"] == pytest.approx((exact["min"], exact["max"]), abs=1e-9)
    assert found.probabilities["goal"].low <= exact["min"] + 1e-15
    assert found.probabilities["goal"].high >= exact["max"] - 1e-15
    if "steps_min" in exact:
        assert found.time == pytest.approx((exact["steps_min"], exact["steps_max"]), abs=1e-6)
    for horizon, known in case.get("expected_bounded", {}).items():
        low, high = bounds_over_time(chain, "goal", int(horizon))
        assert (low[-1], high[-1]) == pytest.approx((known["min"], known["max"]), abs=1e-12)
    text = unknown_state_bounds(chain, "goal")
    printed = case["methods"]["dissertation_bounds"]
    assert text == pytest.approx((printed["lower"], printed["upper_sound"]), abs=1e-9)


def feasible(chain, rng):
    """A random chain within an interval chain."""
    chances = chain.lower.copy()
    for i in range(chain.n):
        a, b = chain.offsets[i], chain.offsets[i + 1]
        left = 1.0 - chances[a:b].sum()
        for e in rng.permutation(np.arange(a, b)):
            more = min(chain.upper[e] - chain.lower[e], left) * (1.0 if rng.random() < 0.7 else rng.random())
            chances[e] += more
            left -= more
        for e in range(a, b):
            more = min(chain.upper[e] - chances[e], left)
            chances[e] += more
            left -= more
    return chain.chain(chances)


@pytest.mark.parametrize("seed", range(8))
def test_chains_within_the_bounds_have_answers_within_the_bounds(seed):
    rng = np.random.default_rng(seed)
    rows, ends = random_rational_chain(seed)
    chain = IntervalChain.around(as_chain(rows, ends), absolute=0.1)
    found = interval_bounds(chain)
    text = {name: unknown_state_bounds(chain, name) for name in ends}
    for _ in range(20):
        inner = feasible(chain, rng)
        assert chain.contains(inner)
        answer = absorption(inner)
        for name in ends:
            p = answer.probability(name).value
            bounds = found.probabilities[name]
            assert bounds.low - 1e-12 <= p <= bounds.high + 1e-12
            assert text[name].low - 1e-12 <= bounds.low
            assert bounds.high <= text[name].high + 1e-12
        assert found.time.low - 1e-9 <= answer.expected_time.value <= found.time.high + 1e-9


def test_without_uncertainty_the_bounds_are_the_chain():
    chain = random_chain(60, seed=4)
    found = interval_bounds(IntervalChain.around(chain))
    p = absorption(chain).probability("goal").value
    assert found.probabilities["goal"] == pytest.approx((p, p), abs=1e-11)


def test_nature_that_can_stay_for_ever_does_not_raise_what_she_can_reach():
    """Two states between which nature can go for ever: value iteration from above would stay at 1; the best exit gives 3/5."""
    chain = IntervalChain.from_rows(
        [
            {1: (0.0, 1.0), 2: (0.0, 0.5)},
            {0: (0.0, 1.0), 3: (0.0, 0.5)},
            {4: (0.6, 0.6), 5: (0.4, 0.4)},
            {4: (0.3, 0.3), 5: (0.7, 0.7)},
            {},
            {},
        ],
        {"goal": [4], "lost": [5]},
    )
    found = interval_bounds(chain)
    assert found.probabilities["goal"] == pytest.approx((0.0, 0.6), abs=1e-9)
    assert found.probabilities["lost"] == pytest.approx((0.0, 0.7), abs=1e-9)
    assert found.time.high == np.inf
    assert found.time.low == pytest.approx(3.0, abs=1e-9)  # half of the time at once, else around


def test_a_component_without_exits_ends_nowhere():
    chain = IntervalChain.from_rows([{1: (0.5, 0.9), 2: (0.1, 0.5)}, {1: (1.0, 1.0)}, {}], {"goal": [2]})
    found = interval_bounds(chain)
    assert found.probabilities["goal"] == pytest.approx((0.1, 0.5), abs=1e-9)
    assert found.time.high == np.inf


def test_runs_too_long_for_rounding_get_the_texts_bounds_and_say_so():
    step = (1e-8, 0.6)
    chain = IntervalChain.from_rows(
        [{0: (0.0, 1.0), 1: step}, {0: (0.0, 1.0), 2: step}, {0: (0.0, 1.0), 3: step, 4: step}, {}, {}], {"goal": [3], "lost": [4]}
    )
    found = interval_bounds(chain)
    assert found.error == np.inf
    assert found.probabilities["goal"] == unknown_state_bounds(chain, "goal")
    assert found.time.high == np.inf
    assert 1.0 <= found.time.low <= 20.0


def test_the_printed_upper_bound_is_wrong_before_the_limit():
    chain = IntervalChain.around(walk_chain(10), absolute=0.001)
    for cycles in (5, 10, 50):
        assert unknown_state_bounds(chain, "rich", cycles).high >= 0.5
    low, high = bounds_over_time(chain, "rich", 50)
    assert (low <= high).all()
    assert (np.diff(low) >= -1e-15).all()


def test_optimal_bounds_of_a_model_with_many_retries_are_fifty_times_narrower():
    """About 9,000 states, every chance wrong by up to 1 %."""
    chain = IntervalChain.around(behaviour_chain(9), relative=0.01)
    assert chain.n == 9002
    optimal, text = interval_bounds(chain).probabilities["done"], unknown_state_bounds(chain, "done")
    print(f"optimal {optimal}, text {text}")
    assert text.width > 50 * optimal.width
    assert optimal.holds(absorption(behaviour_chain(9)).probability("done").value)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([{1: (0.0, 0.5)}, {}], "state 0: chances between 0.0 and 0.5 cannot sum to one"),
        ([{1: (0.8, 0.9), 0: (0.3, 0.4)}, {}], "state 0: chances between 1.1"),
        ([{1: (0.8, 0.7), 0: (0.3, 0.4)}, {}], r"state 0: \[0.8, 0.7\] is no interval"),
        ([{1: (-0.1, 1.0)}, {}], "is no interval"),
    ],
)
def test_rows_that_fit_nothing_are_refused(rows, message):
    with pytest.raises(ModelError, match=message):
        IntervalChain.from_rows(rows, {"goal": [1]})


def test_upper_chances_that_no_row_can_have_are_cut():
    chain = IntervalChain.from_rows([{1: (0.4, 0.9), 2: (0.3, 0.5)}, {}, {}], {"goal": [1], "lost": [2]})
    assert chain.upper.tolist() == pytest.approx([0.7, 0.5])


def test_unknown_outcomes_and_damaged_files_are_named(tmp_path):
    chain = IntervalChain.around(walk_chain(4), absolute=0.1)
    for ask in (lambda: unknown_state_bounds(chain, "rch"), lambda: bounds_over_time(chain, "rch", 3)):
        with pytest.raises(UnknownName, match="Did you mean 'rich'"):
            ask()
    file = tmp_path / "bad.json"
    for text, message in (("{", "bad.json"), ("[]", "no interval chain"), ('{"n": 1}', "without 'goal'"),
                          ('{"n": 1, "init": 0, "goal": [0], "target": [0], "rows": [[[0, 1, 1], [0, 0, 1]]]}', "twice")):  # fmt: skip
        file.write_text(text)
        with pytest.raises(FormatError, match=message):
            load_interval_chain(file)
