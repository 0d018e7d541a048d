"""What was once answered wrongly by filters and banks; each test failed before."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from cprm_gym.architecture.prm import (
    BOOL,
    AnyCause,
    Attribute,
    Count,
    Exists,
    Filter,
    FilterBank,
    Grounding,
    Link,
    Max,
    Mean,
    Model,
    PRMClass,
    Reference,
    Relation,
    Replace,
    Role,
    Table,
)
from cprm_gym.errors import EvidenceError, ModelError

SAME = Table({"yes": (0.0, 1.0), "no": (1.0, 0.0)})
MOSTLY = Table({"yes": (0.1, 0.9), "no": (0.9, 0.1)})


@pytest.mark.parametrize("engine", ["exact", "projection", "particles", "anytime"])
def test_an_object_with_static_attributes_only_stays(engine):
    """Its variables were gone after the first slice."""
    room = PRMClass("Room", (Attribute("infected", BOOL, (0.8, 0.2), static=True),))
    ill = Attribute("ill", BOOL, Table({"yes": (0.3, 0.7), "no": (0.95, 0.05)}), parents=("room.infected",))
    patient = PRMClass("Patient", references=(Reference("room", "Room"),), attributes=(ill,))
    options = {"seed": 1, "particles": 20_000} if engine == "particles" else {}
    filter_ = Filter(Grounding(Model("h", (room, patient)), {"r": "Room", "p": "Patient"}), engine=engine, **options)
    for t in range(4):
        odds = 0.2 * 0.7 ** (t + 1) / (0.2 * 0.7 ** (t + 1) + 0.8 * 0.05 ** (t + 1))
        seen = filter_.step({"p.ill": "yes"})
        assert seen["r.infected"][0, 1] == pytest.approx(odds, abs=0.02 if engine == "particles" else 1e-12)


def test_a_static_object_that_leaves_is_forgotten():
    sign = PRMClass("Sign", (Attribute("bold", BOOL, (0.5, 0.5), static=True),))
    thing = PRMClass("Thing", (Attribute("x", BOOL, (0.5, 0.5)),))
    filter_ = Filter(Grounding(Model("m", (sign, thing)), {"s": "Sign", "t": "Thing"}))
    assert "s.bold" in filter_.step({"s.bold": 1})
    assert "s.bold" not in filter_.step({}, objects=["t"])
    np.testing.assert_allclose(filter_.step({})["s.bold"], [[0.5, 0.5]])


def judged(*aggregates, members=("a",)):
    """One attribute for each aggregate, a copy of it."""
    one = PRMClass("A", (Attribute("on", BOOL, (0.0, 1.0)),))
    judge = PRMClass(
        "B",
        tuple(Attribute(f"f{k}", BOOL, SAME, parents=(a,)) for k, a in enumerate(aggregates)),
        references=(Reference("as_", "A", many=True),),
    )
    objects = {"a": "A", "b": "B"}
    return Filter(Grounding(Model("m", (one, judge)), objects, {"b": {"as_": members}})).step()


def test_aggregates_that_differ_in_their_parameters_are_variables_of_their_own():
    """`AnyCause(strength=.9)` beside `.1` gave .9 for both."""
    seen = judged(AnyCause("as_.on", strength=0.9), AnyCause("as_.on", strength=0.1), AnyCause("as_.on", strength=0.1, leak=0.5))
    assert [seen[f"b.f{k}"][0, 1] for k in range(3)] == pytest.approx([0.9, 0.1, 0.55])
    empty = judged(Mean("as_.on", empty="no"), Mean("as_.on", empty="yes"), members=())
    assert [empty[f"b.f{k}"][0, 1] for k in range(2)] == [0.0, 1.0]


def test_equal_aggregates_of_an_object_are_one_variable():
    seen = judged(AnyCause("as_.on", strength=0.5), AnyCause("as_.on", strength=0.5))
    np.testing.assert_allclose(seen.joint("b.f0", "b.f1")[0], [[0.5, 0.0], [0.0, 0.5]])


def alarm():
    """An alarm that sums up, and a relation that takes its only aggregate away."""
    one = PRMClass("A", (Attribute("on", BOOL, (0.5, 0.5)),))
    watcher = PRMClass(
        "B", (Attribute("alarm", BOOL, MOSTLY, parents=(Exists("as_.on"),)),), references=(Reference("as_", "A", many=True),)
    )
    off = Relation("off", {"y": "B"}, (Replace("y.alarm", (), (0.5, 0.5)),))
    return Grounding(Model("m", (one, watcher), (off,)), {"x0": "A", "x1": "A", "y": "B"})


def test_a_bank_takes_a_relation_that_replaces_an_aggregates_only_user():
    """The bank looked for the aggregate's variable in a slice without it."""
    grounding = alarm()
    bank, own = FilterBank(grounding, 2), [Filter(grounding) for _ in range(2)]
    for _ in range(3):
        bank.step({"x0.on": np.array([1, 0])}, [Link("off", (Role("B", np.array([0, -1])),))])
        for k, relations in enumerate((("off(y)",), ())):
            expected = own[k].step({"x0.on": 1 - k}, relations)
            np.testing.assert_allclose(bank.marginal("y.alarm", k), expected["y.alarm"][0], atol=1e-14)


