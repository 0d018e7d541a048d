"""Objects and active relations become a flat net."""

from __future__ import annotations

import numpy as np
import pytest
from ball_world import scene, soccer
from cases import filter_slices, load
from flat import joint, marginal
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.architecture.prm.grounding.grounding import GroundCPD, Grounding, GroundSlice, GroundVariable, unroll
from cprm_gym.architecture.prm.inference.bayes_net import BayesNet
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.architecture.prm.inference.filter_bank import FilterBank
from cprm_gym.architecture.prm.inference.learning import count
from cprm_gym.architecture.prm.inference.links import Link
from cprm_gym.architecture.prm.model.aggregates import All, AnyCause, Count, Exists, Max, Mean, Min
from cprm_gym.architecture.prm.model.cpds import Dense, Mixture, NoisyOr, Prior, Switch, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Add, Attribute, Given, PRMClass, Reference, Relation, Replace
from cprm_gym.errors import EvidenceError, ModelError, ParameterError

FLIP = Table({"yes": (0.2, 0.8), "no": (0.7, 0.3)})


def test_one_variable_for_every_object_and_attribute():
    ground = scene(opponents=2).ground()
    assert len(ground.variables) == 3 * 8 + 2
    assert ground.by_child["ball.dist"].parents == (("ball.dist", 1), ("ball.vdist", 1))
    assert ground.by_child["o1.dist"].parents == ()
    assert ground.given == ("ball.turn", "o1.turn", "o2.turn")


def test_objects_of_a_class_share_the_table_and_its_key():
    ground = scene(opponents=2).ground()
    first, second = ground.by_child["o1.obs_dist"], ground.by_child["o2.obs_dist"]
    assert first.table is second.table
    assert first.key == second.key == ("class", "Thing", "obs_dist", "cpd")


def test_the_first_slice_has_no_previous_parents():
    ground = scene().ground(["attended(o1)"], first=True)
    assert all(lag == 0 for cpd in ground.cpds for _, lag in cpd.parents)


def test_an_active_relation_replaces_the_parents_of_its_objects_only():
    ground = scene().ground(["attended(o1)"])
    assert ground.by_child["o1.dist"].parents == (("o1.dist", 1), ("o1.vdist", 1))
    assert ground.by_child["o2.dist"].parents == ()


def test_a_relation_brings_its_own_hidden_variable():
    ground = scene().ground([("possesses", "o2", "ball")])
    assert ground.by_child["possesses(o2,ball).shoot"].parents == (("o2.dist", 0), ("o2.orient", 0))
    assert ground.by_child["ball.dist"].parents == (("o2.dist", 0), ("possesses(o2,ball).shoot", 0))
    assert ground.clusters == (("ball.dist", "ball.vdist", "o2.dist", "o2.vdist"),)
    assert ground.relations == ("possesses(o2,ball)",)


def test_the_order_of_active_relations_does_not_matter_and_slices_are_remembered():
    world = scene()
    first = world.ground(["attended(o1)", "possesses(o2, ball)"])
    assert world.ground([("possesses", "o2", "ball"), ("attended", "o1")]) is first
    assert world.ground(["attended(o1)", "possesses(o2, ball)"]) is first


def test_remembered_slices_are_bounded():
    world = scene(opponents=1)
    for k in range(1200):
        world.ground(["attended(o1)"] * (k + 1))
    assert len(world._slices) <= 1024


def test_an_entering_object_starts_from_its_prior():
    ground = scene().ground(["attended(o1)", "attended(o2)"], entering=["o2"])
    assert ground.by_child["o1.vdist"].parents == (("o1.vdist", 1),)
    assert ground.by_child["o2.vdist"].parents == ()


def test_an_object_that_left_has_no_variables():
    ground = scene(opponents=3).ground(objects=["ball", "o2"])
    assert {v.object_name for v in ground.variables.values()} == {"ball", "o2"}
    with pytest.raises(ModelError, match=r"possesses\(o1,ball\) is active, but 'o1' does not exist"):
        scene(opponents=3).ground(["possesses(o1,ball)"], objects=["ball", "o2"])


