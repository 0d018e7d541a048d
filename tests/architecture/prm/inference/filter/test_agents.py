"""The filter as an object: agents in a batch, snapshots, windows, and what becomes of it in the long run."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, load
from inference_filters import Fixed, umbrella
from inference_scene import Scene
from inference_worlds import RandomWorld

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ModelError, ParameterError


@pytest.mark.parametrize("engine", ["exact", "projection"])
def test_agents_that_begin_anew_are_new_filters(engine):
    world = RandomWorld(5, static=False)
    rng = np.random.default_rng(0)
    width = 4
    batch = Filter(world, batch=width, engine=engine)
    alone = [Filter(world) for _ in range(width)]
    for t in range(8):
        active = (int(t % 5),) if t else ()
        evidence = {n: rng.integers(0, v.card, width) for n, v in world.ground().variables.items() if "obs" in n or n in world.given}
        if t in (3, 5):
            mask = rng.random(width) < 0.5
            batch.reset(mask)
            for w in np.flatnonzero(mask):
                alone[w].reset()
        result = batch.step(evidence, relations=active)
        for w, one in enumerate(alone):
            single = one.step({n: int(v[w]) for n, v in evidence.items()}, relations=active)
            assert result.log_likelihood[w] == pytest.approx(single.log_likelihood[0], abs=1e-10)
            for name in result:
                np.testing.assert_allclose(result[name][w], single[name][0], atol=1e-10)
            np.testing.assert_allclose(result.joint("x0.p", "x1.q")[w], single.joint("x0.p", "x1.q")[0], atol=1e-10)


def test_a_snapshot_is_the_whole_state():
    filter_ = umbrella(batch=2, window=3)
    filter_.step(relations="prior")
    filter_.step({"umb": [0, 1]}, relations="step")
    kept = filter_.state
    first = filter_.step({"umb": 1}, relations="step")
    filter_.step({"umb": 0}, relations="step")
    filter_.state = kept
    again = filter_.step({"umb": 1}, relations="step")
    np.testing.assert_array_equal(first["rain"], again["rain"])
    np.testing.assert_array_equal(first.log_likelihood, again.log_likelihood)
    assert again.step == 2


def test_prediction_leaves_the_filter_where_it_is():
    filter_ = umbrella()
    filter_.step(relations="prior")
    filter_.step({"umb": 1}, relations="step")
    belief = filter_.state.belief
    ahead = filter_.predict(50, relations="step")
    np.testing.assert_allclose(ahead["rain"], 0.5, atol=1e-12)
    assert filter_.state.belief is belief
    assert filter_.step_count == 2


@pytest.mark.slow
def test_a_hundred_thousand_steps_lose_no_mass_and_do_not_slow_down_or_grow():
    import tracemalloc
    from time import process_time

    scene = Scene(10, opponents=0)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    readings = [scene.readings(rng) for _ in range(64)]
    spent, sizes = [], []
    tracemalloc.start()
    for block in range(10):
        begun = process_time()
        for t in range(10_000):
            result = filter_.step(readings[(7 * t + block) % 64])
        spent.append(process_time() - begun)
        sizes.append(tracemalloc.get_traced_memory()[0])
        for name in scene.hidden():
            assert abs(result[name].sum() - 1.0) < 1e-9
    tracemalloc.stop()
    assert sizes[-1] < sizes[1] + 50_000
    assert np.median(spent[-3:]) < 1.5 * np.median(spent[1:4])


def test_what_is_remembered_stays_bounded_when_names_come_and_go():
    card = ("0", "1")
    chain = np.array([[0.9, 0.1], [0.2, 0.8]])

    def slice_of(names, old):
        variables = {n: GroundVariable(n, card) for n in names}
        return GroundSlice(variables, tuple(GroundCPD(n, ((n, 1),) if n in old else (), chain if n in old else chain[0], 0) for n in names))

    filter_ = Filter(Fixed(slice_of(["a"], []), slice_of(["a"], ["a"])))
    filter_.step()
    old = ["a"]
    for t in range(1500):
        new = ["a", f"n{t}", f"n{t - 1}"][: 3 if t else 2]
        result = filter_.step(relations=slice_of(new, old))
        old = new
    assert result["a"].sum() == pytest.approx(1.0)
    compiler = filter_.engine.compiler
    assert len(compiler.slice_steps) <= 512
    assert len(compiler.layouts) <= 512
    assert compiler.compiled < 10


def test_a_window_does_not_reach_back_over_agents_that_began_anew():
    filter_ = umbrella(batch=2, window=10)
    filter_.step(relations="prior")
    filter_.step({"umb": 1}, relations="step")
    filter_.reset([0])
    filter_.step({"umb": 1}, relations="step")
    with pytest.raises(ParameterError, match="went on"):
        filter_.smooth()
    result = filter_.step({"umb": 0}, relations="step")
    smoothed = filter_.smooth()
    assert len(smoothed) == 1
    np.testing.assert_allclose(smoothed[0]["rain"], result["rain"], atol=1e-12)


def test_the_last_step_is_done_again_with_the_agents_that_began_anew():
    """A variable is found to be needed one step after some agents were reset."""
    world = RandomWorld(3, static=False)
    batch, alone = Filter(world, batch=2), [Filter(world), Filter(world)]
    rng = np.random.default_rng(0)
    names = [n for n in world.ground().variables if "obs" in n or n in world.given]
    for t in range(5):
        evidence = {n: rng.integers(0, 2, 2) for n in names}
        if t == 3:
            batch.reset([1])
            alone[1].reset()
            batch.engine.temporal = frozenset()
            batch.engine.compiler.slice_steps.clear()
            for info in batch.engine.store.infos.values():
                info._statuses.clear()
        result = batch.step(evidence)
        for w, one in enumerate(alone):
            single = one.step({n: int(v[w]) for n, v in evidence.items()})
            np.testing.assert_allclose(result["x1.p"][w], single["x1.p"][0], atol=1e-12)


def test_a_belief_is_projected_on_demand_and_says_what_it_lost():
    case = load("d07_entangle_min")
    filter_ = Filter(Schedule(case))
    for step, relations in list(zip(case["steps"], case["schedule"]))[:5]:
        result = filter_.step(step["evidence"], relations=relations)
    joint = result.joint("A", "B")[0]
    product = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    loss = filter_.project([("A",), ("B",)])
    assert loss[0] == pytest.approx((joint * np.log(joint / product)).sum(), abs=1e-12)
    result = filter_.step({}, relations="off")
    assert not result.exact
    after = result.joint("A", "B")[0]
    np.testing.assert_allclose(after, after.sum(axis=1, keepdims=True) * after.sum(axis=0, keepdims=True), atol=1e-14)
    with pytest.raises(ModelError, match="'C'"):
        filter_.project([("C",)])
