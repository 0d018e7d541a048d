"""The particle filter and the anytime engine."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, find, load
from inference_scene import Active, Scene
from inference_worlds import RandomWorld, unrolled_joint

from cprm_gym.architecture.prm.inference.compiled import kernels
from cprm_gym.architecture.prm.inference.engines.anytime import to_factors, to_particles
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ImpossibleEvidence, ParameterError


def follow(case, engine, **options):
    """(result, recorded step) for every step of a case."""
    filter_ = Filter(Schedule(case), engine=engine, **options)
    for step, relations in zip(case["steps"], case["schedule"]):
        yield filter_.step(step["evidence"], soft=step["soft"], relations=relations), step


@pytest.mark.parametrize(
    "name",
    [
        "d03_ball_n10",
        "d05_attention_on_off",
        "d06_possession_on_off",
        "d08_possession_temporal",
        "d13_object_enter_leave",
        "d15_corridor",
        "d17_scene_11opp",
    ],
)
def test_a_thousand_particles_give_means_within_one_bin(name):
    if find(name) is None:
        pytest.skip(f"{name} is in ../shared, which is not there")
    for seed in range(3):
        for result, step in follow(load(name), "particles", particles=1000, seed=seed):
            assert not result.exact
            for variable, mean in step["expectation"].items():
                assert abs(result.index_mean(variable)[0] - mean) < 1.0


def test_the_error_falls_as_one_over_the_root_of_the_number():
    case = load("d03_ball_n10")
    errors = []
    for number in (100, 400, 1600, 6400):
        squares = []
        for seed in range(8):
            for result, step in follow(case, "particles", particles=number, seed=seed):
                squares += [(result.index_mean(v)[0] - step["expectation"][v]) ** 2 for v in ("b.dist", "b.dir", "b.vdist", "b.vdir")]
        errors.append(np.sqrt(np.mean(squares)))
    slope = np.polyfit(np.log([100, 400, 1600, 6400]), np.log(errors), 1)[0]
    assert -0.62 < slope < -0.38


def test_the_likelihood_is_estimated_without_bias():
    case = load("d08_possession_temporal")
    ratios = []
    for seed in range(60):
        *_, (result, step) = follow(case, "particles", particles=200, seed=seed)
        ratios.append(np.exp(result.log_likelihood[0] - step["log_evidence"]))
    assert abs(np.mean(ratios) - 1.0) < 4 * np.std(ratios) / np.sqrt(60)


def test_the_same_seed_gives_the_same_particles():
    case = load("d06_possession_on_off")
    runs = [[result["b.dist"] for result, _ in follow(case, "particles", particles=50, seed=7)] for _ in range(2)]
    np.testing.assert_array_equal(runs[0], runs[1])
    other = [result["b.dist"] for result, _ in follow(case, "particles", particles=50, seed=8)]
    assert any((a != b).any() for a, b in zip(runs[0], other))


def test_every_independent_component_has_weights_of_its_own():
    scene = Scene(10, opponents=5)
    filter_ = Filter(scene, engine="particles", particles=100, seed=0)
    rng = np.random.default_rng(0)
    for _ in range(10):
        result = filter_.step(scene.readings(rng), relations=scene.all_attended())
    parts = result.report["components"]
    assert sorted(map(len, parts)) == [1] * 5 + [2] * 12
    assert result.report["ess"].shape == (1, 17)
    assert (result.report["ess"] > 5).all()
    held = Active(scene.opponents, "o1")
    parts = filter_.step(scene.readings(rng), relations=held).report["components"]
    assert max(map(len, parts)) >= 9


def test_a_switching_world_with_an_atemporal_variable_is_followed():
    world = RandomWorld(13)
    rng = np.random.default_rng(2)
    filter_ = Filter(world, batch=2, engine="particles", particles=20_000, seed=1)
    slices, hard = [], [[], []]
    for t in range(4):
        active = (int(rng.integers(0, 30)), int(rng.integers(0, 30))) if t else ()
        ground = world.ground(active, first=t == 0)
        slices.append(ground)
        evidence = {n: rng.integers(0, v.card, 2) for n, v in ground.variables.items() if n in world.given or "obs" in n}
        evidence["x0.seen"] = np.array([1, -1])
        for w in range(2):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
        result = filter_.step(evidence, relations=active)
        for w in range(2):
            for name in ground.variables:
                if name not in world.given:
                    joint = unrolled_joint(slices, hard[w], [{}] * 4, [(name, t)], world.static)
                    np.testing.assert_allclose(result[name][w], joint / joint.sum(), atol=0.03)
            joint = unrolled_joint(slices, hard[w], [{}] * 4, [("x0.p", t), ("x0.q", t)], world.static)
            np.testing.assert_allclose(result.joint("x0.p", "x0.q")[w], joint / joint.sum(), atol=0.03)


def test_where_no_particle_fits_the_filter_raises_or_goes_on():
    case = load("d12_impossible")
    schedule = Schedule(case)
    strict = Filter(schedule, engine="particles", particles=50, seed=0)
    lenient = Filter(schedule, engine="particles", particles=50, seed=0, on_impossible="drop")
    for step, relations in list(zip(case["steps"], case["schedule"]))[:4]:
        strict.step(step["evidence"], relations=relations)
        lenient.step(step["evidence"], relations=relations)
    before = strict.state.belief
    with pytest.raises(ImpossibleEvidence, match="obs"):
        strict.step(case["steps"][4]["evidence"], relations="step")
    assert strict.state.belief is before
    result = lenient.step(case["steps"][4]["evidence"], relations="step")
    np.testing.assert_allclose(result["pos"][0], [1, 0, 0, 0])
    assert lenient.impossible_count[0] == 1


def test_agents_begin_anew_alone():
    case = load("d02_casino")
    schedule = Schedule(case)
    filter_ = Filter(schedule, batch=2, engine="particles", particles=20_000, seed=0)
    fresh = Filter(schedule)
    for t in range(4):
        filter_.step({"roll": 5}, relations="prior" if t == 0 else "step")
    filter_.reset([1])
    result = filter_.step({"roll": 5}, relations="step")
    expected = fresh.step({"roll": 5}, relations="prior")
    np.testing.assert_allclose(result["die"][1], expected["die"][0], atol=0.02)
    assert result["die"][0, 1] > result["die"][1, 1] + 0.2
    assert result.log_likelihood[1] == pytest.approx(expected.log_likelihood[0], abs=0.05)


def test_a_snapshot_holds_the_random_numbers_too():
    case = load("d02_casino")
    filter_ = Filter(Schedule(case), engine="particles", particles=50, seed=0)
    filter_.step({"roll": 1}, relations="prior")
    kept = filter_.state
    first = filter_.step({"roll": 5}, relations="step")["die"]
    filter_.state = kept
    np.testing.assert_array_equal(filter_.step({"roll": 5}, relations="step")["die"], first)


def test_systematic_resampling_takes_each_particle_as_often_as_its_weight_says():
    rng = np.random.default_rng(0)
    weights = rng.dirichlet(np.ones(7), size=2)
    ancestors = np.empty((2, 1000), np.int64)
    kernels.systematic(weights, rng.random(2), ancestors)
    for w in range(2):
        np.testing.assert_allclose(np.bincount(ancestors[w], minlength=7) / 1000, weights[w], atol=1.1e-3)


# ------------------------------------------------------------------------------------------------------ anytime


def through_possession(bins, opponents=2, steps=10, **options):
    scene = Scene(bins, opponents)
    rng = np.random.default_rng(5)
    filter_ = Filter(scene, engine="anytime", seed=0, **options)
    exact = []
    for t in range(steps):
        active = Active(scene.opponents, "o1") if 3 <= t < 7 else scene.all_attended()
        exact.append(filter_.step(scene.readings(rng), relations=active))
    return exact


def test_with_time_enough_anytime_is_exact():
    case = load("d06_possession_on_off")
    for result, step in follow(case, "anytime", budget_ms=1e4):
        assert result.engine == "exact"
        assert result.exact
        for variable, posterior in step["posterior"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=1e-9)


def test_with_less_time_anytime_projects_and_says_so():
    results = through_possession(10, budget_ms=1.0)
    engines = {r.engine for r in results}
    assert "projection" in engines
    assert not results[-1].exact
    assert any(r.loss[0] > 0 for r in results)
    assert all(r.report["budget_ms"] == 1.0 and r.report["ms"] > 0 for r in results)


def test_with_too_little_memory_anytime_samples_and_comes_back_when_it_can():
    scene = Scene(6, 1)
    rng = np.random.default_rng(0)
    filter_ = Filter(scene, engine="anytime", seed=0, memory_limit=500.0, budget_ms=50.0)
    assert filter_.step(scene.readings(rng)).engine == "particles"
    result = filter_.step(scene.readings(rng), relations=scene.all_attended())
    assert result.engine == "particles"
    assert result.report["particles"] % 500 == 0
    assert result.report["particles"] >= 500
    filter_.engine.factors.memory_limit = 2.0**26
    result = filter_.step(scene.readings(rng))
    assert result.engine == "exact"
    assert not result.exact
    for name in result:
        np.testing.assert_allclose(result[name].sum(axis=1), 1.0, atol=1e-9)


def test_more_time_means_more_particles():
    counts = []
    for budget in (0.01, 5000.0):
        scene = Scene(6, 1)
        rng = np.random.default_rng(0)
        filter_ = Filter(scene, engine="anytime", seed=0, memory_limit=500.0, budget_ms=budget, most=3000)
        counts.append({filter_.step(scene.readings(rng)).report["particles"] for _ in range(3)})
    assert counts == [{500}, {3000}]


def test_factors_and_particles_are_turned_into_each_other():
    scene = Scene(5, 1)
    rng = np.random.default_rng(1)
    filter_ = Filter(scene, engine="anytime", seed=0, budget_ms=1e4)
    for _ in range(4):
        result = filter_.step(scene.readings(rng), relations=scene.all_attended())
    particles = to_particles(filter_.engine.factored(filter_.state.belief), 50_000, rng)
    back = to_factors(filter_.engine.factors, particles)
    filter_.state = filter_.state._replace(belief=filter_.engine.adopt(back))
    again = filter_.predict(1, relations=scene.all_attended())
    direct = Filter(scene)
    rng = np.random.default_rng(1)
    for _ in range(4):
        direct.step(scene.readings(rng), relations=scene.all_attended())
    expected = direct.predict(1, relations=scene.all_attended())
    for name in scene.hidden():
        np.testing.assert_allclose(again[name], expected[name], atol=0.02)
    assert result.exact


@pytest.mark.parametrize("wrong", [{"engine": "particles", "particles": 1}, {"engine": "anytime", "budget_ms": 0.0}])
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ParameterError):
        Filter(Scene(3, 0), **wrong)