def test_a_bank_renames_a_belief_after_a_mixture_that_was_not_usable():
    """The renamed slice had a selector, the belief had none."""
    attributes = (Attribute("x", BOOL, MOSTLY, parents=("prev.x",), initial=(0.5, 0.5)),)
    held = Relation("held", {"o": "Opp", "b": "Ball"}, (Replace("b.x", ("prev.o.x",), MOSTLY),), conflict="mixture")
    model = Model("m", (PRMClass("Ball", attributes), PRMClass("Opp", attributes)), (held,))
    grounding = Grounding(model, {"ball": "Ball", **{f"o{k}": "Opp" for k in range(4)}})
    bank, own = FilterBank(grounding, 1), Filter(grounding)
    for pair in ((0, 1), (2, 3), (1, 3), (3, 0)):
        bank.step({"o1.x": np.array([1])}, [Link("held", (Role("Opp", np.array([k])), "ball")) for k in pair])
        expected = own.step({"o1.x": 1}, [f"held(o{k},ball)" for k in pair])
        for name in ("ball.x", "o0.x", "o3.x"):
            np.testing.assert_allclose(bank.marginal(name), expected[name][0], atol=1e-14)


@pytest.mark.parametrize("policy", ["raise", "restart"])
def test_agents_begin_anew_where_an_aggregate_sums_up_the_slice_before(policy):
    """The first slice has no links of the aggregate's chain, and was refused."""
    moving = PRMClass("A", (Attribute("on", BOOL, MOSTLY, parents=("prev.on",), initial=(0.5, 0.5)),))
    watcher = PRMClass(
        "B", (Attribute("alarm", BOOL, SAME, parents=(Max("prev.as_.on"),)),), references=(Reference("as_", "A", many=True),)
    )
    grounding = Grounding(Model("m", (moving, watcher)), {"x0": "A", "x1": "A", "x2": "A", "y": "B"})
    filter_, own = Filter(grounding, 2, on_impossible=policy), [Filter(grounding), Filter(grounding)]
    bank = FilterBank(grounding, 2, on_impossible=policy)
    for t in range(6):
        if t in (2, 4):
            filter_.reset([1])
            bank.reset(np.array([False, True]))
            own[1].reset()
        evidence = {"x0.on": np.array([1, t % 2]), "x2.on": np.array([-1, 1])}
        seen = filter_.step(evidence)
        bank.step(evidence)
        for k, one in enumerate(own):
            expected = one.step({n: int(v[k]) for n, v in evidence.items()})
            for name in ("x1.on", "y.alarm"):
                np.testing.assert_allclose(seen[name][k], expected[name][0], atol=1e-14)
                np.testing.assert_allclose(bank.marginal(name, k), expected[name][0], atol=1e-14)
            assert seen.log_likelihood[k] == pytest.approx(expected.log_likelihood[0], abs=1e-13)


def chain():
    """Four copies of one flag."""
    names = ("x", "y", "z", "w")
    attributes = [Attribute("x", BOOL, (0.9, 0.1))]
    attributes += [Attribute(b, BOOL, SAME, parents=(a,)) for a, b in itertools.pairwise(names)]
    return Grounding(Model("m", (PRMClass("A", tuple(attributes)),)), {"a": "A"})


@pytest.mark.parametrize("policy", ["drop", "soften"])
def test_what_is_done_with_impossible_readings_does_not_depend_on_the_others(policy):
    """Alone P(x) was 0, beside an agent who saw nothing .1."""
    grounding = chain()
    one = Filter(grounding, on_impossible=policy).step({"a.x": 1, "a.z": 0, "a.w": 0})
    for other in ((-1, -1, -1), (0, 0, -1), (1, -1, 0), (0, 1, 1)):
        evidence = {n: np.array([mine, his]) for n, mine, his in zip(("a.x", "a.z", "a.w"), (1, 0, 0), other)}
        both = Filter(grounding, batch=2, on_impossible=policy).step(evidence)
        for name in one:
            np.testing.assert_allclose(both[name][0], one[name][0], atol=1e-12)


