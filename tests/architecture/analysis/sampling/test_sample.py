"""Samples: the exact value inside, the same runs in any order, resumed, stopped at a width, by a test."""

import json

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.architecture.analysis.markov.generators import behaviour_chain, walk_chain
from cprm_gym.architecture.analysis.sampling.gymnasium_runs import GymnasiumRuns
from cprm_gym.architecture.analysis.sampling.runs import UNFINISHED, ChainRuns, Run, Runs
from cprm_gym.architecture.analysis.sampling.sample import sample
from cprm_gym.architecture.analysis.sampling.sequences import confidence_sequence
from cprm_gym.architecture.analysis.sampling.sequential import ProbabilityRatioTest
from cprm_gym.errors import FormatError, ModelError, UnknownName

STATS = SHARED / "cases" / "markov" / "stats"
WALK = walk_chain(10, 0.45)
HEIGHT = {"height": np.arange(11.0)}


def test_exact_values_lie_in_the_intervals():
    for chain, n in ((WALK, 4000), (behaviour_chain(1), 4000)):
        exact, found = absorption(chain), sample(ChainRuns(chain), n, seed=5)
        joint = found.intervals()
        for name in chain.outcomes:
            assert joint[name].holds(exact.probability(name).value)
        assert found.count(UNFINISHED) == 0
        mean = sum(found.cycles[name][0] for name in found.counts) / found.runs
        assert mean == pytest.approx(exact.expected_time.value, rel=0.1)


def test_runs_do_not_depend_on_blocks_or_on_who_else_is_played():
    runs = ChainRuns(WALK)
    whole = runs.play(range(50), 3, False)
    assert whole[17] == runs.play([17], 3, False)[0]
    assert sample(runs, 300, seed=3, block=7).to_json() == sample(runs, 300, seed=3, block=300).to_json()
    assert sample(runs, 300, seed=4).counts != sample(runs, 300, seed=3).counts
    assert isinstance(runs, Runs)


def test_two_workers_count_the_same():
    runs = ChainRuns(WALK)
    assert sample(runs, 60, workers=2, block=20).to_json() == sample(runs, 60, block=20).to_json()


def test_properties_beside_outcomes():
    found = sample(ChainRuns(WALK, signals=HEIGHT), 400, properties_={"high": "F height >= 8", "not low": "G height > 0"})
    assert found.properties["high"].true >= found.count("rich")
    assert found.properties["not low"].true == found.count("rich")
    assert found.property_interval("high").holds(found.properties["high"].true / 400)
    number = found.properties["not low"].first_false
    assert ChainRuns(WALK).play([number], 0, False)[0].outcome == "broke"
    with pytest.raises(UnknownName, match="Known: high, not low"):
        found.property_interval("low")


def test_an_interrupted_sample_goes_on_from_its_journal(tmp_path):
    class Interrupted(ChainRuns):
        played = 0

        def play(self, numbers, seed, signals):
            Interrupted.played += len(numbers)
            if Interrupted.played == 300:
                raise KeyboardInterrupt
            return super().play(numbers, seed, signals)

    journal = tmp_path / "runs.jsonl"
    first = sample(Interrupted(WALK), 500, block=50, journal=journal)
    assert first.reason == "interrupted"
    assert first.runs == 250
    with journal.open("a") as file:
        file.write('{"start": 300, "ru')
    Interrupted.played = 1000
    second = sample(Interrupted(WALK), 500, block=50, journal=journal)
    assert Interrupted.played == 1250  # the first half is not played again
    assert second.to_json() == sample(ChainRuns(WALK), 500).to_json()
    with pytest.raises(FormatError, match="another sample"):
        sample(ChainRuns(WALK), 500, seed=1, block=50, journal=journal)


def test_a_budget_ends_it_and_keeps_what_there_is():
    found = sample(ChainRuns(walk_chain(100)), 10**7, budget=Budget(seconds=0.3))
    assert found.reason == "seconds"
    assert 0 < found.runs < 10**7


def test_stopping_at_a_width_is_done_by_the_interval_that_may_be_looked_at():
    found = sample(ChainRuns(WALK), 10**5, width=0.06)
    assert found.reason == "width"
    assert found.sequence("rich").width <= 0.06
    assert found.sequence("rich").holds(absorption(WALK).probability("rich").value)


def test_a_run_with_an_outcome_that_was_not_announced_is_an_error():
    class Odd:
        outcomes = ("goal",)

        def play(self, numbers, seed, signals):
            return [Run("lost", 1) for _ in numbers]

    with pytest.raises(ModelError, match="run 0 ended in 'lost'"):
        sample(Odd(), 3)


