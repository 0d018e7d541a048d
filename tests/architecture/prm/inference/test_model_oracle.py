"""Filters and banks against the meaning of random models, written out case by case."""

from __future__ import annotations

import numpy as np
import pytest
from model_oracle import EDGES, Case, Oracle, quantity, random_case

from cprm_gym.architecture.prm import Filter, FilterBank, Grounding, Link, Role
from cprm_gym.errors import ImpossibleEvidence

EXACT = 1e-12


def observed(rng: np.random.Generator, case: Case, chance: float = 0.5) -> dict[str, int]:
    """States of some of the readings."""
    return {n: int(rng.integers(0, case.card if n.endswith("seen") else 2)) for n in case.readings if rng.random() < chance}


def as_told(rng: np.random.Generator, case: Case, states: dict[str, int]) -> dict[str, object]:
    """The same as a user says it: quantities for bins, integers among them."""
    return {n: quantity(rng, k) if case.card == 3 and n.endswith("seen") else k for n, k in states.items()}


def check_filter(seed: int) -> None:
    """One agent through five slices, relations that change, a restart of all."""
    rng, case = np.random.default_rng(seed), random_case(seed)
    filter_, oracle = Filter(Grounding(case.model, case.objects)), Oracle(case)
    for t in range(5):
        relations = [r for r in ("calm(w)", "drifts(t0)") if rng.random() < 0.3]
        states = observed(rng, case)
        expected = oracle.step(states, relations)
        if expected is None:
            with pytest.raises(ImpossibleEvidence):
                filter_.step(as_told(rng, case, states), relations)
            continue
        found = filter_.step(as_told(rng, case, states), relations)
        assert found.log_likelihood[0] == pytest.approx(oracle.log_likelihood, abs=EXACT), (seed, t)
        for name, table in expected.items():
            np.testing.assert_allclose(found[name][0], table, atol=EXACT, err_msg=f"seed {seed}, slice {t}, {name}")
        if t == 2 and rng.random() < 0.3:
            filter_.reset()
            oracle.reset()


def check_bank(seed: int, batch: int = 4) -> None:
    """Agents with relations of their own, some of whom begin anew or are not due."""
    rng, case = np.random.default_rng(seed), random_case(seed, alike=seed % 2 == 0)
    bank = FilterBank(Grounding(case.model, case.objects), batch)
    oracles = [Oracle(case) for _ in range(batch)]
    things = oracles[0].things
    for t in range(5):
        calm = rng.random(batch) < 0.3
        whom = rng.integers(-1, len(things), batch)
        due = rng.random(batch) < 0.9
        states = [observed(rng, case) for _ in range(batch)]
        expected: list[dict[str, np.ndarray] | None] = [None] * batch
        for k in np.flatnonzero(due):
            relations = (["calm(w)"] if calm[k] else []) + ([f"drifts({things[whom[k]]})"] if whom[k] >= 0 else [])
            expected[k] = oracles[k].step(states[k], relations)
            if expected[k] is None:  # seeing nothing is never impossible
                states[k] = {}
                expected[k] = oracles[k].step({}, relations)
        evidence = {}
        for name in case.readings:
            column = [s.get(name, -1) for s in states]
            if case.card == 3 and name.endswith("seen"):
                middles = [(EDGES[k] + EDGES[k + 1]) / 2 if k >= 0 else np.nan for k in column]
                evidence[name] = np.array(middles)
            else:
                evidence[name] = np.array(column)
        bank.step(evidence, [Link("calm", (Role("Watcher", np.where(calm, 0, -1)),)), Link("drifts", (Role("Thing", whom),))], due)
        for k, tables in enumerate(expected):
            if tables is None:
                continue
            assert bank.log_likelihood[k] == pytest.approx(oracles[k].log_likelihood, abs=EXACT), (seed, t, k)
            for name, table in tables.items():
                np.testing.assert_allclose(bank.marginal(name, k), table, atol=EXACT, err_msg=f"seed {seed}, slice {t}, agent {k}, {name}")
        again = rng.random(batch) < 0.2
        bank.reset(again)
        for k in np.flatnonzero(again):
            oracles[k].reset()


def check_partial_reset(seed: int) -> None:
    """A batch in one filter, of which some begin anew, and readings that cannot be are answered with a restart."""
    rng, case, batch = np.random.default_rng(seed), random_case(seed), 3
    filter_ = Filter(Grounding(case.model, case.objects), batch)
    oracles = [Oracle(case) for _ in range(batch)]
    for t in range(5):
        relations = [r for r in ("calm(w)", "drifts(t0)") if rng.random() < 0.2]
        states = [observed(rng, case) for _ in range(batch)]
        expected = []
        for k in range(batch):
            found = oracles[k].step(states[k], relations)
            if found is None:
                states[k] = {}
                found = oracles[k].step({}, relations)
            expected.append(found)
        evidence = {name: [None if name not in s else as_told(rng, case, s)[name] for s in states] for name in case.readings}
        result = filter_.step(evidence, relations)
        for k, tables in enumerate(expected):
            assert result.log_likelihood[k] == pytest.approx(oracles[k].log_likelihood, abs=EXACT), (seed, t, k)
            for name, table in tables.items():
                np.testing.assert_allclose(result[name][k], table, atol=EXACT, err_msg=f"seed {seed}, slice {t}, agent {k}, {name}")
        again = rng.random(batch) < 0.3
        filter_.reset(again)
        for k in np.flatnonzero(again):
            oracles[k].reset()


@pytest.mark.parametrize("seed", range(25))
def test_a_filter_answers_what_the_model_means(seed):
    check_filter(seed)


@pytest.mark.parametrize("seed", range(1000, 1025))
def test_a_bank_answers_every_agent_what_the_model_means(seed):
    check_bank(seed)


@pytest.mark.parametrize("seed", range(2000, 2020))
def test_agents_who_begin_anew_among_others_are_answered_what_the_model_means(seed):
    check_partial_reset(seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(54))
def test_five_thousand_random_models_mean_what_they_say(block):
    """Seeds 10,000 to 15,399: a third each."""
    for seed in range(10_000 + 100 * block, 10_100 + 100 * block):
        (check_filter, check_bank, check_partial_reset)[seed % 3](seed)
