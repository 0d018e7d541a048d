"""Models in the editor: renaming everywhere, tables, the ground net, queries that agree with the engine, learning from a log."""

import json
import random
from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.goalie import goalie_cprm
from cprm_gym.architecture.cprm import CPRM, Observe
from cprm_gym.architecture.petri import Belief, PetriNet, Place
from cprm_gym.architecture.prm import (
    Attribute,
    Exists,
    Filter,
    Grounding,
    Model,
    Noise,
    PRMClass,
    Reference,
    Relation,
    Replace,
    Switch,
    Table,
)
from cprm_gym.architecture.prm.model.domains import Bins
from cprm_gym.errors import CprmError, ModelError, ParameterError, UnknownName
from cprm_gym.studio.editing.desk import Desk
from cprm_gym.studio.editing.document import Document, form_of
from cprm_gym.studio.editing.logs import log_text
from cprm_gym.studio.editing.model_operations import OPERATIONS
from cprm_gym.studio.editing.model_view import cpd_table, graph, query, tuples
from cprm_gym.studio.editing.models import Models

BOOL = ("no", "yes")
ZONE = ("own", "middle", "attack")
BALL = PRMClass(
    "Ball",
    (
        Attribute("zone", ZONE, Table({"own": (0.8, 0.1, 0.1), "*": (0.2, 0.4, 0.4)}), ("prev.zone",), (0.2, 0.6, 0.2)),
        Attribute("dist", Bins((0.0, 1.0, 2.0, 4.0)), Noise("prev.dist", "0.5 + 0.1 * prev.dist"), ("prev.dist",)),
    ),
)
PLAYER = PRMClass(
    "Player",
    references=(Reference("ball", "Ball"), Reference("others", "Player", many=True)),
    attributes=(
        Attribute("near", BOOL, Switch("ball.zone", {"own": (0.9, 0.1), "*": (0.5, 0.5)}), ("ball.zone",)),
        Attribute("pressed", BOOL, Table({("yes", "yes"): (0.2, 0.8), ("*", "*"): (0.9, 0.1)}), ("near", Exists("others.near", "yes"))),
    ),
)
HOLDS = Relation(
    "holds",
    (("p", "Player"), ("b", "Ball")),
    (Replace("b.dist", ("p.near",), Table({"yes": (0.8, 0.1, 0.1), "no": (0.1, 0.1, 0.8)})),),
)
MODEL = Model("play", (BALL, PLAYER), (HOLDS,))
WORLD = Grounding(
    MODEL, {"ball": "Ball", "p1": "Player", "p2": "Player"},
    {"p1": {"ball": "ball", "others": ("p2",)}, "p2": {"ball": "ball", "others": ("p1",)}},
)  # fmt: skip


def changed(*ops):
    made = Document("play", form_of(WORLD))
    for op in ops:
        made.apply(op, "model")
        assert made.problem() == "", op
    return made


def test_a_class_is_renamed_with_references_roles_and_objects():
    world = changed({"op": "rename", "what": "class", "name": "Player", "to": "Robot"}).value()
    assert world.objects == {"ball": "Ball", "p1": "Robot", "p2": "Robot"}
    robot = world.model.classes[1]
    assert robot.references[1] == Reference("others", "Robot", many=True)
    assert world.model.relations[0].roles[0] == ("p", "Robot")


def test_an_attribute_is_renamed_in_parents_chains_expressions_and_targets():
    model = changed(
        {"op": "rename", "what": "attribute", "owner": "Ball", "name": "zone", "to": "third"},
        {"op": "rename", "what": "attribute", "owner": "Ball", "name": "dist", "to": "range"},
        {"op": "rename", "what": "attribute", "owner": "Player", "name": "near", "to": "close"},
    ).value().model  # fmt: skip
    ball, player = model.classes
    assert ball.attributes[0].parents == ("prev.third",)
    assert ball.attributes[1].cpd == Noise("prev.range", "0.5 + 0.1 * prev.range")
    assert player.attributes[0].parents == ("ball.third",)
    assert player.attributes[0].cpd.parent == "ball.third"
    assert player.attributes[1].parents == ("close", Exists("others.close", "yes"))
    assert (model.relations[0].changes[0].target, model.relations[0].changes[0].parents) == ("b.range", ("p.close",))


