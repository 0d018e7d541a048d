"""Single questions about a net."""

import json

import pytest
from contract_modules import turn_to_ball
from structure_nets import philosophers, producer

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.queries import can_become, coverability, deadlocks, save_graph, tokens
from cprm_gym.architecture.petri import Input, PetriNet, Place, Transition
from cprm_gym.errors import FormatError, NetError, UnknownName


def test_a_predicate_is_reached_with_a_run_or_never():
    found = can_become(philosophers(3), "eats0 == 1 and waits2 >= 1")
    assert found.holds is True
    assert found.marking["eats0"] == found.marking["waits2"] == 1
    assert can_become(philosophers(3), "eats0 and eats1").holds is False
    with pytest.raises(UnknownName, match="Did you mean 'eats0'"):
        can_become(philosophers(3), "eat0")


def test_a_predicate_is_followed_with_clocks_where_there_are_some():
    net = PetriNet(
        "race",
        (Place("p", capacity=1, tokens=1), Place("fast", capacity=1), Place("slow", capacity=1), Input("x")),
        (Transition("f", ("p",), ("fast",), delay=2), Transition("s", ("p",), ("slow",), delay=3)),
    )
    assert can_become(net, "slow").holds is False
    assert [s.cycle for s in can_become(net, "fast").run] == [2]


def test_every_deadlock_is_listed_with_a_run():
    found = deadlocks(philosophers(3))
    assert (found.complete, found.markings) == (True, ({"waits0": 1, "waits1": 1, "waits2": 1},))
    assert len(found.runs[0]) == 3
    two = PetriNet(
        "two ends",
        (Place("p", capacity=1, tokens=1), Place("a", capacity=1), Place("b", capacity=1)),
        (Transition("x", ("p",), ("a",)), Transition("y", ("p",), ("b",), delay=2), Transition("z", ("p",), ("b",))),
    )
    assert {tuple(m) for m in deadlocks(two).markings} == {("a",), ("b",)}
    few = deadlocks(two, most=1)
    assert (len(few.markings), few.complete, few.reason) == (1, False, "only 1 of 2 are listed")


def test_what_can_be_covered_is_told_for_unbounded_nets():
    tree = coverability(producer(None))
    assert tree.covers(tokens("buffer=1000")) is True
    assert tree.covers(tokens("buffer=3,busy,idle")) is False
    assert tree.unbounded_places == ("buffer",)
    with pytest.raises(NetError, match="place=tokens"):
        tokens("buffer=many")


def test_a_module_is_covered_with_its_caller():
    net = turn_to_ball()
    assert can_become(net, "ongoing >= 1").holds is True
    assert (coverability(net).covers({"ongoing": 1}), coverability(net).covers({"ongoing": 2})) == (True, False)


def test_the_graph_is_written_whole_or_not_at_all(tmp_path):
    assert save_graph(philosophers(2), tmp_path / "g.json") == 6
    graph = json.loads((tmp_path / "g.json").read_text())
    assert (len(graph["nodes"]), graph["places"][0]) == (6, "fork0")
    assert all(label in {t.name for t in philosophers(2).transitions} for _, _, label in graph["edges"])
    save_graph(philosophers(2), tmp_path / "g.dot")
    assert (tmp_path / "g.dot").read_text().startswith('digraph "philosophers" {')
    with pytest.raises(NetError, match="the exploration stopped"):
        save_graph(producer(None), tmp_path / "none.json", budget=Budget(states=100))
    assert not (tmp_path / "none.json").exists()
    with pytest.raises(FormatError, match=r"written as \.json or \.dot"):
        save_graph(philosophers(2), tmp_path / "g.txt")