@pytest.mark.parametrize(
    ("relations", "message"),
    [
        (["posesses(o1,ball)"], "unknown relation 'posesses'. Did you mean 'possesses'"),
        (["possesses(o1)"], r"possesses\(o1\) has 1 objects for the roles o, b"),
        (["possesses(ball,o1)"], "role 'o' takes a Opponent, got 'ball'"),
        (["possesses(o9,ball)"], "got 'o9'. Known: o1, o2"),
    ],
)
def test_a_wrong_active_relation_is_refused_by_name(relations, message):
    with pytest.raises(ModelError, match=message):
        scene().ground(relations)


@pytest.mark.parametrize(
    ("objects", "references", "message"),
    [
        ({"ball": "Bal"}, None, "unknown class 'Bal'. Did you mean 'Ball'"),
        ({"x": "Thing"}, None, "class 'Thing' is abstract"),
        ({"a.b": "Ball"}, None, "must not be empty or hold"),
        ({"ball": "Ball"}, {"bal": {}}, "unknown object 'bal'. Did you mean 'ball'"),
        ({"ball": "Ball"}, {"ball": {"x": "ball"}}, "has no such reference"),
    ],
)
def test_a_wrong_world_is_refused_by_name(objects, references, message):
    with pytest.raises(ModelError, match=message):
        Grounding(soccer(4), objects, references)


def test_two_tuples_that_change_one_variable_conflict_unless_a_rule_decides():
    with pytest.raises(ModelError, match=r"possesses\(o1,ball\) and possesses\(o2,ball\) all change 'ball.dist'"):
        scene().ground(["possesses(o1,ball)", "possesses(o2,ball)"])


def conflicting(conflict, domain=BOOL):
    child = Attribute("x", domain, (0.9, 0.1))
    first = Relation("r", {"p": "P", "b": "B"}, (Replace("b.x", ("p.y",), FLIP),), conflict=conflict)
    second = Relation("s", {"b": "B"}, (Replace("b.x", (), Prior((0.1, 0.9))),), conflict=conflict, priority=1)
    model = Model("m", (PRMClass("B", (child,)), PRMClass("P", (Attribute("y", BOOL, (0.5, 0.5)),))), (first, second))
    return Grounding(model, {"b": "B", "p": "P", "q": "P"})


def test_mean_of_two_tuples_is_the_mean_of_their_tables():
    cpd = conflicting("mean").ground(["r(p,b)", "r(q,b)"]).by_child["b.x"]
    table = np.array([[0.7, 0.3], [0.2, 0.8]])
    assert cpd.parents == (("p.y", 0), ("q.y", 0))
    assert np.allclose(cpd.table, (table[:, None] + table[None, :]) / 2)


def test_noisy_or_of_two_tuples_multiplies_their_failures():
    cpd = conflicting("noisy-or").ground(["r(p,b)", "r(q,b)"]).by_child["b.x"]
    none = np.array([0.7, 0.2])
    assert np.allclose(cpd.table[..., 0], none[:, None] * none[None, :])


def test_mixture_of_two_tuples_has_a_hidden_selector_and_the_same_marginal_as_their_mean():
    ground = conflicting("mixture").ground(["r(p,b)", "r(q,b)"])
    assert ground.variables["b.selector"].states == ("r(p,b)", "r(q,b)")
    assert ground.by_child["b.x"].parents == (("b.selector", 0), ("p.y", 0), ("q.y", 0))
    mean = conflicting("mean").ground(["r(p,b)", "r(q,b)"])
    assert np.allclose(marginal(ground, "b.x"), marginal(mean, "b.x"))


