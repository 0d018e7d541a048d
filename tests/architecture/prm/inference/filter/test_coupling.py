"""What hangs together with what in a filter, and stays a distribution."""

from __future__ import annotations

import numpy as np
import pytest
from inference_cases import Schedule, load
from inference_filters import Fixed
from inference_scene import Active, Scene
from inference_worlds import RandomWorld, table, unrolled_joint

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import EvidenceError, ModelError


def test_possession_that_passes_on_entangles_both_players_through_the_ball():
    """p has the ball, then q, then nobody: p and q are dependent, exactly as in the unrolled net."""
    rng = np.random.default_rng(9)
    names = {n: GroundVariable(n, ("0", "1", "2")) for n in ("b", "p", "q", "sb", "sp", "sq")}
    tables = {k: table(rng, shape) for k, shape in {"prior": (3,), "move": (3, 3), "sense": (3, 3), "held": (3, 3, 3)}.items()}

    def slice_of(active, first):
        cpds = []
        for n in "bpq":
            parents = [] if first else [(n, 1)]
            if n == "b" and active and not first:
                parents.append((active, 0))
            key = "prior" if first else "held" if len(parents) == 2 else "move"
            cpds += [GroundCPD(n, tuple(parents), tables[key], key), GroundCPD(f"s{n}", ((n, 0),), tables["sense"], "sense")]
        return GroundSlice(names, tuple(cpds))

    made = {(a, f): slice_of(a, f) for a in ("", "p", "q") for f in (False, True)}

    class Passing(Grounds):
        def ground(self, relations="", first=False):
            return made[relations or "", first]

    filter_ = Filter(Passing())
    slices, hard = [], []
    dependence = []
    for t, active in enumerate(["", "", "p", "p", "q", "", ""]):
        evidence = {f"s{n}": int(rng.integers(0, 3)) for n in "bpq" if rng.random() < 0.6}
        slices.append(made[active, t == 0])
        hard.append(evidence)
        result = filter_.step(evidence, relations=active)
        joint = unrolled_joint(slices, hard, [{}] * 7, [("p", t), ("q", t)])
        np.testing.assert_allclose(result.joint("p", "q")[0], joint / joint.sum(), atol=1e-12)
        pq = joint / joint.sum()
        dependence.append(np.abs(pq - pq.sum(axis=1, keepdims=True) * pq.sum(axis=0, keepdims=True)).max())
    assert max(dependence[:4]) < 1e-12
    assert max(dependence[4:]) > 1e-5


def test_a_flag_that_depends_on_two_quantities_couples_all_four():
    scene = Scene(3, opponents=0, coupled=True)
    filter_ = Filter(scene, batch=2)
    rng = np.random.default_rng(0)
    slices, hard = [], [[], []]
    for t in range(4):
        evidence = scene.readings(rng, 2)
        if t == 2:
            evidence["b.seen"] = np.array([-1, 1])
            evidence["b.obs_dist"] = np.array([2, -1])
        slices.append(scene.ground(first=t == 0))
        for w in range(2):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
        result = filter_.step(evidence)
        for w in range(2):
            keep = [(f"b.{x}", t) for x in ("dist", "dir", "vdist", "vdir")]
            joint = unrolled_joint(slices, hard[w], [{}] * 4, keep)
            np.testing.assert_allclose(result.joint("b.dist", "b.dir", "b.vdist", "b.vdir")[w], joint / joint.sum(), atol=1e-12)
    assert filter_.cost()[0].largest >= 81


def test_prediction_without_readings_keeps_apart_what_only_readings_would_couple():
    scene = Scene(10, opponents=0)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    for _ in range(3):
        filter_.step(scene.readings(rng))
    assert max(c.largest for c in filter_.cost(evidence={})) == 100
    filter_.step({})
    assert max(c.largest for c in filter_.cost()) == 100


