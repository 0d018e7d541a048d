"""Definitions are checked when they are written, and every mistake is named."""

from __future__ import annotations

import dataclasses

import pytest
from ball_world import soccer

from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.bayes_net import BayesNet
from cprm_gym.architecture.prm.model.aggregates import Exists
from cprm_gym.architecture.prm.model.cpds import Dense, Noise, Prior, Table, Uniform
from cprm_gym.architecture.prm.model.domains import BOOL, Bins, Labels
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Add, Attribute, Given, PRMClass, Reference, Relation, Replace, parse_tuple, prev
from cprm_gym.errors import ModelError

ZONES = ("own", "middle", "attack")
BALL = PRMClass("Ball", attributes=(Attribute("zone", ZONES, Prior((0.2, 0.3, 0.5))),))


def player(*attributes, **fields):
    return PRMClass(
        "Player",
        attributes=attributes,
        references=(Reference("ball", "Ball"), Reference("others", "Player", many=True)),
        **fields,
    )


def test_models_are_values():
    assert soccer(4) == soccer(4)
    assert soccer(4) != soccer(5)
    with pytest.raises(dataclasses.FrozenInstanceError):
        soccer(4).name = "x"


def test_equal_models_have_equal_hashes():
    assert hash(soccer(4)) == hash(soccer(4))
    assert len({soccer(4), soccer(4), soccer(5)}) == 2


def test_an_unknown_parent_suggests_the_nearest():
    near = Attribute("near", BOOL, Table({"*": (0.5, 0.5)}), parents=("bal.zone",))
    with pytest.raises(ModelError, match=r"class 'Player', attribute 'near': .*no reference 'bal'. Did you mean 'ball'"):
        Model("m", (BALL, player(near)))
    near = Attribute("near", BOOL, Table({"*": (0.5, 0.5)}), parents=("ball.zon",))
    with pytest.raises(ModelError, match=r"class 'Ball' has no attribute 'zon'. Did you mean 'zone'"):
        Model("m", (BALL, player(near)))


def test_a_parent_given_as_a_bare_string_is_refused_with_the_remedy():
    with pytest.raises(ModelError, match=r"`parents` takes a tuple, got the string 'zone'; write \('zone',\)"):
        Attribute("near", BOOL, Uniform(), parents="zone")


def test_a_row_missing_from_a_class_table_is_refused_at_definition():
    near = Attribute("near", BOOL, Table({"own": (0.5, 0.5)}), parents=("ball.zone",))
    with pytest.raises(ModelError, match=r"model 'm', class 'Player', attribute 'near': no row for \('middle',\)"):
        Model("m", (BALL, player(near)))


def test_a_prior_of_the_wrong_length_is_refused_at_definition():
    with pytest.raises(ModelError, match="attribute 'x': 2 probabilities for 3 states"):
        Model("m", (PRMClass("C", (Attribute("x", ZONES, (0.5, 0.5)),)),))


def test_many_objects_need_an_aggregate_and_one_does_not():
    near = Attribute("near", BOOL, Uniform(), parents=("others.near",))
    with pytest.raises(ModelError, match=r"leads to many objects; use an aggregate such as Exists\('others.near', state\)"):
        Model("m", (BALL, player(near)))
    near = Attribute("near", BOOL, Uniform(), parents=(Exists("ball.zone", "own"),))
    with pytest.raises(ModelError, match="leads to one object"):
        Model("m", (BALL, player(near)))


def test_a_cycle_within_a_class_is_refused_and_shown():
    a = Attribute("a", BOOL, Table({"*": (0.5, 0.5)}), parents=("b",))
    b = Attribute("b", BOOL, Table({"*": (0.5, 0.5)}), parents=("a",))
    with pytest.raises(ModelError, match=r"class 'C': .*cycle: a -> b -> a"):
        Model("m", (PRMClass("C", (a, b)),))


def test_a_cycle_through_the_previous_slice_is_none():
    a = Attribute("a", BOOL, Table({"*": (0.5, 0.5)}), parents=(prev("b"),))
    b = Attribute("b", BOOL, Table({"*": (0.5, 0.5)}), parents=("a",))
    assert Model("m", (PRMClass("C", (a, b)),)).acyclic


