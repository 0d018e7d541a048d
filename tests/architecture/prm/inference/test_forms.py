"""Steps by form: a filter whose relations wander answers what one in its own names does.

A filter with a window never makes steps by form, so it is the one to compare with.
"""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import scene

from cprm_gym.architecture.prm import BOOL, Attribute, Filter, Grounding, Model, Prior, PRMClass, Relation, Replace, Table
from cprm_gym.architecture.prm.inference import filter as filter_module
from cprm_gym.errors import EvidenceError, ImpossibleEvidence, ModelError


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    monkeypatch.setattr(filter_module, "SETTLED", 0)


def readings(rng, objects, batch):
    """What is seen of some objects, by some agents."""
    told = {}
    for o in objects:
        if rng.random() < 0.8:
            seen = rng.random(batch) < 0.6
            told[f"{o}.seen"] = seen.astype(np.int64)
            told[f"{o}.obs_dist"] = np.where(seen, rng.uniform(2.0, 25.0, batch), np.nan)
            told[f"{o}.obs_dir"] = np.where(seen, rng.uniform(-1.0, 1.0, batch), np.nan)
    told["o2.turn"] = rng.uniform(-0.3, 0.3, batch)
    return told


def alike(seen, expected, joints=()):
    assert list(seen) == list(expected)
    for name in expected:
        np.testing.assert_allclose(seen[name], expected[name], atol=1e-12)
    for pair in joints:
        np.testing.assert_allclose(seen.joint(*pair), expected.joint(*pair), atol=1e-12)
    np.testing.assert_allclose(seen.log_likelihood, expected.log_likelihood, atol=1e-10)
    assert seen.relations == expected.relations
    assert seen.hidden() == expected.hidden()
    assert list(seen.slice.variables) == list(expected.slice.variables)


@pytest.mark.parametrize("batch", [1, 3])
@pytest.mark.parametrize("seed", range(3))
def test_attention_at_random_is_answered_as_in_own_names(seed, batch):
    grounding, rng = scene(5, 5), np.random.default_rng(seed)
    by_form, own = Filter(grounding, batch), Filter(grounding, batch, window=1)
    for t in range(30):
        attended = [f"attended(o{k})" for k in rng.permutation(np.arange(1, 6))[: rng.integers(0, 6)]]
        told = readings(rng, grounding.objects, batch)
        soft = {"o3.dist": rng.uniform(0.1, 1.0, (batch, 5))} if t % 3 == 0 else None
        alike(
            by_form.step(told, attended, soft=soft), own.step(told, attended, soft=soft), [("o1.dist", "o1.vdist"), ("o4.dir", "ball.dist")]
        )
    assert by_form._order is not None


@pytest.mark.parametrize("seed", range(4))
def test_whatever_else_is_asked_in_between_is_answered_in_own_names(seed):
    """Possession joins objects and has a variable of its own; objects leave; agents begin anew; the filter looks ahead."""
    grounding, rng = scene(4, 4), np.random.default_rng(seed)
    by_form, own = Filter(grounding, 2), Filter(grounding, 2, window=1)
    used = 0
    for _ in range(40):
        relations = [f"attended(o{k})" for k in rng.permutation(np.arange(1, 5))[: rng.integers(0, 5)]]
        told, kind, objects = readings(rng, grounding.objects, 2), rng.integers(0, 12), None
        if kind == 0:
            relations = [*relations, f"possesses(o{rng.integers(1, 5)},ball)"]
        elif kind == 1:
            objects = [o for o in grounding.objects if o != "o4"]
            relations = [r for r in relations if r != "attended(o4)"]
            told = {n: v for n, v in told.items() if not n.startswith("o4")}
        elif kind == 2:
            for f in (by_form, own):
                f.reset([1])
        alike(by_form.step(told, relations, objects=objects), own.step(told, relations, objects=objects))
        used += by_form._order is not None
        if kind == 3:
            ahead, expected = by_form.predict(2, ["attended(o1)"]), own.predict(2, ["attended(o1)"])
            for name in expected:
                np.testing.assert_allclose(ahead[name], expected[name], atol=1e-12)
        elif kind == 4:
            assert by_form.variables(["attended(o2)"]) == own.variables(["attended(o2)"])
            by_form.state = by_form.state
    assert used > 10