def test_an_observed_variable_can_be_a_parent_in_the_next_slice():
    """An action is observed now and moves the state later."""
    rng = np.random.default_rng(4)
    names = {n: GroundVariable(n, ("0", "1", "2")) for n in ("x", "a", "y")}
    move, prior, sense = table(rng, (3, 3, 3)), table(rng, (3,)), table(rng, (3, 3))
    common = (GroundCPD("a", (), prior, "a"), GroundCPD("y", (("x", 0),), sense, "y"))
    first = GroundSlice(names, (GroundCPD("x", (), prior, "x0"), *common))
    later = GroundSlice(names, (GroundCPD("x", (("x", 1), ("a", 1)), move, "x"), *common))
    filter_ = Filter(Fixed(first, later), batch=2)
    slices, hard = [], [[], []]
    for t in range(5):
        evidence = {"a": np.array([t % 3, -1 if t == 2 else 1]), "y": rng.integers(0, 3, 2)}
        slices.append(first if t == 0 else later)
        for w in range(2):
            hard[w].append({n: int(v[w]) for n, v in evidence.items() if v[w] >= 0})
        result = filter_.step(evidence)
        for w in range(2):
            joint = unrolled_joint(slices, hard[w], [{}] * 5, [("x", t)])
            np.testing.assert_allclose(result["x"][w], joint / joint.sum(), atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_every_engine_stays_a_distribution_through_beginnings_and_impossible_readings(seed):
    rng = np.random.default_rng(seed)
    width, policy = 3, ("drop", "soften", "restart")[seed % 3]
    world = RandomWorld(seed, static=seed % 2 == 0, zeros=0.2 * (seed % 3))
    engines = [
        {"engine": "exact"},
        {"engine": "projection", "max_flops": 200},
        {"engine": "particles", "particles": 100, "seed": 1},
        {"engine": "anytime", "budget_ms": 1.0, "memory_limit": (300, 3e3, 1e5)[seed % 3], "most": 1000, "seed": 1},
    ]
    filters = [Filter(world, batch=width, on_impossible=policy, **options) for options in engines]
    for t in range(6):
        active = () if t == 0 else tuple(int(k) for k in rng.integers(0, 30, rng.integers(0, 3)))
        evidence = {}
        for name, variable in world.ground(active, first=t == 0).variables.items():
            chance = 0.7 if name.split(".")[-1] in ("obs", "seen") else 0.15
            if name in world.given or rng.random() < chance:
                evidence[name] = np.where((rng.random(width) < 0.8) | (name in world.given), rng.integers(0, variable.card, width), -1)
        mask = rng.random(width) < (0.3 if t else 0.0)
        for filter_ in filters:
            filter_.reset(mask)
            result = filter_.step(evidence, relations=active)
            assert np.isfinite(result.log_likelihood).all()
            for name in result:
                np.testing.assert_allclose(result[name].sum(axis=1), 1.0, atol=1e-9)
                assert (result[name] >= 0).all()


def test_jeffrey_moves_one_variable_after_the_other():
    filter_ = Filter(Schedule(load("d07_entangle_min")))
    for relations in ("prior", "off", "on"):
        filter_.step({"oA": 1}, relations=relations)
    soft = filter_.jeffrey({"A": [0.2, 0.8], "B": [0.6, 0.4]}, relations="on")
    result = filter_.step({}, soft=soft, relations="on")
    np.testing.assert_allclose(result["B"], [[0.6, 0.4]], atol=1e-12)
    assert abs(result["A"][0, 0] - 0.2) > 1e-3
    with pytest.raises(EvidenceError, match="distribution"):
        filter_.jeffrey({"A": [0.2, 0.9]}, relations="on")


def test_plans_of_steps_to_come_can_be_made_beforehand():
    scene = Scene(3, opponents=2)
    filter_ = Filter(scene)
    rng = np.random.default_rng(0)
    path = [Active(("o1",)), Active(("o1",)), Active(("o1",), "o1"), Active(("o1",), "o1")]
    for _ in range(3):
        filter_.step(scene.readings(rng), relations=path[0])
    before = filter_.state
    assert filter_.prepare(path) > 0
    assert filter_.prepare(path) == 0
    assert filter_.state.belief is before.belief
    compiled, made = filter_.engine.compiler.compiled, len(filter_.engine.compiler.slice_steps)
    for active in path:
        filter_.step(scene.readings(rng), relations=active)
    assert filter_.engine.compiler.compiled == compiled
    assert len(filter_.engine.compiler.slice_steps) == made


def test_an_atemporal_variable_that_is_first_used_late_can_be_named():
    names = {"bias": GroundVariable("bias", ("0", "1")), "coin": GroundVariable("coin", ("0", "1"))}
    toss, prior = np.array([[0.5, 0.5], [0.9, 0.1]]), np.array([0.6, 0.4])
    free = GroundCPD("coin", (), np.array([0.5, 0.5]), "free")
    first = GroundSlice(names, (GroundCPD("bias", (), prior, "b"), free))
    quiet = GroundSlice({"coin": names["coin"]}, (free,))
    biased = GroundSlice({"coin": names["coin"]}, (GroundCPD("coin", (("bias", -1),), toss, "c"),))
    filter_ = Filter(Fixed(first, quiet), static=["bias"])
    for slice_ in (first, quiet, quiet):
        filter_.step({"coin": 0}, relations=slice_)
    result = filter_.step({"coin": 0}, relations=biased)
    expected = prior * toss[:, 0]
    np.testing.assert_allclose(result["bias"][0], expected / expected.sum(), atol=1e-12)
    unnamed = Filter(Fixed(first, quiet))
    for slice_ in (first, quiet, quiet):
        unnamed.step({"coin": 0}, relations=slice_)
    with pytest.raises(ModelError, match="bias"):
        unnamed.step({"coin": 0}, relations=biased)


def test_threads_share_the_agents_and_change_nothing():
    scene = Scene(8, opponents=1)
    rng = np.random.default_rng(0)
    one, three = Filter(scene, batch=7), Filter(scene, batch=7, threads=3)
    for active in (Active(), Active(("o1",)), Active(("o1",), "o1"), Active(("o1",), "o1")):
        readings = scene.readings(rng, 7)
        mine, theirs = one.step(readings, relations=active), three.step(readings, relations=active)
        np.testing.assert_array_equal(mine.log_likelihood, theirs.log_likelihood)
        for name in scene.hidden(active):
            np.testing.assert_array_equal(mine[name], theirs[name])
