"""Plans of a filter: patterns of evidence, relations that come and go, costs that are known beforehand."""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import scene as goalie_scene
from inference_filters import Fixed
from inference_scene import Active, Scene

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import CostError


def test_missing_readings_never_compile_a_new_plan():
    scene = Scene(5, opponents=2)
    filter_ = Filter(scene, batch=3)
    rng = np.random.default_rng(0)
    active = scene.all_attended()
    for _ in range(4):
        filter_.step(scene.readings(rng, 3), relations=active)
    compiled = filter_.engine.compiler.compiled
    for _ in range(20):
        evidence = scene.readings(rng, 3)
        evidence = {n: np.where(rng.random(3) < 0.5, v, -1) if "obs" in n else v for n, v in evidence.items()}
        filter_.step(evidence, relations=active)
    assert filter_.engine.compiler.compiled == compiled


def test_objects_of_the_same_class_run_as_one_batch():
    scene = Scene(4, opponents=11)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    for _ in range(3):
        filter_.step(scene.readings(rng), relations=scene.all_attended())
    costs = filter_.cost(scene.all_attended())
    assert sorted(c.objects for c in costs) == [11, 12, 12]


def test_a_relation_that_was_on_before_needs_no_new_plan():
    scene = Scene(3, opponents=2)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    pattern = [scene.all_attended(), Active(("o1",)), Active(("o1",), "o1")]

    def around():
        for active in pattern:
            for _ in range(3):
                filter_.step(scene.readings(rng), relations=active)

    filter_.step(scene.readings(rng))
    around()
    around()
    compiled, made = filter_.engine.compiler.compiled, len(filter_.engine.compiler.slice_steps)
    around()
    assert filter_.engine.compiler.compiled == compiled
    assert len(filter_.engine.compiler.slice_steps) == made


def test_cost_grows_linearly_with_unattended_opponents():
    totals = []
    for opponents in (5, 10, 20):
        scene = Scene(6, opponents)
        filter_ = Filter(scene)
        rng = np.random.default_rng(0)
        for _ in range(3):
            filter_.step(scene.readings(rng))
        totals.append(sum(c.flops for c in filter_.cost()))
    assert totals[2] - totals[1] == pytest.approx(2 * (totals[1] - totals[0]))


def test_cost_is_known_before_the_step_and_a_step_beyond_the_memory_is_refused():
    scene = Scene(10, opponents=1)
    filter_ = Filter(scene, memory_limit=1e8)
    rng = np.random.default_rng(0)
    held = Active(("o1",), "o1")
    filter_.step(scene.readings(rng))
    for _ in range(2):
        filter_.step(scene.readings(rng), relations=held)
    before = filter_.state
    costs = filter_.cost(Active(("o1",)))
    assert costs[0].largest >= 8e8
    assert costs[0].bytes > 6e9
    with pytest.raises(CostError, match="GiB"):
        filter_.step(scene.readings(rng), relations=Active(("o1",)))
    assert filter_.state.belief is before.belief
    filter_.step(scene.readings(rng), relations=held)


def test_a_variable_that_becomes_a_parent_in_time_later_is_brought_back():
    """A hidden chain without readings: at slice 0 nothing says that the next slice will need it."""
    x, y = (GroundVariable(n, ("a", "b")) for n in "xy")
    first = GroundSlice({"x": x}, (GroundCPD("x", (), np.array([0.2, 0.8]), "x0"),))
    move = np.array([[0.9, 0.1], [0.3, 0.7]])
    later = GroundSlice({"x": x, "y": y}, (GroundCPD("x", (("x", 1),), move, "x"), GroundCPD("y", (("x", 0),), move, "y")))
    filter_ = Filter(Fixed(first, later))
    filter_.step()
    result = filter_.step({"y": 1})
    expected = np.array([0.2, 0.8]) @ move * move[:, 1]
    np.testing.assert_allclose(result["x"][0], expected / expected.sum(), atol=1e-12)


def test_an_atemporal_parent_is_learned_about_for_ever():
    rng = np.random.default_rng(3)
    bias = GroundVariable("bias", ("fair", "loaded"))
    coin = GroundVariable("coin", ("heads", "tails"))
    toss = np.array([[0.5, 0.5], [0.8, 0.2]])
    prior = np.array([0.7, 0.3])
    first = GroundSlice({"bias": bias, "coin": coin}, (GroundCPD("bias", (), prior, "b"), GroundCPD("coin", (("bias", 0),), toss, "c0")))
    later = GroundSlice({"coin": coin}, (GroundCPD("coin", (("bias", -1),), toss, "c"),))
    filter_ = Filter(Fixed(first, later), window=6)
    belief = prior
    for coin_state in rng.integers(0, 2, 6):
        result = filter_.step({"coin": int(coin_state)})
        belief = belief * toss[:, coin_state]
        np.testing.assert_allclose(result["bias"][0], belief / belief.sum(), atol=1e-12)
    assert result.log_likelihood[0] == pytest.approx(np.log(belief.sum()), abs=1e-12)
    np.testing.assert_allclose(filter_.smooth()[0]["bias"][0], belief / belief.sum(), atol=1e-12)


def test_a_model_with_classes_is_filtered_and_new_relations_need_no_telling():
    grounding = goalie_scene(bins=4, opponents=2)
    filter_ = Filter(grounding, batch=2, window=4)
    for relations in ((), ("attended(o1)",), ("attended(o1)", "possesses(o1,ball)"), ("attended(o1)",)):
        result = filter_.step({"ball.seen": "yes", "ball.obs_dist": np.array([3.0, 12.0])}, relations=relations)
    assert result.exact
    np.testing.assert_allclose(result["ball.dist"].sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(filter_.smooth()[-1]["o1.dist"], result["o1.dist"], atol=1e-10)
