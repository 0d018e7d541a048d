"""Models survive being written and read."""

from __future__ import annotations

import json
import random

import numpy as np
import pytest
from ball_world import scene, soccer
from every_part import everything

from cprm_gym.architecture.prm.interchange import json as io
from cprm_gym.architecture.prm.model.cpds import Dense
from cprm_gym.architecture.prm.model.domains import BOOL
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, Given, PRMClass
from cprm_gym.errors import CprmError, FormatError, ModelError


@pytest.mark.parametrize("model", [everything(), soccer(4), Model("empty")], ids=lambda m: m.name)
def test_a_model_read_back_is_equal(model):
    text = io.model_to_json(model)
    again = io.model_from_json(text)
    assert again == model
    assert io.model_to_json(again) == text


def test_tables_are_read_back_to_the_last_bit():
    values = np.random.default_rng(1).dirichlet(np.ones(7), 5)
    model = Model("m", (PRMClass("C", (Attribute("a", tuple("vwxyz")), Attribute("b", tuple("abcdefg"), Dense(values), parents=("a",)))),))
    again = io.model_from_json(io.model_to_json(model)).checked.classes["C"].rules["b"].main.table
    assert np.array_equal(again, values)


def test_a_file_is_written_whole_and_read_back(tmp_path):
    path = tmp_path / "soccer.prm.json"
    io.save_model(soccer(4), path)
    assert io.load_model(path) == soccer(4)
    assert [p.name for p in tmp_path.iterdir()] == ["soccer.prm.json"]


def test_a_world_keeps_its_objects_and_references():
    world = scene(4, 2)
    again = io.world_from_json(io.world_to_json(world))
    assert again.model == world.model
    assert again.objects == world.objects
    assert again.references == world.references


def edited(change):
    document = json.loads(io.model_to_json(soccer(4)))
    change(document)
    return json.dumps(document)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not JSON"),
        ("[1]", "'format' must be"),
        ("[" * 100_000, "nested too deeply"),
        (edited(lambda d: d.update(version=2)), "version 2; this program reads version 1"),
        (edited(lambda d: d.pop("model")), "has no 'model'"),
        (edited(lambda d: d["model"].update(classes=[{"is": "os.system"}])), "must name a part of a model, got 'os.system'"),
        (edited(lambda d: d["model"]["classes"][0].update(naem="x")), "unknown field 'naem'. Did you mean 'name'"),
        (edited(lambda d: d["model"]["classes"][0].pop("name")), "cannot be made from"),
        (edited(lambda d: d.update(model={"is": "Labels", "names": ["a"]})), "holds a Labels, not a Model"),
        (io.model_to_json(soccer(4)).replace("1.0", "NaN", 1), "NaN is not a number"),
    ],
)
def test_a_text_that_is_no_model_is_refused_with_its_place(text, message):
    with pytest.raises(FormatError, match=message):
        io.model_from_json(text, "x.json")


def test_a_model_that_is_wrong_is_refused_with_its_place():
    text = edited(lambda d: d["model"]["classes"][0]["attributes"][0]["domain"].update(edges=[3.0, 1.0]))
    with pytest.raises(ModelError, match=r"x.json: model.Model 'soccer'.classes\[0\].PRMClass 'Thing'.*edges of bins must increase"):
        io.model_from_json(text, "x.json")


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(FormatError, match=r"none\.json: cannot be read"):
        io.load_model(tmp_path / "none.json")


def places(value, path=()):
    """Every place of a JSON document."""
    yield path
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*path, key))


WRONG = (
    None,
    -1,
    0,
    1e300,
    10**12,
    "",
    "x",
    "prev.x",
    "*",
    [],
    {},
    [[]],
    {"is": "Uniform"},
    {"is": "Labels", "names": ["a"]},
    True,
    "a" * 2000,
)


@pytest.mark.parametrize("model", [everything(), soccer(3)], ids=lambda m: m.name)
def test_a_damaged_document_is_refused_and_never_breaks_the_reader(model):
    """Any part replaced by anything: an equal or other model, or one of our errors."""
    rng = random.Random(8)
    text = io.model_to_json(model)
    all_places = [p for p in places(json.loads(text)) if p]
    refused = 0
    for _ in range(250):
        document = json.loads(text)
        *way, last = rng.choice(all_places)
        inner = document
        for key in way:
            inner = inner[key]
        inner[last] = rng.choice(WRONG)
        try:
            io.model_from_json(json.dumps(document))
        except CprmError:
            refused += 1
    assert refused > 100


def test_a_document_nested_beyond_reason_is_refused():
    text = io.model_to_json(soccer(3)).replace('"classes": [', '"classes": [' + "[" * 900 + "]" * 900 + ",", 1)
    with pytest.raises(FormatError):
        io.model_from_json(text)


def test_a_file_with_the_former_words_for_what_is_given_is_read():
    now = Model("m", (PRMClass("C", (Attribute("x", BOOL, (0.5, 0.5)),), given=(Given("act", BOOL),)),))
    former = io.model_to_json(now).replace('"given"', '"inputs"').replace('"Given"', '"Input"')
    assert former != io.model_to_json(now)
    assert io.model_from_json(former) == now