def test_references_roles_relations_and_objects_are_renamed():
    made = Document("play", form_of(WORLD))
    made.apply({"op": "rename", "what": "role", "owner": "holds", "name": "b", "to": "thing"}, "model")
    made.apply({"op": "rename", "what": "relation", "name": "holds", "to": "has"}, "model")
    made.apply({"op": "rename", "what": "object", "name": "p2", "to": "mate"}, "model")
    made.apply({"op": "rename", "what": "reference", "owner": "Player", "name": "ball", "to": "toy"}, "model")
    world = made.value()
    assert world.model.relations[0].changes[0].target == "thing.dist"
    assert world.references["p1", "others"] == ("mate",)
    assert world.references["mate", "toy"] == ("ball",)
    assert world.model.classes[1].attributes[0].parents == ("toy.zone",)


def test_a_state_is_renamed_in_its_tables_and_those_of_its_children():
    made = changed(
        {"op": "rename_state", "owner": "Ball", "attribute": "zone", "name": "own", "to": "back"},
        {"op": "rename_state", "owner": "Player", "attribute": "near", "name": "yes", "to": "sure"},
    )
    world = made.value()
    ball, player = world.model.classes
    assert ball.attributes[0].domain.names == ("back", "middle", "attack")
    assert ball.attributes[0].cpd.rows[0][0] == ("back",)
    assert player.attributes[0].cpd.cases[0][0] == "back"
    assert player.attributes[1].cpd.rows[0][0] == ("sure", "yes"), "the aggregate has states of its own"
    assert player.attributes[1].parents[1].state == "sure"
    assert world.model.relations[0].changes[0].cpd.rows[0][0] == ("sure",)
    for relations in ((), ("holds(p1,ball)",)):
        for a, b in zip(WORLD.ground(relations).cpds, world.ground(relations).cpds):
            assert np.array_equal(a.table, b.table)


BAD = [
    ({"op": "fly"}, "fly"),
    ({"op": "set", "path": [], "value": 1}, "path"),
    ({"op": "set", "path": ["model", "classes", "Ball"], "value": 1}, "leads nowhere"),
    ({"op": "remove", "path": ["model", "classes", 9]}, "has no"),
    ({"op": "insert", "path": ["model", "name"], "value": 1}, "list"),
    ({"op": "rename", "what": "class", "name": "Bal", "to": "x"}, "'Bal'"),
    ({"op": "rename", "what": "soul", "name": "Ball", "to": "x"}, "soul"),
    ({"op": "rename", "what": "attribute", "owner": "Ball", "name": "zoned", "to": "x"}, "'zoned'"),
    ({"op": "rename_state", "owner": "Ball", "attribute": "dist", "name": "own", "to": "x"}, "no named state"),
    ({"op": "set", "pfad": []}, "set"),
]


@pytest.mark.parametrize(("op", "words"), BAD, ids=[str(k) for k in range(len(BAD))])
def test_what_does_not_fit_is_refused_and_changes_nothing(op, words):
    made = Document("play", form_of(WORLD))
    with pytest.raises(CprmError, match=words):
        made.apply(op, "model")
    assert made.data == form_of(WORLD)


def test_an_unfinished_model_says_what_is_wrong_and_can_be_finished():
    made = Document("play", form_of(WORLD))
    zone = ["model", "classes", 0, "attributes", 0]
    made.apply({"op": "set", "path": [*zone, "domain", "names"], "value": ["own", "attack"]}, "model")
    assert "zone" in made.problem()
    with pytest.raises(CprmError):
        made.value()
    made.undo()
    assert made.problem() == ""


def test_classes_and_attributes_are_added_and_taken_away():
    made = changed(
        {"op": "insert", "path": ["model", "classes", 2], "value": {"is": "PRMClass", "name": "Goal"}},
        {"op": "insert", "path": ["model", "classes", 2, "attributes", 0],
         "value": {"is": "Attribute", "name": "open", "domain": {"is": "Labels", "names": ["no", "yes"]}}},
        {"op": "set", "path": ["objects", "goal"], "value": "Goal"},
        {"op": "move", "path": ["model", "classes", 2], "to": 0},
    )  # fmt: skip
    world = made.value()
    assert [c.name for c in world.model.classes] == ["Goal", "Ball", "Player"]
    assert world.objects["goal"] == "Goal"
    made.apply({"op": "all", "ops": [{"op": "set", "path": ["objects", "goal"], "value": None},
                                     {"op": "remove", "path": ["model", "classes", 0]}]}, "model")  # fmt: skip
    assert made.value().model == MODEL


