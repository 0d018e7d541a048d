"""Intervals from counts hold together as often as they say; shared parameters are not forgotten."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.bounded.interval_chain import IntervalChain
from cprm_gym.architecture.analysis.bounded.learning import UNSEEN, intervals_from_counts
from cprm_gym.architecture.analysis.bounded.parametric import ParametricChain, parameter_bounds
from cprm_gym.architecture.analysis.bounded.value_iteration import interval_bounds
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.errors import ModelError

ROWS = [{0: 0.2, 1: 0.5, 2: 0.3}, {0: 0.3, 3: 0.6, 4: 0.1}, {0: 0.5, 4: 0.5}, {}, {}]
ENDS = {"goal": [3], "lost": [4]}


def drawn(rng, n):
    """Counts of n visits to each state of the chain above."""
    return [dict(zip(row, rng.multinomial(n, list(row.values())).tolist())) if row else {} for row in ROWS]


def test_learned_intervals_hold_the_true_chain_in_95_of_100_cases():
    rng = np.random.default_rng(1)
    true = MarkovChain.from_rows(ROWS, ENDS)
    missed = 0
    for _ in range(1000):
        missed += not intervals_from_counts(drawn(rng, 60), ENDS).contains(true)
    assert missed <= 50 + 3 * (1000 * 0.05 * 0.95) ** 0.5


def test_what_follows_from_learned_intervals_holds_the_true_value():
    rng = np.random.default_rng(2)
    p = absorption(MarkovChain.from_rows(ROWS, ENDS)).probability("goal").value
    bounds = [interval_bounds(intervals_from_counts(drawn(rng, n), ENDS)).probabilities["goal"] for n in (30, 3000)]
    assert all(b.holds(p) for b in bounds)
    assert bounds[1].width < 0.2 * bounds[0].width


def test_successors_that_never_came_have_room():
    chain = intervals_from_counts([{1: 30}, {}], {"goal": [1]}, unseen=True)
    assert chain.outcomes[UNSEEN].tolist() == [2]
    low, high = interval_bounds(chain).probabilities["goal"]
    assert high == pytest.approx(1.0)
    assert 0.8 < low < 0.95
    assert interval_bounds(intervals_from_counts([{1: 30}, {}], {"goal": [1]})).probabilities["goal"] == pytest.approx((1.0, 1.0))


def test_a_state_never_seen_is_named():
    with pytest.raises(ModelError, match="counts of state 1: it was never seen"):
        intervals_from_counts([{1: 3}, {2: 0}, {}], {"goal": [2]})


DIE = [{1: "p", 2: "1 - p"}, {3: "p", 4: "1 - p"}, {5: "p", 6: "1 - p"}, {1: "p", 7: "1 - p"}, {8: "p", 9: "1 - p"},
       {10: "p", 11: "1 - p"}, {2: "p", 12: "1 - p"}, *[{}] * 6]  # fmt: skip


def test_one_coin_for_all_throws_is_narrower_than_a_coin_in_each_state():
    die = ParametricChain(DIE, {"one": [7], "rest": [8, 9, 10, 11, 12]})
    assert die.parameters == ("p",)
    apart = interval_bounds(die.over({"p": (1 / 3, 2 / 3)})).probabilities["one"]
    assert apart == pytest.approx((1 / 21, 8 / 21), abs=1e-9)
    shared = parameter_bounds(die, {"p": (1 / 3, 2 / 3)}, "one", gap=1e-4)
    assert shared.bounds == pytest.approx((1 / 12, 4 / 15), abs=1e-4)
    assert shared.bounds.low <= 1 / 12
    assert shared.bounds.high >= 4 / 15
    assert shared.most_at["p"] == pytest.approx(2 / 3)


def test_a_spent_budget_leaves_sound_bounds():
    die = ParametricChain(DIE, {"one": [7], "rest": [8, 9, 10, 11, 12]})
    few = parameter_bounds(die, {"p": (1 / 3, 2 / 3)}, "one", gap=1e-9, budget=Budget(states=4))
    assert few.bounds.low <= 1 / 12
    assert few.bounds.high >= 4 / 15
    assert few.boxes <= 8


def test_rows_that_are_no_chances_are_refused():
    with pytest.raises(ModelError, match="sum to"):
        ParametricChain([{0: "p", 1: "p"}, {}], {"goal": [1]}).at({"p": 0.2})
    with pytest.raises(ModelError, match=r"state 0: '2 \* p' is no chance"):
        ParametricChain([{0: "1 - p", 1: "2 * p"}, {}], {"goal": [1]}).over({"p": (0.6, 0.7)})


def test_margins_keep_what_is_certain():
    chain = MarkovChain.from_rows([{1: 1.0}, {0: 0.5, 2: 0.5}, {}], {"goal": [2]})
    around = IntervalChain.around(chain, absolute=0.1)
    assert around.lower.tolist() == pytest.approx([1.0, 0.4, 0.4])
    assert around.upper.tolist() == pytest.approx([1.0, 0.6, 0.6])