def test_all_changes_to_an_object_share_one_selector():
    """Who has the ball decides about its place and its speed together."""
    ball = PRMClass("Ball", (Attribute("x", BOOL), Attribute("v", BOOL)))
    has = Relation("has", {"p": "P", "b": "Ball"}, (Replace("b.x", ("p.y",), FLIP), Replace("b.v", ("p.y",), FLIP)), conflict="mixture")
    world = Grounding(Model("m", (ball, PRMClass("P", (Attribute("y", BOOL),))), (has,)), {"b": "Ball", "p": "P", "q": "P"})
    ground = world.ground(["has(p,b)", "has(q,b)"])
    assert [v for v in ground.variables if "selector" in v] == ["b.selector"]
    assert ground.by_child["b.x"].parents[0] == ground.by_child["b.v"].parents[0] == ("b.selector", 0)


def test_added_parents_come_after_the_own_ones():
    ball = PRMClass("Ball", (Attribute("x", BOOL), Attribute("y", BOOL, FLIP, parents=("x",))))
    cpd = Table({("*", "yes"): (0.1, 0.9), ("*", "*"): (0.8, 0.2)})
    near = Relation("near", {"p": "Ball", "q": "Ball"}, (Add("p.y", ("prev.q.y",), cpd),))
    world = Grounding(Model("m", (ball,), (near,)), {"a": "Ball", "b": "Ball"})
    assert world.ground(["near(a,b)"]).by_child["a.y"].parents == (("a.x", 0), ("b.y", 1))
    assert world.ground(["near(a,b)"], entering=["b"]).by_child["a.y"].parents == (("a.x", 0),)


def test_higher_priority_wins():
    cpd = conflicting("exclusive").ground(["r(p,b)", "s(b)"]).by_child["b.x"]
    assert cpd.key == ("relation", "s", "b.x", "cpd")


def test_a_parent_reached_twice_is_one_axis():
    xor = Table({("yes", "no"): (0.0, 1.0), ("no", "yes"): (0.0, 1.0), ("*", "*"): (1.0, 0.0)})
    model = Model(
        "m",
        (PRMClass("A", (Attribute("x", BOOL),)), PRMClass("B", (Attribute("z", BOOL),))),
        (Relation("r", {"p": "A", "q": "A", "b": "B"}, (Replace("b.z", ("p.x", "q.x"), xor),)),),
    )
    world = Grounding(model, {"a": "A", "b": "B"})
    cpd = world.ground(["r(a,a,b)"]).by_child["b.z"]
    assert cpd.parents == (("a.x", 0),)
    assert cpd.table.tolist() == [[1.0, 0.0], [1.0, 0.0]]


def test_a_cycle_between_objects_is_refused_when_it_becomes_active():
    model = Model(
        "m",
        (PRMClass("A", (Attribute("x", BOOL),)),),
        (Relation("r", {"p": "A", "q": "A"}, (Replace("p.x", ("q.x",), FLIP),)),),
    )
    assert not model.acyclic
    world = Grounding(model, {"a": "A", "b": "A"})
    world.ground(["r(a,b)"])
    with pytest.raises(ModelError, match=r"with r\(a,b\), r\(b,a\): .*cycle: a.x -> b.x -> a.x"):
        world.ground(["r(a,b)", "r(b,a)"])


def test_references_follow_the_given_objects_and_default_to_the_only_one():
    ball = PRMClass("Ball", (Attribute("x", BOOL),))
    player = PRMClass("Player", (Attribute("near", BOOL, FLIP, parents=("ball.x",)),), (Reference("ball", "Ball"),))
    model = Model("m", (ball, player))
    assert Grounding(model, {"b": "Ball", "p": "Player"}).ground().by_child["p.near"].parents == (("b.x", 0),)
    two = {"b": "Ball", "c": "Ball", "p": "Player"}
    assert Grounding(model, two, {"p": {"ball": "c"}}).ground().by_child["p.near"].parents == (("c.x", 0),)
    with pytest.raises(ModelError, match="object 'p', reference 'ball': several could be meant: b, c"):
        Grounding(model, two).ground()


