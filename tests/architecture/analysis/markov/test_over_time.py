"""Outcomes cycle by cycle: steps and squaring agree, and run into the limit."""

import json

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.files import load_chain
from cprm_gym.architecture.analysis.markov.generators import behaviour_chain, random_chain, walk_chain
from cprm_gym.architecture.analysis.markov.over_time import distribution_at, outcomes_over_time
from cprm_gym.errors import CostError, ModelError

CASES = [f for f in sorted((SHARED / "cases" / "markov" / "dtmc").glob("*.json")) if "by_horizon" in json.loads(f.read_text())["expected"]]


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("file", CASES or ["absent"], ids=lambda f: getattr(f, "stem", f))
def test_known_answers_by_horizon(file):
    chain = load_chain(file)
    for horizon, known in json.loads(file.read_text())["expected"]["by_horizon"].items():
        found = outcomes_over_time(chain, int(horizon))
        for outcome, value in known.items():
            assert found.by(outcome)[-1] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("cycle", [0, 1, 7, 1000])
def test_squaring_and_stepping_agree(cycle):
    chain = random_chain(60, seed=2)
    steps, squares = distribution_at(chain, cycle, "steps"), distribution_at(chain, cycle, "squaring")
    assert np.abs(steps - squares).max() < 1e-13
    assert steps.sum() == pytest.approx(1.0)


def test_the_limit_lies_between_what_has_ended_and_what_may():
    chain = walk_chain(10, 0.45)
    limit = absorption(chain).probability("rich").value
    found = outcomes_over_time(chain, 200)
    ended, remaining = found.by("rich"), found.remaining
    assert ((ended <= limit + found.error) & (limit <= ended + remaining + found.error)).all()
    assert (np.diff(ended) >= 0).all()
    assert remaining[-1] < 1e-3


def test_lumping_keeps_every_cycle():
    chain = behaviour_chain(2)
    found = outcomes_over_time(chain, 60)
    state = distribution_at(chain, 60, "steps")
    for name in ("done", "failed"):
        assert found.by(name)[-1] == pytest.approx(state[chain.states_of(name)].sum(), abs=1e-12)


def test_quantiles_of_the_end():
    found = outcomes_over_time(walk_chain(4, 0.5, start=2), 20)
    assert found.quantile(0.5) == 2  # half of the runs end with two equal steps
    assert found.quantile(1.1) is None


@pytest.mark.parametrize("cycles", [-1, 1.5, True])
def test_a_number_of_cycles_is_needed(cycles):
    with pytest.raises(ModelError, match="whole number from 0"):
        outcomes_over_time(walk_chain(4), cycles)


def test_large_chains_are_not_squared():
    with pytest.raises(CostError, match="go by steps"):
        distribution_at(walk_chain(4000), 10, "squaring")
    with pytest.raises(ModelError, match="'squaring'"):
        distribution_at(walk_chain(4), 10, "power")
