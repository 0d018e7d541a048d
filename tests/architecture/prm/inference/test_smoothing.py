"""Windows: smoothing, best path, expected counts, samples."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from inference_cases import Schedule, load
from inference_worlds import RandomWorld, table, unrolled_joint

from cprm_gym.architecture.prm import Attribute, BayesNet, Grounding, Labels, Model, Prior, PRMClass, Table, unroll
from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.factors import Factor, sample_factors
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ParameterError


class HiddenMarkov(Grounds):
    """One hidden chain and its readings."""

    def __init__(self, seed: int, states: int = 3, readings: int = 4) -> None:
        rng = np.random.default_rng(seed)
        self.prior, self.move, self.sense = table(rng, (states,)), table(rng, (states, states)), table(rng, (states, readings))
        names = {"x": GroundVariable("x", tuple(map(str, range(states)))), "y": GroundVariable("y", tuple(map(str, range(readings))))}
        reading = GroundCPD("y", (("x", 0),), self.sense, "sense")
        self.slices = {
            True: GroundSlice(names, (GroundCPD("x", (), self.prior, "prior"), reading)),
            False: GroundSlice(names, (GroundCPD("x", (("x", 1),), self.move, "move"), reading)),
        }

    def ground(self, relations=(), first=False):
        return self.slices[first]

    def paths(self, readings):
        """Every path and its probability with the readings; -1 is a missing one."""
        for path in itertools.product(range(len(self.prior)), repeat=len(readings)):
            p = self.prior[path[0]]
            for a, b in itertools.pairwise(path):
                p *= self.move[a, b]
            for x, y in zip(path, readings):
                p *= self.sense[x, y] if y >= 0 else 1.0
            yield path, p


READINGS = (2, -1, 0, 3, 1)


def run(world, readings, window):
    filter_ = Filter(world, window=window)
    for y in readings:
        filter_.step({"y": y})
    return filter_


def test_smoothing_equals_the_sum_over_all_paths():
    world = HiddenMarkov(1)
    smoothed = run(world, READINGS, 5).smooth()
    total = sum(p for _, p in world.paths(READINGS))
    for t in range(5):
        expected = np.zeros(3)
        for path, p in world.paths(READINGS):
            expected[path[t]] += p / total
        np.testing.assert_allclose(smoothed[t]["x"][0], expected, atol=1e-12)
    np.testing.assert_allclose(smoothed[1]["y"][0], smoothed[1]["x"][0] @ world.sense, atol=1e-12)


def test_a_window_shorter_than_the_past_gives_the_same_answers_for_its_slices():
    world = HiddenMarkov(2)
    whole, part = run(world, READINGS, 5).smooth(), run(world, READINGS, 2).smooth()
    assert len(part) == 2
    for mine, theirs in zip(part, whole[-2:]):
        np.testing.assert_allclose(mine["x"], theirs["x"], atol=1e-12)


def test_most_probable_path_is_the_best_of_all_paths():
    world = HiddenMarkov(3)
    found = run(world, READINGS, 5).most_probable_path()
    best = max(((path, p * world.sense[path[1]].max()) for path, p in world.paths(READINGS)), key=lambda pair: pair[1])[0]
    assert tuple(int(values["x"].value[0]) for values in found) == best
    assert [int(values["y"].value[0]) for values in found] == [y if y >= 0 else world.sense[best[1]].argmax() for y in READINGS]


def test_expected_counts_are_the_posterior_means_over_all_paths():
    world = HiddenMarkov(4)
    counts = run(world, READINGS, 5).expected_counts()
    prior, move, sense = np.zeros(3), np.zeros((3, 3)), np.zeros((3, 4))
    total = sum(p for _, p in world.paths(READINGS))
    for path, p in world.paths(READINGS):
        prior[path[0]] += p / total
        for a, b in itertools.pairwise(path):
            move[a, b] += p / total
        for x, y in zip(path, READINGS):
            sense[x] += p / total * (np.eye(4)[y] if y >= 0 else world.sense[x])
    np.testing.assert_allclose(counts["prior"], prior, atol=1e-12)
    np.testing.assert_allclose(counts["move"], move, atol=1e-12)
    np.testing.assert_allclose(counts["sense"], sense, atol=1e-12)


def test_counts_of_a_class_are_summed_over_its_objects_and_agents():
    case = load("d13_object_enter_leave")
    filter_ = Filter(Schedule(case), batch=2, window=4)
    for step, relations in list(zip(case["steps"], case["schedule"]))[:4]:
        filter_.step(step["evidence"], relations=relations)
    counts = filter_.expected_counts()
    assert sum(c.sum() for c in counts.values()) == pytest.approx(2 * sum(len(case["cpd_sets"][s]) for s in case["schedule"][:4]))


def test_expectation_maximisation_climbs_the_likelihood():
    """What the counts are for: one EM step never lowers the likelihood."""
    world = HiddenMarkov(5)
    readings = [int(y) for y in np.random.default_rng(0).integers(0, 4, 30)]
    last = -np.inf
    for _ in range(6):
        filter_ = run(world, readings, 30)
        assert filter_.log_likelihood[0] >= last - 1e-9
        last = filter_.log_likelihood[0]
        counts = filter_.expected_counts()
        better = HiddenMarkov(5)
        for name, key in (("prior", "prior"), ("move", "move"), ("sense", "sense")):
            getattr(better, name)[...] = counts[key] / counts[key].sum(axis=-1, keepdims=True)
        world = better


def test_smoothing_of_a_switching_world_equals_the_unrolled_net():
    world = RandomWorld(11)
    rng = np.random.default_rng(1)
    filter_ = Filter(world, window=3)
    slices, hard = [], []
    for t in range(5):
        active = (int(rng.integers(0, 30)),) if t else ()
        slices.append(world.ground(active, first=t == 0))
        evidence = {n: int(rng.integers(0, v.card)) for n, v in slices[-1].variables.items() if n in world.given or "obs" in n}
        hard.append(evidence)
        filter_.step(evidence, relations=active)
    for t, answer in zip((2, 3, 4), filter_.smooth()):
        for name in answer:
            if name not in world.given:
                joint = unrolled_joint(slices, hard, [{}] * 5, [(name, t)], world.static)
                np.testing.assert_allclose(answer[name][0], joint / joint.sum(), atol=1e-10)


def test_a_filter_without_a_window_says_so():
    filter_ = Filter(HiddenMarkov(1))
    filter_.step({"y": 0})
    for question in (filter_.smooth, filter_.most_probable_path, filter_.expected_counts):
        with pytest.raises(ParameterError, match="window"):
            question()


def test_samples_of_a_belief_follow_it():
    case = load("d06_possession_on_off")
    filter_ = Filter(Schedule(case), batch=2)
    for step, relations in list(zip(case["steps"], case["schedule"]))[:7]:
        result = filter_.step(step["evidence"], relations=relations)
    drawn = filter_.sample(20_000, seed=3)
    joint = np.zeros((3, 3))
    np.add.at(joint, (drawn["b.dist"][1], drawn["o1.dist"][1]), 1 / 20_000)
    np.testing.assert_allclose(joint, result.joint("b.dist", "o1.dist")[1], atol=0.015)


def test_samples_of_factors_follow_their_product():
    rng = np.random.default_rng(0)
    factors = [Factor(("a", "b"), rng.random((2, 3, 2))), Factor(("b", "c"), rng.random((1, 2, 4)))]
    drawn = sample_factors(factors, 2, 40_000, rng)
    joint = np.einsum("wab,wbc->wabc", factors[0].table, np.repeat(factors[1].table, 2, axis=0))
    joint /= joint.sum(axis=(1, 2, 3), keepdims=True)
    counted = np.zeros((3, 2, 4))
    np.add.at(counted, (drawn["a"][1], drawn["b"][1], drawn["c"][1]), 1 / 40_000)
    np.testing.assert_allclose(counted, joint[1], atol=0.012)


def test_the_atemporal_variable_of_an_object_that_comes_back_is_a_new_one():
    """Filtering and smoothing through a leave-taking and a return, against the static unrolled net."""
    coin = PRMClass(
        "Coin",
        attributes=(
            Attribute("bias", Labels(("fair", "loaded")), Prior((0.6, 0.4)), static=True),
            Attribute("face", Labels(("heads", "tails")), Table({("fair",): (0.5, 0.5), ("loaded",): (0.9, 0.1)}), parents=("bias",)),
        ),
    )
    world = Grounding(Model("coins", (coin,)), {"c1": "Coin", "c2": "Coin"})
    filter_ = Filter(world, window=5)
    slices, evidence, situation = [], {}, None
    for t, objects in enumerate([("c1", "c2"), ("c1", "c2"), ("c1",), ("c1", "c2"), ("c1", "c2")]):
        situation = world.situation((), objects, situation)
        slices.append(world.ground(situation, first=t == 0))
        faces = {f"{c}.face": "heads" for c in objects if (t, c) not in ((0, "c2"), (4, "c2"))}
        result = filter_.step(faces, objects=objects)
        evidence.update({f"{name}#{t}": state for name, state in faces.items()})
        answer = BayesNet(unroll(slices)).query(evidence)
        assert result.log_likelihood[0] == pytest.approx(answer.log_evidence[0], abs=1e-12)
        for name in result:
            drawn = [s for s in range(t + 1) if f"{name}#{s}" in answer][-1]
            np.testing.assert_allclose(result[name], answer[f"{name}#{drawn}"], atol=1e-12)
    for t, smoothed in enumerate(filter_.smooth()):
        for name in smoothed:
            drawn = [s for s in range(t + 1) if f"{name}#{s}" in answer][-1]
            np.testing.assert_allclose(smoothed[name], answer[f"{name}#{drawn}"], atol=1e-12)
