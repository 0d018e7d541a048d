"""The reference cases: static nets, filters with switching relations, prediction, smoothing, likelihoods."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, find, load, static_slice
from inference_worlds import table

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.bayes_net import BayesNet
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ImpossibleEvidence

STATIC = ("s01_asia", "s02_cancer", "s03_earthquake", "s04_survey", "s05_sachs", "s06_child", "s07_insurance", "s08_alarm")
OURS = ("s11_sprinkler", "s12_student")
FILTERS = (
    "d01_umbrella",
    "d02_casino",
    "d03_ball_n10",
    "d05_attention_on_off",
    "d06_possession_on_off",
    "d07_entangle_min",
    "d08_possession_temporal",
    "d10_places_observed",
    "d11_soft",
    "d12_impossible",
    "d13_object_enter_leave",
    "d15_corridor",
    "d17_scene_11opp",
)
EXACT = 1e-9


def case_or_skip(name):
    if find(name) is None:
        pytest.skip(f"{name} is in ../shared, which is not there")
    return load(name)


@pytest.mark.parametrize("name", STATIC + OURS)
def test_static_net_gives_the_recorded_posteriors(name):
    case = case_or_skip(name)
    net = BayesNet(static_slice(case))
    for query in case["queries"]:
        if query.get("impossible"):
            with pytest.raises(ImpossibleEvidence) as caught:
                net.query(query["evidence"], query["soft"])
            assert caught.value.conflict
            continue
        answer = net.query(query["evidence"], query["soft"])
        assert answer.log_evidence[0] == pytest.approx(query["log_evidence"], abs=EXACT)
        for variable, posterior in query["posterior"].items():
            np.testing.assert_allclose(answer[variable][0], posterior, atol=EXACT)
        for joint in query["joints"]:
            np.testing.assert_allclose(answer.joint(*joint["vars"])[0].ravel(), joint["table"], atol=EXACT)
            eliminated = net.variable_elimination(joint["vars"], query["evidence"], query["soft"])
            np.testing.assert_allclose(eliminated[0].ravel(), joint["table"], atol=EXACT)


@pytest.mark.parametrize("name", FILTERS)
def test_filter_gives_the_recorded_posteriors(name):
    case = case_or_skip(name)
    filter_ = Filter(Schedule(case), window=len(case["schedule"]))
    for step, relations in zip(case["steps"], case["schedule"]):
        if step.get("impossible"):
            before = filter_.state
            with pytest.raises(ImpossibleEvidence):
                filter_.step(step["evidence"], soft=step["soft"], relations=relations)
            assert filter_.state.belief is before.belief
            continue
        result = filter_.step(step["evidence"], soft=step["soft"], relations=relations)
        assert result.exact
        assert result.increment[0] == pytest.approx(step["log_evidence_increment"], abs=EXACT)
        assert result.log_likelihood[0] == pytest.approx(step["log_evidence"], abs=EXACT)
        for variable, posterior in step["posterior"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=EXACT)
        for variable, mean in step["expectation"].items():
            assert result.index_mean(variable)[0] == pytest.approx(mean, abs=EXACT)
        for joint in step["joints"]:
            np.testing.assert_allclose(result.joint(*joint["vars"])[0].ravel(), joint["table"], atol=EXACT)
    for ahead in case.get("predict", []):
        result = filter_.predict(ahead["horizon"], relations=ahead["cpds"])
        for variable, posterior in ahead["posterior"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=EXACT)
    if "smoothed" in case:
        smoothed = filter_.smooth()
        for key, posterior in case["smoothed"].items():
            variable, t = key.split("#")
            np.testing.assert_allclose(smoothed[int(t)][variable][0], posterior, atol=EXACT)


@pytest.mark.parametrize("name", ["d05_attention_on_off", "d06_possession_on_off", "d08_possession_temporal", "d13_object_enter_leave"])
def test_a_batch_of_agents_with_different_readings_missing_is_each_agent_alone(name):
    case = load(name)
    schedule = Schedule(case)
    rng = np.random.default_rng(4)
    width = 5
    batch = Filter(schedule, batch=width)
    alone = [Filter(schedule) for _ in range(width)]
    for step, relations in zip(case["steps"], case["schedule"]):
        evidence = {}
        for variable, state in step["evidence"].items():
            kept = rng.random(width) < 0.7 if "obs" in variable else np.ones(width, bool)
            evidence[variable] = np.where(kept, state, -1)
        together = batch.step(evidence, soft=step["soft"], relations=relations)
        for w, one in enumerate(alone):
            single = one.step({v: int(s[w]) for v, s in evidence.items()}, soft=step["soft"], relations=relations)
            assert together.log_likelihood[w] == pytest.approx(single.log_likelihood[0], abs=EXACT)
            for variable in step["posterior"]:
                np.testing.assert_allclose(together[variable][w], single[variable][0], atol=EXACT)


def test_a_place_that_is_given_gives_the_posteriors_without_its_prior():
    case = load("d10_places_observed")
    filter_ = Filter(Schedule(case, given=("pl", "tok")))
    for step, relations in zip(case["steps"], case["schedule"]):
        result = filter_.step(step["evidence"], soft=step["soft"], relations=relations)
        for variable, posterior in step["posterior"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=EXACT)
        prior = -(result.step + 1) * np.log(6.0)
        assert result.log_likelihood[0] == pytest.approx(step["log_evidence"] - prior, abs=EXACT)


def test_log_likelihood_of_a_long_chain_does_not_underflow():
    rng = np.random.default_rng(16)
    prior, move, sense = table(rng, (4,)), table(rng, (4, 4)), table(rng, (4, 5))
    names = {"x": GroundVariable("x", tuple("abcd")), "y": GroundVariable("y", tuple("vwxyz"))}
    reading = GroundCPD("y", (("x", 0),), sense, "y")
    first = GroundSlice(names, (GroundCPD("x", (), prior, "x0"), reading))
    later = GroundSlice(names, (GroundCPD("x", (("x", 1),), move, "x"), reading))

    class Chain(Grounds):
        def ground(self, relations=(), first=False, slices=(later, first)):
            return slices[first]

    filter_ = Filter(Chain())
    belief, total = prior, 0.0
    readings = rng.integers(0, 5, 3000)
    for t, y in enumerate(readings):
        belief = (belief if t == 0 else belief @ move) * sense[:, y]
        total += np.log(belief.sum())
        belief = belief / belief.sum()
        result = filter_.step({"y": int(y)})
    assert total < -1400
    assert result.log_likelihood[0] == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(result["x"][0], belief, atol=EXACT)
    assert filter_.engine.compiler.compiled <= 3
