"""Drawings hold everything, once, and are well formed."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

import pytest
from ball_world import scene, soccer
from defusedxml.ElementTree import fromstring

from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.interchange.drawing import class_diagram_dot, class_diagram_svg, ground_net_dot, ground_net_svg
from cprm_gym.architecture.prm.model.cpds import Table
from cprm_gym.architecture.prm.model.domains import BOOL
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, PRMClass, Reference

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def ground():
    return scene(4, 2).ground(["attended(o1)", "possesses(o1,ball)"])


def texts(picture: Element) -> list[str]:
    return [t.text or "" for t in picture.iter(f"{SVG}text")]


def test_class_diagram_names_every_class_attribute_and_relation():
    picture = fromstring(class_diagram_svg(soccer(4)))
    words = "\n".join(texts(picture))
    for word in (
        "Thing (abstract)",
        "Ball : Thing",
        "obs_dist [4] | dist, seen",
        "possesses(o: Opponent, b: Ball)",
        "b.dist = o.dist, shoot",
    ):
        assert word in words
    dot = class_diagram_dot(soccer(4))
    assert dot.count("arrowhead=empty") == 2
    assert '"relation possesses" -> "Ball" [label="b"' in dot


def test_ground_net_has_a_node_for_every_variable_and_an_arrow_for_every_parent(ground):
    picture = fromstring(ground_net_svg(ground, observed=["ball.seen"]))
    kinds = [r.get("class") for r in picture.iter(f"{SVG}rect")]
    past = {p for c in ground.cpds for p, lag in c.parents if lag == 1}
    assert kinds.count("node") + kinds.count("seen") + kinds.count("given") == len(ground.variables)
    assert kinds.count("past") == len(past)
    assert kinds.count("seen") == 1
    arrows = [p.get("class") for p in picture.iter(f"{SVG}path") if p.get("class")]
    assert len(arrows) == sum(len(c.parents) for c in ground.cpds)
    assert arrows.count("lag") == sum(lag for c in ground.cpds for _, lag in c.parents)


def test_ground_net_as_dot_has_the_same_nodes_and_arrows(ground):
    dot = ground_net_dot(ground, observed=["ball.seen"])
    assert dot.count(" -> ") == sum(len(c.parents) for c in ground.cpds)
    assert len(re.findall(r"\[label=", dot)) == len(ground.variables)
    assert '"possesses(o1,ball).shoot" -> "ball.dist"' in dot


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_graphviz_grammar_accepts_our_dot(ground):
    pydot = pytest.importorskip("pydot")
    for text, edges in ((ground_net_dot(ground), sum(len(c.parents) for c in ground.cpds)), (class_diagram_dot(soccer(4)), 5)):
        (graph,) = pydot.graph_from_dot_data(text)
        found = len(graph.get_edges()) + sum(len(s.get_edges()) for s in graph.get_subgraphs())
        assert found == edges


def test_boxes_of_one_object_do_not_overlap_and_stay_inside_the_picture(ground):
    picture = fromstring(ground_net_svg(ground))
    width, height = float(picture.get("width")), float(picture.get("height"))
    nodes = [
        [float(r.get(k)) for k in ("x", "y", "width", "height")]
        for r in picture.iter(f"{SVG}rect") if r.get("class") != "object"
    ]  # fmt: skip
    for i, (x, y, w, h) in enumerate(nodes):
        assert x >= 0
        assert y >= 0
        assert x + w <= width
        assert y + h <= height
        for x2, y2, w2, h2 in nodes[:i]:
            assert x + w <= x2 or x2 + w2 <= x or y + h <= y2 or y2 + h2 <= y


def test_a_crowd_is_drawn_in_rows():
    picture = fromstring(ground_net_svg(scene(3, 11).ground(), columns=4))
    tops = {r.get("y") for r in picture.iter(f"{SVG}rect") if r.get("class") == "object"}
    assert len(tops) == 3


def test_references_and_odd_names_are_drawn():
    model = Model("a<b", (PRMClass("A", (Attribute("x", ("<1", "&")),), (Reference("peers", "A", True), Reference("b", "B"))),
                          PRMClass("B", (Attribute("y", BOOL),))))  # fmt: skip
    assert "-> peers: A *" in texts(fromstring(class_diagram_svg(model)))
    net = Grounding(model, {"a": "A", "b": "B"}).ground()
    assert "x" in texts(fromstring(ground_net_svg(net)))
    assert '"A" -> "A" [label="peers *"]' in class_diagram_dot(model)


def test_static_parents_of_an_earlier_slice_are_drawn():
    room = PRMClass("Room", (Attribute("infected", BOOL, static=True),))
    cpd = Table({"yes": (0.3, 0.7), "no": (0.9, 0.1)})
    patient = PRMClass("Patient", (Attribute("ill", BOOL, cpd, parents=("room.infected",)),), references=(Reference("room", "Room"),))
    world = Grounding(Model("hospital", (room, patient)), {"r": "Room", "p": "Patient"})
    later = world.ground()
    picture = fromstring(ground_net_svg(later))
    assert [p.get("class") for p in picture.iter(f"{SVG}path") if p.get("class")] == ["static"]
    assert {"r", "p", "ill", "infected (static)"} <= set(texts(picture))
    assert '"r.infected" [label="infected (static)"' in ground_net_dot(later)