def test_a_cycle_that_one_relation_makes_is_refused():
    near = Attribute("near", BOOL, Table({"*": (0.5, 0.5)}), parents=("ball.zone",))
    relation = Relation(
        "r",
        {"p": "Player", "b": "Ball"},
        changes=(Replace("b.zone", ("x",), Uniform()),),
        attributes=(Attribute("x", BOOL, Uniform(), parents=("b.zone",)),),
    )
    with pytest.raises(ModelError, match=r"relation 'r': .*cycle"):
        Model("m", (BALL, player(near)), (relation,))


def test_classes_alone_prove_the_soccer_model_acyclic():
    assert soccer(4).acyclic


def test_a_cycle_that_depends_on_the_objects_is_left_to_grounding():
    near = Attribute("near", BOOL, Table({"*": (0.5, 0.5)}), parents=(Exists("others.near"),))
    assert not Model("m", (BALL, player(near))).acyclic


def test_subclasses_inherit_and_override_with_the_same_states():
    base = PRMClass("Thing", (Attribute("x", BOOL, (0.9, 0.1)), Attribute("y", BOOL, Uniform(), parents=("x",))), abstract=True)
    sub = PRMClass("Ball", (Attribute("x", BOOL, (0.2, 0.8)),), extends="Thing")
    info = Model("m", (sub, base)).checked.classes["Ball"]
    assert list(info.attributes) == ["x", "y"]
    assert info.rules["x"].main.table.tolist() == [0.2, 0.8]
    assert info.rules["y"].main.key == ("class", "Thing", "y", "cpd")
    with pytest.raises(ModelError, match="'x' overrides an attribute of 'Thing' with other states"):
        Model("m", (base, PRMClass("Ball", (Attribute("x", ZONES),), extends="Thing")))


