"""Drawings: well-formed, complete, nothing on top of anything else, in the dissertation's signs."""

import re
from itertools import combinations

import numpy as np
import pytest
from defusedxml import ElementTree
from orient_module import ORIENT, TWICE
from petri_random_nets import random_net

from cprm_gym.architecture.petri import PetriNet, Place, Transition, flatten
from cprm_gym.architecture.petri.drawing.dot import ALL, save_drawing, to_dot, to_svg
from cprm_gym.architecture.petri.drawing.labels import curve_points, place_labels
from cprm_gym.architecture.petri.drawing.layout import Edge, Node, arrange
from cprm_gym.architecture.petri.drawing.picture import picture
from cprm_gym.architecture.petri.drawing.svg import BAR, RADIUS
from cprm_gym.errors import NetError

SVG = "{http://www.w3.org/2000/svg}"


def parts(svg: str, tag: str) -> list[dict[str, str]]:
    return [dict(element.attrib) for element in ElementTree.fromstring(svg).iter(SVG + tag)]


def texts(svg: str) -> set[str]:
    return {element.text for element in ElementTree.fromstring(svg).iter(SVG + "text")}


def test_every_place_transition_and_arc_is_drawn():
    svg = to_svg(ORIENT)
    assert {p.name for p in ORIENT.places} | {t.name for t in ORIENT.transitions} <= texts(svg)
    circles = [c for c in parts(svg, "circle") if float(c["r"]) == RADIUS]
    bars = [r for r in parts(svg, "rect") if r["width"] == f"{BAR:g}"]
    assert (len(circles), len(bars)) == (len(ORIENT.places), len(ORIENT.transitions))
    arcs = sum(len(t.inputs) + len(t.outputs) + len(t.tests) + len(t.inhibitors) + len(t.sets) for t in ORIENT.transitions)
    curves = [p for p in parts(svg, "path") if p["fill"] == "none"]
    assert len(curves) == arcs + 1 + 3  # a command parameter, operands of math


def test_signs_are_those_of_the_dissertation():
    svg = to_svg(ORIENT)
    paths, circles, bars = parts(svg, "path"), parts(svg, "circle"), [r for r in parts(svg, "rect") if r["width"] == f"{BAR:g}"]
    tests = sum(len(t.tests) for t in ORIENT.transitions)
    inhibitors = sum(len(t.inhibitors) for t in ORIENT.transitions)
    assert sum(p.get("stroke-dasharray") == "5 3" for p in paths) == tests + inhibitors, "test and inhibitor arcs are dashed"
    assert sum(c["r"] == "3.5" for c in circles) == inhibitors, "inhibitor arcs end in a circle"
    assert sum(c["fill"] == "url(#hash)" for c in circles) == 2, "input places are hashed"
    assert sum(float(c["r"]) == RADIUS - 3 for c in circles) == 1, "belief places have a double line"
    assert [b["fill"] for b in bars].count("url(#hash)") == 1, "output transitions are hashed"
    heads = sum(p["fill"] == "#1f2933" for p in paths)
    arrows = sum(len(t.inputs) + len(t.outputs) + len(t.tests) for t in ORIENT.transitions)
    assert heads == arrows + 2, "a set arc has two heads"


def test_immediate_bars_are_filled_and_timed_ones_open_with_their_delay():
    net = PetriNet("n", (Place("p", tokens=1),), (Transition("now", ("p",)), Transition("later", ("p",), delay=7)))
    svg = to_svg(net)
    assert [r["fill"] for r in parts(svg, "rect") if r["width"] == f"{BAR:g}"] == ["#1f2933", "white"]
    assert "7" in texts(svg)


def test_modules_are_boxes_with_ports_folded_and_nets_unfolded():
    folded, unfolded = to_svg(TWICE), to_svg(TWICE, ALL)
    for svg in (folded, unfolded):
        assert {"first : orient", "second : orient"} <= texts(svg)
    assert "turns" not in texts(folded)
    assert "turns" in texts(unfolded)
    assert {"begin", "facing", "abort", "off_axis"} <= texts(folded)
    flat = to_svg(flatten(TWICE))
    assert "first.turns" in texts(flat)


def test_levels_unfold_one_by_one():
    inner = PetriNet("inner", (Place("deep"),))
    net = PetriNet("outer", modules={"m": PetriNet("middle", (Place("mid"),), modules={"i": inner})})
    seen = [("mid" in texts(to_svg(net, level)), "deep" in texts(to_svg(net, level))) for level in (0, 1, 2)]
    assert seen == [(False, False), (True, False), (True, True)]
    assert [len(list(picture(net, level).walk())) for level in (0, 1, ALL)] == [2, 3, 3]


