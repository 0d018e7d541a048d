"""Object places: selection by an expression, tokens moved by transitions, attributes read by math."""

import numpy as np
import pytest

from cprm_gym.architecture.petri import Executor, Input, Math, ObjectPlace, PetriNet, Place, Selection, Transition
from cprm_gym.errors import NetError, UnknownName


def chooser(**options) -> Executor:
    options.setdefault("best", "teammate.openness")
    place = ObjectPlace("chosen", "Teammate", Selection("Teammate", **options))
    return Executor(PetriNet("m", (place, Input("least", value=10), Math("at", "chosen.x", default=-1))), batch=2, objects={"Teammate": 4})


TEAM = {"openness": [[3, 30, 12, 30], [1, 2, 3, 4]], "x": [0, 10, 20, 30]}


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, [1, 3]),
        ({"k": 2}, [3, 2]),
        ({"k": 3}, [2, 1]),
        ({"minimize": True}, [0, 0]),
        ({"where": "teammate.openness >= least"}, [1, -1]),
        ({"where": "teammate.openness >= least", "k": 3}, [2, -1]),
        ({"where": "teammate.openness >= least", "k": 4}, [-1, -1]),
        ({"best": "hypot(teammate.x - 20, teammate.openness - 12)", "minimize": True}, [2, 2]),
    ],
)
def test_the_kth_best_candidate_is_selected_ties_in_order(options, expected):
    executor = chooser(**options)
    executor.step(objects={"Teammate": {key: TEAM[key] for key in executor.attributes["Teammate"]}})
    assert executor.holds("chosen").tolist() == expected
    assert executor.read("chosen").tolist() == [float(i >= 0) for i in expected]
    assert executor.read("at").tolist() == [10.0 * i if i >= 0 else -1.0 for i in expected]


def test_absent_and_unknown_candidates_are_not_selected():
    executor = chooser()
    present = np.array([[1, 0, 1, 0], [0, 0, 0, 0]])
    executor.step(objects={"Teammate": {**TEAM, "present": present}})
    assert executor.holds("chosen").tolist() == [2, -1]
    executor.step(objects={"Teammate": {"openness": [np.nan, 5, np.nan, 4], "x": [0, 1, 2, 3]}})
    assert executor.holds("chosen").tolist() == [1, 1]


def test_nobody_is_selected_before_the_first_look():
    executor = chooser()
    executor.step()
    assert executor.holds("chosen").tolist() == [-1, -1]


MOVES = PetriNet(
    "moves",
    (
        ObjectPlace("nearest", "Opponent", Selection("Opponent", "opponent.distance", minimize=True)),
        ObjectPlace("marked", "Opponent"), ObjectPlace("also", "Opponent"), Place("go", tokens=1), Place("copy"), Place("drop"),
        Math("distance", "marked.distance", default=99),
    ),
    (
        Transition("mark", ("go", "nearest"), ("marked", "copy"), delay=1),
        Transition("double", ("copy", "marked"), ("marked", "also"), delay=1),
        Transition("forget", ("drop",), sets={"marked": 0}, inhibitors={"distance": 50}),
    ),
)  # fmt: skip


def test_transitions_move_the_object_and_math_follows():
    executor = Executor(MOVES, objects={"Opponent": 3})
    executor.step(objects={"Opponent": {"distance": [30, 5, 9]}})
    assert executor.read("distance")[0] == 99
    executor.step(objects={"Opponent": {"distance": [30, 6, 9]}})
    assert executor.holds("marked")[0] == 1
    assert executor.read("distance")[0] == 6
    executor.step(objects={"Opponent": {"distance": [30, 60, 2]}})
    assert [executor.holds(p)[0] for p in ("marked", "also", "nearest")] == [1, 1, 2]
    assert executor.read("distance")[0] == 60
    executor.write("drop", 1)
    executor.step()
    assert executor.holds("marked")[0] == 1
    executor.step(objects={"Opponent": {"distance": [30, 49, 2]}})
    assert executor.holds("marked")[0] == -1
    assert executor.read("distance")[0] == 99


def test_an_occupied_object_place_is_full():
    executor = Executor(MOVES, objects={"Opponent": 3})
    executor.write("marked", 2)
    executor.write("nearest", 1)
    assert executor.why_not("mark") == ["marked is full with 1"]


def test_objects_are_checked():
    executor = chooser()
    for objects, message in (
        ({"Teamate": {}}, "unknown class 'Teamate'. Did you mean 'Teammate'?"),
        ({"Teammate": {"openness": [1, 2, 3, 4], "y": [0] * 4}}, "unknown attribute 'y' of class 'Teammate'"),
        ({"Teammate": {"x": [1, 2, 3, 4]}}, "the net also reads 'openness'"),
    ):
        with pytest.raises(UnknownName, match=message):
            executor.step(objects=objects)
    with pytest.raises(NetError, match=r"attribute 'x' of class 'Teammate' must have shape \(4,\) or \(2, 4\), got \(3,\)"):
        executor.step(objects={"Teammate": {"openness": [1, 2, 3, 4], "x": [1, 2, 3]}})
    with pytest.raises(NetError, match="holds an infinite number"):
        executor.step(objects={"Teammate": {"openness": [1, 2, 3, 4], "x": [1, 2, 3, np.inf]}})
    with pytest.raises(NetError, match="holds an object of 4, -1 for none, got 4"):
        executor.write("chosen", 4)
    with pytest.raises(UnknownName, match="unknown object place 'chose'"):
        executor.holds("chose")


def test_the_number_of_objects_must_be_said_and_fit():
    net = chooser().net
    with pytest.raises(NetError, match=r"reads attributes of class 'Teammate'; say how many there are: objects=\{'Teammate': 11\}"):
        Executor(net)
    with pytest.raises(NetError, match=r"has no object place of class 'Opponent'\. Its classes: Teammate"):
        Executor(net, objects={"Teammate": 4, "Opponent": 11})


def test_objects_that_are_only_moved_need_no_number():
    net = PetriNet("m", (ObjectPlace("a", "Ball"), ObjectPlace("b", "Ball")), (Transition("t", ("a",), ("b",)),))
    executor = Executor(net)
    executor.write("a", 7)
    executor.step()
    assert executor.holds("b")[0] == 7
