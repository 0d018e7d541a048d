"""Outcomes that hardly ever come: exact, drawn, weighted, split, each against exact values."""

import json

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.architecture.analysis.markov.files import chain_from_json
from cprm_gym.architecture.analysis.markov.generators import tandem_chain, walk_chain
from cprm_gym.architecture.analysis.rare.conditional import conditional, expected_visits
from cprm_gym.architecture.analysis.rare.importance import importance_sampling, learned_h
from cprm_gym.architecture.analysis.rare.splitting import split_chain, split_worlds
from cprm_gym.architecture.analysis.sampling.runs import ChainRuns
from cprm_gym.errors import CostError, ModelError, UnknownName

CASES = sorted((SHARED / "cases" / "markov" / "rare").glob("*.json"))
OVERFLOW_17 = 4.59773e-10


def load(file):
    case = json.loads(file.read_text())
    return case, chain_from_json({**case, "classes": {"rare": case["rare"], "other": case["other"]}})


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("file", CASES or ["absent"], ids=lambda f: getattr(f, "stem", f))
def test_known_probabilities_and_what_their_runs_visit(file):
    case, chain = load(file)
    given = conditional(chain, "rare")
    assert given.probability == pytest.approx(case["p"], rel=1e-12)
    visits = given.visits()
    for state, known in case["conditional_visits_given_rare"].items():
        assert visits[int(state)] == pytest.approx(known, rel=1e-9)


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("name", ["ruin_22", "ruin_33", "tandem_7", "tandem_12", "reliability_3e-3", "runs_4_20"])
def test_weighted_runs_with_a_learned_h_come_within_three_errors(name):
    case, chain = load(SHARED / "cases" / "markov" / "rare" / f"{name}.json")
    found = importance_sampling(chain, "rare", learned_h(chain, "rare", seed=1), 20_000, seed=1)
    assert abs(found.value - case["p"]) <= 3 * found.deviation
    assert found.relative < 0.05
    assert found.trusted


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("name", ["ruin_22", "tandem_7", "tandem_12", "runs_4_20"])
def test_split_runs_come_within_three_errors(name):
    case, chain = load(SHARED / "cases" / "markov" / "rare" / f"{name}.json")
    found = split_chain(chain, "rare", np.array(case["level"], float), 500, 40, seed=2)
    assert abs(found.value - case["p"]) <= 3 * found.deviation
    assert found.relative < 0.25


def test_overflow_of_two_queues():
    """p = 4.59773e-10: exactly, and to 10 % within twice the 4,000 cycles of specification/analysis.md 5."""
    chain = tandem_chain(17)
    exact = absorption(chain).probability("overflow")
    assert exact.value == pytest.approx(OVERFLOW_17, rel=1e-5)
    found = importance_sampling(chain, "overflow", learned_h(chain, "overflow"), 10_000)
    assert found.steps_for(0.1) <= 8000
    assert abs(found.value - exact.value) <= 3 * found.deviation


def test_a_wrong_h_is_unbiased_and_says_that_it_is_not_to_be_trusted():
    chain = tandem_chain(7)
    exact = absorption(chain).probability("overflow").value
    flat = importance_sampling(chain, "overflow", np.ones(chain.n), 10_000, share=1.0)  # plain sampling
    assert not flat.trusted
    good = importance_sampling(chain, "overflow", learned_h(chain, "overflow"), 10_000)
    assert good.trusted
    assert good.interval.holds(exact) or abs(good.value - exact) < 3 * good.deviation
    assert good.steps_for(0.1) < 0.01 * max(flat.steps_for(0.1), 1e4) or flat.hits == 0


def test_the_interval_of_weighted_runs_holds_95_of_100_times():
    chain = tandem_chain(7)
    exact, h = absorption(chain).probability("overflow").value, learned_h(chain, "overflow")
    held = [importance_sampling(chain, "overflow", h, 1000, seed=s).interval.holds(exact) for s in range(1000)]
    assert sum(held) >= 950 - 3 * (1000 * 0.05 * 0.95) ** 0.5 - 10  # normal approximation


