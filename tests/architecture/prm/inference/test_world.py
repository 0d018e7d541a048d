"""From a model to numbers: worlds that are tracked while objects and relations come and go."""

from __future__ import annotations

import hypothesis
import numpy as np
import pytest
from ball_world import scene, soccer
from cases import filter_slices, load
from flat import joint, marginal
from hypothesis import strategies as st

from cprm_gym.architecture.prm import (
    BOOL,
    Attribute,
    Bins,
    DeepFilter,
    Dense,
    Exists,
    Filter,
    Given,
    Grounding,
    Index,
    Labels,
    Model,
    Noise,
    PRMClass,
    Reference,
    Relation,
    Replace,
    Table,
    Uniform,
    prev,
    unroll,
)
from cprm_gym.errors import EvidenceError, ImpossibleEvidence, ModelError, ParameterError

OBJECTS = {"ball": "Ball", "o1": "Opponent", "o2": "Opponent"}


def small(conflict="exclusive", bins=3):
    return Grounding(soccer(bins, conflict), OBJECTS)


MIXED = small("mixture", 2)
SCRIPT = [
    ({"ball.seen": 1, "ball.obs_dist": Index(2), "o1.seen": 0, "ball.turn": Index(1)}, (), None),
    ({"o1.seen": 1, "o1.obs_dist": Index(1)}, ("attended(o1)",), None),
    ({"ball.seen": 0, "o1.obs_dist": Index(1), "o1.turn": Index(4)}, ("attended(o1)", "possesses(o1,ball)"), None),
    ({"ball.obs_dist": Index(1), "ball.seen": 1}, ("attended(o1)",), ("ball", "o1")),
    ({"o2.obs_dist": Index(0), "o2.seen": 1}, ("attended(o2)",), None),
]


def unrolled(world, script):
    """The whole run as one static net, with its evidence."""
    slices, evidence, before = [], {}, None
    for t, (given, relations, objects) in enumerate(script):
        before = world.situation(relations, objects, before)
        ground = world.ground(before, first=t == 0)
        slices.append(ground)
        told = {**{n: Index(k) for n, k in world.defaults(ground).items()}, **given}
        evidence.update({f"{n}#{t}": ground.variables[n].index(k) for n, k in told.items()})
    return unroll(slices), evidence


@pytest.mark.parametrize("conflict", ["exclusive", "mixture"])
def test_tracking_equals_enumeration_of_the_unrolled_net(conflict):
    """Attention, possession, an object that leaves and comes back: exact at every step."""
    world = small(conflict)
    tracker = Filter(world)
    for t, (given, relations, objects) in enumerate(SCRIPT):
        seen = tracker.step(given, relations, objects=objects)
        net, evidence = unrolled(world, SCRIPT[: t + 1])
        wanted = ["ball.dist", "o1.dist"] + (["possesses(o1,ball).shoot"] if "possesses(o1,ball)" in relations else [])
        for name in wanted:
            assert np.abs(seen[name][0] - marginal(net, f"{name}#{t}", evidence)).max() < 1e-12
        assert seen.log_likelihood[0] == pytest.approx(np.log(joint(net, evidence, ()).item()), abs=1e-10)
    assert seen.exact


@hypothesis.settings(max_examples=12)
@hypothesis.given(st.data())
def test_tracking_any_sequence_of_relations_objects_and_readings_equals_enumeration(data):
    """Whatever is switched on and off, whoever comes and goes: the belief is that of the unrolled net."""
    world = MIXED
    tracker, script = Filter(world), []
    for t in range(4):
        objects = ["ball", *data.draw(st.sets(st.sampled_from(["o1", "o2"])), label="there")]
        active = [f"attended({o})" for o in objects[1:] if data.draw(st.booleans(), label="attended")]
        active += [f"possesses({o},ball)" for o in objects[1:] if data.draw(st.booleans(), label="possesses")]
        given_ = {
            f"{o}.{a}": Index(data.draw(st.integers(0, 1))) for o in objects for a in ("obs_dist", "seen") if data.draw(st.booleans())
        }
        script.append((given_, tuple(active), tuple(objects)))
        seen = tracker.step(given_, active, objects=objects)
        net, evidence = unrolled(world, script)
        for name in ("ball.dist", *(f"{o}.dist" for o in objects[1:])):
            assert np.abs(seen[name][0] - marginal(net, f"{name}#{t}", evidence)).max() < 1e-11
        assert seen.log_likelihood[0] == pytest.approx(np.log(joint(net, evidence, ()).item()), abs=1e-10)


