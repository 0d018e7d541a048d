"""Chains as values: what is refused, what comes back from files."""

import json

import numpy as np
import pytest

from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.architecture.analysis.markov.files import chain_from_json, chain_to_drn, chain_to_json, chain_to_prism, load_chain, save_chain
from cprm_gym.errors import FormatError, ModelError, UnknownName

ROWS = [{0: 0.5, 1: 0.3, 2: 0.2}, {}, {}]
ENDS = {"goal": [1], "lost": [2]}


def chain(**changes):
    return MarkovChain.from_rows(**{"rows": ROWS, "outcomes": ENDS, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rows": [{0: 0.5, 1: 0.3}, {}, {}]}, "state 0: its chances sum to 0.8"),
        ({"rows": [{0: 0.5, 1: -0.1, 2: 0.6}, {}, {}]}, "state 0: -0.1 is no probability"),
        ({"rows": [{0: float("nan"), 1: 1.0}, {}, {}]}, "state 0: nan is no probability"),
        ({"rows": [{0: 0.5, 3: 0.5}, {}, {}]}, "targets are states from 0 to 2"),
        ({"outcomes": {"goal": [1], "never": [2]}}, "'never' is what runs come to that reach no outcome"),
        ({"outcomes": {"goal": [1], "lost": [1, 2]}}, "state 1 belongs to the outcomes 'goal' and 'lost'"),
        ({"outcomes": {"goal": [3]}}, "outcome 'goal': states go from 0 to 2"),
        ({"initial": 5}, "the start 5 is no state"),
        ({"initial": {0: 0.5}}, "sum 0.5"),
        ({"rows": [{0: 0.5, 1: 0.5}, {}, {}], "outcomes": {"goal": [1]}}, "state 2: its chances sum to 0"),
    ],
)
def test_what_is_no_chain_is_refused_and_named(changes, message):
    with pytest.raises(ModelError, match=message):
        chain(**changes)


def test_an_unknown_outcome_lists_those_there_are():
    with pytest.raises(UnknownName, match=r"goall.*Did you mean 'goal'.*Known: goal, lost"):
        chain().states_of("goall")


def test_states_have_names():
    assert chain(names=("far", "near", "lost")).name(1) == "near"
    assert chain(names=lambda i: f"state {i}").name(2) == "state 2"
    assert chain().name(2) == "2"


def test_a_chain_comes_back_from_its_file(tmp_path):
    given = chain(names=("far", "near", "lost"), initial={0: 0.25, 1: 0.75})
    save_chain(given, tmp_path / "chain.json")
    back = load_chain(tmp_path / "chain.json")
    assert chain_to_json(back) == chain_to_json(given)
    assert [back.row(i) for i in range(3)] == ROWS


def test_arrays_may_lie_beside_the_file(tmp_path):
    c = chain()
    np.savez(tmp_path / "c.npz", indptr=c.offsets, indices=c.targets, data=c.chances)
    (tmp_path / "c.json").write_text(json.dumps({"n": 3, "init": 0, "classes": ENDS, "npz": "c.npz"}))
    assert load_chain(tmp_path / "c.json").row(0) == ROWS[0]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ([], "an object is needed"),
        ({"n": 1}, "missing: init, classes"),
        ({"n": 1, "init": 0, "classes": {}}, "missing: rows or npz"),
        ({"n": "1", "init": 0, "classes": {}, "rows": []}, "n is a number of states"),
        ({"n": 2, "init": 0, "classes": {}, "rows": [[]]}, "1 rows for 2 states"),
        ({"n": 1, "init": 0, "classes": {}, "rows": [[[0, "1/0"]]]}, "not understood|Fraction"),
        ({"n": 1, "init": 0, "classes": {}, "rows": [[[0, "one"]]]}, "not understood"),
        ({"n": 1, "init": 0, "classes": {}, "rows": [[[4, 1.0]]]}, "no states from 0 to 0"),
        ({"n": 1, "init": 0, "classes": {}, "npz": "../../secret.npz"}, "npz names a file in the same folder"),
    ],
)
def test_damaged_files_are_refused(data, message, tmp_path):
    (tmp_path / "bad.json").write_text(json.dumps(data))
    with pytest.raises(FormatError, match=rf"bad.json.*({message})"):
        load_chain(tmp_path / "bad.json")


def test_a_file_that_is_no_json_is_named(tmp_path):
    (tmp_path / "bad.json").write_text("{")
    with pytest.raises(FormatError, match=r"bad\.json"):
        load_chain(tmp_path / "bad.json")


def test_pickles_are_not_read(tmp_path):
    np.savez(tmp_path / "c.npz", indptr=np.array([object()]), indices=np.array([0]), data=np.array([1.0]))
    with pytest.raises(FormatError, match=r"c\.npz"):
        chain_from_json({"n": 1, "init": 0, "classes": {"end": [0]}, "npz": "c.npz"}, tmp_path)


def parse_drn(text):
    """Rows, labels of an explicit model, read back by the words of the format alone."""
    rows, labels, state = {}, {}, None
    for line in text.split("@model\n")[1].splitlines():
        words = line.split()
        if words[0] == "state":
            state = int(words[1])
            rows[state], labels[state] = {}, words[3:]
        elif words[0] != "action":
            rows[state][int(words[0])] = float(words[2])
    return rows, labels


def test_exported_text_says_the_same_chain():
    rows, labels = parse_drn(chain_to_drn(chain()))
    assert rows == {0: ROWS[0], 1: {1: 1.0}, 2: {2: 1.0}}
    assert labels == {0: ["init"], 1: ["goal"], 2: ["lost"]}
    prism = chain_to_prism(chain())
    assert "[] s=0 -> 0.5 : (s'=0) + 0.3 : (s'=1) + 0.2 : (s'=2);" in prism
    assert 'label "goal" = s=1;' in prism


def test_a_start_that_is_drawn_becomes_a_state():
    rows, labels = parse_drn(chain_to_drn(chain(initial={0: 0.25, 1: 0.75})))
    assert rows[3] == {0: 0.25, 1: 0.75}
    assert labels[3] == ["init"]


def test_storm_reads_what_is_exported_and_agrees(tmp_path):
    stormpy = pytest.importorskip("stormpy")
    file = tmp_path / "chain.drn"
    file.write_text(chain_to_drn(chain()))
    model = stormpy.build_model_from_drn(str(file))
    (formula,) = stormpy.parse_properties('P=? [F "goal"]')
    found = stormpy.model_checking(model, formula)
    assert found.get_value_vector()[0] == pytest.approx(0.6, abs=1e-6)
