"""Where chains end, against exact fractions and the cases with known answers; certificates that hold."""

import json

import numpy as np
import pytest
from markov_chains import as_chain, exact_absorption, random_rational_chain
from paths import SHARED
from scipy import sparse
from scipy.sparse.linalg import spsolve

from cprm_gym.architecture.analysis.markov import solving
from cprm_gym.architecture.analysis.markov.absorption import absorption, caught_states
from cprm_gym.architecture.analysis.markov.chain import NEVER, MarkovChain
from cprm_gym.architecture.analysis.markov.components import components
from cprm_gym.architecture.analysis.markov.files import load_chain
from cprm_gym.architecture.analysis.markov.generators import behaviour_chain, grid_chain, random_chain, walk_chain
from cprm_gym.architecture.analysis.markov.lumping import lump, worthwhile_lumping
from cprm_gym.errors import UnknownName

CASES = sorted((SHARED / "cases" / "markov" / "dtmc").glob("*.json"))


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("file", CASES or ["absent"], ids=lambda f: getattr(f, "stem", f))
@pytest.mark.parametrize("lumped", [False, True], ids=["whole", "lumped"])
def test_known_answers_come_out_within_their_certificate(file, lumped):
    known = json.loads(file.read_text())["expected"]
    found = absorption(load_chain(file), lump=lumped)
    for outcome, value in known["prob"].items():
        p = found.probability(outcome)
        assert p.value == pytest.approx(value, abs=1e-9)
        assert abs(p.value - value) <= p.error + 4e-16
        assert p.error < 1e-9
    time = found.expected_time
    assert time.value == pytest.approx(float(known["steps"]), rel=1e-9)
    assert time.value == float(known["steps"]) or abs(time.value - known["steps"]) <= time.error + 4e-16 * time.value


@pytest.mark.parametrize("seed", range(25))
def test_random_chains_agree_with_fractions(seed):
    rows, ends = random_rational_chain(seed)
    exact, never, time = exact_absorption(rows, ends)
    found = absorption(as_chain(rows, ends))
    for state in range(len(rows)):
        for name, values in {**exact, NEVER: never}.items():
            p = found.probability(name, state)
            assert abs(p.value - values[state]) <= p.error + 3e-16, (state, name)
            assert p.error < 1e-10
        assert found.time[state] == pytest.approx(float(time[state]), rel=1e-12)


def test_a_run_caught_outside_of_all_outcomes_is_an_outcome_of_its_own():
    chain = MarkovChain.from_rows([{1: 0.5, 3: 0.5}, {2: 1.0}, {1: 1.0}, {}], {"goal": [3]})
    found = absorption(chain)
    assert found.probability(NEVER).value == 0.5
    assert found.may_diverge
    assert found.expected_time.value == np.inf
    assert found.time[0] == 1.0  # until nothing but that is left
    assert not absorption(chain.__class__.from_rows([{1: 0.5, 3: 0.5}, {2: 1.0}, {3: 1.0}, {}], {"goal": [3]})).may_diverge


def test_what_cannot_be_reached_from_the_start_does_not_make_it_diverge():
    chain = MarkovChain.from_rows([{2: 1.0}, {1: 1.0}, {1: 1.0}], {"goal": [2]})
    assert absorption(chain).expected_time == (1.0, 0.0) or absorption(chain).expected_time.value == 1.0


def test_rare_outcomes_are_exact_relative_to_their_size():
    up = 0.4
    chain = walk_chain(60, up, start=1)
    ratio = (1 - up) / up
    exact = (ratio - 1) / (ratio**60 - 1)
    assert absorption(chain).probability("rich").value == pytest.approx(exact, rel=1e-13)
    assert exact < 1e-10


METHODS = {
    "elimination": (lambda: walk_chain(400), {"SMALL": 500}),
    "sweeps": (lambda: behaviour_chain(3), {"SMALL": 10}),
    "gradients": (lambda: random_chain(3000, seed=3), {"MEDIUM": 50, "SWEEPS": 1, "REFINED": 0}),
    "mixing": (lambda: random_chain(3000, seed=3), {"MEDIUM": 50, "SWEEPS": 1}),
    "factors": (lambda: walk_chain(400, 0.5), {"SMALL": 10, "MEDIUM": 50, "SWEEPS": 1}),
}


@pytest.mark.parametrize("method", METHODS)
def test_every_solver_gives_the_same_certified_answer(method, monkeypatch):
    make, settings = METHODS[method]
    chain = make()
    plain = absorption(chain, lump=False)
    for name, value in settings.items():
        monkeypatch.setattr(solving, name, value)
    found = absorption(chain, lump=False)
    assert found.methods.get(method, 0) > 0.9 * (chain.n - 10)
    for outcome in found.outcomes:
        a, b = plain.probability(outcome), found.probability(outcome)
        assert abs(a.value - b.value) <= a.error + b.error
        assert b.error < 1e-9
    assert found.expected_time.value == pytest.approx(plain.expected_time.value, rel=1e-9)


def test_a_wrong_solution_is_not_certified(monkeypatch):
    """The certificate looks at the answer alone: a solver that errs by 1e-3 is told so."""
    from cprm_gym.architecture.analysis.markov import absorption as module

    true_solve = module.solve

    def wrong(chain, parts, closed, values):
        methods = true_solve(chain, parts, closed, values)
        values[0, ~closed] += 1e-3
        return methods

    monkeypatch.setattr(module, "solve", wrong)
    found = module.absorption(grid_chain(12), lump=False)
    assert found.probability("goal").error > 1e-3

    def nonsense(chain, parts, closed, values):
        values[-1, ~closed] = -1.0
        return {}

    monkeypatch.setattr(module, "solve", nonsense)
    assert module.absorption(grid_chain(12), lump=False).probability("goal").error == np.inf