def test_an_unknown_outcome_is_named():
    with pytest.raises(UnknownName, match="Did you mean 'rich'"):
        sample(ChainRuns(WALK), 10).count("rch")


@pytest.mark.skipif(not STATS.is_dir(), reason="data of ../shared absent")
def test_sequences_have_the_reference_values():
    for case in json.loads((STATS / "binomial_intervals.json").read_text())["cases"]:
        found = confidence_sequence(case["k"], case["n"], 1 - case["alpha"])
        assert found == pytest.approx(case["beta_binomial_cs_a_half"], abs=1e-9)


def test_looking_at_every_run_a_sequence_errs_rarely_and_repeated_intervals_often():
    """1000 repetitions of 1000 runs, looked at 100 times each."""
    from cprm_gym.architecture.analysis.sampling.intervals import clopper_pearson

    rng = np.random.default_rng(8)
    sums = np.cumsum(rng.random((1000, 1000)) < 0.3, axis=1)
    looks = np.arange(9, 1000, 10)
    low = np.zeros((len(looks), 1001), bool)
    plain = np.zeros((len(looks), 1001), bool)
    for a, n in enumerate(looks + 1):
        for k in np.unique(sums[:, n - 1]):
            low[a, k] = not confidence_sequence(int(k), int(n)).holds(0.3)
            plain[a, k] = not clopper_pearson(int(k), int(n)).holds(0.3)
    at = np.arange(len(looks))
    errs = np.mean([low[at, row[looks]].any() for row in sums])
    peeking = np.mean([plain[at, row[looks]].any() for row in sums])
    assert errs <= 0.05
    assert peeking > 0.15


@pytest.mark.skipif(not STATS.is_dir(), reason="data of ../shared absent")
def test_the_sequential_test_decides_as_often_and_as_early_as_computed():
    rng = np.random.default_rng(4)
    for case in json.loads((STATS / "sprt.json").read_text())["cases"]:
        if case["p"] not in (0.98, 0.94):
            continue
        margin = (case["p0"] - case["p1"]) / 2
        numbers, below = [], 0
        for _ in range(300):
            test = ProbabilityRatioTest((case["p0"] + case["p1"]) / 2, margin, case["alpha"], case["beta"])
            while test.verdict == "undecided":
                test.observe(bool(rng.random() < case["p"]))
            numbers.append(test.trials)
            below += test.verdict == "below"
        assert np.mean(numbers) == pytest.approx(case["E_n"], abs=4 * np.std(numbers) / 300**0.5)
        p = case["P_accept_H1"]
        assert abs(below / 300 - p) <= 4 * (p * (1 - p) / 300) ** 0.5 + 1e-3


def test_a_test_without_room_is_refused():
    with pytest.raises(ModelError, match=r"theta 0.99 \+- 0.05"):
        ProbabilityRatioTest(0.99, 0.05)


def test_any_gymnasium_environment_is_sampled():
    runs = GymnasiumRuns("CartPole-v1", limit=200)
    found = sample(runs, 12, seed=1, properties_={"upright": "G[0,5] (abs(obs.o2) < 0.2)"}, block=4)
    assert found.count("terminated") == 12
    again = sample(runs, 12, seed=1, properties_={"upright": "G[0,5] (abs(obs.o2) < 0.2)"}, block=12)
    assert again.cycles == found.cycles
    assert again.properties["upright"].least == found.properties["upright"].least
    assert found.properties["upright"].true > 6


@pytest.mark.parametrize(
    ("whole", "damaged"),
    [
        ('"runs": 100', '"runs": -100'),
        ('"counts": {"g": 100}', '"counts": {"g": "x"}'),
        ('"counts": {"g": 100}', '"counts": {"h": 100}'),
        ('"counts": {"g": 100}', '"counts": {"g": 10000}'),
        ('"counts": {"g": 100}', '"counts": []'),
    ],
)
def test_a_journal_that_does_not_add_up_is_refused(tmp_path, whole, damaged):
    runs = ChainRuns(MarkovChain.from_rows([{0: 0.5, 1: 0.5}, {}], {"g": [1]}))
    journal = tmp_path / "journal"
    sample(runs, 200, seed=1, block=100, journal=journal)
    assert sample(runs, 200, seed=1, block=100, journal=journal).counts == {"g": 200}
    text = journal.read_text()
    assert whole in text
    journal.write_text(text.replace(whole, damaged, 1))
    with pytest.raises(FormatError, match="journal"):
        sample(runs, 200, seed=1, block=100, journal=journal)