def test_a_mixture_of_two_possessors_is_tracked_exactly_with_its_selector():
    world = small("mixture", 2)
    script = [({}, (), None), ({"ball.obs_dist": Index(1), "ball.seen": 1}, ("possesses(o1,ball)", "possesses(o2,ball)"), None)]
    tracker = Filter(world)
    for given, relations, objects in script:
        seen = tracker.step(given, relations, objects=objects)
    net, evidence = unrolled(world, script)
    assert np.abs(seen["ball.selector"][0] - marginal(net, "ball.selector#1", evidence)).max() < 1e-12


def test_ten_lines_from_model_to_numbers():
    dist, speed = Bins.linear(0, 40, 20, "m", clip=True), Bins.linear(-3, 3, 13)
    ball = PRMClass("Ball", given=(Given("dash", Bins.linear(-1, 1, 5), default=0.0),), attributes=(
        Attribute("speed", speed, Noise("0.94 * prev.speed", 0.2), parents=(prev("speed"),), initial=Noise("0", 1.0)),
        Attribute("dist", dist, Noise("prev.dist + prev.speed - dash", 0.3), ("prev.dist", "prev.speed", "dash"), Uniform()),
        Attribute("seen_dist", dist, Noise("dist", "0.2 + 0.03 * dist"), parents=("dist",))))  # fmt: skip
    tracker = Filter(Grounding(Model("one ball", (ball,)), {"ball": "Ball"}), engine="exact", batch=3)
    rng = np.random.default_rng(1)
    truth = np.array([24.0, 27.0, 30.0])
    for _ in range(25):
        truth = truth - 0.7
        seen = tracker.step({"ball.seen_dist": truth + rng.normal(size=3) * (0.2 + 0.03 * truth)})
    assert np.abs(seen.read("ball.dist") - truth).max() < 2.0
    assert np.abs(seen.read("ball.speed") + 0.7).max() < 0.4
    assert np.all(seen.read("ball.dist", "probability(..20)") > 0.95)
    ahead = tracker.predict(4)
    assert np.abs(ahead.read("ball.dist") - (truth - 2.8)).max() < 2.5
    assert np.all(ahead.read("ball.dist", "deviation") > seen.read("ball.dist", "deviation"))


def test_own_motion_is_not_taken_for_motion_of_the_ball():
    """d15's lesson: the turn is given, so turning by half a radian moves the belief by that, with no more doubt."""
    world = Grounding(soccer(24), {"ball": "Ball"})
    still, turned = Filter(world), Filter(world)
    for tracker, turn in ((still, 0.0), (turned, 0.5)):
        tracker.step({"ball.seen": "yes", "ball.obs_dir": 0.1, "ball.turn": 0.0})
        seen = tracker.step({"ball.turn": turn})
        shift = seen.read("ball.dir")[0]
        if turn == 0.0:
            start = shift
    assert shift - start == pytest.approx(-0.4, abs=0.01)


def test_reading_a_belief_through_a_view():
    tracker = Filter(small(bins=6), batch=2)
    seen = tracker.step({"ball.seen": "yes", "ball.obs_dist": np.array([3.0, 22.0])})
    values = seen.read_all({"near": ("ball.dist", "probability(..10)"), "d": ("ball.dist", "expectation")})
    assert values["near"][0] > 0.9 > 0.1 > values["near"][1]
    assert values["d"].shape == (2,)
    with pytest.raises(ModelError, match=r"no variable 'ball.dits' in this slice. Did you mean 'ball.dist'"):
        seen.read("ball.dits")
    with pytest.raises(ModelError, match="unknown view 'expect'"):
        seen.read("ball.dist", "expect")