def test_a_table_shows_what_the_engine_uses():
    shown = cpd_table(MODEL, "class", "Player", "pressed")
    table = MODEL.checked.classes["Player"].rules["pressed"].main.table
    assert [p["name"] for p in shown["parents"]] == ["near", "exists(others.near=yes)"]
    assert shown["states"] == ["no", "yes"]
    for states, row in shown["rows"]:
        index = tuple(p["states"].index(s) for p, s in zip(shown["parents"], states))
        assert row == pytest.approx(table[index], abs=1e-6)
    assert shown["left"] == 0
    assert cpd_table(MODEL, "class", "Ball", "zone", "initial")["rows"] == [[[], [0.2, 0.6, 0.2]]]
    assert cpd_table(MODEL, "change", "holds", "b.dist")["parents"][0]["name"] == "p.near"


def test_a_table_that_is_not_there_names_those_that_are():
    with pytest.raises(UnknownName, match="pressed"):
        cpd_table(MODEL, "class", "Player", "presed")
    with pytest.raises(ModelError, match="no initial"):
        cpd_table(MODEL, "class", "Player", "near", "initial")


def test_the_graph_has_every_variable_and_marks_what_a_relation_changes():
    plain, held = graph(WORLD), graph(WORLD, ("holds(p1,ball)",))
    assert {n["key"] for n in plain["nodes"]} == set(WORLD.ground(()).variables)
    edges = {(e["source"], e["target"], e["lag"]) for e in plain["edges"]}
    assert ("ball.zone", "p1.near", 0) in edges
    assert ("ball.dist", "ball.dist", 1) in edges
    assert [(e["source"], e["target"]) for e in held["edges"] if e["changed"]] == [("p1.near", "ball.dist")]


def test_a_query_gives_the_posterior_of_the_engine():
    evidence = {"p1.near": "yes", "p2.pressed": "yes"}
    answer = query(WORLD, [{}, {"evidence": evidence, "relations": ["holds(p1,ball)"]}])
    filter = Filter(WORLD)
    filter.step({})
    posterior = filter.step(evidence, ("holds(p1,ball)",))
    for name in ("ball.zone", "ball.dist", "p2.near"):
        assert answer["beliefs"][name] == pytest.approx(posterior[name][0], abs=1e-6)
    assert answer["log_likelihood"] == pytest.approx(filter.log_likelihood[0])
    assert answer["exact"]


def test_the_goalies_model_is_shown_and_asked():
    grounding = goalie_cprm().grounding()
    assert "attendedOpponent(o1)" in " ".join(tuples(grounding))
    assert len(graph(grounding, first=True)["nodes"]) == len(grounding.ground((), first=True).variables)


@pytest.fixture
def models(tmp_path):
    desk = Desk(lambda *_, **__: None, tmp_path, tmp_path / "drafts", seconds=0.2)
    yield Models(desk)
    desk.close()


def sampled(rng, slices):
    rows = []
    for _ in range(slices):
        near = rng.random() < 0.3
        rows.append({"c.near": "yes" if near else "no", "c.pressed": "yes" if rng.random() < (0.9 if near else 0.1) else "no"})
    return rows


ONE = Model("one", (PRMClass("C", (Attribute("near", BOOL), Attribute("pressed", BOOL, parents=("near",)))),))


