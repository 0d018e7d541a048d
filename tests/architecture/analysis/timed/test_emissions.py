"""Two commands of which one goes out, sent in one cycle."""

import pytest

from cprm_gym.architecture.analysis.timed.properties import analyze_timed
from cprm_gym.architecture.petri import Command, Executor, Input, PetriNet, Place, Ports, Transition

BODY = (("dash", "kick"),)


def mover(command):
    return PetriNet(
        command,
        tuple(Place(p, capacity=1) for p in ("begin", "ongoing", "done")),
        (
            Transition("s", ("begin",), ("ongoing",)),
            Transition("act", ("ongoing",), ("done",), delay=1, emits=Command(command, power=50)),
        ),
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
    )


def both(together, second="kick"):
    calls = (Transition("call", ("idle",), ("a.begin", "b.begin") if together else ("a.begin",)),)
    calls += () if together else (Transition("next", ("a.done",), ("b.begin",), delay=1),)
    return PetriNet(
        "both",
        (Place("idle", capacity=1, tokens=1),),
        calls,
        modules={"a": mover("dash"), "b": mover(second)},
    )


def test_body_commands_of_modules_that_run_together_are_reported_with_a_run_and_happen():
    found = analyze_timed(both(True), exclusive=BODY).emissions
    assert [(e.first, e.second, e.commands) for e in found] == [("a.act", "b.act", ("dash", "kick"))]
    assert [(s.cycle, s.what) for s in found[0].run][-2:] == [(1, "a.act"), (1, "b.act")]
    executor = Executor(both(True), exclusive=BODY)
    executor.step()
    assert executor.step().overruled.any()


def test_commands_that_may_go_out_together_or_in_different_cycles_are_not_reported():
    assert analyze_timed(both(True)).emissions == ()
    assert analyze_timed(both(False), exclusive=BODY).emissions == ()


def test_two_commands_of_one_name_are_always_exclusive():
    assert len(analyze_timed(both(True, second="dash")).emissions) == 1


@pytest.mark.parametrize("threshold", [2, 3])
def test_what_no_observation_allows_at_once_is_not_reported(threshold):
    net = PetriNet(
        "either",
        (Place("a", capacity=1, tokens=1), Place("b", capacity=1, tokens=1), Input("d")),
        (
            Transition("near", ("a",), (), inhibitors={"d": 3}, emits=Command("dash")),
            Transition("far", ("b",), (), tests={"d": threshold}, emits=Command("kick")),
        ),
    )
    assert len(analyze_timed(net, exclusive=BODY).emissions) == (threshold < 3)