def test_what_no_outcome_tells_apart_is_put_together():
    assert lump(grid_chain(20)).chain.n == 20  # sideways nothing matters
    blocks = worthwhile_lumping(grid_chain(20))
    assert blocks is not None
    assert worthwhile_lumping(random_chain(500)) is None
    whole, small = absorption(grid_chain(20), lump=False), absorption(grid_chain(20))
    assert np.abs(whole.probabilities - small.probabilities).max() < 1e-12
    assert small.methods["lumped away"] == 380


@pytest.mark.parametrize("seed", range(6))
def test_a_lumped_chain_is_the_chain_in_every_cycle(seed):
    from cprm_gym.architecture.analysis.markov.over_time import distribution_at

    rows, ends = random_rational_chain(seed)
    doubled = [{2 * j + k: p / 2 for j, p in row.items() for k in (0, 1)} for row in rows for _ in (0, 1)]
    twice = as_chain(doubled, {name: [2 * s + k for s in states for k in (0, 1)] for name, states in ends.items()})
    blocks = lump(twice)
    assert blocks.chain.n <= len(rows)
    for cycle in (1, 3, 8):
        for name in ends:
            mass = [distribution_at(c, cycle)[c.states_of(name)].sum() for c in (twice, blocks.chain)]
            assert mass[0] == pytest.approx(mass[1], abs=1e-12)


def test_the_time_of_runs_that_end_well():
    chain = walk_chain(4, 0.5, start=1)
    found = absorption(chain)
    # from 1 of 4: E[T; rich] = (16 - 1) / 3 / 4 = 1.25, P(rich) = 1/4
    given = found.time_given("rich")
    assert given.value == pytest.approx(5.0, abs=1e-12)
    assert given.error < 1e-11
    assert np.isnan(absorption(MarkovChain.from_rows([{1: 1.0}, {}, {}], {"goal": [1], "lost": [2]})).time_given("lost").value)


def test_components_come_after_those_they_lead_to():
    chain = random_chain(300, seed=1)
    parts = components(chain)
    for i in range(chain.n):
        for e in range(chain.offsets[i], chain.offsets[i + 1]):
            if parts.targets[e] >= 0:
                assert parts.component[parts.targets[e]] <= parts.component[i]
    assert not caught_states(chain, parts).any()


def test_an_unknown_outcome_is_named():
    with pytest.raises(UnknownName, match="Known: broke, never, rich"):
        absorption(walk_chain(4)).probability("poor")


def test_sweeps_in_single_precision_are_given_up_where_a_chain_does_not_mix(monkeypatch):
    """Two crowds with hardly a way between them: taking out one slow mode leaves the other."""
    one = random_chain(2000, seed=5)
    inner = one.n - 2
    targets = np.where(one.targets < inner, one.targets % (inner // 2) + (np.repeat(np.arange(one.n), np.diff(one.offsets)) >= inner // 2)
                       * (inner // 2), one.targets).astype(np.int32)  # fmt: skip
    targets[0], targets[one.offsets[inner // 2]] = inner // 2, 0  # one way over and one back
    chances = one.chances.copy()
    rows = np.repeat(np.arange(one.n), np.diff(one.offsets))
    chances[(rows >= inner // 2) & (targets == inner)] += chances[(rows >= inner // 2) & (targets == inner + 1)] * 0.99
    chances[(rows >= inner // 2) & (targets == inner + 1)] *= 0.01
    chain = MarkovChain(one.offsets, targets, chances, one.outcomes, one.initial)
    monkeypatch.setattr(solving, "MEDIUM", 50)
    found = absorption(chain, lump=False)
    assert "mixing" not in found.methods
    assert found.probability("goal").error < 1e-9
    monkeypatch.setattr(solving, "REFINED", 0)
    assert found.probability("goal").value == pytest.approx(absorption(chain, lump=False).probability("goal").value, abs=1e-9)


@pytest.mark.parametrize("method", ["mixing", "gradients"])
@pytest.mark.parametrize("rare", [False, True])
def test_two_columns_at_once_are_what_a_direct_solver_says(rare, method, monkeypatch):
    """Also where the second outcome is so rare that it does not follow from the others, and one column is there before the other."""
    if method == "gradients":
        monkeypatch.setattr(solving, "REFINED", 0)
    chain = random_chain(4000, leak=0.02)
    if rare:
        chances = chain.chances.copy()
        to_lost = chain.targets == chain.outcomes["lost"][0]
        to_goal = chain.targets == chain.outcomes["goal"][0]
        moved = 0.999 * chances[to_lost]
        chances[to_lost] -= moved
        chances[to_goal] += moved
        chain = MarkovChain(chain.offsets, chain.targets, chances, chain.outcomes, chain.initial)
    found = absorption(chain, lump=False)
    assert found.methods["gradients" if rare else method] > 3000  # a rare one is solved by itself
    inner = np.flatnonzero(~chain.absorbing)
    system = sparse.identity(len(inner), format="csr") - chain.matrix[inner][:, inner]
    right = np.column_stack((chain.matrix[inner][:, chain.outcomes["lost"]].toarray()[:, 0], np.ones(len(inner))))
    direct = spsolve(system.tocsc(), right)
    lost = found.probabilities[found.outcomes.index("lost")][inner]
    assert np.abs(lost - direct[:, 0]).max() < 1e-13
    assert np.abs(found.time[inner] / direct[:, 1] - 1.0).max() < 1e-12
    assert bool(lost.max() < 0.01) == rare