def test_a_place_of_a_net_is_given_and_has_no_part_in_the_likelihood():
    """d10: places select the motion; the recorded likelihood counts their root priors, ours leaves them out."""
    case = load("d10")
    slices = filter_slices(case)
    pos = Labels(tuple("0123"))
    token, marked = Labels(("0", "1", "2")), BOOL
    step = slices["step"]
    thing = PRMClass(
        "Thing",
        (
            Attribute("pos", pos, Dense(step.by_child["pos"].table), parents=("prev.pos", "pl", "tok"),
                      initial=Dense(slices["prior"].by_child["pos"].table)),
            Attribute("obs", pos, Dense(step.by_child["obs"].table), parents=("pos",)),
        ),
        given=(Given("pl", marked), Given("tok", token)),
    )  # fmt: skip
    tracker = Filter(Grounding(Model("places", (thing,)), {"x": "Thing"}))
    priors = 0.0
    for recorded in case["steps"]:
        given = recorded["evidence"]
        seen = tracker.step({f"x.{n}": k for n, k in given.items()})
        if "pos" in recorded["posterior"]:
            assert np.abs(seen["x.pos"][0] - recorded["posterior"]["pos"]).max() < 1e-9
        priors += sum(float(np.log(step.by_child[n].table[given[n]])) for n in ("pl", "tok"))
        assert seen.log_likelihood[0] == pytest.approx(recorded["log_evidence"] - priors, abs=1e-9)


def test_an_object_that_returns_is_a_new_one():
    world = small(bins=6)
    tracker = Filter(world)
    for _ in range(4):
        near = tracker.step({"o1.seen": "yes", "o1.obs_dist": 2.0}, ["attended(o1)"])
    assert near.read("o1.dist")[0] < 6.0
    gone = tracker.step({}, objects=["ball", "o2"])
    assert "o1.dist" not in gone.variables
    back = tracker.step({}, ["attended(o1)"])
    assert back.relations.entering == ("o1", "attended(o1)")
    assert np.allclose(back["o1.dist"][0], 1 / 6)


def test_an_aggregate_over_the_previous_slice_is_tracked_exactly():
    """Alarm spreads: each one is afraid when somebody was, a step before; newcomers did not exist then."""
    spread = Table({"yes": (0.3, 0.7), "no": (0.9, 0.1)})
    fish = PRMClass("Fish", references=(Reference("others", "Fish", many=True),), attributes=(
        Attribute("afraid", BOOL, spread, parents=(Exists("prev.others.afraid"),), initial=(0.8, 0.2)),
        Attribute("flees", BOOL, Table({"yes": (0.1, 0.9), "no": (0.95, 0.05)}), parents=("afraid",))))  # fmt: skip
    world = Grounding(Model("shoal", (fish,)), {"a": "Fish", "b": "Fish", "c": "Fish"})
    script = [
        ({"a.flees": 1}, (), ("a", "b")),
        ({"b.flees": 0}, (), ("a", "b", "c")),
        ({"c.flees": 1}, (), ("a", "b", "c")),
        ({}, (), ("b", "c")),
    ]
    tracker = Filter(world)
    for t, (given, relations, objects) in enumerate(script):
        seen = tracker.step(given, relations, objects=objects)
        net, evidence = unrolled(world, script[: t + 1])
        for o in objects:
            assert np.abs(seen[f"{o}.afraid"][0] - marginal(net, f"{o}.afraid#{t}", evidence)).max() < 1e-12