def test_nothing_stands_on_anything_else():
    for seed in range(25):
        net = random_net(np.random.default_rng(seed))
        svg = to_svg(net)
        spots = [(float(c["cx"]), float(c["cy"]), RADIUS) for c in parts(svg, "circle") if float(c["r"]) == RADIUS]
        for rect in parts(svg, "rect"):
            if rect["width"] == f"{BAR:g}":
                spots.append((float(rect["x"]) + BAR / 2, float(rect["y"]) + 3.5, BAR / 2))
        for (x0, y0, r0), (x1, y1, r1) in combinations(spots, 2):
            assert abs(x0 - x1) >= r0 + r1 - 0.2 or abs(y0 - y1) > 2 * RADIUS, f"seed {seed}"
        width, height = (float(ElementTree.fromstring(svg).attrib[k]) for k in ("width", "height"))
        assert all(0 < x < width and 0 < y < height for x, y, _ in spots)


def test_names_from_strangers_are_escaped():
    net = PetriNet("a<b>&\"'", (Place('<script>"&'),), (Transition("t]]>", ('<script>"&',)),))
    assert '<script>"&' in texts(to_svg(net))
    dot = to_dot(net)
    assert r'"<script>\"&"' in dot
    assert dot.count("{") == dot.count("}")


def test_dot_names_every_part_with_its_style():
    dot = to_dot(TWICE, ALL)
    assert dot.startswith('digraph "twice" {')
    assert dot.count("subgraph") == 2
    assert '"first.begin" [shape=circle' in dot
    assert re.search(r'"first\.bearing" \[shape=doublecircle', dot)
    assert re.search(r'"first\.turns" -> "first\.turn" \[style=dashed, arrowhead=odot, label="≥ 5"\];', dot)
    assert re.search(r'"first\.start" -> "first\.turns" \[arrowhead=normalnormal, label="= 0"\];', dot)
    assert re.search(r'"first\.off_axis" -> "first\.turn" \[style=dashed, label="≥ 3"\];', dot)
    assert re.search(r'"go" -> "first\.begin" \[dir=none', dot)
    assert re.search(r'"first\.turn" \[shape=box, style=striped', dot)


def test_drawings_are_written_by_suffix(tmp_path):
    save_drawing(TWICE, tmp_path / "a.svg")
    save_drawing(TWICE, tmp_path / "a.dot", ALL)
    assert (tmp_path / "a.svg").read_text(encoding="utf-8") == to_svg(TWICE)
    assert (tmp_path / "a.dot").read_text(encoding="utf-8") == to_dot(TWICE, ALL)
    with pytest.raises(NetError, match=r"a drawing is written as \.svg, \.dot, \.gv, got 'a\.png'"):
        save_drawing(TWICE, tmp_path / "a.png")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.dot", "a.svg"]


def test_empty_net_can_be_drawn():
    assert texts(to_svg(PetriNet("empty"))) == set()


def test_layers_run_downwards_and_circles_are_turned_round():
    nodes = [Node(k, 10, 10, 10) for k in "abcd"]
    edges = [Edge("a", "b"), Edge("b", "c"), Edge("c", "a"), Edge("a", "d"), Edge("a", "c")]
    width, height = arrange(nodes, edges)
    at = {node.key: node for node in nodes}
    assert at["a"].y < at["b"].y < at["c"].y
    assert at["d"].y == at["b"].y
    assert all(node.left <= node.x <= width - node.right + 1e-9 for node in nodes)
    assert max(node.y + node.height / 2 for node in nodes) == height
    back = edges[2].points
    assert back[0][1] > back[-1][1], "the points of a turned edge lead upwards"


def test_arcs_that_need_not_cross_do_not():
    nodes = [Node(k, 10, 10, 10) for k in ("a", "b", "c", "x", "y", "z")]
    arrange(nodes, [Edge("a", "z"), Edge("b", "y"), Edge("c", "x")])
    at = {node.key: node.x for node in nodes}
    assert sorted("abc", key=lambda k: at[k]) == [{"z": "a", "y": "b", "x": "c"}[k] for k in sorted("xyz", key=lambda k: at[k])]


def test_labels_of_crossing_arcs_stand_clear_of_each_other_of_texts_and_of_arcs():
    paths = [[(0.0, 0.0), (100.0, 60.0)], [(100.0, 0.0), (0.0, 60.0)]]
    text = (20.0, 8.0, 45.0, 18.0)
    rects = [*place_labels([(20.0, 0), (20.0, 1)], 9.0, [text], paths), text]
    for n, (left, top, right, bottom) in enumerate(rects[:2]):
        for x, y in np.concatenate([curve_points(path) for path in paths]):
            assert not (left < x < right and top < y < bottom)
        for other in rects[n + 1 :]:
            assert right <= other[0] or other[2] <= left or bottom <= other[1] or other[3] <= top