def test_split_estimates_are_unbiased():
    chain = walk_chain(12, 0.4, start=1)
    exact = absorption(chain).probability("rich").value
    found = split_chain(chain, "rich", np.arange(13.0), 50, 3000, killed=5)
    assert abs(found.value - exact) <= 3 * found.deviation
    assert found.relative < 0.02


def test_runs_that_are_drawn_all_end_so_and_visit_what_they_should():
    chain = tandem_chain(9)
    given = conditional(chain, "overflow")
    runs = ChainRuns(given.chain, signals={"state": np.arange(chain.n, dtype=float)}).play(range(400), 0, True)
    assert {run.outcome for run in runs} == {"overflow"}
    counts = np.bincount(np.concatenate([run.signals["state"] for run in runs]).astype(int), minlength=chain.n) / 400
    visits = given.visits()
    assert np.abs(counts - visits).max() < 0.25


def test_the_likeliest_run_and_the_causes():
    given = conditional(walk_chain(12, 0.3, start=1), "rich")
    run, share = given.likeliest_run()
    assert run == list(range(1, 13))
    assert 0 < share < 1
    cause = given.causes(1)[0]
    assert cause.target == cause.source + 1
    assert cause.lift > 1


def test_visits_add_up_to_the_expected_time():
    chain = walk_chain(9, 0.45)
    visits = expected_visits(chain)
    assert visits[~chain.absorbing].sum() == pytest.approx(absorption(chain).expected_time.value, rel=1e-12)
    assert visits[chain.absorbing].sum() == pytest.approx(1.0)


def test_what_cannot_come_has_no_runs():
    chain = MarkovChain.from_rows([{1: 1.0}, {}, {}], {"goal": [1], "lost": [2]})
    with pytest.raises(ModelError, match="outcome 'lost' has probability 0"):
        conditional(chain, "lost")
    with pytest.raises(UnknownName):
        importance_sampling(chain, "los", np.ones(3))
    with pytest.raises(ModelError, match="one finite number from 0"):
        importance_sampling(chain, "lost", np.ones(2))


def test_runs_that_do_not_fit_are_an_error():
    with pytest.raises(CostError, match="longer than 10 cycles"):
        split_chain(walk_chain(40), "rich", np.arange(41.0), 20, 1, longest=10)


class Walkers:
    """Random walks as worlds that can be copied: up with 0.4, from 1, to 0 or `top`."""

    def __init__(self, n, top=12):
        self.n, self.top = n, top

    def begin(self, seed):
        self.at = np.ones(self.n, int)
        self.rngs = [np.random.default_rng((seed, k)) for k in range(self.n)]

    def advance(self, active):
        for w in np.flatnonzero(active):
            self.at[w] += 1 if self.rngs[w].random() < 0.4 else -1

    def levels(self):
        return np.where(self.at == self.top, np.inf, self.at.astype(float))

    def ended(self):
        return (self.at == 0) | (self.at == self.top)

    def keep(self, world):
        return int(self.at[world])

    def put(self, world, kept, fresh):
        self.at[world] = kept
        self.rngs[world] = np.random.default_rng(fresh)


def test_worlds_that_can_be_copied_are_split():
    exact = absorption(walk_chain(12, 0.4, start=1)).probability("rich").value
    found = split_worlds(Walkers, 60, 30, seed=3)
    assert abs(found.value - exact) <= 3 * found.deviation
    assert found.relative < 0.3
    assert found == split_worlds(Walkers, 60, 30, seed=3)


def test_a_spent_budget_keeps_what_was_finished():
    found = split_worlds(lambda n: Walkers(n, 30), 100, 10_000, budget=Budget(seconds=0.5))
    assert found.reason == "seconds"
    assert len(found.estimates) < 10_000