@pytest.mark.parametrize("policy", ["drop", "soften", "restart"])
@pytest.mark.parametrize("seed", range(12))
def test_in_random_worlds_impossible_readings_of_an_agent_are_answered_as_if_he_were_alone(policy, seed):
    rng = np.random.default_rng(seed)
    flags = [Attribute("v0", BOOL, (0.7, 0.3))]
    for k in range(1, 5):
        table = rng.choice([0.0, 0.5, 1.0], 2)
        rows = {s: (1.0 - p, p) for s, p in zip(("yes", "no"), table)}
        flags.append(Attribute(f"v{k}", BOOL, Table(rows), parents=(f"v{rng.integers(0, k)}",)))
    moving = Attribute("m", BOOL, Table({"yes": (0.0, 1.0), "no": (0.8, 0.2)}), parents=("prev.m",), initial=(0.5, 0.5))
    read = Attribute("r", BOOL, Table({("yes", "yes"): (0.0, 1.0), ("*", "*"): (0.6, 0.4)}), parents=("m", "v4"))
    grounding = Grounding(Model("m", (PRMClass("A", (*flags, moving, read)),)), {"a": "A"})
    together, alone = Filter(grounding, 4, on_impossible=policy), [Filter(grounding, on_impossible=policy) for _ in range(4)]
    for _ in range(4):
        names = [f"a.v{k}" for k in range(5)] + ["a.m", "a.r"]
        evidence = {n: np.where(rng.random(4) < 0.6, rng.integers(0, 2, 4), -1) for n in names}
        both = together.step(evidence)
        for k, one in enumerate(alone):
            expected = one.step({n: int(v[k]) for n, v in evidence.items()})
            for name in expected:
                np.testing.assert_allclose(both[name][k], expected[name][0], atol=1e-10)
    np.testing.assert_array_equal(together.impossible_count, [one.impossible_count[0] for one in alone])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: AnyCause("as_.on", strength="a"), "'a' is not a probability"),
        (lambda: AnyCause("as_.on", leak=None), "None is not a probability"),
        (lambda: Count("as_.on", at_most=1.5), "at_most must be 1 to 2048, got 1.5"),
        (lambda: Count("as_.on", at_most=True), "at_most must be 1 to 2048, got True"),
    ],
)
def test_parameters_of_aggregates_are_numbers(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def two_alike():
    """Two objects of one class, so that steps are made by form."""
    carries = Relation("carries", (("who", "Thing"), ("what", "Thing")))
    thing = PRMClass("Thing", (Attribute("x", BOOL, (0.5, 0.5)),))
    return Grounding(Model("m", (thing,), (carries,)), {"a": "Thing", "b": "Thing", "c": "Thing"})


@pytest.mark.parametrize("settled", [0, 100], ids=["by form", "in own names"])
def test_relations_and_evidence_that_are_none_are_refused_by_name_and_change_nothing(settled, monkeypatch):
    """None raised a TypeError of Python."""
    monkeypatch.setattr("cprm_gym.architecture.prm.inference.filter.SETTLED", settled)
    filter_ = Filter(two_alike(), 2)
    for relations in ((), ("carries(a,b)",)):
        filter_.step({"a.x": "yes"}, relations)
    for wrong in (None, 5, 1.5):
        with pytest.raises(ModelError, match=rf"relations: {wrong} given; .* \(\) for none"):
            filter_.step({}, wrong)
    for wrong in ([], (), 0, "", False):
        with pytest.raises(EvidenceError, match="evidence is a mapping"):
            filter_.step(wrong)
    with pytest.raises(ModelError, match="objects: 3 given"):
        filter_.step({}, (), objects=3)
    assert filter_.step_count == 2


def test_a_bank_refuses_them_too():
    bank = FilterBank(two_alike(), 2)
    for wrong in (None, 5):
        with pytest.raises(ModelError, match=f"relations: {wrong} given"):
            bank.step({}, wrong)
    for wrong in (None, [], 0):
        with pytest.raises(EvidenceError, match="evidence is a mapping"):
            bank.step(wrong)
