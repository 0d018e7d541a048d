"""JSON: equal after a round trip, and whatever is not a net is refused with the place."""

import json

import numpy as np
import pytest
from orient_module import ORIENT, TWICE
from petri_random_nets import random_net

from cprm_gym.architecture.petri import Belief, Command, Continuous, ObjectPlace, PetriNet, Place, Ports, Selection, Semantics, Transition
from cprm_gym.architecture.petri.files.json import net_from_dict, net_from_json, net_to_dict, net_to_json, save_net
from cprm_gym.architecture.petri.files.load import load_net
from cprm_gym.errors import FormatError, NetError


@pytest.mark.parametrize("net", [ORIENT, TWICE, PetriNet("empty")], ids=lambda net: net.name)
def test_net_is_equal_after_a_round_trip(net):
    assert net_from_json(net_to_json(net)) == net


def test_random_nets_are_equal_after_a_round_trip():
    for seed in range(60):
        net = random_net(np.random.default_rng(seed))
        again = net_from_json(net_to_json(net))
        assert again == net
        assert [p.name for p in again.places] == [p.name for p in net.places]


def test_every_field_travels():
    net = PetriNet(
        "all",
        (
            Place("p", 3, 2), Continuous("c", 1.5), Belief("b", "ball.d", "probability", "near", 0.25),
            ObjectPlace("o", "Ball", Selection("Ball", "ball.x", "ball.y > c", 2, True)), ObjectPlace("q", "Ball"),
            Place("begin", 1), Place("stop", 1), Place("failed", 1),
        ),
        (
            Transition("t", {"p": 2, "o": 1}, ("q",), tests={"c": 0.5}, inhibitors={"b": 0.5}, sets={"p": 0}, delay=3, priority=-2,
                       emits=Command("kick", power="c", angle=3, at="o"), weight=2.5, memory="age", set_wins=True),
            Transition("u", ("p",), delay=1, servers=-1),
        ),
        ports=Ports(begin="begin", interrupts=("stop",), errors=("failed",), answers={"stop": ("failed",)}, within=3,
                    idle_interrupts="kept"),
        semantics=Semantics("weak", "atomic", "random", 50),
    )  # fmt: skip
    assert net_from_json(net_to_json(net)) == net


def test_a_module_used_twice_is_written_once():
    data = net_to_dict(TWICE)
    assert list(data["definitions"]) == ["orient", "twice"]
    assert data["definitions"]["twice"]["modules"] == {"first": "orient", "second": "orient"}


def test_two_modules_of_one_name_are_kept_apart():
    a, b = PetriNet("m", (Place("a"),)), PetriNet("m", (Place("b"),))
    net = PetriNet("n", modules={"x": a, "y": b, "z": a})
    assert list(net_to_dict(net)["definitions"]) == ["m", "m#2", "n"]
    assert net_from_json(net_to_json(net)) == net


def test_modules_in_a_circle_are_refused_with_the_circle():
    definitions = {"a": {"modules": {"x": "b"}}, "b": {"modules": {"y": "c"}}, "c": {"modules": {"z": "a"}}}
    with pytest.raises(NetError, match="modules contain each other in a circle: 'a' -> 'b' -> 'c' -> 'a'"):
        net_from_dict({"format": "cprm_gym net", "version": 1, "net": "a", "definitions": definitions})


