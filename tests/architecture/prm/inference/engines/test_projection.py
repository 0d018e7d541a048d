"""Boyen-Koller projection: which clusters, what is lost, and that it is said."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, load
from inference_scene import Active, Scene
from inference_worlds import RandomWorld

from cprm_gym.architecture.prm.inference.engines.projection import mutual_information
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ParameterError


def test_given_clusters_give_the_recorded_posteriors_of_a_filter_that_projects():
    case = load("d07_entangle_min")
    filter_ = Filter(Schedule(case), engine="projection", clusters=[("A",), ("B",)])
    for step, relations in zip(case["steps"], case["schedule"]):
        result = filter_.step(step["evidence"], relations=relations)
        for variable, posterior in step["posterior_if_projected"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=1e-9)
    assert not result.exact


def test_the_loss_is_the_divergence_from_the_joint_to_the_product():
    case = load("d07_entangle_min")
    schedule = Schedule(case)
    exact, projected = Filter(schedule), Filter(schedule, engine="projection", clusters=[("A",), ("B",)])
    for step, relations in list(zip(case["steps"], case["schedule"]))[:5]:
        before = exact.step(step["evidence"], relations=relations).joint("A", "B")[0]
    projected.state = exact.state
    loss = projected.step(case["steps"][5]["evidence"], relations=case["schedule"][5]).loss[0]
    product = before.sum(axis=1, keepdims=True) * before.sum(axis=0, keepdims=True)
    assert loss == pytest.approx((before * np.log(before / product)).sum(), abs=1e-12)
    assert loss > 0.01


def test_within_the_budget_nothing_is_projected():
    case = load("d06_possession_on_off")
    filter_ = Filter(Schedule(case), engine="projection", max_flops=1e9)
    for step, relations in zip(case["steps"], case["schedule"]):
        result = filter_.step(step["evidence"], relations=relations)
        for variable, posterior in step["posterior"].items():
            np.testing.assert_allclose(result[variable][0], posterior, atol=1e-9)
    assert result.exact
    assert result.loss[0] == 0.0


def possession(bins, engine, steps=14, off=9, seed=2, **options):
    """Posteriors, losses and clusters of a possession that begins at step 3 and stops at `off`."""
    scene = Scene(bins, opponents=1)
    rng = np.random.default_rng(seed)
    filter_ = Filter(scene, engine=engine, **options)
    out = []
    for t in range(steps):
        active = Active(("o1",), "o1") if 3 <= t < off else Active(("o1",))
        result = filter_.step(scene.readings(rng), relations=active)
        out.append((result, {n: result[n][0] for n in scene.hidden(active)}))
    return out


def distance(mine, theirs):
    return max(np.abs(mine[n] - theirs[n]).sum() / 2 for n in theirs)


@pytest.mark.parametrize("seed", range(3))
def test_projection_by_information_stays_close_to_exact_through_a_possession(seed):
    exact = possession(3, "exact", seed=seed)
    projected = possession(3, "projection", seed=seed, max_flops=3e4)
    assert any(r.loss[0] > 0 for r, _ in projected)
    errors = [distance(mine[1], theirs[1]) for mine, theirs in zip(projected, exact)]
    assert max(errors) < 0.08


def test_projection_by_information_is_closer_than_one_cluster_for_each_object():
    objects = [tuple(f"{o}.{x}" for x in ("dist", "dir", "vdist", "vdir")) + ((f"{o}.orient",) if o == "o1" else ()) for o in ("b", "o1")]
    mean = {"information": [], "objects": []}
    for seed in range(4):
        exact = possession(3, "exact", seed=seed)[9:]
        for name, options in (("information", {"max_flops": 3e4}), ("objects", {"clusters": objects})):
            projected = possession(3, "projection", seed=seed, **options)[9:]
            mean[name] += [np.mean([np.abs(m[n] - e[n]).sum() / 2 for n in e]) for (_, m), (_, e) in zip(projected, exact)]
    assert np.mean(mean["information"]) < 0.75 * np.mean(mean["objects"])


def test_clusters_are_reported_and_cover_what_the_next_slice_needs():
    found = possession(30, "projection", steps=12, off=10)
    clusters = [r.report["clusters"] for r, _ in found if "clusters" in r.report]
    assert clusters
    for parts in clusters:
        names = [n for part in parts for n in part]
        assert len(names) == len(set(names))
        assert {"o1.dist", "o1.dir", "o1.vdist", "o1.vdir", "o1.orient"} <= set(names)
    assert all(np.isfinite(r.loss).all() and (r.loss >= 0).all() for r, _ in found)


def test_a_batch_is_projected_like_each_agent_alone():
    world = RandomWorld(21, static=False, with_given=False)
    clusters = [("x0.p", "x0.q"), ("x1.p",)]
    rng = np.random.default_rng(0)
    batch = Filter(world, batch=3, engine="projection", clusters=clusters)
    alone = [Filter(world, engine="projection", clusters=clusters) for _ in range(3)]
    for t in range(5):
        active = (t,) if t else ()
        evidence = {f"x{k}.obs": rng.integers(0, 2, 3) for k in range(3)}
        result = batch.step(evidence, relations=active)
        for w, one in enumerate(alone):
            single = one.step({n: int(v[w]) for n, v in evidence.items()}, relations=active)
            assert result.loss[w] == pytest.approx(single.loss[0], abs=1e-12)
            np.testing.assert_allclose(result["x2.p"][w], single["x2.p"][0], atol=1e-12)


def test_mutual_information_of_independent_variables_is_zero_and_of_a_copy_its_entropy():
    scene = Scene(4, opponents=0)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    for _ in range(3):
        result = filter_.step(scene.readings(rng))
    belief = filter_.state.belief
    pieces = {i: tuple(v for f in p.factors for v in f.scope) for i, p in enumerate(belief.layout.pieces)}
    shared = mutual_information(belief, pieces)
    for (a, b), information in shared.items():
        joint = result.joint(a[0], b[0])[0]
        product = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
        assert information == pytest.approx((joint * np.log(joint / product)).sum(), abs=1e-12)
    assert {frozenset(n for n, _ in pair) for pair in shared} == {frozenset(("b.dist", "b.vdist")), frozenset(("b.dir", "b.vdir"))}


@pytest.mark.parametrize("wrong", [{"clusters": "object"}, {"max_flops": 0}, {"clusters": [("a", "b"), ("b",)]}])
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ParameterError):
        Filter(Scene(3, 0), engine="projection", **wrong)