def test_a_static_attribute_is_drawn_when_its_object_enters_and_read_ever_after():
    model = Model(
        "m", (PRMClass("A", (Attribute("skill", BOOL, (0.3, 0.7), static=True), Attribute("x", BOOL, FLIP, parents=("skill",)))),)
    )
    world = Grounding(model, {"a": "A"})
    assert world.ground(first=True).by_child["a.x"].parents == (("a.skill", 0),)
    later = world.ground()
    assert "a.skill" not in later.variables
    assert later.by_child["a.x"].parents == (("a.skill", -1),)


def test_a_relation_attribute_with_a_previous_value_starts_from_its_initial_cpd():
    model = Model(
        "m",
        (PRMClass("A", (Attribute("x", BOOL),)),),
        (Relation("r", {"a": "A"}, attributes=(Attribute("will", BOOL, FLIP, parents=("prev.will",), initial=Prior((0.9, 0.1))),)),),
    )
    world = Grounding(model, {"a": "A"})
    assert world.ground(["r(a)"], entering=["r(a)"]).by_child["r(a).will"].table.tolist() == [0.9, 0.1]
    assert world.ground(["r(a)"]).by_child["r(a).will"].parents == (("r(a).will", 1),)


def crowd(aggregate, count, states=BOOL, child=None):
    """One judge with an aggregate over `count` players, and the joint of its net."""
    size = len(aggregate.domain(states, "x"))
    judge = PRMClass(
        "Judge",
        (Attribute("says", Labels(tuple(f"s{k}" for k in range(size))), Dense(np.eye(size)), parents=(aggregate,)),),
        (Reference("players", "Player", many=True),),
    )
    weights = np.arange(1, len(states) + 1) / np.arange(1, len(states) + 1).sum()
    player = PRMClass("Player", (Attribute("x", states, tuple(weights)),))
    model = Model("m", (judge, player))
    return Grounding(model, {"judge": "Judge", **{f"p{k}": "Player" for k in range(count)}}).ground(), weights


LEVELS = Labels(("low", "mid", "high"))


@pytest.mark.parametrize("count", [0, 1, 2, 4])
@pytest.mark.parametrize(
    ("aggregate", "states", "function"),
    [
        (Exists("players.x"), BOOL, lambda xs: int(any(xs))),
        (All("players.x"), BOOL, lambda xs: int(all(xs))),
        (Count("players.x", "yes", 2), BOOL, lambda xs: min(sum(xs), 2)),
        (Min("players.x"), LEVELS, lambda xs: min(xs, default=2)),
        (Max("players.x"), LEVELS, lambda xs: max(xs, default=0)),
        (Mean("players.x", "mid"), LEVELS, lambda xs: int(np.floor(sum(xs) / len(xs) + 0.5)) if xs else 1),
        (
            Mean("players.x", "1..4"),
            Bins((0.0, 1.0, 4.0, 6.0)),
            lambda xs: np.searchsorted((1.0, 4.0), np.mean([(0.5, 2.5, 5.0)[x] for x in xs]), side="right") if xs else 1,
        ),
    ],
)
def test_an_aggregate_equals_the_function_of_all_states(aggregate, states, function, count):
    ground, weights = crowd(aggregate, count, states)
    wanted = np.zeros(len(ground.variables["judge.says"].states))
    for index in np.ndindex(*(len(states),) * count):
        wanted[function(list(index))] += np.prod(weights[list(index)])
    assert np.allclose(marginal(ground, "judge.says"), wanted, atol=1e-14)


def test_any_cause_is_noisy_or():
    ground, _ = crowd(AnyCause("players.x", "yes", strength=0.4, leak=0.1), 3)
    p = 2 / 3
    assert marginal(ground, "judge.says")[0] == pytest.approx(0.9 * (1 - 0.4 * p) ** 3)


def test_an_aggregate_over_many_objects_is_a_chain_of_small_tables():
    ground, _ = crowd(Count("players.x", "yes", 3), 40)
    assert max(cpd.table.size for cpd in ground.cpds) <= 4 * 2 * 4
    assert "judge.count(players.x=yes, at_most=3)#12" in ground.variables