def change(path: str, value) -> dict:
    data = json.loads(net_to_json(ORIENT))
    inner = data
    *parts, last = path.split("/")
    for part in parts:
        inner = inner[int(part)] if part.isdigit() else inner[part]
    inner[int(last) if last.isdigit() else last] = value
    return data


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("format", "x", "not a net: 'format' is 'x'"),
        ("version", 2, "version 2 of the net format; this package reads version 1"),
        ("net", "orientt", "'net' names 'orientt', which is not defined. Did you mean 'orient'?"),
        ("extra", 1, "the file: unknown entry 'extra'"),
        ("definitions", [], "'definitions': expected an object, got list"),
        ("definitions/orient/place", [], "definition 'orient': unknown entry 'place'. Did you mean 'places'?"),
        ("definitions/orient/places", {}, "'places': expected a list, got dict"),
        ("definitions/orient/places/0", 3, "place 0: expected an object, got int"),
        ("definitions/orient/places/0/kind", "plase", "place 0: unknown kind 'plase'. Did you mean 'place'?"),
        ("definitions/orient/places/0/capcity", 3, "place 0: unknown entry 'capcity'. Did you mean 'capacity'?"),
        ("definitions/orient/places/0/capacity", "many", "place 'begin': capacity is a whole number, got 'many'"),
        ("definitions/orient/places/0/name", 4, "place 0: the name of a place is text, got int"),
        ("definitions/orient/places/9/expression", "__import__('os')", "math place 'off_axis'"),
        ("definitions/orient/transitions/0/inputs", ["begin"], "transition 0: 'inputs': expected an object, got list"),
        ("definitions/orient/transitions/0/inputs", {"begn": 1}, "unknown place 'begn'. Did you mean 'begin'?"),
        ("definitions/orient/transitions/1/emits", {"comand": "turn"}, "'emits': unknown entry 'comand'"),
        ("definitions/orient/transitions/1/emits", {"command": 3}, "the name of a command is text, got int"),
        ("definitions/orient/modules", {"x": "nowhere"}, "unknown module 'nowhere'"),
        ("definitions/orient/modules", {"x": ["nowhere"]}, "unknown module"),
        ("definitions/orient/ports", {"begin": ["a"]}, "ports"),
    ],
)
def test_what_is_not_a_net_is_refused_with_the_place(path, value, message):
    with pytest.raises(NetError, match=message):
        net_from_dict(change(path, value))


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "null", "3", "[" * 100_000])
def test_text_that_is_not_a_net_is_refused(text):
    with pytest.raises(NetError):
        net_from_json(text)


def test_files_are_written_whole_and_read_back(tmp_path):
    path = tmp_path / "orient.json"
    save_net(ORIENT, path)
    assert load_net(path) == ORIENT
    assert [p.name for p in tmp_path.iterdir()] == ["orient.json"]


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(FormatError, match=r"missing\.json: "):
        load_net(tmp_path / "missing.json")
    (tmp_path / "bad.json").write_bytes(b"{\xff")
    with pytest.raises(FormatError, match=r"bad\.json: "):
        load_net(tmp_path / "bad.json")


TOP = '{"format": "cprm_gym net", "version": 1, "net": "n", "definitions": {"n": %s}}'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"format": "cprm_gym net", "version": 1, "net": {}, "definitions": {}}', "'net' names {}, which is not defined"),
        ('{"format": "cprm_gym net", "version": ' + "9" * 5000 + "}", "not JSON"),
        ('{"format": "cprm_gym net", "version": 1e999}', "version inf of the net format"),
        ('{"a": ' * 2000 + "1" + "}" * 2000, "unknown entry 'a'|not JSON"),
        ("[" * 200_000, "not JSON"),
        (TOP % '{"modules": {"x": ["n"]}}', r"unknown module \['n'\]"),
        (TOP % '{"name": 3}', "the name of a net is text, got int: 3"),
        (TOP % '{"places": [{"kind": ["place"]}]}', r"unknown kind \['place'\]"),
        (TOP % '{"places": [{"kind": "place"}]}', "definition 'n': place 0: has no 'name'"),
        (TOP % '{"places": [{"kind": "math", "name": "m"}]}', "definition 'n': place 0: has no 'expression'"),
        (TOP % '{"transitions": [{}]}', "definition 'n': transition 0: has no 'name'"),
        (TOP % ('{"places": [{"kind": "place", "name": "p", "tokens": ' + "9" * 4000 + "}]}"), "got a whole number of 13288 bits"),
        (TOP % '{"places": [{"kind": "input", "name": "p", "value": NaN}]}', "value is a finite number, got nan"),
        (TOP % '{"fuse": {"a": []}}', r"fuse 'a' with \[\]"),
        (TOP % '{"ports": {"errors": [["a"]]}}', "ports: `errors` takes a tuple of place names"),
        (TOP % '{"transitions": [{"name": "t", "emits": {"command": []}}]}', "the name of a command is text"),
        (TOP % '{"transitions": [{"name": "t", "inputs": {"p": 1e999}}]}', "weight of 'p' is a whole number, got inf"),
    ],
)
def test_hostile_json_is_refused_in_our_own_words(text, message):
    with pytest.raises(NetError, match=message):
        net_from_json(text)


def test_a_command_may_have_parameters_of_any_name():
    net = net_from_json(TOP % '{"transitions": [{"name": "t", "emits": {"command": "c", "params": {"self": 1, "name": 2}}}]}')
    assert net.transition("t").emits.params == {"self": 1, "name": 2}


def test_an_entry_that_stands_twice_is_refused():
    with pytest.raises(NetError, match="the entry 'places' stands twice in one object"):
        net_from_json(TOP % '{"places": [], "places": [{"kind": "place", "name": "p"}]}')