FLIP = Table({"yes": (0.0, 1.0), "no": (0.8, 0.2)})
BOTH = Table({("yes", "yes"): (0.1, 0.9), ("*", "*"): (0.7, 0.3)})
READ = Table({"yes": (0.0, 1.0), "no": (1.0, 0.0)})


def watched():
    """Flags that stay once they are up, if they are watched; a reading never lies."""
    thing = PRMClass("A", (Attribute("up", BOOL, Prior((0.5, 0.5))), Attribute("seen", BOOL, READ, parents=("up",))))
    watch = Relation("watch", {"o": "A"}, (Replace("o.up", ("prev.o.up",), FLIP),))
    near = Relation("near", {"a": "A", "b": "A"}, (Replace("a.up", ("prev.a.up", "prev.b.up"), BOTH),), priority=1)
    return Grounding(Model("m", (thing,), (watch, near)), {f"a{k}": "A" for k in range(5)})


@pytest.mark.parametrize("policy", ["drop", "soften", "restart"])
@pytest.mark.parametrize("seed", range(4))
def test_impossible_readings_are_answered_as_in_own_names(policy, seed):
    grounding, rng = watched(), np.random.default_rng(seed)
    by_form, own = Filter(grounding, 2, on_impossible=policy), Filter(grounding, 2, on_impossible=policy, window=1)
    used = 0
    for _ in range(40):
        relations = [f"watch(a{k})" for k in rng.permutation(5)[: rng.integers(0, 6)]]
        if rng.random() < 0.3:
            relations.append("near(a{},a{})".format(*rng.permutation(5)[:2]))
        told = {f"a{k}.seen": rng.integers(0, 2, 2) for k in rng.permutation(5)[:2]}
        alike(by_form.step(told, relations), own.step(told, relations))
        np.testing.assert_array_equal(by_form.impossible_count, own.impossible_count)
        used += by_form._order is not None
    assert used > 10
    assert own.impossible_count.sum() > 0


def test_errors_speak_in_own_names_and_leave_the_belief():
    by_form, own = Filter(watched()), Filter(watched(), window=1)
    for f in (by_form, own):
        f.step({}, ["watch(a0)"])
        f.step({}, ["watch(a3)"])
        f.step({"a3.seen": 1}, ["watch(a3)", "watch(a4)"])
        with pytest.raises(ImpossibleEvidence) as told:
            f.step({"a3.seen": 0, "a1.seen": 0}, ["watch(a3)"])
        assert told.value.conflict == ("a3.seen",)
        with pytest.raises(ModelError, match=r"near\(a3,a1\) and near\(a3,a2\) all change 'a3.up'"):
            f.step({}, ["near(a3,a1)", "near(a3,a2)"])
        with pytest.raises(EvidenceError, match=r"a7\.seen"):
            f.step({"a7.seen": 0}, ["watch(a4)"])
    alike(by_form.step({"a4.seen": 1}, ["watch(a4)", "watch(a3)"]), own.step({"a4.seen": 1}, ["watch(a4)", "watch(a3)"]))


def test_a_variable_that_is_needed_for_the_first_time_is_found():
    """The first set of relations keeps nothing; the belief is made again with what the second one needs."""
    grounding = watched()
    by_form, own = Filter(grounding), Filter(grounding, window=1)
    for relations in ((), (), (), ("watch(a2)",), ("near(a2,a4)", "watch(a1)"), ("watch(a4)",)):
        alike(by_form.step({"a2.seen": 1}, relations), own.step({"a2.seen": 1}, relations))


def test_attention_at_random_needs_few_steps():
    """A slice step for each set of objects, and the one before, would be 165 x 165."""
    grounding, rng = scene(4, 11), np.random.default_rng(0)
    filter_ = Filter(grounding)
    for t in range(300):
        filter_.step({"o5.seen": t % 2}, [f"attended(o{k})" for k in rng.permutation(np.arange(1, 12))[:3]])
    made = set(filter_.engine.compiler.slice_steps)
    for t in range(200):
        filter_.step({"o5.seen": t % 2}, [f"attended(o{k})" for k in rng.permutation(np.arange(1, 12))[:3]])
    assert len(made) < 60
    assert len(set(filter_.engine.compiler.slice_steps) - made) < 3