@pytest.mark.parametrize("ending", ["csv", "json"])
def test_learning_from_a_log_finds_the_chances_that_made_it_and_can_be_undone(models, tmp_path, ending):
    rows = sampled(np.random.default_rng(1), 3000)
    if ending == "csv":
        lines = ["c.near,c.pressed", *(f"{r['c.near']},{r['c.pressed']}" for r in rows[:2000]), "",
                 *(f"{r['c.near']},{r['c.pressed']}" for r in rows[2000:])]  # fmt: skip
        (tmp_path / "log.csv").write_text("\n".join(lines))
    else:
        (tmp_path / "log.json").write_text(json.dumps({"episodes": [[{"evidence": r} for r in rows]]}))
    key = models.desk.add("one", Grounding(ONE, {"c": "C"}), "new:one")
    state = models.learn(key, f"log.{ending}", "count")
    assert state["learned"]["slices"] == 3000
    assert state["learned"]["episodes"] == (2 if ending == "csv" else 1)
    near, pressed = models.table(key, "class", "C", "near"), models.table(key, "class", "C", "pressed")
    assert near["rows"][0][1][1] == pytest.approx(0.3, abs=0.04)
    assert pressed["rows"][1][1][1] == pytest.approx(0.9, abs=0.04)
    models.desk.undo(key)
    assert models.desk.document(key).model_value() == ONE


def test_the_model_of_an_agent_is_learned_where_it_is_and_all_else_of_the_agent_stays(models, tmp_path):
    net = PetriNet("reader", (Place("a", tokens=1), Belief("seen", variable="c.near", view="probability", state="yes")), ())
    agent = CPRM("agent", net, ONE, {"c": "C"}, (Observe("c.pressed", "touch"),))
    rows = sampled(np.random.default_rng(2), 400)
    for k, row in enumerate(rows):
        if k % 4 == 0:
            del row["c.near"]
    (tmp_path / "log.json").write_text(log_text([[(row, ()) for row in rows]]))
    key = models.desk.add("agent", agent, "new:agent")
    learned = models.learn(key, "log.json", "em", iterations=5)["learned"]["log_likelihoods"]
    assert learned == sorted(learned)
    assert learned[-1] > learned[0] + 50
    value = models.desk.document(key).value()
    assert value.model != ONE
    assert replace(value, model=ONE) == agent
    assert models.desk.models() == {"one": value.model}
    models.desk.undo(key)
    assert models.desk.document(key).value() == agent
    with pytest.raises(ParameterError, match="iterations: 1 to 1000, got 0"):
        models.learn(key, "log.json", "em", iterations=0)


@pytest.mark.parametrize("text", ["", "a,b\n1", '{"episodes": 3}', "c.near\nperhaps"])
def test_a_log_that_does_not_fit_is_refused(models, tmp_path, text):
    name = "log.json" if text.startswith("{") else "log.csv"
    (tmp_path / name).write_text(text)
    key = models.desk.add("one", Grounding(ONE, {"c": "C"}), "new:one")
    with pytest.raises(CprmError):
        models.learn(key, name, "em")
    assert models.desk.document(key).model_value() == ONE


def places(value, path=()):
    """Every path into a JSON value."""
    yield list(path)
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


@pytest.mark.parametrize("seed", range(2))
def test_whatever_a_page_sends_is_done_or_refused_with_words(seed):
    rng = random.Random(seed)
    paths = list(places(form_of(WORLD)))
    values = [
        None,
        0,
        -1,
        0.5,
        "",
        "x",
        "zone",
        [],
        ["zone"],
        {},
        {"is": "Prior", "p": [1]},
        {"is": "x"},
        True,
        [[1]],
        {"is": "PRMClass", "name": "C"},
    ]
    unfinished = 0
    for _ in range(300):
        made = Document("play", form_of(WORLD))
        for _ in range(rng.randrange(1, 4)):
            op = {"op": rng.choice(sorted(OPERATIONS)), "path": rng.choice(paths), "value": rng.choice(values)}
            if op["op"] in ("remove",):
                del op["value"]
            if op["op"] in ("rename", "rename_state"):
                op = {"op": op["op"], "what": rng.choice(["class", "attribute", "object", 3]), "owner": rng.choice(["Ball", "Player", ""]),
                      "name": rng.choice(["zone", "Ball", "own", "p1"]), "to": rng.choice(values)}  # fmt: skip
            try:
                made.apply(op, "model")
            except CprmError:
                continue
        unfinished += bool(made.problem())
    assert unfinished > 20


def test_expressions_of_cpds_are_checked_while_they_are_typed(models):
    key = models.desk.add("world", WORLD, "new:world")
    assert models.expression(key, "prev.dist + 1", ["prev.dist"])["ok"]
    answer = models.expression(key, "prev.dits + 1", ["prev.dist"])
    assert "Did you mean 'prev.dist'" in answer["error"]
    assert models.expression(key, "1 +", [])["at"] == 3