def test_classes_that_inherit_in_a_circle_are_refused():
    with pytest.raises(ModelError, match="circle: A -> B -> A"):
        Model("m", (PRMClass("A", extends="B"), PRMClass("B", extends="A")))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Attribute("prev", BOOL), "'prev' is reserved"),
        (lambda: Attribute("a b", BOOL), "letters, digits"),
        (lambda: Attribute("a", BOOL, "half"), "a CPD is Prior, Uniform"),
        (lambda: Attribute("a", BOOL, Uniform(), parents=("x", "x")), "'x' is defined twice"),
        (lambda: Attribute("a", BOOL, Uniform(), initial_parents=("x",)), "need an `initial` CPD"),
        (
            lambda: Attribute("a", BOOL, Uniform(), parents=("prev.a",), static=True),
            "static attribute has no parents in the previous",
        ),
        (lambda: PRMClass("C", (Attribute("x", BOOL), Attribute("x", BOOL))), "class 'C': 'x' is defined twice"),
        (lambda: PRMClass("C", (BOOL,)), "`attributes` holds Attribute values"),
        (lambda: Given("turn", Bins((0, 1)), default=3.0), r"given 'turn': default: 3.0 is outside"),
        (lambda: Replace("dist", (), Uniform()), "the target is 'role.attribute'"),
        (lambda: Relation("r", {}), "at least one role"),
        (lambda: Relation("r", {"a": "A"}, conflict="max"), "conflict must be one of exclusive"),
        (lambda: Model("m", (PRMClass("A"), PRMClass("A"))), "class 'A' is defined twice"),
        (lambda: Model("m", (PRMClass("A", extends="Bb"),)), "unknown class 'Bb'"),
        (
            lambda: Model("m", (PRMClass("A", references=(Reference("r", "Bal"),)), BALL)),
            "unknown class 'Bal'. Did you mean 'Ball'",
        ),
        (lambda: Model("m", (BALL,), (Relation("r", {"b": "Ball"}, (Replace("c.zone"),)),)), "unknown role 'c'"),
        (
            lambda: Model("m", (BALL,), (Relation("r", {"b": "Ball"}, (Replace("b.zon"),)),)),
            "no attribute 'zon'. Did you mean 'zone'",
        ),
        (
            lambda: Model("m", (BALL,), (Relation("r", {"b": "Ball"}, keep_joint=(("b.zon",),)),)),
            "keep_joint: class 'Ball' has no",
        ),
        (lambda: Model("m", (PRMClass("A", (Attribute("x", BOOL, Noise("0", 1)),)),)), "noise needs a child with bins"),
        (lambda: parse_tuple("possesses o3 ball"), "an active relation is written"),
    ],
)
def test_a_mistake_is_refused_and_named(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_what_is_given_has_no_previous_value():
    c = PRMClass("C", (Attribute("x", BOOL, Uniform(), parents=("prev.act",)),), given=(Given("act", BOOL),))
    with pytest.raises(ModelError, match="what is given has no previous value"):
        Model("m", (c,))


def test_noisy_or_of_more_than_two_states_is_refused_at_definition():
    with pytest.raises(ModelError, match=r"relation 'r', 'b.zone': conflict 'noisy-or' needs a target of two states"):
        Model("m", (BALL,), (Relation("r", {"b": "Ball"}, (Replace("b.zone"),), conflict="noisy-or"),))


def test_add_puts_new_parents_after_the_old_ones():
    ball = PRMClass("Ball", (Attribute("x", BOOL), Attribute("y", BOOL, Table({"*": (0.9, 0.1)}), parents=("x",))))
    more = Relation("tracked", {"b": "Ball"}, (Add("b.y", ("prev.b.y",), Table({("yes", "*"): (0.1, 0.9), ("*", "*"): (0.9, 0.1)})),))
    rule = Model("m", (ball,), (more,)).checked.relations["tracked"].changes["b.y"].main
    assert [s.text for s in rule.parents] == ["b.x", "prev.b.y"]
    assert rule.table.shape == (2, 2, 2)


def test_a_model_with_other_cpds_keeps_everything_else():
    model = Model("m", (BALL,))
    learned = model.with_cpds({("class", "Ball", "zone", "cpd"): Dense((0.1, 0.1, 0.8))})
    assert learned.checked.classes["Ball"].rules["zone"].main.table.tolist() == [0.1, 0.1, 0.8]
    assert learned.classes[0].name == "Ball"
    with pytest.raises(ModelError, match="has no CPD"):
        model.with_cpds({("class", "Ball", "zon", "cpd"): Dense((0.1, 0.1, 0.8))})


def test_add_keeps_an_aggregate_parent_of_the_class():
    """`Add` wrote the class's parents anew from their fields and tripped over the aggregate's name (TypeError)."""
    a = PRMClass("A", (Attribute("on", BOOL, (0.5, 0.5)), Attribute("w", BOOL, (0.3, 0.7))))
    alarm = Attribute("alarm", BOOL, Table({"yes": (0.1, 0.9), "no": (0.9, 0.1)}), parents=(Exists("as_.on"),))
    b = PRMClass("B", (alarm,), references=(Reference("as_", "A", many=True),))
    table = Table({("yes", "yes"): (0.0, 1.0), ("yes", "no"): (0.4, 0.6), ("no", "*"): (0.9, 0.1)})
    model = Model("m", (a, b), (Relation("r", {"x": "A", "y": "B"}, (Add("y.alarm", ("x.w",), table),)),))
    world = Grounding(model, {"x0": "A", "x1": "A", "y": "B"})
    net = BayesNet(world.ground(["r(x1,y)"], first=True))
    some, w = 0.75, 0.7
    assert net.query()["y.alarm"][0, 1] == pytest.approx(some * (w + 0.6 * (1 - w)) + (1 - some) * 0.1)


def test_the_tables_of_a_model_have_a_limit_together():
    wide = Labels(tuple(f"s{k}" for k in range(250)))
    attributes = [Attribute("a", wide), Attribute("b", wide)]
    attributes += [Attribute(f"c{k}", wide, Uniform(), parents=("a", "b")) for k in range(4)]
    with pytest.raises(ModelError, match=r"attribute 'c3': with this table the model has \d+ cells; at most 50000000"):
        Model("m", (PRMClass("C", tuple(attributes)),))