def test_what_is_given_has_no_cpd_and_takes_its_default():
    world = scene(opponents=1)
    ground = world.ground()
    assert "ball.turn" not in ground.by_child
    assert world.defaults(ground) == {"o1.turn": 2, "ball.turn": 2}
    needy = PRMClass("C", (Attribute("x", BOOL),), given=(Given("act", BOOL),))
    world = Grounding(Model("m", (needy,)), {"c": "C"})
    with pytest.raises(EvidenceError, match=r"'c.act' must be given for every agent in every slice: it has no default"):
        Filter(world).step({})


def test_a_situation_says_what_is_new():
    world = scene(opponents=2)
    first = world.situation(["attended(o1)"], ["ball", "o1"])
    then = world.situation(["attended(o1)", "attended(o2)"], None, first)
    assert then.entering == ("o2", "attended(o2)")
    assert world.situation(["attended(o2)", "attended(o1)"], None, then).entering == ()
    assert world.ground(then).by_child["o2.dist"].parents == ()


def test_evidence_for_a_ground_variable_is_refused_by_its_name():
    ground = scene().ground()
    assert ground.variables["ball.dist"].index(12.0) == 2
    assert ground.variables["ball.seen"].index("yes") == 1
    with pytest.raises(EvidenceError, match=r"evidence for 'ball.dist': nan is not a finite number"):
        ground.variables["ball.dist"].index(float("nan"))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: slice_(cpd("a", (), [0.5, 0.6])), r"CPD of 'a': row \(\) sums to 1.1"),
        (lambda: slice_(cpd("a", (), [0.5, 0.5]), cpd("a", (), [0.5, 0.5])), "'a' has two CPDs"),
        (lambda: slice_(cpd("a", (("b", 0),), [[0.5, 0.5]] * 2)), "unknown parent 'b'"),
        (lambda: slice_(cpd("a", (("a", 0),), [[0.5, 0.5]] * 2)), "cycle: a -> a"),
        (lambda: slice_(cpd("a", (), [0.2, 0.3, 0.5])), "3 probabilities for 2 states"),
        (lambda: slice_(cpd("a", (("a", 2),), [[0.5, 0.5]] * 2)), "lag of parent 'a' is 2"),
        (lambda: GroundSlice({"a": GroundVariable("a", ("x", "y"))}, ()), "'a' has no CPD and is not given"),
    ],
)
def test_a_slice_that_is_no_net_is_refused(build, message):
    with pytest.raises(ModelError, match=message):
        build()


def cpd(child, parents, table):
    return GroundCPD(child, parents, np.array(table), child)


def slice_(*cpds):
    return GroundSlice({c.child: GroundVariable(c.child, ("x", "y")) for c in cpds}, cpds)


def test_an_unrolled_case_has_the_recorded_likelihood():
    """The unrolled net of d07 (a relation switched on and off) summed over everything gives the recorded evidence."""
    case = load("d07")
    slices = filter_slices(case)
    steps = case["steps"][:6]
    net = unroll([slices[name] for name in case["schedule"][: len(steps)]])
    evidence = {f"{v}#{t}": x for t, step in enumerate(steps) for v, x in step["evidence"].items()}
    assert np.log(joint(net, evidence, ()).item()) == pytest.approx(steps[-1]["log_evidence"], abs=1e-9)


@given(st.integers(0, 3), st.booleans())
def test_grounding_any_set_of_attended_opponents_gives_a_valid_net(bits, possessed):
    active = [f"attended(o{k})" for k in (1, 2) if bits & k] + (["possesses(o1,ball)"] if possessed else [])
    ground = scene(3).ground(active)
    assert set(ground.order()) == set(ground.variables)
    assert all(abs(c.table.sum(axis=-1) - 1).max() < 1e-12 for c in ground.cpds)