def test_a_static_attribute_is_remembered_through_every_slice():
    skill = Attribute("good", BOOL, (0.5, 0.5), static=True)
    shot = Attribute("hit", BOOL, Table({"yes": (0.2, 0.8), "no": (0.7, 0.3)}), parents=("good",))
    tracker = Filter(Grounding(Model("m", (PRMClass("Player", (skill, shot)),)), {"p": "Player"}))
    hits = [1, 1, 0, 1]
    for h in hits:
        seen = tracker.step({"p.hit": h})
    odds = np.prod([(0.8 / 0.3) if h else (0.2 / 0.7) for h in hits])
    assert seen["p.good"][0, 1] == pytest.approx(odds / (1 + odds))


def test_prediction_leaves_the_tracker_where_it_is():
    tracker = Filter(small())
    tracker.step({"ball.seen": 1, "ball.obs_dist": Index(2)})
    before = tracker.step({}, ["attended(o1)"])["ball.dist"].copy()
    tracker.predict(3, relations=["possesses(o1,ball)"], given={"ball.turn": Index(1)})
    assert tracker.step_count == 2
    assert tracker.state.relations.relations == ("attended(o1)",)
    again = Filter(small())
    again.step({"ball.seen": 1, "ball.obs_dist": Index(2)})
    again.step({}, ["attended(o1)"])
    assert np.array_equal(tracker.step({})["ball.dist"], again.step({})["ball.dist"])
    assert not np.array_equal(before, tracker.step({})["ball.dist"])


def test_wrong_evidence_leaves_the_belief_as_it_was():
    tracker = Filter(small())
    tracker.step({"ball.seen": 1, "ball.obs_dist": Index(2)})
    for wrong, message in (
        ({"ball.obs_dist": 99.0}, "evidence for 'ball.obs_dist': 99.0"),
        ({"ball.obs_dist": float("inf")}, "'ball.obs_dist': inf is not a finite number"),
        ([1], "evidence is a mapping"),
        ({"ball.obs_dits": 1}, "unknown variable 'ball.obs_dits'. Did you mean 'ball.obs_dist'"),
    ):
        with pytest.raises(EvidenceError, match=message):
            tracker.step(wrong, ["attended(o1)"])
    assert tracker.step_count == 1
    assert tracker.state.relations.relations == ()


def test_impossible_evidence_is_counted_or_raised():
    sure = PRMClass("C", (Attribute("x", BOOL, Table({"yes": (0.0, 1.0), "no": (1.0, 0.0)}), parents=("prev.x",), initial=Uniform()),))
    world = Grounding(Model("m", (sure,)), {"c": "C"})
    strict, lenient = Filter(world), Filter(world, on_impossible="restart")
    for tracker in (strict, lenient):
        tracker.step({"c.x": 1})
    with pytest.raises(ImpossibleEvidence, match=r"c\.x"):
        strict.step({"c.x": 0})
    assert strict.step({"c.x": 1}).exact
    lenient.step({"c.x": 0})
    assert lenient.impossible_count.tolist() == [1]


def test_the_filter_alone_takes_a_grounding_and_active_relations():
    world = scene(3, 2)
    plain, tracked = Filter(world), Filter(small())
    turns = {f"{o}.turn": 2 for o in OBJECTS}
    for given, relations, _ in SCRIPT[:2]:
        a = plain.step({**turns, **given}, relations=relations)
        b = tracked.step(given, relations)
    assert np.array_equal(a["ball.dist"], b["ball.dist"])


def test_cost_and_slice_are_known():
    tracker = Filter(small())
    seen = tracker.step({})
    assert seen.variables["ball.dist"].card == 3
    assert seen.slice.by_child["ball.dist"].child == "ball.dist"
    with pytest.raises(ModelError, match=r"Did you mean 'ball.dist'"):
        seen["ball.dst"]
    pair = {"ball.dist", "o1.dist"}
    seen = {"ball.obs_dist": Index(1)}
    linked = tracker.cost(["attended(o1)", "possesses(o1,ball)"], evidence=seen)
    assert any(pair <= set(c.variables) for c in linked)
    assert not any(pair <= set(c.variables) for c in tracker.cost(evidence=seen))


