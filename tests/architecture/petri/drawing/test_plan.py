"""The plan of a drawing: every part once, under its flat name, where the drawing puts it."""

import json

import pytest

from cprm_gym.agents.goalie import GOALIE_NET
from cprm_gym.agents.skills.approach import APPROACH
from cprm_gym.architecture.petri import PetriNet, Place, Ports, Transition, flatten
from cprm_gym.architecture.petri.drawing.picture import ALL
from cprm_gym.architecture.petri.drawing.plan import drawing_plan


def keys(plan, part):
    return [p["key"] for p in plan[part]]


def test_the_unfolded_plan_has_every_place_and_transition_of_the_flat_net():
    flat, plan = flatten(APPROACH), drawing_plan(APPROACH, ALL)
    assert {p.name for p in flat.places} | {t.name for t in flat.transitions} <= set(keys(plan, "nodes"))
    assert len(set(keys(plan, "nodes"))) == len(plan["nodes"])


def test_arcs_join_nodes_that_are_there_and_end_at_them():
    plan = drawing_plan(GOALIE_NET)
    at = {n["key"]: n for n in plan["nodes"]}
    assert len(plan["links"]) > 100
    for link in plan["links"]:
        (x0, y0), (x1, y1) = link["path"][0], link["path"][-1]
        for x, y, end in ((x0, y0, at[link["source"]]), (x1, y1, at[link["target"]])):
            assert abs(x - end["x"]) <= 20.1
            assert abs(y - end["y"]) <= 12.1


def test_one_instance_is_unfolded_by_its_path():
    first, *others = APPROACH.modules
    plan = drawing_plan(APPROACH, {first})
    folded = {b["key"]: b["folded"] for b in plan["boxes"]}
    assert folded[first] is False
    assert all(folded[o] for o in others)
    inside = {f"{first}.{t.name}" for t in APPROACH.modules[first].transitions}
    assert inside <= set(keys(plan, "nodes"))


def test_every_port_is_shown_on_request():
    folded = next(iter(APPROACH.modules))
    shown = set(keys(drawing_plan(APPROACH, all_ports=True), "nodes"))
    assert {f"{folded}.{port}" for port in APPROACH.modules[folded].ports.all} <= shown


INNER = PetriNet("inner", (Place("a"), Place("b")), (Transition("t", ("a",), ("b",)),), ports=Ports(inputs=("a",), outputs=("b",)))
OUTER = PetriNet("outer", (Place("p", tokens=1), Place("q")), (Transition("go", ("p",), ("i.a",)),), modules={"i": INNER})


def test_positions_chosen_by_hand_are_kept_and_arcs_to_them_run_straight():
    plan = drawing_plan(OUTER, positions={"outer": {"p": (-40, 7), "i": (300, 200)}})
    at = {n["key"]: (n["x"], n["y"]) for n in plan["nodes"]}
    assert at["p"] == (-40, 7)
    (box,) = plan["boxes"]
    assert (box["x"], box["y"]) == (300, 200)
    assert all(link["path"] == [] for link in plan["links"])


def test_positions_inside_a_module_move_only_its_inside():
    plan = drawing_plan(OUTER, ALL, {"inner": {"a": (0, 0), "t": (200, 0), "b": (400, 0)}})
    at = {n["key"]: (n["x"], n["y"]) for n in plan["nodes"]}
    assert at["i.b"][0] - at["i.a"][0] == 400
    assert at["i.a"][1] == at["i.t"][1] == at["i.b"][1]
    (box,) = plan["boxes"]
    assert box["width"] > 400
    assert all(box["x"] <= at[f"i.{n}"][0] <= box["x"] + box["width"] for n in "atb")


def test_an_unfolded_module_makes_room_beside_positions_chosen_by_hand():
    net = PetriNet("around", (Place("right"), Place("below"), Place("left")), (), modules={"m": next(iter(APPROACH.modules.values()))})
    positions = {"around": {"m": (100, 100), "left": (0, 150), "right": (900, 150), "below": (100, 900)}}
    folded, unfolded = drawing_plan(net, 0, positions), drawing_plan(net, ALL, positions)
    (box,) = [b for b in unfolded["boxes"] if b["key"] == "m"]
    (small,) = folded["boxes"]
    at = {n["key"]: (n["x"], n["y"]) for n in unfolded["nodes"]}
    assert box["height"] > small["height"]
    assert at["left"] == (0, 150)
    assert at["below"][1] == pytest.approx(900 + box["height"] - small["height"], abs=0.3)
    assert at["right"][0] == pytest.approx(900 + max(0, box["width"] - small["width"]), abs=0.3)


def test_a_plan_is_what_json_can_say():
    plan = drawing_plan(OUTER)
    assert json.loads(json.dumps(plan)) == plan