def test_the_corridor_with_a_given_action_equals_the_recorded_case():
    """d15: where the action is given instead of a variable with a prior."""
    case = load("d15")
    step = filter_slices(case)["step"]
    cell = Labels(tuple(str(k) for k in range(12)))
    robot = PRMClass(
        "Robot",
        (
            Attribute("pos", cell, Dense(step.by_child["pos"].table), parents=("prev.pos", "act"), initial=Uniform()),
            Attribute("door", BOOL, Dense(step.by_child["door"].table), parents=("pos",)),
        ),
        given=(Given("act", Labels(("stay", "left", "right"))),),
    )
    world = Grounding(Model("corridor", (robot,)), {"r": "Robot"})
    belief = marginal(world.ground(first=True), "r.pos", {"r.door": case["steps"][0]["evidence"]["door"], "r.act": 0})
    assert np.allclose(belief, case["steps"][0]["posterior"]["pos"], atol=1e-12)
    for recorded in case["steps"][1:]:
        act, door = recorded["evidence"]["act"], recorded["evidence"].get("door")
        moved = belief @ world.ground().by_child["r.pos"].table[:, act]
        seen = moved if door is None else moved * world.ground().by_child["r.door"].table[:, door]
        belief = seen / seen.sum()
        assert np.allclose(belief, recorded["posterior"]["pos"], atol=1e-12)


def test_a_text_alone_is_one_relation_or_object_and_not_its_letters():
    """`relations="attended(o1)"` was split into letters."""
    world = scene(opponents=2)
    assert world.ground("attended(o1)") is world.ground(["attended(o1)"])
    assert world.situation("attended(o1)", "o1").objects == ("o1",)
    assert list(world.ground(objects="ball").variables) == list(world.ground(objects=["ball"]).variables)
    assert Filter(world).step({}, "attended(o1)").slice.relations == ("attended(o1)",)
    assert Filter(world, static="ball.dist").settings.static == {"ball.dist"}
    bank = FilterBank(world, 1)
    bank.step({}, [Link("attended", "o2")])
    assert len(bank.answers[0][1].slice.relations) == 1
    net = BayesNet(world.ground(first=True))
    assert net.variable_elimination("ball.seen", {"ball.turn": 0.0, "o1.turn": 0.0, "o2.turn": 0.0}).shape == (1, 2)
    for only in ("class", ("class", "Ball")):
        with pytest.raises(ParameterError, match="`only` is a list of beginnings of keys"):
            count(world, [], only=only)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Relation("r", "ab"),
        lambda: Relation("r", ("x", "y")),
        lambda: Relation("r", {"x": "C"}, keep_joint=("x.a", "x.b")),
        lambda: Relation("r", {"x": "C"}, changes=Replace("x.a")),
        lambda: PRMClass("C", attributes=Attribute("a", BOOL)),
        lambda: PRMClass("C", references="home"),
        lambda: Attribute("a", "no"),
        lambda: Attribute("a", BOOL, (0.5, 0.5), parents="b"),
        lambda: Model("m", PRMClass("C")),
        lambda: Labels("abc"),
        lambda: Bins("012"),
        lambda: Bins(3),
        lambda: Prior(0.5),
        lambda: Prior("ab"),
        lambda: NoisyOr(0.5),
        lambda: NoisyOr("0.5"),
        lambda: Table(3),
        lambda: Table({1: (0.5, 0.5)}),
        lambda: Table({"a": 0.5}),
        lambda: Switch("x", 3),
        lambda: Mixture(0.5, 0.5),
        lambda: Grounding(Model("m", (PRMClass("C"),)), "ab"),
        lambda: Grounding(Model("m", (PRMClass("C"),)), ["a"]),
        lambda: Grounding(Model("m", (PRMClass("C"),)), {"a": "C"}, ["b"]),
    ],
)  # fmt: skip
def test_what_is_no_tuple_where_one_is_taken_is_an_error_of_ours(make):
    with pytest.raises(ModelError):
        make()