def entangled():
    """Two coins that were linked for a while: a projecting filter loses what the exact one keeps."""
    coin = PRMClass("Coin", (Attribute("x", BOOL, Table({"yes": (0.1, 0.9), "no": (0.9, 0.1)}), parents=("prev.x",), initial=Uniform()),
                             Attribute("o", BOOL, Table({"yes": (0.2, 0.8), "no": (0.8, 0.2)}), parents=("x",))))  # fmt: skip
    same = Relation("follows", {"a": "Coin", "b": "Coin"}, (
        Replace("a.x", ("b.x",), Table({"yes": (0.05, 0.95), "no": (0.95, 0.05)})),))  # fmt: skip
    return Grounding(Model("coins", (coin,), (same,)), {"a": "Coin", "b": "Coin"})


def run(tracker, steps, rng_seed=4):
    rng = np.random.default_rng(rng_seed)
    for t in range(steps):
        given = {"b.o": int(rng.integers(2))} if rng.random() < 0.7 else {"a.o": int(rng.integers(2))}
        seen = tracker.step(given, ["follows(a,b)"] if t % 5 in (1, 2) else [])
    return seen


def test_deep_inference_on_demand_restores_the_exact_belief():
    exact = run(Filter(entangled()), 14)
    clusters = [("a.x",), ("b.x",)]
    shallow = Filter(entangled(), engine="projection", clusters=clusters)
    assert np.abs(run(shallow, 14).joint("a.x", "b.x") - exact.joint("a.x", "b.x")).max() > 1e-3
    both = DeepFilter(entangled(), engine="projection", clusters=clusters, deep="exact")
    assert not run(both, 14).exact
    deep = both.deepen()
    assert np.abs(deep.joint("a.x", "b.x") - exact.joint("a.x", "b.x")).max() < 1e-12
    assert deep.exact
    assert deep.log_likelihood[0] == pytest.approx(exact.log_likelihood[0])
    with pytest.raises(ParameterError, match="nothing to infer deeply"):
        both.deepen()
    assert not both.step({"b.o": 1}).loss[0] < 0.0


def test_deep_inference_comes_by_itself_every_so_many_steps():
    exact = run(Filter(entangled()), 12)
    both = run(DeepFilter(entangled(), engine="projection", clusters=[("a.x",), ("b.x",)], deep="exact", every=4), 12)
    assert np.abs(both.joint("a.x", "b.x") - exact.joint("a.x", "b.x")).max() < 1e-12


def test_deep_inference_remembers_which_agents_began_anew():
    both = DeepFilter(entangled(), engine="projection", batch=2, deep="exact")
    plain = Filter(entangled(), engine="exact", batch=2)
    for tracker in (both, plain):
        run(tracker, 6)
        tracker.reset([1])
        run(tracker, 3, 9)
    assert np.abs(both.deepen()["a.x"] - plain.step({})["a.x"]).max() < 1.0
    wanted = Filter(entangled(), engine="exact", batch=2)
    run(wanted, 6)
    wanted.reset([1])
    assert np.abs(both.log_likelihood - run(wanted, 3, 9).log_likelihood).max() < 1e-10


def test_particles_cannot_be_deepened():
    with pytest.raises(ParameterError, match="engine 'particles' cannot go on from a belief of factors"):
        DeepFilter(entangled(), engine="particles", deep="exact", seed=1)
    with pytest.raises(ParameterError, match="at least 1"):
        DeepFilter(entangled(), engine="projection", deep="exact", every=0)


@pytest.mark.parametrize("engine", ["exact", "projection", "particles", "anytime"])
def test_every_engine_tracks_the_same_world(engine):
    options = {"seed": 3} if engine in ("particles", "anytime") else {}
    exact, other = Filter(small(bins=6)), Filter(small(bins=6), engine=engine, **options)
    for given, relations, objects in SCRIPT:
        a, b = exact.step(given, relations, objects=objects), other.step(given, relations, objects=objects)
    tolerance = 5.0 if engine == "particles" else 1e-9
    assert abs(a.read("ball.dist") - b.read("ball.dist"))[0] <= tolerance
